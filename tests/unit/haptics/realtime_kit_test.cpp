// RealtimeKit, against a bus that speaks, stutters, refuses or says nothing at all.

#include "haptics/threads/realtime_kit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <string>
#include <thread>

#include "haptics/threads/realtime_thread.h"

namespace argil::haptics {
namespace {

using ::testing::HasSubstr;

/// One end of a socket that answers as a bus with RealtimeKit behind it, or not.
class FakeBus {
 public:
  enum class Mood { good, silentAtOnce, silentLater, hangsUp, rejects, refuses, garbage, endless, wrongType, split };

  explicit FakeBus(Mood mood)
      : mood_(mood), path_(std::filesystem::temp_directory_path() / ("argil-bus-" + std::to_string(getpid()))) {
    std::filesystem::remove(path_);
    socket_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un at{};
    at.sun_family = AF_UNIX;
    std::strncpy(at.sun_path, path_.c_str(), sizeof at.sun_path - 1);
    if (bind(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0 || listen(socket_, 4) != 0) std::abort();
    std::filesystem::permissions(path_, std::filesystem::perms::all);
    thread_ = std::thread([this] { serve(); });
  }
  ~FakeBus() {
    stop_ = true;
    thread_.join();
    close(socket_);
    std::filesystem::remove(path_);
  }
  std::string address() const { return "unix:path=/nowhere/at/all;unix:guid=00,path=" + path_.string(); }
  std::atomic<uint64_t> thread{0};
  std::atomic<uint32_t> priority{0};
  std::atomic<bool> schedules{false};  // Does what it is asked for, as the service does.

 private:
  static void put(std::string& to, uint64_t v, size_t size) {
    while (to.size() % size) to += '\0';
    for (size_t i = 0; i < size; ++i) to += static_cast<char>(v >> (8 * i));
  }
  static uint64_t get(const std::string& from, size_t at, size_t size) {
    uint64_t v = 0;
    for (size_t i = 0; i < size; ++i) v |= uint64_t{static_cast<uint8_t>(from.at(at + i))} << (8 * i);
    return v;
  }
  static std::string message(uint8_t kind, uint32_t replyTo, const std::string& body) {
    std::string m = {'l', static_cast<char>(kind), 0, 1};
    put(m, body.size(), 4);
    put(m, 77, 4);
    put(m, 0, 4);
    m += std::string("\5\1u\0", 4);  // Reply serial.
    put(m, replyTo, 4);
    while (m.size() % 8) m += '\0';
    m += std::string("\7\1s\0", 4);  // Sender, which nobody needs.
    put(m, 3, 4);
    m += std::string(":.1\0", 4);
    const size_t fields = m.size() - 16;
    for (size_t i = 0; i < 4; ++i) m[12 + i] = static_cast<char>(fields >> (8 * i));
    while (m.size() % 8) m += '\0';
    return m + body;
  }
  bool wait(int fd) const {
    while (!stop_) {
      pollfd ready{fd, POLLIN, 0};
      if (poll(&ready, 1, 5) > 0) return true;
    }
    return false;
  }
  bool receive(int fd, std::string& bytes, size_t size) const {
    while (bytes.size() < size) {
      std::array<char, 512> some;
      if (!wait(fd)) return false;
      const ssize_t got = recv(fd, some.data(), std::min(some.size(), size - bytes.size()), 0);
      if (got <= 0) return false;
      bytes.append(some.data(), size_t(got));
    }
    return true;
  }
  void answer(int fd, const std::string& bytes) const {
    const size_t part = mood_ == Mood::split ? 3 : bytes.size();
    for (size_t at = 0; at < bytes.size(); at += part)
      (void)!send(fd, bytes.data() + at, std::min(part, bytes.size() - at), MSG_NOSIGNAL);
  }
  void serve() {
    while (wait(socket_)) {
      const int fd = accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC);
      if (fd < 0) continue;
      talk(fd);
      close(fd);
    }
  }
  void talk(int fd) {
    if (mood_ == Mood::hangsUp) return;
    std::string line;
    for (std::string one; !line.ends_with("\r\n"); line += one) {
      one.clear();
      if (!receive(fd, one, 1)) return;
    }
    if (!line.starts_with(std::string("\0AUTH EXTERNAL ", 15))) return;
    if (mood_ == Mood::silentAtOnce) return (void)receive(fd, line, 1 << 20);
    answer(fd, mood_ == Mood::rejects ? "REJECTED EXTERNAL\r\n" : "OK 0123\r\n");
    std::string begin;
    if (!receive(fd, begin, 7) || begin != "BEGIN\r\n") return;
    for (;;) {
      std::string in;
      if (!receive(fd, in, 16)) return;
      const size_t fields = (get(in, 12, 4) + 7) / 8 * 8, body = get(in, 4, 4);
      if (!receive(fd, in, 16 + fields + body)) return;
      if (!reply(fd, in, in.substr(16 + fields), static_cast<uint32_t>(get(in, 8, 4))))
        return (void)receive(fd, in, 1 << 20);
    }
  }
  bool reply(int fd, const std::string& in, const std::string& body, uint32_t serial) {
    const auto is = [&](const char* what) { return in.find(what) != std::string::npos; };
    answer(fd, message(4, 0, "a signal that nobody asked for"));
    // An error that says of no call that it answers it: another field stands where the call's number would.
    std::string stray = message(3, serial, "");
    stray[16] = 9;
    answer(fd, stray);
    if (is("Hello")) {
      answer(fd, message(2, serial, std::string("\4\0\0\0:1.7\0", 9)));
      return true;
    }
    if (mood_ == Mood::silentLater) return false;
    if (mood_ == Mood::garbage) return answer(fd, std::string(400, 'x')), false;
    if (mood_ == Mood::endless) {
      for (int i = 0; i < 200'000 && !stop_; ++i) {
        const std::string signal = message(4, 0, "and another");
        if (send(fd, signal.data(), signal.size(), MSG_NOSIGNAL) < 0) break;
      }
      return false;
    }
    std::string out;
    if (is("MaxRealtimePriority")) {
      out = std::string(mood_ == Mood::wrongType ? "\1s\0" : "\1i\0", 3);
      put(out, 20, 4);
    } else if (is("RTTimeUSecMax")) {
      out = std::string("\1x\0", 3);
      put(out, 200'000, 8);
    } else {
      thread = get(body, 0, 8);
      priority = static_cast<uint32_t>(get(body, 8, 4));
      sched_param parameter{};
      parameter.sched_priority = static_cast<int>(priority.load());
      if (schedules &&
          sched_setscheduler(static_cast<pid_t>(thread.load()), SCHED_RR | SCHED_RESET_ON_FORK, &parameter) != 0)
        return answer(fd, message(3, serial, "")), true;
    }
    answer(fd, message(mood_ == Mood::refuses ? 3 : 2, serial, out));
    return true;
  }

  Mood mood_;
  std::filesystem::path path_;
  int socket_ = -1;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// What is asked changes a limit of the process for good, so it is asked in one of its own. Its exit code.
template <class What>
int inAProcess(What what) {
  const pid_t child = fork();
  if (child == 0) _exit(what());
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + status;
}

TEST(RealtimeKit, IsAskedForTheThreadWithinWhatItLends) {
  for (const auto mood : {FakeBus::Mood::good, FakeBus::Mood::split}) {
    FakeBus bus(mood);
    const int priority = inAProcess([&] {
      const RealtimeKitAnswer answer = askRealtimeKit(bus.address(), 4711, 80, 10);
      rlimit limit{};
      getrlimit(RLIMIT_RTTIME, &limit);
      if (limit.rlim_max > 200'000) return 100;
      return answer.granted ? answer.priority : 101;
    });
    EXPECT_EQ(priority, 15) << "five below a device's thread, which has the most";
    EXPECT_EQ(bus.thread, 4711u);
    EXPECT_EQ(bus.priority, 15u);
  }
}

TEST(RealtimeKit, ThatIsNotThereOrTalksNonsenseIsARefusal) {
  EXPECT_FALSE(askRealtimeKit("unix:path=/nowhere/at/all", 1, 80).granted);
  for (const char* address : {"", ";", "unix:", "tcp:host=localhost", "unix:path=", "unix:path=%",
                              "unix:abstract=argil-nobody", "nonsense"}) {
    const RealtimeKitAnswer answer = askRealtimeKit(address, 1, 80);
    EXPECT_FALSE(answer.granted || answer.silent) << address;
    EXPECT_FALSE(answer.why.empty());
  }
  for (const auto mood : {FakeBus::Mood::hangsUp, FakeBus::Mood::rejects, FakeBus::Mood::refuses,
                          FakeBus::Mood::garbage, FakeBus::Mood::wrongType}) {
    FakeBus bus(mood);
    const RealtimeKitAnswer answer = askRealtimeKit(bus.address(), 1, 80, 10);
    EXPECT_FALSE(answer.granted) << int(mood);
    EXPECT_FALSE(answer.silent) << int(mood);
    EXPECT_FALSE(answer.why.empty());
  }
}

TEST(RealtimeKit, ThatDoesNotAnswerIsWaitedForNoLongerThanAsked) {
  for (const auto mood : {FakeBus::Mood::silentAtOnce, FakeBus::Mood::silentLater, FakeBus::Mood::endless}) {
    FakeBus bus(mood);
    const auto begin = std::chrono::steady_clock::now();
    const RealtimeKitAnswer answer = askRealtimeKit(bus.address(), 1, 80, 0.05);
    EXPECT_FALSE(answer.granted);
    EXPECT_TRUE(answer.silent) << int(mood) << ": " << answer.why;
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20))
        << "far below the 200 000 signals of the endless one";
  }
}

TEST(RealtimeKit, IsMissedOnARealBus) {
  const std::string socket =
      (std::filesystem::temp_directory_path() / ("argil-dbus-" + std::to_string(getpid()))).string();
  const pid_t daemon = fork();
  if (daemon == 0) {
    const std::string address = "--address=unix:path=" + socket;
    execlp("dbus-daemon", "dbus-daemon", "--session", "--nofork", "--nopidfile", address.c_str(), nullptr);
    _exit(127);
  }
  RealtimeKitAnswer answer;
  int status = 0;
  bool gone = false;
  while (answer.why.empty() || answer.why == "no system bus") {
    gone = waitpid(daemon, &status, WNOHANG) == daemon;
    if (gone) break;
    answer = askRealtimeKit("unix:path=" + socket, gettid(), 80, 60);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  if (gone) GTEST_SKIP() << "there is no dbus-daemon that runs here";
  kill(daemon, SIGTERM);
  waitpid(daemon, &status, 0);
  EXPECT_EQ(answer.why, "refused") << "it greets, understands what is asked, and knows nobody of that name";
}

TEST(RealtimeKit, LendsToAUserWhomTheSystemRefuses) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can stand for the service";
  FakeBus bus(FakeBus::Mood::good);
  bus.schedules = true;
  const auto asNobody = [&](const std::string& address) {
    return inAProcess([&] {
      if (setgid(65534) != 0 || setuid(65534) != 0) return 50;
      const rlimit none{};
      if (setrlimit(RLIMIT_RTPRIO, &none) != 0) return 51;
      setenv("DBUS_SYSTEM_BUS_ADDRESS", address.c_str(), 1);
      const RealtimeGrant grant = becomeRealtime(85, false);
      const int policy = sched_getscheduler(0) & ~SCHED_RESET_ON_FORK;
      if (grant.fifo != (policy == SCHED_RR)) return 52;
      if (grant.sentence.find(grant.fifo ? "granted by RealtimeKit (SCHED_RR 20)" : "allow it with 'ulimit -r 90'") ==
          std::string::npos)
        return 53;
      return grant.fifo ? 1 : 0;
    });
  };
  const int lent = asNobody(bus.address());
  EXPECT_EQ(asNobody("unix:path=/nowhere/at/all"), 0) << "without the service it is said as before";
  if (lent == 0 && bus.thread != 0) GTEST_SKIP() << "this machine lets not even root schedule another's thread";
  EXPECT_EQ(lent, 1);
}

}  // namespace
}  // namespace argil::haptics
