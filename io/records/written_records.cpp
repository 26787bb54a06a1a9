#include "io/records/written_records.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace argil::io {
namespace {

constexpr uint64_t kMostGap = 16 << 10;  // bytes between two records that are rather read than skipped
constexpr uint64_t kMostRun = 1 << 20;

// How many bytes came.
size_t readAt(int fd, uint64_t offset, std::span<std::byte> to) {
  size_t done = 0;
  while (done < to.size()) {
    const ssize_t got = ::pread(fd, to.data() + done, to.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    done += static_cast<size_t>(got);
  }
  return done;
}

}  // namespace

WrittenRecords::~WrittenRecords() {
  ::close(fd_);
}

void WrittenRecords::add(RecordId id, uint64_t offset, size_t bytes) {
  const std::lock_guard lock(mutex_);
  sorted_ = sorted_ && (entries_.empty() || entries_.back().id < id);
  entries_.push_back({id, offset, bytes});
}

const WrittenRecords::Entry* WrittenRecords::find(RecordId id) {
  if (!std::exchange(sorted_, true)) {
    std::stable_sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.id < b.id; });
    const auto first =
        std::unique(entries_.rbegin(), entries_.rend(), [](const Entry& a, const Entry& b) { return a.id == b.id; });
    entries_.erase(entries_.begin(), first.base());
  }
  const auto at = std::lower_bound(entries_.begin(), entries_.end(), id,
                                   [](const Entry& entry, RecordId wanted) { return entry.id < wanted; });
  return at != entries_.end() && at->id == id ? &*at : nullptr;
}

bool WrittenRecords::get(RecordId id, std::vector<std::byte>& record) {
  Entry entry{};
  {
    const std::lock_guard lock(mutex_);
    const Entry* found = find(id);
    if (!found) return false;
    entry = *found;
  }
  record.resize(entry.bytes);
  return readAt(fd_, entry.offset, record) == record.size();
}

void WrittenRecords::getMany(std::span<const RecordId> ids,
                             const std::function<void(size_t, std::span<const std::byte>)>& each) {
  std::vector<std::pair<size_t, Entry>> wanted;
  {
    const std::lock_guard lock(mutex_);
    for (size_t i = 0; i < ids.size(); ++i) {
      if (const Entry* found = find(ids[i])) wanted.emplace_back(i, *found);
    }
  }
  std::vector<std::byte> bytes;
  for (size_t begin = 0; begin < wanted.size();) {
    const uint64_t from = wanted[begin].second.offset;
    uint64_t to = from + wanted[begin].second.bytes;
    size_t end = begin + 1;
    for (; end < wanted.size(); ++end) {
      const Entry& next = wanted[end].second;
      if (next.offset < to || next.offset - to > kMostGap || next.offset + next.bytes - from > kMostRun) break;
      to = next.offset + next.bytes;
    }
    bytes.resize(to - from);
    const size_t got = readAt(fd_, from, bytes);
    for (; begin < end; ++begin) {
      const auto& [index, entry] = wanted[begin];
      if (entry.offset - from + entry.bytes <= got)
        each(index, std::span(bytes).subspan(entry.offset - from, entry.bytes));
    }
  }
}

}  // namespace argil::io
