#include "emulated_usb.h"

#include <fmt/format.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <umockdev.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <list>
#include <mutex>
#include <stdexcept>

#include "haptics/base/clock.h"

namespace argil::haptics::testing {
namespace {

// As an FTDI chip describes itself: one vendor interface, bulk IN 0x81 and OUT 0x02 of 64 bytes, under the Falcon's
// numbers.
constexpr const char* kDescriptors =
    "12010002000000080304"
    "48cb"
    "0004"
    "000000"
    "01"
    "0902200001010080"
    "2d"
    "0904000002ffffff00"
    "07058102400000"
    "07050202400000";
constexpr uint8_t kIn = 0x81, kOut = 0x02;

struct Urb {
  UMockdevIoctlData* data;
  UMockdevIoctlData* buffer;
  [[nodiscard]] usbdevfs_urb& head() const { return *reinterpret_cast<usbdevfs_urb*>(data->data); }
};

/// What is in one socket, from plug to unplug; kept afterwards for programs that still hold it open.
struct Plugged {
  FalconEmulator* emulator;
  std::string port, node, sys;
  UMockdevIoctlBase* handler;
  std::mutex mutex;
  bool gone = false;
  const UMockdevIoctlClient* claimedBy = nullptr;
  std::list<Urb> flying, done;

  void finish(std::list<Urb>::iterator urb, int status, size_t length) {
    urb->head().status = status;
    urb->head().actual_length = int(length);
    done.splice(done.end(), flying, urb);
  }
  void begin(std::list<Urb>::iterator urb) {
    const auto& head = urb->head();
    const std::span<const uint8_t> bytes(urb->buffer->data, size_t(head.buffer_length));
    if (head.type == USBDEVFS_URB_TYPE_CONTROL) {
      const bool vendor = bytes.size() >= 8 && bytes[0] == 0x40;
      if (vendor) emulator->control(bytes[1], uint16_t(bytes[2] | bytes[3] << 8));
      return finish(urb, vendor ? 0 : -EPIPE, 0);
    }
    if (head.endpoint == kOut) {
      const bool taken = emulator->out(bytes);
      return finish(urb, taken ? 0 : -EPIPE, taken ? bytes.size() : 0);
    }
    if (head.endpoint != kIn) finish(urb, -EPIPE, 0);
  }
  /// Answers that are due go to the reads that wait, first come, first served.
  void listen() {
    for (auto urb = flying.begin(); urb != flying.end();) {
      const auto next = std::next(urb);
      std::array<uint8_t, 64> packet;
      const size_t length = emulator->in(packet, nowNs());
      if (length == 0) return;
      const size_t taken = std::min(length, size_t(urb->head().buffer_length));
      std::memcpy(urb->buffer->data, packet.data(), taken);
      finish(urb, 0, taken);
      urb = next;
    }
  }

  /// On umockdev's thread. What a kernel would do; `complete` takes the result and errno.
  template <class Complete>
  void handle(gulong request, UMockdevIoctlData* argument, const UMockdevIoctlClient* client, Complete&& complete) {
    const std::scoped_lock lock(mutex);
    const bool reaps = request == USBDEVFS_REAPURB || request == USBDEVFS_REAPURBNDELAY;
    if (gone && !(reaps && !done.empty())) return complete(-1, ENODEV);
    switch (request) {
      case USBDEVFS_GET_CAPABILITIES: {
        UMockdevIoctlData* flags = umockdev_ioctl_data_resolve(argument, 0, sizeof(uint32_t), nullptr);
        const uint32_t value = USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_NO_PACKET_SIZE_LIM;
        std::memcpy(flags->data, &value, sizeof value);
        g_object_unref(flags);
        return complete(0, 0);
      }
      case USBDEVFS_CLAIMINTERFACE:
      case USBDEVFS_DISCONNECT_CLAIM:
        if (claimedBy && claimedBy != client) return complete(-1, EBUSY);
        claimedBy = client;
        return complete(0, 0);
      case USBDEVFS_RELEASEINTERFACE:
        if (claimedBy == client) claimedBy = nullptr;
        return complete(0, 0);
      case USBDEVFS_GETDRIVER:
        return complete(-1, ENODATA);
      case USBDEVFS_CLEAR_HALT:
      case USBDEVFS_RESET:
        return complete(0, 0);
      case USBDEVFS_SUBMITURB: {
        Urb urb{umockdev_ioctl_data_resolve(argument, 0, sizeof(usbdevfs_urb), nullptr), nullptr};
        urb.buffer = umockdev_ioctl_data_resolve(urb.data, offsetof(usbdevfs_urb, buffer),
                                                 gsize(urb.head().buffer_length), nullptr);
        begin(flying.insert(flying.end(), urb));
        return complete(0, 0);
      }
      case USBDEVFS_REAPURB:
      case USBDEVFS_REAPURBNDELAY: {
        if (!gone) listen();
        if (done.empty()) return complete(-1, EAGAIN);
        const Urb urb = done.front();
        done.pop_front();
        UMockdevIoctlData* pointer = umockdev_ioctl_data_resolve(argument, 0, sizeof(void*), nullptr);
        umockdev_ioctl_data_set_ptr(pointer, 0, urb.data);
        complete(0, 0);
        for (UMockdevIoctlData* data : {pointer, urb.buffer, urb.data}) g_object_unref(data);
        return;
      }
      case USBDEVFS_DISCARDURB: {
        const auto address = *reinterpret_cast<const gulong*>(argument->data);
        const auto urb =
            std::find_if(flying.begin(), flying.end(), [&](const Urb& u) { return u.data->client_addr == address; });
        if (urb == flying.end()) return complete(-1, EINVAL);
        finish(urb, -ENOENT, 0);
        return complete(0, 0);
      }
      default:
        return complete(-1, ENOTTY);
    }
  }
};

gboolean onIoctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer user) {
  static_cast<Plugged*>(user)->handle(
      umockdev_ioctl_client_get_request(client), umockdev_ioctl_client_get_arg(client), client,
      [&](int result, int error) { umockdev_ioctl_client_complete(client, result, error); });
  return TRUE;
}

void require(bool done, const char* what) {
  if (!done) throw std::runtime_error(std::string("emulated USB: ") + what);
}

}  // namespace

struct EmulatedUsb::Bus {
  UMockdevTestbed* testbed = umockdev_testbed_new();
  std::list<Plugged> sockets;
  int nextAddress = 2;
};

EmulatedUsb::EmulatedUsb() {
  const char* preloaded = std::getenv("LD_PRELOAD");
  require(preloaded && std::strstr(preloaded, "umockdev"), "start this program under umockdev-wrapper");
  bus_ = std::make_unique<Bus>();
}

EmulatedUsb::~EmulatedUsb() {
  for (Plugged& one : bus_->sockets) {
    umockdev_testbed_detach_ioctl(bus_->testbed, one.node.c_str(), nullptr);
    g_object_unref(one.handler);
    for (const std::list<Urb>* urbs : {&one.flying, &one.done})
      for (const Urb& urb : *urbs) {
        g_object_unref(urb.buffer);
        g_object_unref(urb.data);
      }
  }
  g_object_unref(bus_->testbed);
}

void EmulatedUsb::plug(FalconEmulator& emulator, const std::string& port) {
  Plugged& one = bus_->sockets.emplace_back();
  const int address = bus_->nextAddress++;
  one.emulator = &emulator;
  one.port = port;
  one.node = fmt::format("/dev/bus/usb/001/{:03}", address);
  one.sys = "/sys/devices/usb1/1-" + port;
  one.handler = umockdev_ioctl_base_new();
  g_signal_connect(one.handler, "handle-ioctl", G_CALLBACK(onIoctl), &one);
  emulator.replug();
  require(umockdev_testbed_attach_ioctl(bus_->testbed, one.node.c_str(), one.handler, nullptr), "no ioctl handler");
  const std::string text = fmt::format(
      "P: /devices/usb1/1-{0}\nN: bus/usb/001/{1:03}\nE: SUBSYSTEM=usb\nE: DRIVER=usb\nE: BUSNUM=001\nE: "
      "DEVNUM={1:03}\n"
      "E: DEVNAME=/dev/bus/usb/001/{1:03}\nE: DEVTYPE=usb_device\nA: busnum=1\\n\nA: devnum={1}\\n\nA: "
      "bConfigurationValue=1\\n\n"
      "A: speed=12\\n\nH: descriptors={2}\n",
      port, address, kDescriptors);
  require(umockdev_testbed_add_from_string(bus_->testbed, text.c_str(), nullptr), "no device");
  // libusb looks when it hears of it, which may be before the files were there.
  umockdev_testbed_uevent(bus_->testbed, one.sys.c_str(), "add");
}

void EmulatedUsb::unplug(const std::string& port) {
  for (Plugged& one : bus_->sockets) {
    if (one.port != port || one.gone) continue;
    {
      const std::scoped_lock lock(one.mutex);
      one.gone = true;
      while (!one.flying.empty()) one.finish(one.flying.begin(), -ESHUTDOWN, 0);
    }
    one.emulator->unplug();
    umockdev_testbed_uevent(bus_->testbed, one.sys.c_str(), "remove");
    umockdev_testbed_remove_device(bus_->testbed, one.sys.c_str());
  }
}

}  // namespace argil::haptics::testing
