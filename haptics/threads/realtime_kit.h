#pragma once
// Desktops that grant no real-time scheduling by themselves lend it through RealtimeKit, a service of the system's
// D-Bus.

#include <sys/types.h>

#include <string>

namespace argil::haptics {

inline constexpr double kRealtimeKitSeconds = 0.5;  ///< A service that must be started first takes a tenth of that.

struct RealtimeKitAnswer {
  bool granted = false;
  int priority = 0;     ///< That was granted.
  bool silent = false;  ///< Somebody is there and did not answer in time.
  std::string why;      ///< What went wrong, for a log; empty when granted.
};

/// Where the system's bus is: DBUS_SYSTEM_BUS_ADDRESS, or the usual socket.
[[nodiscard]] std::string systemBus();

/// Asks org.freedesktop.RealtimeKit1 to make `thread` of this process real-time (SCHED_RR). `priority` is one as
/// SCHED_FIFO has it here (80 to 90); the service lends the lowest few (20 at most, as a rule), so differences are kept
/// and the highest gets the most that it lends. It wants RLIMIT_RTTIME to be set: the process is ended when one of its
/// real-time threads runs for so long (0.2 s) without ever sleeping. Waits `seconds` at most in all. Never throws.
[[nodiscard]] RealtimeKitAnswer askRealtimeKit(const std::string& bus, pid_t thread, int priority,
                                               double seconds = kRealtimeKitSeconds) noexcept;

}  // namespace argil::haptics
