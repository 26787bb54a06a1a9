#include "tests/support/own_new.h"

#include <cstdlib>
#include <new>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define ARGIL_OWN_NEW 0
#else
#define ARGIL_OWN_NEW 1
#endif

namespace argil::tests {

namespace {

struct State {
  size_t left = 0;  // allocations that are granted; 0: nobody counts
  bool counts = false, forGood = false, refused = false;
};
thread_local State state;
thread_local size_t made = 0;

}  // namespace

bool memoryCanFail() {
  return ARGIL_OWN_NEW;
}
size_t allocations() {
  return made;
}
FailingMemory::FailingMemory(size_t nth, bool forGood) {
  state = {nth, true, forGood, false};
}
FailingMemory::~FailingMemory() {
  state = {};
}
bool FailingMemory::refused() const {
  return state.refused;
}

#if ARGIL_OWN_NEW
namespace {

void* granted(size_t bytes, size_t alignment) {
  ++made;
  if (state.counts && (state.left == 0 || --state.left == 0) && (state.forGood || !state.refused)) {
    state.refused = true;
    throw std::bad_alloc();
  }
  void* const room = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  if (!room) throw std::bad_alloc();
  return room;
}

}  // namespace
#endif

}  // namespace argil::tests

#if ARGIL_OWN_NEW
void* operator new(size_t bytes) {
  return argil::tests::granted(bytes, __STDCPP_DEFAULT_NEW_ALIGNMENT__);
}
void* operator new(size_t bytes, std::align_val_t alignment) {
  return argil::tests::granted(bytes, static_cast<size_t>(alignment));
}
void operator delete(void* room) noexcept {
  std::free(room);
}
void operator delete(void* room, size_t) noexcept {
  std::free(room);
}
void operator delete(void* room, std::align_val_t) noexcept {
  std::free(room);
}
void operator delete(void* room, size_t, std::align_val_t) noexcept {
  std::free(room);
}
#endif
