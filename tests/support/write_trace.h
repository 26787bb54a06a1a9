#pragma once
// Every change that a program makes to the files of a folder, in order, with the flushes between: what a power cut may
// take away is told from that (power_cut.h).
//
// Traced are the calls that failing_writes.h intercepts and open, creat, mkdir, unlink, remove, rmdir and truncate,
// SQLite's own among them; each is done and written down under one lock, so that the order is the true one. What goes
// another way (a file that is mapped) is found by comparing a replay of the whole trace with the folder.

#include <cstdint>
#include <string>
#include <vector>

namespace argil::failing {

struct TraceOp {
  enum class Kind : uint8_t { write, resize, create, makeFolder, rename, unlink, flush, note } kind{};
  uint32_t node = 0;     ///< File or folder that is written, resized, made, renamed, removed or flushed.
  uint32_t folder = 0;   ///< Where its entry is.
  std::string name, to;  ///< Of the entry; `to` of a rename. Of a flush: the name that it has then.
  uint64_t at = 0;       ///< Offset of a write, new length, or the value of a note.
  std::string bytes;     ///< Of a write.
};

struct Trace {
  struct Found {
    bool folder = false;
    uint32_t parent = 0;
    std::string name, bytes;
  };
  std::string root;
  std::vector<Found> before;  ///< What was there, all of it on the disk: the first nodes. Number 0 is the root.
  std::vector<TraceOp> ops;
  uint32_t nodes = 0;
};

/// From now on everything under `root` is traced, in all threads. Flushes are not waited for. Not while others write
/// there.
void beginTrace(const std::string& root);
/// The program's own word on where it is.
void note(uint64_t value);
[[nodiscard]] Trace endTrace();

/// For the intercepted functions alone.
namespace tracing {

/// Held from before a call until it was written down. Does nothing while nothing is traced.
class Guard {
 public:
  Guard();
  ~Guard();
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;
  [[nodiscard]] bool on() const { return on_; }

 private:
  bool on_;
};
// With a guard that is on, after the call has succeeded; none of them changes errno. `end`: the bytes stand before the
// descriptor's position.
void wrote(int fd, const void* bytes, size_t count, int64_t offset);
void wroteBeforePosition(int fd, const void* bytes, size_t count);
void resized(int fd, uint64_t length);
void resizedPath(int folder, const char* path, uint64_t length);
/// `fd` was opened; `flags` as open() had them.
void opened(int folder, const char* path, int flags, int fd);
void madeFolder(int folder, const char* path);
void renamed(int fromFolder, const char* from, int toFolder, const char* to);
void unlinked(int folder, const char* path);
void flushed(int fd);

}  // namespace tracing
}  // namespace argil::failing
