#pragma once
// What a thread that must keep time asks of the system.

#include <string>

namespace argil::haptics {

/// What the system granted to a thread that asked to be real-time.
struct RealtimeGrant {
  bool fifo = false;     ///< SCHED_FIFO, or SCHED_RR from RealtimeKit.
  bool locked = false;   ///< The memory; whoever asked calls unlockMemory() in the end.
  std::string sentence;  ///< In plain words, with what to do when something was refused.
};

/// Asks for SCHED_FIFO at `priority` for the calling thread, of RealtimeKit where the system itself refuses (it answers
/// within kRealtimeKitSeconds or not at all), and, with `lockMemory`, calls that. Pre-touches the stack. Never throws
/// for a refusal.
[[nodiscard]] RealtimeGrant becomeRealtime(int priority, bool lockMemory);

/// Keeps the pages of this process that are or get used in memory, until everybody who was granted it has called
/// unlockMemory(). Memory that is only reserved costs nothing. The first call brings in the code that a tick may need.
/// False when the system refuses. Any thread but a real-time one.
[[nodiscard]] bool lockMemory() noexcept;
void unlockMemory() noexcept;

/// While it lives, the thread that made it takes numbers too small for a normal exponent as zero: sums that fade out
/// otherwise cost a hundred times the time on their last stretch. For the servo's own thread alone: whatever is stored
/// must have equal bits everywhere, so no thread that edits or saves may do this, nor virtual time.
class FlushDenormals {
 public:
  FlushDenormals() noexcept;
  ~FlushDenormals();
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned long long before_ = 0;
};

}  // namespace argil::haptics
