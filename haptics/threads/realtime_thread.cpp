#include "haptics/threads/realtime_thread.h"

#include <link.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <string_view>

#include "haptics/threads/realtime_kit.h"

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace argil::haptics {
namespace {

constexpr size_t kStackBytes = 256 * 1024;  // Touched before the first tick; a tick uses far less.
// MADV_POPULATE_READ and MADV_POPULATE_WRITE (Linux 5.14), which the C library's headers may not know.
constexpr int kPopulateRead = 22, kPopulateWrite = 23;

[[gnu::noinline]] void touchStack() {
  char stack[kStackBytes];
  for (size_t i = 0; i < kStackBytes; i += 4096) static_cast<volatile char*>(stack)[i] = 0;
}

// Code and constants of the program and of the libraries that arithmetic calls: a page of them that is first needed in
// a tick would come from the disk. Other libraries are large, and no tick calls them.
int touchCode(dl_phdr_info* object, size_t, void*) {
  const std::string_view path = object->dlpi_name;
  const std::string_view name = path.substr(path.find_last_of('/') + 1);
  bool wanted = path.empty();
  for (const std::string_view library : {"libc.so", "libm.so", "libstdc++.so", "libgcc_s.so"})
    wanted = wanted || name.starts_with(library);
  if (!wanted) return 0;
  const auto page = static_cast<uintptr_t>(sysconf(_SC_PAGESIZE));
  // Linked once, its beginning may be read alone from then on.
  uintptr_t sealed = 0;
  for (int i = 0; i < object->dlpi_phnum; ++i) {
    const auto& part = object->dlpi_phdr[i];
    if (part.p_type == PT_GNU_RELRO) sealed = (object->dlpi_addr + part.p_vaddr + part.p_memsz) & ~(page - 1);
  }
  // A kernel that cannot do this leaves it to the first ticks.
  const auto populate = [](uintptr_t from, uintptr_t to, int how) {
    if (from < to) (void)madvise(reinterpret_cast<void*>(from), to - from, how);
  };
  for (int i = 0; i < object->dlpi_phnum; ++i) {
    const auto& part = object->dlpi_phdr[i];
    if (part.p_type != PT_LOAD || !(part.p_flags & PF_R)) continue;
    const uintptr_t begin = (object->dlpi_addr + part.p_vaddr) & ~(page - 1);
    const uintptr_t end = object->dlpi_addr + part.p_vaddr + part.p_memsz;
    populate(begin, end, kPopulateRead);
    // What may be written gets a page of its own at once: until then it is shared with the guard, a fork.
    if (part.p_flags & PF_W) populate(std::max(begin, sealed > end ? begin : sealed), end, kPopulateWrite);
  }
  return 0;
}

std::mutex theLock;
int theUsers = 0;

}  // namespace

RealtimeGrant becomeRealtime(int priority, bool memory) {
  static std::atomic<bool> kitSilent{false};  // Who did not answer once is not waited for again.
  RealtimeGrant grant;
  sched_param parameter{};
  parameter.sched_priority = priority;
  const int refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter);
  grant.fifo = refused == 0;
  if (grant.fifo) {
    grant.sentence = "real-time scheduling granted (SCHED_FIFO " + std::to_string(priority) + ")";
  } else if (!kitSilent.load()) {
    const RealtimeKitAnswer answer = askRealtimeKit(systemBus(), gettid(), priority);
    grant.fifo = answer.granted;
    if (answer.silent) kitSilent.store(true);
    if (grant.fifo)
      grant.sentence = "real-time scheduling granted by RealtimeKit (SCHED_RR " + std::to_string(answer.priority) + ")";
  }
  if (!grant.fifo) {
    grant.sentence = "real-time scheduling refused (" + std::string(std::strerror(refused)) +
                     "): ticks may come late; allow it with 'ulimit -r 90' or the rtprio line of limits.conf";
  }
  if (memory) {
    grant.locked = lockMemory();
    grant.sentence += grant.locked ? "; memory locked"
                                   : "; memory not locked (" + std::string(std::strerror(errno)) +
                                         "): a tick may wait for a page; allow it with 'ulimit -l unlimited'";
  }
  touchStack();
  return grant;
}

bool lockMemory() noexcept {
  const std::lock_guard lock(theLock);
  if (theUsers == 0) {
    // On fault: an arena of the clay of which a part is used takes that part. Whatever the servo reads was written
    // before.
    if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) return false;
    (void)dl_iterate_phdr(touchCode, nullptr);
  }
  ++theUsers;
  return true;
}

void unlockMemory() noexcept {
  const std::lock_guard lock(theLock);
  if (theUsers > 0 && --theUsers == 0) munlockall();
}

#if defined(__SSE2__)
namespace {
constexpr unsigned kFlushToZero = 0x8000, kDenormalsAreZero = 0x0040;
}
FlushDenormals::FlushDenormals() noexcept : before_(_mm_getcsr()) {
  _mm_setcsr(static_cast<unsigned>(before_) | kFlushToZero | kDenormalsAreZero);
}
FlushDenormals::~FlushDenormals() {
  _mm_setcsr(static_cast<unsigned>(before_));
}
#elif defined(__aarch64__)
FlushDenormals::FlushDenormals() noexcept {
  asm volatile("mrs %0, fpcr" : "=r"(before_));
  asm volatile("msr fpcr, %0" : : "r"(before_ | (1ull << 24)));
}
FlushDenormals::~FlushDenormals() {
  asm volatile("msr fpcr, %0" : : "r"(before_));
}
#else
FlushDenormals::FlushDenormals() noexcept = default;
FlushDenormals::~FlushDenormals() = default;
#endif

}  // namespace argil::haptics
