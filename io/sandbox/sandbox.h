#pragma once
// What a process that runs other people's code forbids itself before it does: argil-reader and argil-plugin.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace argil::io {

/// Under sanitizers nothing is confined: they look at files themselves, and their leak check traces the process.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kConfinesNothing = true;
#else
inline constexpr bool kConfinesNothing = false;
#endif

struct ProcessLimits {
  uint64_t memoryBytes = 0;           ///< Address space.
  uint64_t cpuSeconds = 0;            ///< 0: no limit.
  bool endsWithParentThread = false;  ///< With the thread that started it, whatever ends that.
};
/// Sets these limits, 64 open files, no bytes into files, no core and no new privileges. Under sanitizers, which
/// reserve terabytes and write what they find, the address space stays free, and files may grow. Throws Error (work)
/// when the system refuses.
void limitResources(const ProcessLimits& limits);

/// From here on this thread and those that it starts open no file but these, and what lies in those that are folders,
/// and these only to read; `nodes` to read and to write (Landlock). False where the kernel has no Landlock
/// (before 5.13, or not switched on), and under sanitizers, where nothing is done. Throws Error when it can and does
/// not.
[[nodiscard]] bool confineFiles(std::span<const std::filesystem::path> readable,
                                std::span<const std::filesystem::path> nodes = {});

/// System calls that are left to the process.
enum class Calls : uint8_t {
  reading,        ///< To read files, to compute and to start threads; others fail with EPERM.
  loading,        ///< The same, and what confining itself once more takes; others raise SIGSYS.
  computing,      ///< To compute and to start threads; others raise SIGSYS. No file is opened.
  loadingDevice,  ///< As loading, and files that are there may be opened to write, and told things by ioctl().
  driving,        ///< As computing, and ioctl() on what is open.
};
/// From here on all threads of the process make no other system calls (seccomp): nothing is opened to write (but
/// for loadingDevice), nothing is sent to anybody, no process is started, none but our own gets a signal. SIGSYS is
/// handled by whoever handles it now; its handler stays. False where the kernel has no filters, and under sanitizers,
/// where nothing is done. Throws Error when it can and does not.
[[nodiscard]] bool confineCalls(Calls calls);

/// "openat": the name of a system call of this machine; its number where it has none.
[[nodiscard]] std::string callName(int number);

}  // namespace argil::io
