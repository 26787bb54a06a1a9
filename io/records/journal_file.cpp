#include "io/records/journal_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "clay/base/error.h"
#include "io/bytes/folder_flush.h"
#include "io/bytes/input.h"
#include "io/records/scanned_records.h"

namespace argil::io {

namespace {

constexpr size_t kBufferBytes = size_t{1} << 20;

std::string reason(int error) {
  return std::generic_category().message(error);
}

[[noreturn]] void failWork(const std::filesystem::path& path, const std::string& wrong) {
  throw Error(displayName(path) + ": " + wrong, Error::Kind::work);
}

/// As create_directories, but for the user alone: what was modelled is nobody else's business. `changed` gets the
/// folders that a new one is in.
void makePrivateFolder(const std::filesystem::path& folder, std::vector<std::filesystem::path>& changed) {
  if (folder.empty() || ::access(folder.c_str(), F_OK) == 0) return;
  if (folder.has_parent_path() && folder.parent_path() != folder) makePrivateFolder(folder.parent_path(), changed);
  if (::mkdir(folder.c_str(), 0700) == 0)
    changed.push_back(folder.parent_path());
  else if (errno != EEXIST)
    failWork(folder, "the folder for journals cannot be made (" + reason(errno) +
                         "); set ARGIL_STATE to one that can be written");
}

/// Throws Error (kind work).
void writeAll(int fd, std::span<const std::byte> bytes, uint64_t at, const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t done = ::pwrite(fd, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) failWork(path, "the journal cannot be written (" + reason(errno) + "); make room");
    bytes = bytes.subspan(static_cast<size_t>(done));
    at += static_cast<uint64_t>(done);
  }
}

}  // namespace

struct JournalWriter::State {
  std::filesystem::path path;
  int fd = -1;
  std::shared_ptr<WrittenRecords> records;
  std::vector<std::byte> buffer;
  mutable std::mutex mutex;  ///< Guards all but the wait for the disk.
  uint64_t put = 0, synced = 0;
  std::vector<std::filesystem::path> unflushed;  ///< Folders that lead to the journal, as a power cut must leave them.
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
  makePrivateFolder(folder, state.unflushed);
  state.unflushed.push_back(folder);
  // Under a hidden name until it is locked: nobody may take it for one that a crash left.
  const std::filesystem::path hidden = folder / ("." + path.filename().string() + "." + std::to_string(::getpid()));
  state.fd = ::open(hidden.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (state.fd < 0)
    failWork(path,
             "the journal cannot be made (" + reason(errno) + "); set ARGIL_STATE to a folder that can be written");
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
    if (error == EINVAL && ::access(path.c_str(), F_OK) != 0)
      error = ::rename(hidden.c_str(), path.c_str()) == 0 ? 0 : errno;
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
  const auto folders = std::exchange(state.unflushed, {});
  lock.unlock();
  const auto begin = std::chrono::steady_clock::now();
  int error = ::fdatasync(state.fd) == 0 ? 0 : errno;
  // Without its name the journal is found by nobody.
  for (const auto& folder : folders)
    if (error == 0) error = flushFolder(folder);
  lock.lock();
  state.syncSeconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  // Never tried again: the kernel may have dropped the pages that it could not write, and call the rest clean.
  if (error != 0)
    state.breakOff("the journal cannot be flushed to the disk (" + reason(error) + "); save your work elsewhere");
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

std::shared_ptr<WrittenRecords> JournalWriter::records() const {
  return state_->records;
}

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
  struct Event {
    ScannedRecords::Place place;
    uint64_t damaged;  ///< Places in front of it.
  };
  std::filesystem::path path;
  int fd = -1;  ///< That of `records`, which closes it.
  std::vector<Event> events;
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
    if (error == EWOULDBLOCK) throw JournalTaken(displayName(path) + ": is in use by another Argil; close that first");
    failWork(path, "cannot be locked (" + reason(error) + ")");
  }
  // It may have been removed by who held it.
  struct stat facts {};
  if (::fstat(fd, &facts) == 0 && facts.st_nlink > 0) return fd;
  ::close(fd);
  throw JournalTaken(displayName(path) + ": was removed meanwhile by another Argil");
}

}  // namespace

JournalReader::JournalReader(const std::filesystem::path& path, bool lock) : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.path = path;
  state.fd = openJournal(path, lock);
  uint64_t damaged = 0, expected = 0;
  state.records = std::make_unique<ScannedRecords>(state.fd, path, nullptr,
                                                   [&](const RecordView& record, ScannedRecords::Place place) {
                                                     damaged += place.offset != expected;
                                                     expected = place.offset + place.bytes;
                                                     if (record.header.id == 0)
                                                       state.events.push_back({place, damaged});
                                                   });
}

JournalReader::~JournalReader() = default;

void JournalReader::forEachEvent(const std::function<void(const RecordView&, uint64_t)>& visit) const {
  std::vector<std::byte> bytes;
  uint64_t lost = 0;  // Since the scan.
  for (const auto& [place, damaged] : state_->events) {
    const auto record = state_->records->read(place, bytes) ? parseRecord(bytes) : std::nullopt;
    if (record)
      visit(*record, damaged + lost);
    else
      ++lost;
  }
}

void JournalReader::append(RecordKind kind, std::span<const std::byte> body) {
  const State& state = *state_;
  struct stat facts {};
  if (::fstat(state.fd, &facts) != 0) failWork(state.path, "cannot be read (" + reason(errno) + ")");
  std::vector<std::byte> record;
  appendRecord(record, {kind, RecordCodec::raw, 0, 0, 0}, body);
  writeAll(state.fd, record, static_cast<uint64_t>(facts.st_size), state.path);
  if (::fdatasync(state.fd) != 0)
    failWork(state.path, "the journal cannot be flushed to the disk (" + reason(errno) + ")");
}

uint64_t JournalReader::records() const {
  return state_->records->records();
}

uint64_t JournalReader::damagedPlaces() const {
  return state_->records->gaps();
}

RecordId JournalReader::highestId() const {
  return state_->records->highestId();
}

bool JournalReader::get(RecordId id, std::vector<std::byte>& record) {
  return state_->records->get(id, record);
}

void JournalReader::getMany(std::span<const RecordId> ids,
                            const std::function<void(size_t, std::span<const std::byte>)>& each) {
  state_->records->getMany(ids, each);
}

void JournalReader::remove() {
  ::unlink(state_->path.c_str());
}

std::vector<std::filesystem::path> abandonedJournals(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> found;
  std::error_code error;
  for (std::filesystem::directory_iterator each(folder, error), end; !error && each != end; each.increment(error)) {
    const std::filesystem::path path = each->path();
    if (path.filename().string().front() == '.') continue;
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW);
    if (fd < 0) continue;
    struct stat facts {};
    const bool free = ::fstat(fd, &facts) == 0 && S_ISREG(facts.st_mode) && ::flock(fd, LOCK_SH | LOCK_NB) == 0;
    ::close(fd);
    if (free) found.push_back(path);
  }
  std::sort(found.begin(), found.end(), std::greater<>());
  return found;
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
