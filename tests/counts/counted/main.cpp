// Small pieces of the program's main work, each counted by Callgrind: the same instructions on any machine, loaded or
// not. Prints how often each allocated; run without Callgrind that alone is counted. argv[1]: names of what is to be
// run, with commas; else all. To be found: ARGIL_COUNT_MORE=N does N of a hundred of each more; ARGIL_COUNT_PLANTED,
// "branch" or "allocation", adds that to each of them.

#include <hwy/highway.h>
#include <valgrind/callgrind.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <new>
#include <string>
#include <string_view>

#include "tests/counts/counted/pieces_of_work.h"
#include "tests/support/own_new.h"

namespace {

volatile int planted = 0;  // what no compiler knows

void plant(std::string_view what, int times) {
  for (int i = 0; i < times; ++i) {
    if (what == "branch" && planted != 0) std::puts("never");
    if (what != "allocation") continue;
    void* volatile room = ::operator new(64);
    ::operator delete(room);
  }
}

}  // namespace

int main(int count, char** arguments) {
  // What every machine has that Callgrind runs on.
  hwy::SetSupportedTargetsForTest(HWY_AVX2);
  const std::string wanted = count > 1 ? "," + std::string(arguments[1]) + "," : "";
  const char* const more = std::getenv("ARGIL_COUNT_MORE");
  const char* const added = std::getenv("ARGIL_COUNT_PLANTED");
  const int times = 100 + (more ? std::atoi(more) : 0);
  for (const argil::tests::PieceOfWork& piece : argil::tests::piecesOfWork()) {
    if (!wanted.empty() && wanted.find("," + piece.name + ",") == std::string::npos) continue;
    const std::function<void(int)> work = piece.begin();
    work(piece.times);  // What is made once is made now.
    const size_t before = argil::tests::allocations();
    CALLGRIND_START_INSTRUMENTATION;
    work(piece.times * times / 100);
    if (added) plant(added, piece.times);
    CALLGRIND_STOP_INSTRUMENTATION;
    std::printf("%s %zu\n", piece.name.c_str(), argil::tests::allocations() - before);
    CALLGRIND_DUMP_STATS_AT(piece.name.c_str());
    CALLGRIND_ZERO_STATS;
  }
}
