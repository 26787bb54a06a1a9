#include "engine/saving/saved_history.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "engine/saving/document_records.h"

namespace argil::engine {
namespace {

std::vector<io::RecordSource*> pointers(const SavedHistory::Sources& sources) {
  std::vector<io::RecordSource*> raw;
  for (const auto& source : sources) raw.push_back(source.get());
  return raw;
}

}  // namespace

void SavedHistory::add(Layer layer) {
  const std::lock_guard lock(mutex_);
  layers_.insert(layers_.begin(), std::move(layer));
}

void SavedHistory::keepOnly(const std::set<uint64_t>& numbers) {
  std::vector<Layer> gone;  // closed without the lock
  const std::lock_guard lock(mutex_);
  const auto at = std::stable_partition(layers_.begin(), layers_.end(),
                                        [&](const Layer& each) { return numbers.contains(each.number); });
  std::move(at, layers_.end(), std::back_inserter(gone));
  layers_.erase(at, layers_.end());
}

size_t SavedHistory::layers() const {
  const std::lock_guard lock(mutex_);
  return layers_.size();
}

SavedHistory::Sources SavedHistory::all() const {
  const std::lock_guard lock(mutex_);
  Sources sources;
  for (const Layer& layer : layers_) sources.insert(sources.end(), layer.journals.begin(), layer.journals.end());
  for (const Layer& layer : layers_) {
    if (layer.file) sources.push_back(layer.file);
  }
  return sources;
}

bool SavedHistory::get(io::RecordId id, std::vector<std::byte>& record) {
  const Sources sources = all();
  return engine::Sources(pointers(sources)).get(id, record);
}

void SavedHistory::getMany(std::span<const io::RecordId> ids,
                           const std::function<void(size_t, std::span<const std::byte>)>& each) {
  const Sources sources = all();
  engine::Sources(pointers(sources)).getMany(ids, each);
}

}  // namespace argil::engine
