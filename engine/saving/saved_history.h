#pragma once
// Where the steps of a document in work are read again that are not in memory.

#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <vector>

#include "io/records/record.h"

namespace argil::engine {

/// All such places as one source, in layers: journals and the saved file under them, which together hold whole
/// documents. Journals are asked before files, newer layers before older ones. A journal can be read as long as its
/// layer is here, whether or not its file still has a name. Any thread, with the lock of the document's records held.
class SavedHistory : public io::RecordSource {
 public:
  using Sources = std::vector<std::shared_ptr<io::RecordSource>>;
  struct Layer {
    uint64_t number = 0;
    Sources journals;
    std::shared_ptr<io::RecordSource> file;  ///< Null: none.
  };
  void add(Layer layer);
  /// The others go; a journal whose file has no name any more gives its room on the disk back.
  void keepOnly(const std::set<uint64_t>& numbers);
  [[nodiscard]] size_t layers() const;

  bool get(io::RecordId id, std::vector<std::byte>& record) override;
  void getMany(std::span<const io::RecordId> ids,
               const std::function<void(size_t, std::span<const std::byte>)>& each) override;

 private:
  [[nodiscard]] Sources all() const;
  mutable std::mutex mutex_;
  std::vector<Layer> layers_;  // newest first
};

}  // namespace argil::engine
