#include "io/journal_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <system_error>
#include <thread>
#include <tuple>
#include <utility>

#include "clay/error.h"
#include "io/input.h"
#include "io/scanned_records.h"

namespace argil::io {

namespace {

constexpr size_t kBufferBytes = size_t{1} << 20;

std::string reason(int error) { return std::generic_category().message(error); }

[[noreturn]] void failWork(const std::filesystem::path& path, const std::string& wrong) { throw Error(displayName(path) + ": " + wrong, Error::Kind::work); }

/// As create_directories, but for the person alone: what was modelled is nobody else's business.
void makePrivateFolder(const std::filesystem::path& folder) {
  if (folder.empty() || ::access(folder.c_str(), F_OK) == 0) return;
  if (folder.has_parent_path() && folder.parent_path() != folder) makePrivateFolder(folder.parent_path());
  if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) failWork(folder, "the folder for journals cannot be made (" + reason(errno) + "); set ARGIL_STATE to one that can be written");
}

void flushFolder(const std::filesystem::path& folder) {
  const int fd = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  (void)!::fsync(fd);  // Some file systems cannot flush a folder.
  ::close(fd);
}

}  // namespace

struct JournalWriter::State {
  std::filesystem::path path;
  int fd = -1;
  std::shared_ptr<WrittenRecords> records;
  std::vector<std::byte> buffer;
  mutable std::mutex mutex;  ///< Guards all but the wait for the disk.
  uint64_t put = 0, synced = 0;
  bool folderFlushed = false;
  double syncSeconds = 0;
  std::string broken;  ///< The sentence, once something failed.

  ~State() {
    if (fd < 0) return;
    try {
      if (broken.empty()) flush();
    } catch (const Error&) {
    }
    ::close(fd);
  }

  [[noreturn]] void breakOff(const std::string& wrong) {
    broken = displayName(path) + ": " + wrong;
    buffer.clear();
    buffer.shrink_to_fit();
    // What was not flushed may be there in parts; a reader copes with that too if even this fails.
    (void)!::ftruncate(fd, static_cast<off_t>(synced));
    throw Error(broken, Error::Kind::work);
  }

  void flush() {
    std::span<const std::byte> bytes = buffer;
    while (!bytes.empty()) {
      const ssize_t done = ::write(fd, bytes.data(), bytes.size());
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) breakOff("the journal cannot be written (" + reason(errno) + "); make room, and save your work");
      bytes = bytes.subspan(static_cast<size_t>(done));
    }
    buffer.clear();
  }

  void mustWork() const {
    if (!broken.empty()) throw Error(broken, Error::Kind::work);
    if (fd < 0) throw Error(displayName(path) + ": the journal was removed; begin another", Error::Kind::work);
  }
};

JournalWriter::JournalWriter(const std::filesystem::path& path, bool unnamed) : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.path = path;
  state.buffer.reserve(kBufferBytes + kMostRecordBytes);
  const std::filesystem::path folder = path.parent_path();
  makePrivateFolder(folder);
  // Under a hidden name until it is locked: nobody may take it for one that a crash left.
  const std::filesystem::path hidden = folder / ("." + path.filename().string() + "." + std::to_string(::getpid()));
  state.fd = ::open(hidden.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (state.fd < 0) failWork(path, "the journal cannot be made (" + reason(errno) + "); set ARGIL_STATE to a folder that can be written");
  int error = 0;
  // A description of its own: closing it must not keep or end the lock.
  const int reading = ::open(hidden.c_str(), O_RDONLY | O_CLOEXEC);
  if (reading >= 0) state.records = std::make_shared<WrittenRecords>(reading);
  if (reading < 0) {
    error = errno;
  } else if (unnamed) {
    ::unlink(hidden.c_str());
  } else if (::flock(state.fd, LOCK_EX | LOCK_NB) != 0) {
    error = errno;
  } else if (::renameat2(AT_FDCWD, hidden.c_str(), AT_FDCWD, path.c_str(), RENAME_NOREPLACE) != 0) {
    error = errno;
    // Some file systems know no such rename.
    if (error == EINVAL && ::access(path.c_str(), F_OK) != 0) error = ::rename(hidden.c_str(), path.c_str()) == 0 ? 0 : errno;
  }
  if (error != 0) {
    ::unlink(hidden.c_str());
    failWork(path, "the journal cannot be made (" + reason(error) + "); set ARGIL_STATE to another folder");
  }
}

JournalWriter::~JournalWriter() = default;

void JournalWriter::put(const RecordHeader& header, std::span<const std::byte> body) {
  const std::lock_guard lock(state_->mutex);
  state_->mustWork();
  const size_t before = state_->buffer.size();
  appendRecord(state_->buffer, header, body);
  if (header.id != 0) state_->records->add(header.id, state_->put, state_->buffer.size() - before);
  state_->put += state_->buffer.size() - before;
  if (state_->buffer.size() >= kBufferBytes) state_->flush();
}

void JournalWriter::write() {
  const std::lock_guard lock(state_->mutex);
  state_->mustWork();
  state_->flush();
}

void JournalWriter::sync() {
  State& state = *state_;
  std::unique_lock lock(state.mutex);
  state.mustWork();
  state.flush();
  if (state.put == state.synced) return;
  const uint64_t reached = state.put;
  const bool folder = !std::exchange(state.folderFlushed, true);
  lock.unlock();
  const auto begin = std::chrono::steady_clock::now();
  const int result = ::fdatasync(state.fd);
  const int error = errno;
  if (folder) flushFolder(state.path.parent_path());
  lock.lock();
  state.syncSeconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  // Never tried again: the kernel may have dropped the pages that it could not write, and call the rest clean.
  if (result != 0) state.breakOff("the journal cannot be flushed to the disk (" + reason(error) + "); save your work elsewhere");
  state.synced = reached;
}

bool JournalWriter::broken() const {
  const std::lock_guard lock(state_->mutex);
  return !state_->broken.empty();
}

uint64_t JournalWriter::bytes() const {
  const std::lock_guard lock(state_->mutex);
  return state_->put;
}

uint64_t JournalWriter::synced() const {
  const std::lock_guard lock(state_->mutex);
  return state_->synced;
}

std::shared_ptr<WrittenRecords> JournalWriter::records() const { return state_->records; }

double JournalWriter::syncSeconds() const {
  const std::lock_guard lock(state_->mutex);
  return state_->syncSeconds;
}

void JournalWriter::remove() {
  if (state_->fd < 0) return;
  // In this order: without the lock it would look abandoned.
  ::unlink(state_->path.c_str());
  ::close(std::exchange(state_->fd, -1));
}

struct JournalReader::State {
  std::filesystem::path path;
  std::vector<ScannedRecords::Place> events;
  std::unique_ptr<ScannedRecords> records;
};

namespace {

int openJournal(const std::filesystem::path& path, bool lock) {
  const int fd = openForScan(path, lock);
  if (!lock) return fd;
  // Somebody who only looks whether it is abandoned holds it for microseconds.
  for (int attempt = 0; ::flock(fd, LOCK_EX | LOCK_NB) != 0; ++attempt) {
    if (attempt < 10) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      continue;
    }
    const int error = errno;
    ::close(fd);
    if (error == EWOULDBLOCK) failWork(path, "is in use by another Argil; close that first");
    failWork(path, "cannot be locked (" + reason(error) + ")");
  }
  // It may have been removed by who held it.
  struct stat facts {};
  if (::fstat(fd, &facts) == 0 && facts.st_nlink > 0) return fd;
  ::close(fd);
  failWork(path, "was removed meanwhile by another Argil");
}

}  // namespace

JournalReader::JournalReader(const std::filesystem::path& path, bool lock) : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.path = path;
  state.records = std::make_unique<ScannedRecords>(openJournal(path, lock), path, nullptr, [&](const RecordView& record, ScannedRecords::Place place) {
    if (record.header.id == 0) state.events.push_back(place);
  });
}

JournalReader::~JournalReader() = default;

void JournalReader::forEachEvent(const std::function<void(const RecordView&)>& visit) const {
  std::vector<std::byte> bytes;
  for (const auto& place : state_->events) {
    if (!state_->records->read(place, bytes)) continue;
    if (const auto record = parseRecord(bytes)) visit(*record);
  }
}

uint64_t JournalReader::records() const { return state_->records->records(); }

uint64_t JournalReader::damagedPlaces() const { return state_->records->gaps(); }

RecordId JournalReader::highestId() const { return state_->records->highestId(); }

bool JournalReader::get(RecordId id, std::vector<std::byte>& record) { return state_->records->get(id, record); }

void JournalReader::getMany(std::span<const RecordId> ids, const std::function<void(size_t, std::span<const std::byte>)>& each) {
  state_->records->getMany(ids, each);
}

void JournalReader::remove() { ::unlink(state_->path.c_str()); }

std::vector<std::filesystem::path> abandonedJournals(const std::filesystem::path& folder) {
  std::vector<std::pair<timespec, std::filesystem::path>> found;
  std::error_code error;
  for (std::filesystem::directory_iterator each(folder, error), end; !error && each != end; each.increment(error)) {
    const std::filesystem::path path = each->path();
    if (path.filename().string().front() == '.') continue;
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW);
    if (fd < 0) continue;
    struct stat facts {};
    const bool free = ::fstat(fd, &facts) == 0 && S_ISREG(facts.st_mode) && ::flock(fd, LOCK_SH | LOCK_NB) == 0;
    ::close(fd);
    if (free) found.emplace_back(facts.st_mtim, path);
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return std::tie(a.first.tv_sec, a.first.tv_nsec, a.second) > std::tie(b.first.tv_sec, b.first.tv_nsec, b.second);
  });
  std::vector<std::filesystem::path> paths;
  for (auto& each : found) paths.push_back(std::move(each.second));
  return paths;
}

std::filesystem::path journalFolder() {
  const auto value = [](const char* name) {
    const char* text = std::getenv(name);
    return std::filesystem::path(text == nullptr ? "" : text);
  };
  if (!value("ARGIL_STATE").empty()) return value("ARGIL_STATE") / "journal";
  // The XDG base directory specification: paths that are not absolute are to be ignored.
  if (value("XDG_STATE_HOME").is_absolute()) return value("XDG_STATE_HOME") / "argil" / "journal";
  return value("HOME") / ".local" / "state" / "argil" / "journal";
}

}  // namespace argil::io
