#pragma once
// The far end of a serial line: a pseudo-terminal whose master speaks a device's bytes, right or wrong.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <random>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "clay/base/vec.h"
#include "device_rig.h"

namespace argil::haptics::testing {

/// Its path is a link that leads to the terminal while plugged in and nowhere otherwise. A kind of device says how it
/// answers; what is done wrong to the answer is the same for all.
class PtyEmulator {
 public:
  PtyEmulator();
  virtual ~PtyEmulator();
  PtyEmulator(const PtyEmulator&) = delete;
  PtyEmulator& operator=(const PtyEmulator&) = delete;

  [[nodiscard]] std::string path() const { return path_.string(); }
  void plug();
  void unplug();
  void misbehave(Misbehaviour what) { misbehaviour_.store(what); }

  /// Bytes as fast as they are taken, whatever is asked.
  void talkWithoutEnd(bool endless) { endless_.store(endless); }

  void hand(const Vec3d& positionMm, uint32_t buttons);
  [[nodiscard]] Vec3d forceN() const;
  [[nodiscard]] double peakN() const;
  /// Forces that it was told so far, zero included: somebody drives it.
  [[nodiscard]] uint64_t told() const;
  [[nodiscard]] Vec3d toldN(uint64_t which) const;  ///< Which of them, below told().

 protected:
  struct Hand {
    Vec3d positionMm = Vec3d::Zero();
    uint32_t buttons = 0;
  };
  /// Takes one whole request off the front of `in`, adds the answer to `out`; bytes taken, 0 when there is no whole
  /// request.
  virtual size_t answer(std::span<const uint8_t> in, const Hand& hand, std::vector<uint8_t>& out) = 0;
  /// Spoils an answer of this kind: numbers that are none, or another's opcode.
  virtual void spoil(Misbehaviour what, std::vector<uint8_t>& out) = 0;
  void motors(const Vec3d& forceN);
  /// In the destructor of what derives: no more calls of its functions.
  void stop();

 private:
  void run(int master);
  void send(int master, std::vector<uint8_t> bytes);

  std::filesystem::path path_;
  int master_ = -1, slave_ = -1;
  std::atomic<bool> stop_{false}, endless_{false};
  std::atomic<Misbehaviour> misbehaviour_{Misbehaviour::none};
  mutable std::mutex mutex_;
  Hand hand_;
  Vec3d forceN_ = Vec3d::Zero();
  std::vector<Vec3d> toldN_;
  double peakN_ = 0;
  std::mt19937 random_{20261120};
  std::thread thread_;
};

}  // namespace argil::haptics::testing
