#pragma once
// A disk that is full or failing, for the program that this library is loaded into: linked to a test, or by LD_PRELOAD
// into any program.
//
// Calls of write, pwrite, writev, fsync, fdatasync, ftruncate, rename and renameat2 on files and folders are counted
// from 1; from a chosen one on they fail. Pipes, terminals and sockets are left alone. SQLite calls these functions
// through libc, so that its writes are counted with ours.
//
// By environment, for LD_PRELOAD=.../libfailing_writes.so PROGRAM:
//   ARGIL_FAIL=enospc:N[:once][:short] or eio:N[...]: the N-th call fails, and all after it unless `once`; `short`: a
//     write takes half of its bytes at the N-th call and fails at the next.
//   ARGIL_FAIL_PATH=TEXT: only calls on paths that contain TEXT are counted and fail.
//   ARGIL_FAIL_TOLD=PATH: this file is made when the first call fails.
//   ARGIL_SLOW_FLUSH_MS=N: each fsync and fdatasync takes so long, and longer.

namespace argil::failing {

struct Plan {
  int error = 0;            ///< errno; 0: calls are only counted.
  long from = 1;            ///< The first call that fails.
  bool once = false;        ///< It is the only one.
  bool shortFirst = false;  ///< A write takes half of its bytes there and fails at the next call.
  const char* pathPart = nullptr;
  bool flushes = true;  ///< False: fsync and fdatasync do nothing but count; enough where no power is cut.
};

/// Counts from 1 again, in all threads. Not while others write.
void begin(const Plan& plan);
/// Calls work again (and are not counted); returns how many there were.
long end();

}  // namespace argil::failing
