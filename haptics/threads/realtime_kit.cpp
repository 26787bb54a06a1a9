// The few messages of the D-Bus protocol (specification, "Message Protocol", "Authentication Protocol") that
// RealtimeKit needs, in code of our own: a library for it would be one more dependency, and none lets a caller bound
// the time that it takes to connect.

#include "haptics/threads/realtime_kit.h"

#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <string_view>
#include <utility>

#include "haptics/base/clock.h"

namespace argil::haptics {
namespace {

// Of Argil's own priorities, that of a device's thread: it gets the most that is lent.
constexpr int kHighestAsked = 85;
constexpr size_t kMostBytes = 1 << 20;  // Of a message: nobody here sends more than some hundred.
constexpr size_t kHeaderBytes = 16;
constexpr const char* kService = "org.freedesktop.RealtimeKit1";
constexpr const char* kPath = "/org/freedesktop/RealtimeKit1";

enum : uint8_t { kCall = 1, kReturn = 2, kError = 3 };
enum : uint8_t {
  kFieldPath = 1,
  kFieldInterface = 2,
  kFieldMember = 3,
  kFieldReplySerial = 5,
  kFieldDestination = 6,
  kFieldSignature = 8
};

/// Little-endian, each value aligned to its size.
class Writer {
 public:
  void align(size_t to) { bytes.resize((bytes.size() + to - 1) / to * to, '\0'); }
  void u8(uint8_t v) { bytes.push_back(static_cast<char>(v)); }
  void u32(uint32_t v) { number(v, 4); }
  void u64(uint64_t v) { number(v, 8); }
  void text(std::string_view v) {
    u32(static_cast<uint32_t>(v.size()));
    bytes.append(v);
    u8(0);
  }
  void signature(std::string_view v) {
    u8(static_cast<uint8_t>(v.size()));
    bytes.append(v);
    u8(0);
  }
  void field(uint8_t code, std::string_view type, std::string_view value) {
    align(8);
    u8(code);
    signature(type);
    if (type == "g")
      signature(value);
    else
      text(value);
  }
  std::string bytes;

 private:
  void number(uint64_t v, size_t size) {
    align(size);
    for (size_t i = 0; i < size; ++i) u8(static_cast<uint8_t>(v >> (8 * i)));
  }
};

/// Of either byte order; what is not there reads as zero and makes it bad.
class Reader {
 public:
  Reader(std::string_view bytes, bool little) : bytes_(bytes), little_(little) {}
  void align(size_t to) { at_ = (at_ + to - 1) / to * to; }
  uint8_t u8() { return static_cast<uint8_t>(number(1)); }
  uint32_t u32() { return static_cast<uint32_t>(number(4)); }
  uint64_t u64() { return number(8); }
  std::string_view text() { return take(u32()); }
  std::string_view signature() { return take(u8()); }
  [[nodiscard]] bool bad() const { return bad_; }
  [[nodiscard]] bool end() const { return at_ >= bytes_.size(); }

 private:
  uint64_t number(size_t size) {
    align(size);
    if (!has(size)) return 0;
    uint64_t v = 0;
    for (size_t i = 0; i < size; ++i)
      v |= uint64_t{static_cast<uint8_t>(bytes_[at_ + i])} << (8 * (little_ ? i : size - 1 - i));
    at_ += size;
    return v;
  }
  // And the zero behind it.
  std::string_view take(size_t size) {
    if (!has(size + 1)) return {};
    const std::string_view v = bytes_.substr(at_, size);
    at_ += size + 1;
    return v;
  }
  bool has(size_t size) {
    bad_ = bad_ || at_ > bytes_.size() || size > bytes_.size() - at_;
    return !bad_;
  }
  std::string_view bytes_;
  size_t at_ = 0;
  bool little_, bad_ = false;
};

struct Trouble {
  std::string why;
  bool silent = false;
};

struct Reply {
  std::string body;
  bool little = true;
};

/// One connection; every wait ends at the deadline. Throws Trouble.
class Bus {
 public:
  explicit Bus(int64_t deadlineNs) : deadlineNs_(deadlineNs) {}
  ~Bus() {
    if (fd_ >= 0) close(fd_);
  }
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  /// A list of addresses; the first that lets in.
  void connectTo(std::string_view addresses) {
    while (!addresses.empty()) {
      const size_t end = std::min(addresses.find(';'), addresses.size());
      if (tryConnect(addresses.substr(0, end))) return;
      addresses.remove_prefix(std::min(end + 1, addresses.size()));
    }
    throw Trouble{"no system bus"};
  }

  void greet() {
    std::string hex;
    for (const char c : std::to_string(getuid())) {
      hex += "0123456789abcdef"[c >> 4];
      hex += "0123456789abcdef"[c & 15];
    }
    sendAll(std::string("\0AUTH EXTERNAL ", 15) + hex + "\r\n");
    std::string line;
    while (!line.ends_with("\r\n")) {
      if (line.size() > 512) throw Trouble{"the bus does not speak D-Bus"};
      line += receive(1);
    }
    if (!line.starts_with("OK ")) throw Trouble{"the bus lets nobody in"};
    sendAll("BEGIN\r\n");
    (void)call("org.freedesktop.DBus", "/org/freedesktop/DBus", "org.freedesktop.DBus", "Hello", "", {});
  }

  Reply call(const char* destination, const char* path, const char* interface, const char* member,
             const char* signature, const Writer& body) {
    Writer out;
    const uint32_t serial = ++serial_;
    for (const uint8_t b : {uint8_t{'l'}, uint8_t{kCall}, uint8_t{0}, uint8_t{1}}) out.u8(b);
    out.u32(static_cast<uint32_t>(body.bytes.size()));
    out.u32(serial);
    out.u32(0);  // Length of the fields, below.
    out.field(kFieldPath, "o", path);
    out.field(kFieldInterface, "s", interface);
    out.field(kFieldMember, "s", member);
    out.field(kFieldDestination, "s", destination);
    if (*signature) out.field(kFieldSignature, "g", signature);
    Writer length;
    length.u32(static_cast<uint32_t>(out.bytes.size() - kHeaderBytes));
    out.bytes.replace(12, 4, length.bytes);
    out.align(8);
    sendAll(out.bytes + body.bytes);
    return replyTo(serial);
  }

 private:
  bool tryConnect(std::string_view address) {
    if (!address.starts_with("unix:")) return false;
    address.remove_prefix(5);
    sockaddr_un to{};
    to.sun_family = AF_UNIX;
    while (!address.empty()) {
      const size_t end = std::min(address.find(','), address.size());
      const std::string_view pair = address.substr(0, end);
      address.remove_prefix(std::min(end + 1, address.size()));
      const bool path = pair.starts_with("path="), abstract = pair.starts_with("abstract=");
      if (!path && !abstract) continue;
      const std::string name = unescaped(pair.substr(pair.find('=') + 1));
      if (name.size() + 2 > sizeof to.sun_path) return false;
      std::memcpy(to.sun_path + (abstract ? 1 : 0), name.data(), name.size());
      const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size() + 1);
      fd_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
      if (fd_ >= 0 && connect(fd_, reinterpret_cast<const sockaddr*>(&to), size) == 0) return true;
      if (fd_ >= 0) close(fd_);
      fd_ = -1;
      return false;
    }
    return false;
  }

  static std::string unescaped(std::string_view from) {
    std::string to;
    for (size_t i = 0; i < from.size(); ++i) {
      if (from[i] == '%' && i + 2 < from.size()) {
        to += static_cast<char>(std::strtol(std::string(from.substr(i + 1, 2)).c_str(), nullptr, 16));
        i += 2;
      } else {
        to += from[i];
      }
    }
    return to;
  }

  void await(short what) {
    const int64_t left = deadlineNs_ - nowNs();
    pollfd wait{fd_, what, 0};
    const int ready = left > 0 ? poll(&wait, 1, static_cast<int>(left / 1'000'000 + 1)) : 0;
    if (ready == 0) throw Trouble{"no answer in time", true};
    if (ready < 0 && errno != EINTR) throw Trouble{std::strerror(errno)};
  }

  void sendAll(std::string_view bytes) {
    while (!bytes.empty()) {
      await(POLLOUT);
      const ssize_t sent = send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent < 0 && errno != EAGAIN && errno != EINTR) throw Trouble{"the bus hung up"};
      if (sent > 0) bytes.remove_prefix(static_cast<size_t>(sent));
    }
  }

  std::string receive(size_t size) {
    std::string bytes(size, '\0');
    for (size_t got = 0; got < size;) {
      await(POLLIN);
      const ssize_t more = recv(fd_, bytes.data() + got, size - got, 0);
      if (more == 0 || (more < 0 && errno != EAGAIN && errno != EINTR)) throw Trouble{"the bus hung up"};
      if (more > 0) got += static_cast<size_t>(more);
    }
    return bytes;
  }

  // Signals and whatever else comes before it are passed over.
  Reply replyTo(uint32_t serial) {
    for (;;) {
      const std::string header = receive(kHeaderBytes);
      const bool little = header[0] == 'l';
      if (!little && header[0] != 'B') throw Trouble{"the bus does not speak D-Bus"};
      const auto kind = static_cast<uint8_t>(header[1]);
      Reader in(header, little);
      (void)in.u32();
      const size_t bodyBytes = in.u32();
      (void)in.u32();
      const size_t fieldBytes = in.u32();
      if (bodyBytes > kMostBytes || fieldBytes > kMostBytes) throw Trouble{"a message too long"};
      const std::string fields = receive((fieldBytes + 7) / 8 * 8);
      Reply reply{receive(bodyBytes), little};
      if ((kind != kReturn && kind != kError) ||
          replySerial(std::string_view(fields).substr(0, fieldBytes), little) != serial)
        continue;
      if (kind == kError) throw Trouble{"refused"};
      return reply;
    }
  }

  static uint32_t replySerial(std::string_view fields, bool little) {
    Reader in(fields, little);
    while (!in.end() && !in.bad()) {
      in.align(8);
      const uint8_t code = in.u8();
      const std::string_view type = in.signature();
      if (type == "u") {
        const uint32_t value = in.u32();
        if (code == kFieldReplySerial && !in.bad()) return value;
      } else if (type == "g") {
        (void)in.signature();
      } else if (type == "s" || type == "o") {
        (void)in.text();
      } else {
        break;
      }
    }
    return 0;
  }

  int64_t deadlineNs_;
  int fd_ = -1;
  uint32_t serial_ = 0;
};

int64_t property(Bus& bus, const char* name) {
  Writer body;
  body.text(kService);
  body.align(4);
  body.text(name);
  const Reply reply = bus.call(kService, kPath, "org.freedesktop.DBus.Properties", "Get", "ss", body);
  Reader in(reply.body, reply.little);
  const std::string_view type = in.signature();
  int64_t value = 0;
  if (type == "i")
    value = static_cast<int32_t>(in.u32());
  else if (type == "u")
    value = in.u32();
  else if (type == "x" || type == "t")
    value = static_cast<int64_t>(in.u64());
  if (in.bad() || value <= 0) throw Trouble{std::string(name) + " is no number"};
  return value;
}

// The service lends nothing to a process that could keep a core for ever.
void limitRealtime(int64_t mostUs) {
  rlimit limit{};
  if (getrlimit(RLIMIT_RTTIME, &limit) != 0) throw Trouble{std::strerror(errno)};
  const rlim_t most = std::min<rlim_t>(limit.rlim_max, static_cast<rlim_t>(mostUs));
  if (limit.rlim_max == most && limit.rlim_cur <= most) return;
  limit = {std::min(limit.rlim_cur, most), most};
  if (setrlimit(RLIMIT_RTTIME, &limit) != 0) throw Trouble{std::strerror(errno)};
}

}  // namespace

std::string systemBus() {
  const char* given = std::getenv("DBUS_SYSTEM_BUS_ADDRESS");
  return given && *given ? given : "unix:path=/run/dbus/system_bus_socket;unix:path=/var/run/dbus/system_bus_socket";
}

RealtimeKitAnswer askRealtimeKit(const std::string& address, pid_t thread, int priority, double seconds) noexcept {
  RealtimeKitAnswer answer;
  try {
    Bus bus(nowNs() + static_cast<int64_t>(seconds * 1e9));
    bus.connectTo(address);
    bus.greet();
    const auto most = static_cast<int>(std::min<int64_t>(property(bus, "MaxRealtimePriority"), 99));
    limitRealtime(property(bus, "RTTimeUSecMax"));
    answer.priority = std::clamp(most - (kHighestAsked - priority), 1, most);
    Writer body;
    body.u64(static_cast<uint64_t>(thread));
    body.u32(static_cast<uint32_t>(answer.priority));
    (void)bus.call(kService, kPath, kService, "MakeThreadRealtime", "tu", body);
    answer.granted = true;
  } catch (const Trouble& trouble) {
    answer.silent = trouble.silent;
    answer.why = trouble.why;
  } catch (const std::exception& e) {
    answer.why = e.what();
  }
  return answer;
}

}  // namespace argil::haptics
