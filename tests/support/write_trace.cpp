#include "tests/support/write_trace.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace argil::failing {
namespace {

namespace fs = std::filesystem;
using Kind = TraceOp::Kind;

struct Tracer {
  Trace trace;
  std::map<std::string, uint32_t> folders;             // by path
  std::map<std::pair<dev_t, ino_t>, uint32_t> inodes;  // what a descriptor leads to
  std::map<std::pair<uint32_t, std::string>, uint32_t> entries;
  std::map<uint32_t, std::string> names;  // of nodes, the last ones

  uint32_t known(const struct stat& facts, uint32_t node) {
    inodes[{facts.st_dev, facts.st_ino}] = node;
    return node;
  }
};

std::mutex mutex;
std::atomic<bool> tracing_{false};
std::optional<Tracer> tracer;

// Where an entry is: nothing outside of the root.
std::optional<std::pair<uint32_t, std::string>> placeOf(int folder, const char* path) {
  fs::path whole = path;
  if (whole.is_relative()) {
    char link[64], base[4096];
    if (folder == AT_FDCWD) {
      if (getcwd(base, sizeof base) == nullptr) return std::nullopt;
    } else {
      std::snprintf(link, sizeof link, "/proc/self/fd/%d", folder);
      const ssize_t size = readlink(link, base, sizeof base - 1);
      if (size < 0) return std::nullopt;
      base[size] = 0;
    }
    whole = fs::path(base) / whole;
  }
  whole = whole.lexically_normal();
  const auto found = tracer->folders.find(whole.parent_path().string());
  if (found == tracer->folders.end()) return std::nullopt;
  return std::pair(found->second, whole.filename().string());
}

std::optional<uint32_t> nodeOf(int fd) {
  struct stat facts {};
  if (fstat(fd, &facts) != 0) return std::nullopt;
  const auto found = tracer->inodes.find({facts.st_dev, facts.st_ino});
  if (found == tracer->inodes.end()) return std::nullopt;
  return found->second;
}

TraceOp& add(Kind kind, uint32_t node) {
  TraceOp& op = tracer->trace.ops.emplace_back();
  op.kind = kind;
  op.node = node;
  return op;
}

struct KeepErrno {
  int value = errno;
  ~KeepErrno() { errno = value; }
};

}  // namespace

void beginTrace(const std::string& root) {
  Tracer fresh;
  fresh.trace.root = fs::canonical(root).string();
  const auto find = [&](const auto& self, const fs::path& path, uint32_t parent) -> void {
    const auto node = static_cast<uint32_t>(fresh.trace.before.size());
    struct stat facts {};
    if (lstat(path.c_str(), &facts) != 0 || (!S_ISREG(facts.st_mode) && !S_ISDIR(facts.st_mode)))
      throw std::runtime_error("cannot trace " + path.string());
    Trace::Found& found = fresh.trace.before.emplace_back();
    found.folder = S_ISDIR(facts.st_mode);
    found.parent = parent;
    found.name = path.filename().string();
    fresh.known(facts, node);
    fresh.names[node] = found.name;
    if (node != 0) fresh.entries[{parent, found.name}] = node;
    if (!found.folder) {
      std::ifstream in(path, std::ios::binary);
      found.bytes.assign(std::istreambuf_iterator<char>(in), {});
      return;
    }
    fresh.folders[path.string()] = node;
    for (const auto& each : fs::directory_iterator(path)) self(self, each.path(), node);
  };
  find(find, fresh.trace.root, 0);
  fresh.trace.nodes = static_cast<uint32_t>(fresh.trace.before.size());
  const std::lock_guard lock(mutex);
  tracer = std::move(fresh);
  tracing_ = true;
}

void note(uint64_t value) {
  const std::lock_guard lock(mutex);
  if (tracer) add(Kind::note, 0).at = value;
}

Trace endTrace() {
  const std::lock_guard lock(mutex);
  tracing_ = false;
  Trace trace = std::move(tracer->trace);
  tracer.reset();
  return trace;
}

namespace tracing {

Guard::Guard() : on_(tracing_.load(std::memory_order_acquire)) {
  if (!on_) return;
  mutex.lock();
  on_ = tracing_;
  if (!on_) mutex.unlock();
}

Guard::~Guard() {
  if (on_) mutex.unlock();
}

void wrote(int fd, const void* bytes, size_t count, int64_t offset) {
  const KeepErrno keep;
  const auto node = nodeOf(fd);
  if (!node) return;
  TraceOp& op = add(Kind::write, *node);
  op.at = static_cast<uint64_t>(offset);
  op.bytes.assign(static_cast<const char*>(bytes), count);
}

void wroteBeforePosition(int fd, const void* bytes, size_t count) {
  const KeepErrno keep;
  wrote(fd, bytes, count, lseek(fd, 0, SEEK_CUR) - static_cast<int64_t>(count));
}

void resized(int fd, uint64_t length) {
  const KeepErrno keep;
  if (const auto node = nodeOf(fd)) add(Kind::resize, *node).at = length;
}

void resizedPath(int folder, const char* path, uint64_t length) {
  const KeepErrno keep;
  const auto place = placeOf(folder, path);
  const auto found = place ? tracer->entries.find(*place) : tracer->entries.end();
  if (found != tracer->entries.end()) add(Kind::resize, found->second).at = length;
}

void opened(int folder, const char* path, int flags, int fd) {
  const KeepErrno keep;
  if ((flags & (O_CREAT | O_TRUNC)) == 0) return;
  const auto place = placeOf(folder, path);
  if (!place) return;
  const auto there = tracer->entries.find(*place);
  if (there != tracer->entries.end()) {
    if ((flags & O_TRUNC) != 0) add(Kind::resize, there->second).at = 0;
    return;
  }
  struct stat facts {};
  if (fstat(fd, &facts) != 0 || !S_ISREG(facts.st_mode)) return;
  const uint32_t node = tracer->known(facts, tracer->trace.nodes++);
  tracer->entries[*place] = node;
  tracer->names[node] = place->second;
  TraceOp& op = add(Kind::create, node);
  std::tie(op.folder, op.name) = *place;
}

void madeFolder(int folder, const char* path) {
  const KeepErrno keep;
  const auto place = placeOf(folder, path);
  struct stat facts {};
  if (!place || stat(path, &facts) != 0) return;
  const uint32_t node = tracer->known(facts, tracer->trace.nodes++);
  tracer->entries[*place] = node;
  tracer->names[node] = place->second;
  const auto parent = std::find_if(tracer->folders.begin(), tracer->folders.end(),
                                   [&](const auto& each) { return each.second == place->first; });
  const std::string whole = parent->first + "/" + place->second;
  tracer->folders[whole] = node;
  TraceOp& op = add(Kind::makeFolder, node);
  std::tie(op.folder, op.name) = *place;
}

void renamed(int fromFolder, const char* from, int toFolder, const char* to) {
  const KeepErrno keep;
  const auto source = placeOf(fromFolder, from), target = placeOf(toFolder, to);
  if (!source || !target || source->first != target->first) return;  // a replay of the whole trace shows it
  const auto there = tracer->entries.find(*source);
  if (there == tracer->entries.end()) return;
  const uint32_t node = there->second;
  tracer->entries.erase(there);
  tracer->entries[*target] = node;
  tracer->names[node] = target->second;
  TraceOp& op = add(Kind::rename, node);
  std::tie(op.folder, op.name) = *source;
  op.to = target->second;
}

void unlinked(int folder, const char* path) {
  const KeepErrno keep;
  const auto place = placeOf(folder, path);
  const auto there = place ? tracer->entries.find(*place) : tracer->entries.end();
  if (there == tracer->entries.end()) return;
  TraceOp& op = add(Kind::unlink, there->second);
  std::tie(op.folder, op.name) = *place;
  tracer->entries.erase(there);
}

void flushed(int fd) {
  const KeepErrno keep;
  if (const auto node = nodeOf(fd)) add(Kind::flush, *node).name = tracer->names[*node];
}

}  // namespace tracing
}  // namespace argil::failing
