// Interposes the allocator and the locks of this test program, and lets the kernel hand back the system calls of a tick
// (prctl PR_SET_SYSCALL_USER_DISPATCH: a byte in memory says whether calls pass).

#include "realtime_trap.h"

#include <dlfcn.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define ARGIL_TRAP_INTERPOSES 0
#else
#define ARGIL_TRAP_INTERPOSES 1
#endif

namespace {

constexpr int kSetDispatch = 59;  // PR_SET_SYSCALL_USER_DISPATCH, Linux 5.11; older headers do not name it.

thread_local bool inTick = false;
thread_local uint64_t allocations = 0, locks = 0;
volatile char blockCalls = 0;
volatile uint64_t calls = 0;

void onCall(int, siginfo_t*, void*) {
  calls = calls + 1;
  blockCalls = 0;  // Or the return from this handler would be trapped too; what follows in the same tick goes unseen.
}

}  // namespace

#if ARGIL_TRAP_INTERPOSES
extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
void __libc_free(void*);

void* malloc(size_t n) {
  allocations += inTick;
  return __libc_malloc(n);
}
void* calloc(size_t n, size_t size) {
  allocations += inTick;
  return __libc_calloc(n, size);
}
void* realloc(void* p, size_t n) {
  allocations += inTick;
  return __libc_realloc(p, n);
}
void* aligned_alloc(size_t alignment, size_t n) {
  allocations += inTick;
  return __libc_memalign(alignment, n);
}
int posix_memalign(void** p, size_t alignment, size_t n) {
  allocations += inTick;
  *p = __libc_memalign(alignment, n);
  return *p ? 0 : 12;
}
void free(void* p) {
  allocations += inTick;
  __libc_free(p);
}

// Found by hand and not by a local static, whose own guard may take a lock.
#define ARGIL_TRAP_LOCK(name, type)                                                            \
  static int (*next_##name)(type*) = nullptr;                                                  \
  int name(type* lock) {                                                                       \
    locks += inTick;                                                                           \
    if (!next_##name) next_##name = reinterpret_cast<int (*)(type*)>(dlsym(RTLD_NEXT, #name)); \
    return next_##name(lock);                                                                  \
  }
ARGIL_TRAP_LOCK(pthread_mutex_lock, pthread_mutex_t)
ARGIL_TRAP_LOCK(pthread_mutex_trylock, pthread_mutex_t)
ARGIL_TRAP_LOCK(pthread_mutex_unlock, pthread_mutex_t)
ARGIL_TRAP_LOCK(pthread_rwlock_rdlock, pthread_rwlock_t)
ARGIL_TRAP_LOCK(pthread_rwlock_wrlock, pthread_rwlock_t)
ARGIL_TRAP_LOCK(sem_wait, sem_t)
#undef ARGIL_TRAP_LOCK
}
#endif

namespace argil::haptics::testing {

RealtimeTrap::RealtimeTrap() {
  struct sigaction action {};
  action.sa_sigaction = onCall;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGSYS, &action, nullptr);
  blockCalls = 0;
  dispatch_ = prctl(kSetDispatch, 1UL, 0UL, 0UL, &blockCalls) == 0;
}

RealtimeTrap::~RealtimeTrap() {
  if (dispatch_) prctl(kSetDispatch, 0UL, 0UL, 0UL, 0UL);
}

void RealtimeTrap::enter() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  faultsBefore_ = usage.ru_minflt + usage.ru_majflt;
  ::allocations = ::locks = 0;
  calls = 0;
  inTick = true;
  if (dispatch_) blockCalls = 1;
}

void RealtimeTrap::leave() noexcept {
  blockCalls = 0;
  inTick = false;
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  pageFaults += static_cast<uint64_t>(usage.ru_minflt + usage.ru_majflt - faultsBefore_);
  allocations += ::allocations;
  locks += ::locks;
  systemCalls += calls;
  ::allocations = ::locks = 0;
}

bool RealtimeTrap::seesAllocationsAndLocks() noexcept {
  return ARGIL_TRAP_INTERPOSES != 0;
}

}  // namespace argil::haptics::testing
