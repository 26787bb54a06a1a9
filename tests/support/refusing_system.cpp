#include "tests/support/refusing_system.h"

#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <stdlib.h>

#include <atomic>
#include <climits>

namespace argil::tests {
namespace {

std::atomic<int> threadsLeft{INT_MAX}, threadsRefused{0};
thread_local int blocksLeft = INT_MAX;

template <class Function>
Function real(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

}  // namespace

NoThreads::NoThreads(int first) {
  threadsRefused = 0;
  threadsLeft = first;
}
NoThreads::~NoThreads() {
  threadsLeft = INT_MAX;
}
int NoThreads::refused() {
  return threadsRefused;
}

NoAlignedMemory::NoAlignedMemory(int first) {
  blocksLeft = first;
}
NoAlignedMemory::~NoAlignedMemory() {
  blocksLeft = INT_MAX;
}

}  // namespace argil::tests

// In place of the system's own, which they call.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*),
                              void* argument) {
  using argil::tests::threadsLeft;
  static const auto next = argil::tests::real<decltype(&pthread_create)>("pthread_create");
  if (threadsLeft.load() != INT_MAX && threadsLeft.fetch_sub(1) <= 0) {
    ++argil::tests::threadsRefused;
    return EAGAIN;
  }
  return next(thread, attributes, run, argument);
}

extern "C" void* aligned_alloc(size_t alignment, size_t size) {
  static const auto next = argil::tests::real<decltype(&aligned_alloc)>("aligned_alloc");
  if (argil::tests::blocksLeft != INT_MAX && argil::tests::blocksLeft-- <= 0) {
    errno = ENOMEM;
    return nullptr;
  }
  return next(alignment, size);
}
