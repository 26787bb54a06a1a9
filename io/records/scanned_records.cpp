#include "io/records/scanned_records.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "io/bytes/input.h"
#include "io/records/open_documents.h"

namespace argil::io {

namespace {

constexpr size_t kBlockBytes = size_t{4} << 20;
/// What is carried over to the next block: a record may begin there and end in the next.
constexpr size_t kOverlap = kMostRecordBytes - 1;

}  // namespace

int openForScan(const std::filesystem::path& path, bool writable) {
  const std::string name = displayName(path);
  // Non-blocking, so that a pipe without a writer is refused instead of waited for.
  const int fd = ::open(path.c_str(), (writable ? O_RDWR : O_RDONLY) | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) {
    if (errno == ENOENT || errno == ENOTDIR) fail(name, "there is no such file; check the name and the folder");
    fail(name, "cannot be opened (" + std::generic_category().message(errno) + "); check the name and the permissions");
  }
  struct stat facts {};
  if (::fstat(fd, &facts) == 0 && S_ISREG(facts.st_mode)) return fd;
  closeKeepingLocks(fd);
  fail(name, "is not a regular file; name a file");
}

ScannedRecords::ScannedRecords(const std::filesystem::path& path, Job* job, const Visit& visit)
    : ScannedRecords(openForScan(path, false), path, job, visit) {}

ScannedRecords::ScannedRecords(int fd, const std::filesystem::path& path, Job* job, const Visit& visit) : fd_(fd) {
  try {
    scan(displayName(path), job, visit);
  } catch (...) {
    closeKeepingLocks(fd_);
    throw;
  }
}

ScannedRecords::~ScannedRecords() {
  closeKeepingLocks(fd_);
}

void ScannedRecords::scan(const std::string& name, Job* job, const Visit& visit) {
  struct stat facts {};
  const double size = ::fstat(fd_, &facts) == 0 ? std::max<double>(1, double(facts.st_size)) : 1;
  std::vector<std::byte> block(kBlockBytes + kOverlap);
  uint64_t start = 0;     // Of the block in the file.
  size_t held = 0;        // Bytes in the block.
  uint64_t expected = 0;  // Where the next record would stand if nothing lay between.
  for (bool ended = false; !ended;) {
    const ssize_t got = ::pread(fd_, block.data() + held, block.size() - held, static_cast<off_t>(start + held));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(name, "cannot be read (" + std::generic_category().message(errno) + "); check the disk");
    ended = got == 0;
    held += static_cast<size_t>(got);
    const std::span<const std::byte> bytes(block.data(), held);
    size_t at = expected > start ? static_cast<size_t>(expected - start) : 0;
    while ((at = findRecord(bytes, at)) < held) {
      const auto view = parseRecord(bytes.subspan(at));
      const Place place{start + at, view->whole.size()};
      gaps_ += place.offset != expected;
      ++records_;
      if (view->header.id != 0) ids_.push_back({view->header.id, place});
      visit(*view, place);
      at += view->whole.size();
      expected = start + at;
    }
    // A found record is never looked at again; what is behind it may begin another one.
    size_t keepFrom = held > kOverlap ? held - kOverlap : 0;
    if (expected > start) keepFrom = std::max(keepFrom, static_cast<size_t>(expected - start));
    std::memmove(block.data(), block.data() + keepFrom, held - keepFrom);
    start += keepFrom;
    held -= keepFrom;
    if (job != nullptr) job->step(std::min(1.0, double(start) / size));
  }
  std::stable_sort(ids_.begin(), ids_.end(), [](const Entry& a, const Entry& b) { return a.id < b.id; });
  const auto first =
      std::unique(ids_.rbegin(), ids_.rend(), [](const Entry& a, const Entry& b) { return a.id == b.id; });
  ids_.erase(ids_.begin(), first.base());
}

bool ScannedRecords::read(Place place, std::vector<std::byte>& record) const {
  record.resize(place.bytes);
  for (size_t done = 0; done < record.size();) {
    const ssize_t got =
        ::pread(fd_, record.data() + done, record.size() - done, static_cast<off_t>(place.offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    done += static_cast<size_t>(got);
  }
  return true;
}

bool ScannedRecords::get(RecordId id, std::vector<std::byte>& record) {
  const auto found = std::lower_bound(ids_.begin(), ids_.end(), id,
                                      [](const Entry& entry, RecordId wanted) { return entry.id < wanted; });
  return found != ids_.end() && found->id == id && read(found->place, record);
}

void ScannedRecords::getMany(std::span<const RecordId> ids,
                             const std::function<void(size_t, std::span<const std::byte>)>& each) {
  std::vector<std::byte> record;
  for (size_t i = 0; i < ids.size(); ++i) {
    if (get(ids[i], record)) each(i, record);
  }
}

}  // namespace argil::io
