// Runs a fuzz target (LLVMFuzzerTestOneInput) without libFuzzer: mutates a kept corpus, the same way in every run.
//   fuzz_NAME CORPUS-FOLDER [--run N]
// 20 000 inputs, or fewer where 1 s of its CPU time is over before; twenty times both in the long tier. When an input
// breaks the target its number is printed; --run N repeats that one, and writes it to the file fuzz-input.

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/support/tier.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);
extern "C" __attribute__((weak)) void __sanitizer_set_death_callback(void (*callback)());

namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<uint8_t>;

volatile uint64_t currentRun = 0;

void tellRun() {
  std::fprintf(stderr, "\nfuzz: broken by run %llu; repeat it with --run\n", (unsigned long long)currentRun);
}

void onSignal(int number) {
  tellRun();
  std::signal(number, SIG_DFL);
  std::raise(number);
}

class Numbers {  // SplitMix64
 public:
  explicit Numbers(uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15u + 1) {}
  uint64_t next() {
    uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  size_t below(size_t count) { return count ? next() % count : 0; }

 private:
  uint64_t state_;
};

// What readers trip over: ends of ranges, numbers that are none, counts that lie.
const std::string kTokens[] = {"0",
                               "-1",
                               "1e999",
                               "nan",
                               "inf",
                               "-0",
                               "4294967295",
                               "4294967296",
                               "18446744073709551616",
                               "2147483648",
                               "1e-320",
                               "\n",
                               "\r\n",
                               " ",
                               "#",
                               std::string("\0\0\0\0", 4),
                               std::string("\xff\xff\xff\xff", 4),
                               std::string("\x00\x00\x80\x7f", 4),
                               std::string("\x00\x00\xc0\x7f", 4),
                               std::string("\xff\xff\xff\x7f", 4)};

void mutateOnce(Bytes& bytes, const std::vector<Bytes>& corpus, Numbers& numbers) {
  const size_t at = numbers.below(bytes.size() + 1);
  const auto position = [&](size_t i) { return bytes.begin() + static_cast<std::ptrdiff_t>(i); };
  switch (numbers.below(7)) {
    case 0:
      bytes.resize(at);
      break;
    case 1:
      if (at < bytes.size()) bytes[at] ^= static_cast<uint8_t>(1u << numbers.below(8));
      break;
    case 2:
      if (at < bytes.size()) bytes[at] = static_cast<uint8_t>(numbers.next());
      break;
    case 3: {
      const std::string& token = kTokens[numbers.below(std::size(kTokens))];
      bytes.insert(position(at), token.begin(), token.end());
      break;
    }
    case 4: {
      const std::string& token = kTokens[numbers.below(std::size(kTokens))];
      for (size_t i = 0; i < token.size() && at + i < bytes.size(); ++i) bytes[at + i] = static_cast<uint8_t>(token[i]);
      break;
    }
    case 5:
      bytes.erase(position(at), position(at + std::min(bytes.size() - at, 1 + numbers.below(16))));
      break;
    default: {
      const Bytes& other = corpus[numbers.below(corpus.size())];
      const size_t from = numbers.below(other.size() + 1), count = numbers.below(other.size() - from + 1);
      bytes.insert(position(at), other.begin() + static_cast<std::ptrdiff_t>(from),
                   other.begin() + static_cast<std::ptrdiff_t>(from + count));
    }
  }
}

// The first runs are the corpus as it is.
Bytes inputOf(uint64_t run, const std::vector<Bytes>& corpus) {
  Numbers numbers(run);
  Bytes bytes = corpus[run < corpus.size() ? run : numbers.below(corpus.size())];
  if (run >= corpus.size()) {
    for (size_t count = 1 + numbers.below(8); count > 0; --count) mutateOnce(bytes, corpus, numbers);
  }
  return bytes;
}

}  // namespace

int main(int count, char** arguments) {
  std::vector<Bytes> corpus;
  std::vector<fs::path> files;
  if (count >= 2 && fs::is_directory(arguments[1])) {
    for (const auto& entry : fs::directory_iterator(arguments[1])) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    std::ifstream stream(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  if (corpus.empty()) {
    std::fprintf(stderr, "fuzz: give a folder with a corpus\n");
    return 2;
  }
  for (const int number : {SIGABRT, SIGSEGV, SIGFPE, SIGBUS, SIGILL}) std::signal(number, onSignal);
  if (__sanitizer_set_death_callback) __sanitizer_set_death_callback(tellRun);

  if (count >= 4 && std::strcmp(arguments[2], "--run") == 0) {
    currentRun = std::strtoull(arguments[3], nullptr, 10);
    const Bytes bytes = inputOf(currentRun, corpus);
    std::ofstream("fuzz-input", std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    return LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
  const auto times = argil::tests::byTier<uint64_t>(1, 20);
  const auto end = std::clock() + static_cast<std::clock_t>(times) * CLOCKS_PER_SEC;
  uint64_t run = 0;
  for (; run < 20000 * times && (std::clock() < end || run < 2 * corpus.size()); ++run) {
    currentRun = run;
    const Bytes bytes = inputOf(run, corpus);
    if (LLVMFuzzerTestOneInput(bytes.data(), bytes.size()) != 0) std::abort();
  }
  std::printf("%llu inputs from a corpus of %zu\n", (unsigned long long)run, corpus.size());
  return 0;
}
