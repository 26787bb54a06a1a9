#include "haptics/threads/guard.h"

#include <fcntl.h>
#include <linux/usbdevice_fs.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <mutex>
#include <string>

#include "clay/base/error.h"
#include "haptics/base/clock.h"

namespace argil::haptics {
namespace {

constexpr int kPollMs = 1;   // With devices to look after; without, the guard sleeps.
constexpr int kRepeats = 3;  // Of the zero packet once Argil is gone: one may meet the tail of a broken one.
constexpr int kRepeatMs = 2;
// A device that takes nothing when Argil is gone is tried for so long.
constexpr int64_t kLastTriesNs = 1'000'000'000;
// Of a call that reached no device: Argil's files may be closed a moment after its socket.
constexpr int kCallRepeats = 5;
// A guard that does not answer for so long is not there. It is there on a machine that has much else to do, and a
// device that is opened can wait: unguarded it would be for as long as it is used.
constexpr int kAnswerMs = 3000;
constexpr int kPriority = 85;  // Above the servo, where the system grants it.
constexpr unsigned kUsbTimeoutMs = 5;

/// What both processes see.
struct Shared {
  std::array<std::atomic<int64_t>, Guard::kMaxDevices> beatNs{};  // 0: at rest.
};
static_assert(std::atomic<int64_t>::is_always_lock_free, "shared between processes");

struct Message {
  enum class Kind : uint8_t { add, addCall, remove } kind = Kind::add;
  Guard::Transport transport = Guard::Transport::write;
  uint8_t endpoint = 0;
  uint8_t slot = 0;
  uint8_t size = 0;
  uint32_t number = 0;  // what the guard answers, so that a late answer is not taken for another's
  std::array<std::byte, Guard::kMaxZeroBytes> zero{};
  // The guard is a fork of the same program: the same address is the same function.
  int (*call)() noexcept = nullptr;
};

// ---- The guard's process: no allocation, no exception, plain system calls; but for the calls at its end.

struct Guarded {
  int fd = -1;
  bool zeroed = false;
  Message message;
};

// False when the device takes nothing at the moment: it may in the next.
bool sendZero(const Guarded& device) {
  const Message& m = device.message;
  if (m.transport == Guard::Transport::usbBulk) {
    std::array<std::byte, Guard::kMaxZeroBytes> bytes = m.zero;
    usbdevfs_bulktransfer transfer{};
    transfer.ep = m.endpoint;
    transfer.len = m.size;
    transfer.timeout = kUsbTimeoutMs;
    transfer.data = bytes.data();
    return ioctl(device.fd, USBDEVFS_BULK, &transfer) >= 0 || (errno != ETIMEDOUT && errno != EINTR);
  }
  // A device that takes nothing must not keep the others from their zero.
  pollfd room{device.fd, POLLOUT, 0};
  if (poll(&room, 1, kPollMs) != 1) return false;
  if (room.revents & POLLOUT) (void)!write(device.fd, m.zero.data(), m.size);
  return true;
}

bool receive(int socket, std::array<Guarded, Guard::kMaxDevices>& devices) {
  Message message;
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  iovec part{&message, sizeof message};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  header.msg_control = control.data();
  header.msg_controllen = control.size();
  const ssize_t got = recvmsg(socket, &header, MSG_CMSG_CLOEXEC);
  if (got < 0 && errno == EINTR) return true;
  if (got != static_cast<ssize_t>(sizeof message) || message.slot >= devices.size()) return false;
  Guarded& device = devices[message.slot];
  if (device.fd >= 0) close(device.fd);
  device = Guarded();
  if (message.kind == Message::Kind::addCall) device.message = message;
  if (message.kind == Message::Kind::add) {
    const cmsghdr* c = CMSG_FIRSTHDR(&header);
    if (c && c->cmsg_type == SCM_RIGHTS) std::memcpy(&device.fd, CMSG_DATA(c), sizeof(int));
    device.message = message;
  }
  return send(socket, &message.number, sizeof message.number, MSG_NOSIGNAL) == sizeof message.number;
}

[[noreturn]] void guardLoop(int socket, const Shared& shared) {
  std::array<Guarded, Guard::kMaxDevices> devices;
  for (bool alive = true; alive;) {
    bool any = false;
    const int64_t now = nowNs();
    for (size_t i = 0; i < devices.size(); ++i) {
      Guarded& device = devices[i];
      if (device.fd < 0) continue;
      any = true;
      const int64_t beat = shared.beatNs[i].load(std::memory_order_relaxed);
      const bool silent = beat != 0 && double(now - beat) * 1e-9 > kGuardSilenceSeconds;
      device.zeroed = silent && (device.zeroed || sendZero(device));
    }
    pollfd wait{socket, POLLIN, 0};
    if (poll(&wait, 1, any ? kPollMs : -1) > 0) alive = receive(socket, devices);
  }
  std::array<int, Guard::kMaxDevices> left{};
  for (size_t i = 0; i < devices.size(); ++i) left[i] = devices[i].fd >= 0 ? kRepeats : 0;
  const int64_t until = nowNs() + kLastTriesNs;
  for (bool some = true; some && nowNs() < until;) {
    some = false;
    for (size_t i = 0; i < devices.size(); ++i) {
      if (left[i] > 0 && sendZero(devices[i])) --left[i];
      some = some || left[i] > 0;
    }
    if (some) (void)poll(nullptr, 0, kRepeatMs);
  }
  for (const Guarded& device : devices) {
    if (!device.message.call) continue;
    for (int repeat = 0; repeat < kCallRepeats && device.message.call() == 0; ++repeat)
      (void)poll(nullptr, 0, kRepeatMs);
  }
  _exit(0);
}

[[noreturn]] void becomeGuard(int socket, const Shared& shared) {
  (void)prctl(PR_SET_NAME, "argil-guard");
  // Out of Argil's process group and deaf to the terminal: Ctrl-C or a kill of the group is for Argil, and then for the
  // guard to clean up.
  (void)setsid();
  for (int s : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGUSR1, SIGUSR2, SIGALRM, SIGTSTP})
    (void)std::signal(s, SIG_IGN);
  sigset_t none;
  sigemptyset(&none);
  (void)sigprocmask(SIG_SETMASK, &none, nullptr);
  // Nothing of Argil's is held open, its output pipes least of all.
  const int null = open("/dev/null", O_RDWR);
  for (int fd : {0, 1, 2}) (void)dup2(null, fd);
  constexpr int kSocket = 3;
  if (socket != kSocket) (void)dup2(socket, kSocket);
  (void)close_range(kSocket + 1, ~0u, 0);
  (void)!chdir("/");
  sched_param parameter{};
  parameter.sched_priority = kPriority;
  (void)sched_setscheduler(0, SCHED_FIFO, &parameter);
  guardLoop(kSocket, shared);
}

// ---- Argil's process.

struct Link {
  std::mutex mutex;
  int socket = -1;
  std::array<bool, Guard::kMaxDevices> used{};
  uint32_t sent = 0;
  // The message that ends what the guard may hold in a slot, where it has not answered it yet; 0: none.
  std::array<uint32_t, Guard::kMaxDevices> ends{};

  void take(uint32_t answer) {
    for (uint32_t& each : ends)
      if (each <= answer) each = 0;
  }
};

Link& theLink() {
  static Link link;
  return link;
}
std::atomic<Shared*> theShared{nullptr};

Error system(const char* what) {
  return Error(std::string("guard process: ") + what + " (" + std::strerror(errno) + ")", Error::Kind::work);
}

// Never waits: a guard that takes nothing is none.
bool tell(Link& link, Message& message, int fd = -1) {
  message.number = ++link.sent;
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  iovec part{&message, sizeof message};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  if (fd >= 0) {
    header.msg_control = control.data();
    header.msg_controllen = control.size();
    cmsghdr* c = CMSG_FIRSTHDR(&header);
    c->cmsg_level = SOL_SOCKET;
    c->cmsg_type = SCM_RIGHTS;
    c->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(c), &fd, sizeof(int));
  }
  return sendmsg(link.socket, &header, MSG_NOSIGNAL | MSG_DONTWAIT) == static_cast<ssize_t>(sizeof message);
}

// Takes answers until that to `number` has come (true), none comes for `ms`, or the guard is gone.
bool answered(Link& link, uint32_t number, int ms) {
  const int64_t until = nowNs() + int64_t{ms} * 1'000'000;
  for (;;) {
    pollfd wait{link.socket, POLLIN, 0};
    const int64_t left = (until - nowNs()) / 1'000'000;
    const int ready = poll(&wait, 1, static_cast<int>(std::max<int64_t>(left, 0)));
    if (ready < 0 && errno == EINTR) continue;
    uint32_t answer = 0;
    if (ready != 1 || recv(link.socket, &answer, sizeof answer, MSG_DONTWAIT) != sizeof answer) return false;
    link.take(answer);
    if (answer == number) return true;
  }
}

bool exchange(Link& link, Message& message, int fd = -1) {
  return tell(link, message, fd) && answered(link, message.number, kAnswerMs);
}

// The slot is free once the guard says so, however late.
void remove(Link& link, size_t slot, int ms) {
  Message message;
  message.kind = Message::Kind::remove;
  message.slot = static_cast<uint8_t>(slot);
  if (!tell(link, message)) return;
  link.ends[slot] = message.number;
  (void)answered(link, message.number, ms);
}

int add(Message& message, int fd) noexcept {
  Link& link = theLink();
  const std::lock_guard lock(link.mutex);
  if (link.socket < 0) return Guard::kUnguarded;
  (void)answered(link, 0, 0);  // what came late
  size_t slot = 0;
  while (slot < link.used.size() && (link.used[slot] || link.ends[slot] != 0)) ++slot;
  if (slot == link.used.size()) return Guard::kUnguarded;
  message.slot = static_cast<uint8_t>(slot);
  const int id = static_cast<int>(slot);
  Guard::rest(id);
  if (!exchange(link, message, fd)) {
    remove(link, slot, 0);  // It may be taken yet.
    return Guard::kUnguarded;
  }
  link.used[slot] = true;
  return id;
}

}  // namespace

Guard::Guard() {
  Link& link = theLink();
  if (link.socket >= 0) throw Error("guard process: there is one already", Error::Kind::work);
  int pair[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) != 0) throw system("no socket to it");
  void* memory = mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) {
    close(pair[0]);
    close(pair[1]);
    throw system("no memory to share with it");
  }
  auto* shared = new (memory) Shared;
  child_ = fork();
  if (child_ == 0) {
    close(pair[0]);
    becomeGuard(pair[1], *shared);
  }
  close(pair[1]);
  if (child_ < 0) {
    close(pair[0]);
    munmap(memory, sizeof(Shared));
    return;
  }
  link.socket = pair[0];
  link.used.fill(false);
  link.ends.fill(0);
  theShared.store(shared, std::memory_order_release);
}

Guard::~Guard() {
  if (!running()) return;
  Link& link = theLink();
  const std::lock_guard lock(link.mutex);
  close(link.socket);
  link.socket = -1;
  // Kept mapped: a servo's beat may be on its way.
  theShared.store(nullptr, std::memory_order_release);
  while (waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

int Guard::registerDevice(int fd, std::span<const std::byte> zero, Transport transport, uint8_t endpoint) noexcept {
  if (fcntl(fd, F_GETFD) < 0 || zero.empty() || zero.size() > kMaxZeroBytes) return kUnguarded;
  Message message;
  message.transport = transport;
  message.endpoint = endpoint;
  message.size = static_cast<uint8_t>(zero.size());
  std::memcpy(message.zero.data(), zero.data(), zero.size());
  return add(message, fd);
}

int Guard::registerCall(int (*zero)() noexcept) noexcept {
  if (!zero) return kUnguarded;
  Message message;
  message.kind = Message::Kind::addCall;
  message.call = zero;
  return add(message, -1);
}

void Guard::unregister(int id) noexcept {
  Link& link = theLink();
  const std::lock_guard lock(link.mutex);
  if (link.socket < 0 || id < 0 || static_cast<size_t>(id) >= kMaxDevices || !link.used[static_cast<size_t>(id)])
    return;
  rest(id);
  remove(link, static_cast<size_t>(id), kAnswerMs);
  link.used[static_cast<size_t>(id)] = false;
}

void Guard::beat(int id) ARGIL_REALTIME {
  Shared* shared = theShared.load(std::memory_order_acquire);
  if (shared && id >= 0 && static_cast<size_t>(id) < kMaxDevices)
    shared->beatNs[static_cast<size_t>(id)].store(nowNs(), std::memory_order_relaxed);
}

void Guard::rest(int id) ARGIL_REALTIME {
  Shared* shared = theShared.load(std::memory_order_acquire);
  if (shared && id >= 0 && static_cast<size_t>(id) < kMaxDevices)
    shared->beatNs[static_cast<size_t>(id)].store(0, std::memory_order_relaxed);
}

}  // namespace argil::haptics
