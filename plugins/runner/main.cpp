// argil-plugin: loads one plugin's library and does what argil asks of it, in memory that both share (channel.h).
//   argil-plugin LIBRARY FOLDER THREADS MEMORY-BYTES [NODE …]
// with nodes of a device that the library may open while it is loaded, with the channel as descriptor 3, and as
// descriptor 0 a pipe that ends with argil.

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
#include "plugins/runner/runner.h"
#include "plugins/runner/workers.h"

namespace argil::plugin {
namespace {

Channel* channel = nullptr;

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

[[noreturn]] void refuse(Refusal why, const std::string& sentence) {
  // What the plugin itself said is better.
  if (why != Refusal::initFailed || channel->text[0] == '\0') put(channel->text, sentence.c_str());
  channel->refusal = why;
  answer(*channel);
  ::_exit(1);
}

}  // namespace
}  // namespace argil::plugin

int main(int argc, char** argv) {
  using namespace argil;
  using namespace argil::plugin;
  struct stat facts {};
  if (argc < 5 || ::fstat(kChannelFd, &facts) != 0 || static_cast<uint64_t>(facts.st_size) != kChannelBytes) {
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
    const std::vector<std::filesystem::path> nodes(argv + 5, argv + argc);
    const bool device = !nodes.empty();
    uint32_t unconfined = 0;
    if (!io::confineFiles(readable, nodes)) unconfined |= 1;
    // What may be written to can be told apart by Landlock alone.
    if (device && unconfined != 0 && !io::kConfinesNothing)
      refuse(Refusal::cannotLoad, "this system cannot keep it to its device (it has no Landlock)");
    endWithArgil();  // a thread: confined as this one is
    if (!io::confineCalls(device ? io::Calls::loadingDevice : io::Calls::loading)) unconfined |= 2;
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
    (void)io::confineCalls(device ? io::Calls::driving : io::Calls::computing);
    channel->stage.store(uint32_t(Stage::ready));
    answer(*channel);
    Runner(*channel, loaded, workers).serve();
  } catch (const Refused& refused) {
    refuse(refused.why, refused.sentence);
  } catch (const std::exception& error) {
    refuse(Refusal::cannotLoad, error.what());
  }
}
