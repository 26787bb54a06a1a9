// argil-plugin: loads one plugin's library and does what argil asks of it, in memory that both share (channel.h).
//   argil-plugin LIBRARY FOLDER THREADS MEMORY-BYTES
// with the channel as descriptor 3, and as descriptor 0 a pipe that ends with argil.

#include <errno.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <ucontext.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <thread>
#include <vector>

#include "clay/base/error.h"
#include "io/sandbox/sandbox.h"
#include "plugins/runner/channel.h"
#include "plugins/runner/futex.h"
#include "plugins/runner/library.h"
#include "plugins/runner/workers.h"

namespace argil::plugin {
namespace {

Channel* channel = nullptr;

void put(char (&to)[kMostText], const char* text) noexcept {
  // Whole characters of UTF-8 alone.
  size_t n = ::strnlen(text, kMostText - 1);
  if (n == kMostText - 1)
    while (n > 0 && (static_cast<unsigned char>(text[n]) & 0xc0) == 0x80) --n;
  std::memcpy(to, text, n);
  to[n] = '\0';
}

// A system call that is refused: noted, and it fails with EPERM.
void onRefused(int, siginfo_t* what, void* context) {
  uint32_t none = 0;
  channel->refusedCall.compare_exchange_strong(none, static_cast<uint32_t>(what->si_syscall) + 1);
  auto* registers = &static_cast<ucontext_t*>(context)->uc_mcontext;
#if defined(__x86_64__)
  registers->gregs[REG_RAX] = -EPERM;
#elif defined(__aarch64__)
  registers->regs[0] = static_cast<unsigned long long>(-EPERM);
#else
#error "say where a system call's result stands on this machine"
#endif
}

void endWithArgil() {
  std::thread([] {
    char byte;
    while (::read(kLifeFd, &byte, 1) < 0 && errno == EINTR) {
    }
    ::_exit(0);
  }).detach();
}

void answer() noexcept {
  channel->answered.fetch_add(1);
  wakeAll(channel->answered);
}

[[noreturn]] void refuse(Refusal why, const std::string& sentence) {
  // What the plugin itself said is better.
  if (why != Refusal::initFailed || channel->text[0] == '\0') put(channel->text, sentence.c_str());
  channel->refusal = why;
  answer();
  ::_exit(1);
}

class Runner {
 public:
  Runner(Library& library, Workers& workers) : library_(library), workers_(workers) {}

  [[noreturn]] void serve() {
    for (uint32_t done = 0;;) {
      while (channel->asked.load() == done) sleepWhile(channel->asked, done, -1);
      ++done;
      channel->text[0] = '\0';
      channel->refusal = Refusal::none;
      channel->status = work();
      answer();
    }
  }

 private:
  argil_status work() {
    switch (channel->command) {
      case Command::none:
        return ARGIL_OK;
      case Command::describeBrush:
        return describe();
      case Command::beginStroke:
        return begin();
      case Command::bricks:
        return bricks();
      case Command::endStroke:
        end();
        return ARGIL_OK;
    }
    return ARGIL_FAILED;
  }

  const argil_brush* find() {
    const argil_brush* brush = library_.brush(channel->thing);
    if (brush == nullptr) channel->refusal = Refusal::unknownThing;
    return brush;
  }

  argil_status describe() {
    const argil_brush* brush = find();
    if (brush == nullptr) return ARGIL_FAILED;
    channel->flags = brush->flags;
    channel->margin = brush->margin;
    channel->parameterCount = brush->parameter_count;
    if (brush->parameters != nullptr)
      for (uint32_t i = 0; i < std::min(brush->parameter_count, kMostParameters); ++i)
        put(channel->parameterIds[i], brush->parameters[i] != nullptr ? brush->parameters[i] : "");
    return ARGIL_OK;
  }

  argil_status begin() {
    end();
    const argil_brush* brush = find();
    if (brush == nullptr) return ARGIL_FAILED;
    argil_stroke stroke = channel->stroke;
    stroke.parameters = channel->parameters;
    if (brush->begin != nullptr) {
      stroke_ = brush->begin(&stroke);
      if (stroke_ == nullptr && brush->end != nullptr) return ARGIL_FAILED;
    }
    brush_ = brush;
    return ARGIL_OK;
  }

  void end() {
    if (brush_ != nullptr && brush_->size >= offsetof(argil_brush, end) + sizeof(brush_->end) && brush_->end != nullptr)
      brush_->end(stroke_);
    brush_ = nullptr;
    stroke_ = nullptr;
  }

  argil_status bricks() {
    if (brush_ == nullptr) return ARGIL_FAILED;
    auto* window = reinterpret_cast<std::byte*>(channel) + kWindowAt;
    const BatchPlace& place = channel->batch;
    std::atomic<argil_status> worst{ARGIL_OK};
    const auto range = [&](uint32_t from, uint32_t to) {
      argil_batch batch{};
      batch.size = sizeof batch;
      batch.image_count = channel->imageCount;
      batch.images = channel->images;
      batch.count = to - from;
      batch.margin = place.margin;
      batch.coords = reinterpret_cast<const int32_t(*)[3]>(window + place.coords) + from;
      batch.phi = reinterpret_cast<const float*>(window + place.phi) + size_t{from} * place.brick;
      batch.brick = place.brick;
      batch.plane = place.plane;
      batch.row = place.row;
      batch.weight = reinterpret_cast<const float*>(window + place.weight) + size_t{from} * 512;
      batch.out = reinterpret_cast<float*>(window + place.out) + size_t{from} * 512;
      if (const argil_status status = brush_->bricks(stroke_, &batch); status != ARGIL_OK) worst.store(status);
    };
    constexpr uint32_t kAtLeast = 16;  // bricks that are worth a thread's while
    workers_.run(place.count, (brush_->flags & ARGIL_BRUSH_SERIAL) != 0 ? place.count : kAtLeast, range);
    return worst.load();
  }

  Library& library_;
  Workers& workers_;
  const argil_brush* brush_ = nullptr;
  void* stroke_ = nullptr;
};

}  // namespace
}  // namespace argil::plugin

int main(int argc, char** argv) {
  using namespace argil;
  using namespace argil::plugin;
  struct stat facts {};
  if (argc != 5 || ::fstat(kChannelFd, &facts) != 0 || static_cast<uint64_t>(facts.st_size) != kChannelBytes) {
    std::fputs("argil-plugin is started by argil\n", stderr);
    return 2;
  }
  void* mapped = ::mmap(nullptr, kChannelBytes, PROT_READ | PROT_WRITE, MAP_SHARED, kChannelFd, 0);
  if (mapped == MAP_FAILED) return 1;
  ::close(kChannelFd);
  channel = static_cast<Channel*>(mapped);
  if (channel->magic != kChannelMagic) return 2;
  const std::filesystem::path library = argv[1], folder = argv[2];
  const auto threads = static_cast<unsigned>(std::clamp(std::atoi(argv[3]), 1, int{kMostThreads}));
  try {
    channel->stage.store(uint32_t(Stage::confining));
    io::limitResources({.memoryBytes = std::strtoull(argv[4], nullptr, 10)});
    struct sigaction refused {};
    refused.sa_sigaction = onRefused;
    refused.sa_flags = SA_SIGINFO | SA_NODEFER;
    ::sigaction(SIGSYS, &refused, nullptr);
    const std::vector<std::filesystem::path> readable{folder,       "/lib",           "/usr/lib",        "/lib64",
                                                      "/usr/lib64", "/usr/local/lib", "/etc/ld.so.cache"};
    uint32_t unconfined = 0;
    if (!io::confineFiles(readable)) unconfined |= 1;
    endWithArgil();  // a thread: confined as this one is
    if (!io::confineCalls(io::Calls::loading)) unconfined |= 2;
    channel->unconfined.store(unconfined);

    static Library loaded;
    channel->stage.store(uint32_t(Stage::loading));
    loaded.load(library.c_str());
    static const argil_host host{
        sizeof(argil_host),
        ARGIL_PLUGIN_MINOR,
        nullptr,
        [](void*, const char* sentence) {
          if (sentence != nullptr) put(channel->text, sentence);
        },
        [](void*, double done) { channel->progressBits.store(std::bit_cast<uint64_t>(done)); },
        [](void*) { return channel->cancel.load() != 0; },
    };
    channel->stage.store(uint32_t(Stage::entering));
    loaded.enter(host);
    put(channel->id, loaded.plugin().id);
    put(channel->version, loaded.plugin().version);
    // Never destroyed: what the library holds is not worth it.
    auto& workers = *new Workers(threads);
    (void)io::confineCalls(io::Calls::computing);
    channel->stage.store(uint32_t(Stage::ready));
    answer();
    Runner(loaded, workers).serve();
  } catch (const Refused& refused) {
    refuse(refused.why, refused.sentence);
  } catch (const std::exception& error) {
    refuse(Refusal::cannotLoad, error.what());
  }
}
