#include "haptics/devices/usb_transport.h"

#include <fmt/format.h>
#include <libusb.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "clay/base/error.h"
#include "haptics/base/clock.h"

namespace argil::haptics {
namespace {

constexpr uint8_t kOut = kUsbOutEndpoint, kIn = 0x81, kVendorRequest = 0x40;
constexpr int kInterface = 0;
constexpr size_t kPacket = 64;  // A full-speed bulk packet; a longer read would hold status bytes in its midst.
constexpr size_t kReads = 2;    // One is handled while the other listens.
constexpr size_t kRing = 4096;  // Far more than is ever unread: a power of two.
constexpr unsigned kControlMs = 500;
constexpr int64_t kCancelNs = 1'000'000'000;

std::string placeOf(libusb_device* device) {
  std::array<uint8_t, 8> ports;
  const int count = libusb_get_port_numbers(device, ports.data(), int(ports.size()));
  std::string where = fmt::format("{}", libusb_get_bus_number(device));
  for (int i = 0; i < count; ++i) where += fmt::format("{}{}", i == 0 ? '-' : '.', ports[size_t(i)]);
  return where;
}

std::string whyNot(int error) {
  switch (error) {
    case LIBUSB_ERROR_ACCESS:
      return "this user may not open it: copy installer/99-argil.rules to /etc/udev/rules.d, then unplug it and plug "
             "it in again";
    case LIBUSB_ERROR_BUSY:
      return "another program uses it: close that first";
    default:
      return fmt::format("it cannot be opened ({}): unplug it and plug it in again", libusb_error_name(error));
  }
}

libusb_context* makeContext() {
  libusb_context* context = nullptr;
  if (const int error = libusb_init(&context); error != 0)
    throw Error(fmt::format("USB cannot be used here ({})", libusb_error_name(error)), Error::Kind::work);
  libusb_set_option(context, LIBUSB_OPTION_LOG_LEVEL, LIBUSB_LOG_LEVEL_NONE);
  return context;
}

/// Calls `each` with every device of that kind until it returns true.
template <class Each>
void overDevices(libusb_context* context, uint16_t vendor, uint16_t product, Each&& each) {
  libusb_device** list = nullptr;
  const ssize_t count = libusb_get_device_list(context, &list);
  for (ssize_t i = 0; i < count; ++i) {
    libusb_device_descriptor descriptor{};
    if (libusb_get_device_descriptor(list[i], &descriptor) != 0) continue;
    if (descriptor.idVendor == vendor && descriptor.idProduct == product && each(list[i])) break;
  }
  if (count >= 0) libusb_free_device_list(list, 1);
}

}  // namespace

std::vector<UsbPlace> findUsb(uint16_t vendor, uint16_t product) {
  libusb_context* context = makeContext();
  std::vector<UsbPlace> found;
  overDevices(context, vendor, product, [&](libusb_device* device) {
    libusb_device_handle* handle = nullptr;
    const int error = libusb_open(device, &handle);
    if (error == 0) libusb_close(handle);
    found.push_back({placeOf(device), error == 0, error == 0 ? "" : whyNot(error)});
    return false;
  });
  libusb_exit(context);
  return found;
}

struct UsbTransport::Usb {
  struct Listening {
    Usb* usb = nullptr;
    libusb_transfer* transfer = nullptr;
    std::array<uint8_t, kPacket> packet{};
    bool active = false;
  };

  uint16_t vendor, product;
  std::string where, sentence;
  libusb_context* context = nullptr;
  libusb_device_handle* handle = nullptr;
  std::array<Listening, kReads> listening;
  libusb_transfer* sending = nullptr;
  std::array<uint8_t, kPacket> sent{};
  bool sendActive = false, closing = false, gone = false, stalled = false, clearToSend = false;
  std::array<uint8_t, kRing> ring{};
  size_t ringBegin = 0, ringEnd = 0;  // Counts, not indices.

  static void received(libusb_transfer* transfer) noexcept {
    Listening& one = *static_cast<Listening*>(transfer->user_data);
    Usb& usb = *one.usb;
    one.active = false;
    switch (transfer->status) {
      case LIBUSB_TRANSFER_COMPLETED: {
        const auto length = static_cast<size_t>(std::max(0, transfer->actual_length));
        for (const uint8_t byte : withoutModemStatus({one.packet.data(), length}, usb.clearToSend))
          if (usb.ringEnd - usb.ringBegin < kRing) usb.ring[usb.ringEnd++ % kRing] = byte;
        usb.listen(one);
        break;
      }
      case LIBUSB_TRANSFER_OVERFLOW:
        usb.listen(one);
        break;
      case LIBUSB_TRANSFER_STALL:
        usb.stalled = true;
        break;
      case LIBUSB_TRANSFER_CANCELLED:
        break;
      default:
        usb.gone = true;
    }
  }
  static void wentOut(libusb_transfer* transfer) noexcept {
    static_cast<Usb*>(transfer->user_data)->sendActive = false;
  }

  void listen(Listening& one) noexcept {
    if (!handle || gone || closing) return;
    libusb_fill_bulk_transfer(one.transfer, handle, kIn, one.packet.data(), int(kPacket), &received, &one, 0);
    const int error = libusb_submit_transfer(one.transfer);
    one.active = error == 0;
    if (error != 0) gone = true;
  }
  void handleEvents(int64_t ns) noexcept {
    ns = std::max<int64_t>(ns, 0);
    timeval wait{static_cast<time_t>(ns / 1'000'000'000), static_cast<suseconds_t>(ns % 1'000'000'000 / 1000)};
    const int error = libusb_handle_events_timeout_completed(context, &wait, nullptr);
    if (error == LIBUSB_ERROR_NO_DEVICE) gone = true;
  }
  void endStall() noexcept {
    stalled = false;
    if (libusb_clear_halt(handle, kIn) == LIBUSB_ERROR_NO_DEVICE) gone = true;
    for (Listening& one : listening)
      if (!one.active) listen(one);
  }
  [[nodiscard]] bool anyActive() const noexcept {
    return sendActive ||
           std::any_of(listening.begin(), listening.end(), [](const Listening& one) { return one.active; });
  }
};

UsbTransport::UsbTransport(uint16_t vendor, uint16_t product, std::string where) : usb_(std::make_unique<Usb>()) {
  usb_->vendor = vendor;
  usb_->product = product;
  usb_->where = std::move(where);
  usb_->context = makeContext();
  for (Usb::Listening& one : usb_->listening) {
    one.usb = usb_.get();
    one.transfer = libusb_alloc_transfer(0);
  }
  usb_->sending = libusb_alloc_transfer(0);
}

UsbTransport::~UsbTransport() {
  close();
  for (Usb::Listening& one : usb_->listening) libusb_free_transfer(one.transfer);
  libusb_free_transfer(usb_->sending);
  libusb_exit(usb_->context);
}

ByteTransport::Opening UsbTransport::open() {
  Usb& usb = *usb_;
  close();
  usb.sentence = usb.where.empty()
                     ? "not plugged in: connect its USB cable and its power"
                     : fmt::format("not plugged in at USB {}: connect its USB cable there and its power", usb.where);
  Opening result = Opening::absent;
  overDevices(usb.context, usb.vendor, usb.product, [&](libusb_device* device) {
    if (!usb.where.empty() && placeOf(device) != usb.where) return false;
    libusb_device_handle* handle = nullptr;
    int error = libusb_open(device, &handle);
    if (error == 0) {
      // A serial driver of the kernel's may hold the chip; where that cannot be asked the claim tells.
      (void)libusb_set_auto_detach_kernel_driver(handle, 1);
      error = libusb_claim_interface(handle, kInterface);
      if (error != 0) libusb_close(handle);
    }
    if (error == LIBUSB_ERROR_NO_DEVICE) return false;
    if (error != 0) {
      usb.sentence = whyNot(error);
      result = Opening::refused;
      return false;
    }
    usb.handle = handle;
    usb.sentence = "at USB " + placeOf(device);
    return true;
  });
  if (!usb.handle) return result;
  usb.gone = usb.stalled = usb.clearToSend = usb.closing = false;
  usb.ringBegin = usb.ringEnd = 0;
  for (Usb::Listening& one : usb.listening) usb.listen(one);
  if (!usb.gone) return Opening::opened;
  close();
  return Opening::absent;
}

void UsbTransport::close() noexcept {
  Usb& usb = *usb_;
  if (!usb.handle) return;
  usb.closing = true;
  for (Usb::Listening& one : usb.listening)
    if (one.active) libusb_cancel_transfer(one.transfer);
  if (usb.sendActive) libusb_cancel_transfer(usb.sending);
  const int64_t end = nowNs() + kCancelNs;
  while (usb.anyActive() && nowNs() < end) usb.handleEvents(10'000'000);
  libusb_release_interface(usb.handle, kInterface);
  libusb_close(usb.handle);  // Takes what is still in flight off libusb's list.
  usb.handle = nullptr;
  for (Usb::Listening& one : usb.listening) one.active = false;
  usb.sendActive = false;
}

std::string UsbTransport::sentence() const {
  return usb_->sentence;
}

Transfer UsbTransport::control(FtdiRequest request, uint16_t value) {
  Usb& usb = *usb_;
  if (!usb.handle || usb.gone) return Transfer::gone;
  const int result = libusb_control_transfer(usb.handle, kVendorRequest, static_cast<uint8_t>(request), value, 0,
                                             nullptr, 0, kControlMs);
  if (request == FtdiRequest::reset && value == kFtdiPurgeRx) usb.ringBegin = usb.ringEnd;
  switch (result) {
    case LIBUSB_ERROR_TIMEOUT:
      return Transfer::timeout;
    case LIBUSB_ERROR_PIPE:
      return Transfer::stall;
    default:
      break;
  }
  if (result < 0) usb.gone = true;
  return usb.gone ? Transfer::gone : Transfer::ok;
}

Transfer UsbTransport::write(std::span<const uint8_t> bytes, int64_t timeoutNs) {
  Usb& usb = *usb_;
  if (!usb.handle || usb.gone) return Transfer::gone;
  const size_t size = std::min(bytes.size(), kPacket);
  std::memcpy(usb.sent.data(), bytes.data(), size);
  libusb_fill_bulk_transfer(usb.sending, usb.handle, kOut, usb.sent.data(), int(size), &Usb::wentOut, &usb, 0);
  if (libusb_submit_transfer(usb.sending) != 0) {
    usb.gone = true;
    return Transfer::gone;
  }
  usb.sendActive = true;
  const int64_t end = nowNs() + timeoutNs;
  for (int64_t left = timeoutNs; usb.sendActive && left > 0; left = end - nowNs()) usb.handleEvents(left);
  if (usb.sendActive) {
    libusb_cancel_transfer(usb.sending);
    const int64_t limit = nowNs() + kCancelNs;
    while (usb.sendActive && nowNs() < limit) usb.handleEvents(10'000'000);
    if (usb.sendActive) usb.gone = true;  // A bus that does not even give it back.
  }
  if (usb.gone) return Transfer::gone;
  switch (usb.sending->status) {
    case LIBUSB_TRANSFER_COMPLETED:
      return size_t(usb.sending->actual_length) == size ? Transfer::ok : Transfer::timeout;
    case LIBUSB_TRANSFER_CANCELLED:
      return Transfer::timeout;
    case LIBUSB_TRANSFER_STALL:
      if (libusb_clear_halt(usb.handle, kOut) == LIBUSB_ERROR_NO_DEVICE) break;
      return Transfer::stall;
    default:
      break;
  }
  usb.gone = true;
  return Transfer::gone;
}

Transfer UsbTransport::read(std::span<uint8_t> into, size_t& count, int64_t timeoutNs) {
  Usb& usb = *usb_;
  count = 0;
  if (!usb.handle) return Transfer::gone;
  const int64_t end = nowNs() + timeoutNs;
  for (bool last = false;;) {
    if (usb.ringBegin != usb.ringEnd) {
      while (count < into.size() && usb.ringBegin != usb.ringEnd) into[count++] = usb.ring[usb.ringBegin++ % kRing];
      return Transfer::ok;
    }
    if (usb.gone) return Transfer::gone;
    if (usb.stalled) {
      usb.endStall();
      return usb.gone ? Transfer::gone : Transfer::stall;
    }
    if (last) return Transfer::timeout;
    const int64_t left = end - nowNs();
    last = left <= 0;  // Looks at least once, so that a time of zero takes what is there.
    usb.handleEvents(left);
  }
}

int UsbTransport::file() const noexcept {
  if (!usb_->handle) return -1;
  // Of the files that libusb waits for, a device's is the one that it waits to write to.
  int file = -1;
  const libusb_pollfd** files = libusb_get_pollfds(usb_->context);
  for (size_t i = 0; files && files[i]; ++i)
    if (files[i]->events & POLLOUT) file = files[i]->fd;
  libusb_free_pollfds(files);
  return file;
}

bool UsbTransport::clearToSend() const noexcept {
  return usb_->clearToSend;
}

}  // namespace argil::haptics
