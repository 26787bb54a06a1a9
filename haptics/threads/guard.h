#pragma once
// A second process that zeroes the devices when this one dies.

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <span>

#include "haptics/base/realtime.h"

namespace argil::haptics {

/// A device that keeps its last force until told otherwise must not be left pushing by a program that is killed, aborts
/// or hangs. The guard is a process forked before Argil starts a thread (those that libraries start while they are
/// loaded may sleep on). It holds a duplicate of each registered device's file and the bytes that mean zero force
/// there; it sends them when Argil's end of a socket closes (however Argil died) and when a device's heartbeat is older
/// than kGuardSilenceSeconds (memory of many gigabytes is freed before files are closed, a core is written before
/// either; a stopped or starved program closes nothing). It ends with Argil, ignores the terminal's signals, and leaves
/// no zombie.
///
/// First line of main():  `const argil::haptics::Guard guard;`
/// A driver, once its file is open: `id = Guard::registerDevice(fd, zeroPacket)`; after each force written:
/// `Guard::beat(id)`; when it stops driving: zero force, `Guard::rest(id)`; before it closes the file:
/// `Guard::unregister(id)`. A device whose bus needs more than bytes to a file gives a function that opens it anew:
/// registerCall(). Without a guard (tools, tests) all of these do nothing. Recipe: NOTES.md, "Guard".
class Guard {
 public:
  /// How the bytes travel.
  enum class Transport : uint8_t {
    write,    ///< write(): serial lines, hidraw.
    usbBulk,  ///< The file is one of /dev/bus/usb with its interface claimed; a bulk transfer to an endpoint.
  };
  static constexpr int kUnguarded = -1;
  static constexpr size_t kMaxDevices = 8;
  static constexpr size_t kMaxZeroBytes = 64;

  /// Forks. One at a time, else Error. A system that refuses another process leaves
  /// running() false: forces are then guarded by the watchdog alone.
  Guard();
  /// Zeroes what is still registered, and waits until the guard has ended (a few ms).
  ~Guard();
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

  [[nodiscard]] bool running() const noexcept { return child_ > 0; }
  [[nodiscard]] pid_t process() const noexcept { return child_; }

  /// From now on `zero` is sent to a duplicate of `fd` when Argil dies; at most kMaxZeroBytes, one whole packet (it is
  /// sent three times). The id for the calls below, or kUnguarded: there is no guard, it does not answer, it has
  /// kMaxDevices, or what it was given cannot be guarded; watchdogs alone stand between a fault and the hand then. Any
  /// thread but the servo's: it waits for the guard.
  static int registerDevice(int fd, std::span<const std::byte> zero, Transport transport = Transport::write,
                            uint8_t endpoint = 0) noexcept;
  /// For a device that must be opened anew: `zero` is called in the guard's process, whose memory is that of Argil when
  /// the guard was made, once Argil is gone and the kernel has closed its files; again a few times while it answers 0,
  /// the number of devices zeroed. It has no heartbeat: the device is still Argil's while Argil hangs. Same threads and
  /// answers.
  static int registerCall(int (*zero)() noexcept) noexcept;
  /// The duplicate is closed. kUnguarded and unknown ids are passed over. Same threads.
  static void unregister(int id) noexcept;

  /// The device was just given a force: after kGuardSilenceSeconds without the next beat it is sent zero, once. Begins
  /// with the first beat. Any thread, the servo's included.
  static void beat(int id) ARGIL_REALTIME;
  /// No force is driven until the next beat. Any thread.
  static void rest(int id) ARGIL_REALTIME;

 private:
  pid_t child_ = -1;
};

/// With the guard's own period and a busy machine, zero within 20 ms.
inline constexpr double kGuardSilenceSeconds = 0.014;

}  // namespace argil::haptics
