#include "engine/plugins/plugin_process.h"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <new>
#include <utility>

#include "io/bytes/input.h"
#include "io/sandbox/sandbox.h"
#include "plugins/runner/futex.h"

namespace argil::engine {

using plugin::Channel;
using Clock = std::chrono::steady_clock;

namespace {

constexpr int64_t kLookNs = 2'000'000;  // between two looks at a process that has not answered
constexpr int64_t kSoonNs = 200'000;    // A batch of a stamp takes about that; waking up half as much.
constexpr double kLongestLookS = 0.02;  // that counts of the time between them
constexpr double kMakesUp = 10;         // seconds of sleep for one of computing

double seconds(Clock::duration d) {
  return std::chrono::duration<double>(d).count();
}

// Of a process and all its threads; 0 when it is not there any more.
double processorSeconds(pid_t pid) {
  clockid_t clock;
  timespec time{};
  if (::clock_getcpuclockid(pid, &clock) != 0 || ::clock_gettime(clock, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Whether some thread of a process computes or waits for a processor, or the disk that its memory went to.
bool computes(pid_t pid) {
  const std::string folder = fmt::format("/proc/{}/task", pid);
  const std::unique_ptr<DIR, int (*)(DIR*)> threads(::opendir(folder.c_str()), ::closedir);
  if (!threads) return false;
  while (const dirent* each = ::readdir(threads.get())) {
    if (each->d_name[0] == '.') continue;
    std::ifstream in(fmt::format("{}/{}/stat", folder, each->d_name));
    std::string line;
    std::getline(in, line);
    const size_t name = line.rfind(')');
    if (name != std::string::npos && name + 2 < line.size() && (line[name + 2] == 'R' || line[name + 2] == 'D'))
      return true;
  }
  return false;
}

}  // namespace

std::string_view nameOf(PluginFault fault) {
  switch (fault) {
    case PluginFault::notThere:
      return "not there";
    case PluginFault::cannotLoad:
      return "cannot be loaded";
    case PluginFault::noEntry:
      return "no plugin of this version";
    case PluginFault::notAsSaid:
      return "not as plugin.json says";
    case PluginFault::crashed:
      return "crash";
    case PluginFault::hung:
      return "hang";
    case PluginFault::memory:
      return "too much memory";
    case PluginFault::outside:
      return "a write outside of its batch";
    case PluginFault::notFinite:
      return "a number that is not finite";
    case PluginFault::failed:
      return "failure";
  }
  return "";
}

void PluginProcess::Unmap::operator()(void* memory) const {
  ::munmap(memory, plugin::kChannelBytes);
}
PluginProcess::Fd::~Fd() {
  if (fd >= 0) ::close(fd);
}

std::filesystem::path pluginProgram() {
  return io::programBeside("argil-plugin", "ARGIL_PLUGIN", "it runs plugins");
}

PluginProcess::PluginProcess(const PluginLibrary& library, int threads, const PluginLimits& limits)
    : library_(library), limits_(limits), threads_(std::clamp(threads, 1, int{plugin::kMostThreads})) {
  const auto cannot = [&](const std::string& why) {
    throw PluginError(PluginFault::notThere, fmt::format("{} cannot be started: {}", library_.name, why));
  };
  if (std::error_code none; !std::filesystem::is_regular_file(library_.file, none))
    cannot(fmt::format("there is no {}; it was made for another machine, or is not built yet",
                       io::displayName(library_.file)));
  Fd shared, end;
  shared.fd = ::memfd_create("argil-plugin", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  // Sealed: memory that the other side made shorter would end us.
  if (shared.fd < 0 || ::ftruncate(shared.fd, off_t(plugin::kChannelBytes)) != 0 ||
      ::fcntl(shared.fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0)
    cannot(fmt::format("no memory can be shared with it ({})", std::strerror(errno)));
  void* mapped = ::mmap(nullptr, plugin::kChannelBytes, PROT_READ | PROT_WRITE, MAP_SHARED, shared.fd, 0);
  if (mapped == MAP_FAILED) cannot(fmt::format("no memory can be shared with it ({})", std::strerror(errno)));
  memory_.reset(mapped);
  auto* channel = ::new (mapped) Channel{};
  channel->magic = plugin::kChannelMagic;
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) cannot(std::strerror(errno));
  end.fd = ends[0];
  life_.fd = ends[1];
  try {
    const std::array<io::ChildProcess::File, 2> files{{{end.fd, plugin::kLifeFd}, {shared.fd, plugin::kChannelFd}}};
    std::vector<std::string> arguments{library_.file.string(), library_.folder.string(), std::to_string(threads_),
                                       std::to_string(limits_.memoryBytes)};
    arguments.insert(arguments.end(), library_.nodes.begin(), library_.nodes.end());
    process_ = std::make_unique<io::ChildProcess>(pluginProgram(), arguments, files);
  } catch (const Error& error) {
    cannot(error.what());
  }
  waitFor(0, limits_.startS, limits_.silentS);
  switch (channel->refusal) {
    case plugin::Refusal::none:
      break;
    case plugin::Refusal::cannotLoad:
      this->end(PluginFault::cannotLoad, fmt::format("cannot be loaded: {}", sentence()));
    case plugin::Refusal::initFailed:
      this->end(PluginFault::failed, fmt::format("could not begin: {}", sentence()));
    default:
      this->end(PluginFault::noEntry, fmt::format("is no plugin that this Argil can use: {}", sentence()));
  }
  if (const std::string id = textOf(channel->id); id != library_.id)
    this->end(PluginFault::notAsSaid, fmt::format("calls itself {}, and plugin.json calls it {}", id, library_.id));
  if (const std::string version = textOf(channel->version); version != library_.version)
    this->end(PluginFault::notAsSaid, fmt::format("is version {}, and plugin.json says {}", version, library_.version));
}

void PluginProcess::name(plugin::ThingKind kind, const std::string& thing) {
  Channel& shared = channel();
  shared.kind = kind;
  const size_t n = std::min(thing.size(), sizeof shared.thing - 1);
  std::memcpy(shared.thing, thing.data(), n);
  shared.thing[n] = '\0';
}

void PluginProcess::ask() {
  Channel& shared = channel();
  shared.asked.fetch_add(1);
  plugin::wakeAll(shared.asked);
}

void PluginProcess::begin(plugin::Command command) {
  if (ended_) throw PluginError(*ended_);
  channel().command = command;
  before_ = channel().answered.load();
  ask();
}

void PluginProcess::finish() {
  if (ended_) throw PluginError(*ended_);
  waitFor(before_, limits_.callS * threads_, limits_.silentS);
  requireDone();
}

void PluginProcess::run(plugin::Command command, const std::function<uint64_t(plugin::Upcall)>& serve, Job* job,
                        double share) {
  if (ended_) throw PluginError(*ended_);
  Channel& shared = channel();
  shared.command = command;
  shared.cancel.store(0);
  shared.progressBits.store(0);
  for (;;) {
    const uint32_t before = shared.answered.load();
    ask();
    try {
      waitFor(before, HUGE_VAL, limits_.workS, job, share);
    } catch (const Cancelled&) {
      stop(before);
      throw;
    }
    if (shared.status != plugin::kAsking) break;
    try {
      shared.result = serve(shared.upcall);
    } catch (...) {
      shared.result = 0;
      const uint32_t asked = shared.answered.load();
      ask();
      stop(asked);
      throw;
    }
  }
  requireDone();
}

// It is told to stop and has 100 ms to; whatever it asks for until then it does not get.
void PluginProcess::stop(uint32_t before) {
  constexpr auto kPatience = std::chrono::milliseconds(100);
  Channel& shared = channel();
  shared.cancel.store(1);
  const Clock::time_point until = Clock::now() + kPatience;
  while (Clock::now() < until && !process_->ended()) {
    if (const uint32_t now = shared.answered.load(); now != before) {
      if (shared.status != plugin::kAsking) return;
      before = now;
      shared.result = 0;
      ask();
    }
    plugin::sleepWhile(shared.answered, before, kLookNs);
  }
  process_->kill();
  (void)process_->wait();
  ended_ =
      std::make_unique<PluginError>(PluginFault::hung, fmt::format("{} did not stop and was stopped", library_.name));
}

void PluginProcess::requireDone() {
  Channel& shared = channel();
  const argil_status status = shared.status;
  if (status == ARGIL_OK) return;
  if (shared.refusal == plugin::Refusal::unknownThing)
    throw PluginError(PluginFault::notAsSaid,
                      fmt::format("{} has no {}, though plugin.json says so", library_.name, textOf(shared.thing)));
  if (status == ARGIL_NO_MEMORY)
    throw PluginError(PluginFault::memory, fmt::format("{} needs more than the {} MiB of memory that it may have",
                                                       library_.name, limits_.memoryBytes >> 20));
  const std::string why = sentence();
  throw PluginError(PluginFault::failed,
                    fmt::format("{} failed{}", library_.name, why.empty() ? ", and does not say why" : ": " + why));
}

// A process that computes may take its processor time, however busy the machine is; one that sleeps has stopped
// working. One that naps is found ready now and then, the more often the busier the machine is: so what it slept is
// added up, and only what it computed makes up for that.
void PluginProcess::waitFor(uint32_t before, double most, double silentS, Job* job, double share) {
  Channel& shared = channel();
  if (plugin::changesSoon(shared.answered, before, kSoonNs)) return;
  plugin::sleepWhile(shared.answered, before, kLookNs);
  if (shared.answered.load() != before) return;
  const double began = processorSeconds(pid());
  Clock::time_point lastLook = Clock::now();
  double sleptS = 0;
  for (;;) {
    if (const auto status = process_->ended()) {
      if (shared.answered.load() != before && shared.refusal != plugin::Refusal::none) return;
      failEnd(*status);
    }
    if (job) {
      const auto done = std::bit_cast<double>(shared.progressBits.load());
      job->step(share * (done >= 0 && done <= 1 ? done : 0));
    }
    plugin::sleepWhile(shared.answered, before, kLookNs);
    if (shared.answered.load() != before) return;
    const Clock::time_point now = Clock::now();
    const double computedS = processorSeconds(pid()) - began;
    if (computedS > most)
      end(PluginFault::hung, fmt::format("computed for more than {:.2g} s without an answer and was stopped", most));
    // When nobody looked for long, all that is known is that it sleeps now.
    if (!computes(pid())) sleptS += std::min(seconds(now - lastLook), kLongestLookS);
    lastLook = now;
    if (sleptS > silentS + kMakesUp * computedS)
      end(PluginFault::hung, fmt::format("did not answer for {:.2g} s and was stopped", silentS));
  }
}

void PluginProcess::end(PluginFault fault, const std::string& what) {
  process_->kill();
  (void)process_->wait();
  ended_ = std::make_unique<PluginError>(fault, fmt::format("{} {}", library_.name, what));
  throw PluginError(*ended_);
}

void PluginProcess::failEnd(int status) {
  const auto stage = static_cast<plugin::Stage>(channel().stage.load());
  const char* when = stage == plugin::Stage::loading    ? " while it was loaded"
                     : stage == plugin::Stage::entering ? " while it began"
                     : stage != plugin::Stage::ready    ? " before it was loaded"
                                                        : "";
  end(PluginFault::crashed, WIFSIGNALED(status) ? fmt::format("crashed{} ({})", when, ::strsignal(WTERMSIG(status)))
                                                : fmt::format("ended its process{}", when));
}

bool PluginProcess::alive() {
  return !ended_ && !process_->ended();
}

std::string PluginProcess::textOf(const char (&text)[plugin::kMostText]) {
  char copy[plugin::kMostText];
  std::memcpy(copy, text, sizeof copy);
  std::atomic_signal_fence(std::memory_order_seq_cst);
  std::string line(copy, ::strnlen(copy, sizeof copy));
  for (char& c : line)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return line;
}

std::string PluginProcess::sentence() const {
  return textOf(channel().text);
}

std::string PluginProcess::refusedCall() const {
  const uint32_t refused = channel().refusedCall.load();
  if (refused == 0) return {};
  const std::string call = io::callName(int(refused) - 1);
  const auto is = [&](std::initializer_list<std::string_view> names) {
    return std::find(names.begin(), names.end(), call) != names.end();
  };
  if (is({"fork", "vfork", "clone", "clone3", "execve", "execveat"})) return "start another process";
  if (is({"socket", "socketpair", "connect", "bind", "sendto", "sendmsg"})) return "open a connection";
  if (is({"open",      "openat",    "openat2",  "creat",      "unlink",     "unlinkat", "rename",     "renameat",
          "renameat2", "mkdir",     "mkdirat",  "truncate",   "stat",       "lstat",    "newfstatat", "statx",
          "access",    "faccessat", "readlink", "readlinkat", "getdents64", "getcwd"}))
    return "look at files";
  if (is({"kill", "tkill", "tgkill", "ptrace", "process_vm_readv", "process_vm_writev"}))
    return "reach another process";
  return fmt::format("make the system call {}", call);
}

std::string PluginProcess::unconfined() const {
  switch (channel().unconfined.load() & 3) {
    case 1:
      return "this system cannot keep it from reading your files while it is loaded (it has no Landlock)";
    case 2:
      return "this system cannot confine what it calls (it has no seccomp)";
    case 3:
      return "this system cannot confine it (it has neither seccomp nor Landlock)";
    default:
      return {};
  }
}

}  // namespace argil::engine
