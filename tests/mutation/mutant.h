#pragma once
// What a mutated source file asks: is this mutant the one that is switched on? (tests/mutation/mutate.py)

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>

namespace argil_mutation {

inline constexpr int kMost = 4096;  // mutants in one build
inline int active = -1;             // from ARGIL_MUTANT; -1: none, the program behaves as it was written
inline uint8_t* reached = nullptr;  // one byte a mutant, shared with the file that ARGIL_MUTANT_TRACE names

// Before every other initialiser, and before a reader confines itself. A shared mapping, so that a program that is
// killed has still told what it reached.
__attribute__((constructor(101))) static void readEnvironment() {
  if (reached || active >= 0) return;
  if (const char* number = std::getenv("ARGIL_MUTANT")) active = std::atoi(number);
  const char* trace = std::getenv("ARGIL_MUTANT_TRACE");
  if (!trace) return;
  const int file = open(trace, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0 || ftruncate(file, kMost) != 0) std::abort();
  void* shared = mmap(nullptr, kMost, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  close(file);
  if (shared == MAP_FAILED) std::abort();
  reached = static_cast<uint8_t*>(shared);
}

inline bool on(int number) {
  if (reached) __atomic_store_n(&reached[number], uint8_t{1}, __ATOMIC_RELAXED);
  return number == active;
}

}  // namespace argil_mutation
