#pragma once
// What argil-plugin does for argil, one question after the other.

#include <atomic>
#include <cstddef>
#include <thread>

#include "plugins/runner/channel.h"
#include "plugins/runner/library.h"
#include "plugins/runner/workers.h"

namespace argil::plugin {

/// A text as a channel has it: whole characters of UTF-8 alone.
void put(char (&to)[kMostText], const char* text) noexcept;
/// What was asked is answered.
void answer(Channel& channel) noexcept;

class Runner {
 public:
  Runner(Channel& channel, Library& library, Workers& workers)
      : channel_(channel), library_(library), workers_(workers) {}
  /// Until the process ends.
  [[noreturn]] void serve();

 private:
  argil_status work();
  template <class Thing>
  const Thing* asked(const Thing* thing);
  argil_status describe();
  // Brushes.
  argil_status beginStroke();
  argil_status bricks();
  void waitUntilFilled(uint32_t count);
  void endStroke();
  // Files and operations.
  argil_status beginExport();
  argil_status exportBlock();
  argil_status endExport();
  argil_status import();
  argil_status operate();
  argil_status texture();
  // Felt guides.
  argil_status beginGuide();
  void endGuide();
  // Devices.
  argil_status beginDevice();
  void endDevice();
  void exchangeUntilEnd();

  void sleepUntilAsked();
  uint64_t ask(Upcall what, uint64_t first, uint64_t count);
  bool giveMesh(Upcall what, const void* items, size_t bytesEach, const uint8_t* colours, uint64_t count);
  template <class T>
  [[nodiscard]] T* window(uint64_t bytes = 0) const {
    return reinterpret_cast<T*>(reinterpret_cast<std::byte*>(&channel_) + kWindowAt + bytes);
  }

  Channel& channel_;
  Library& library_;
  Workers& workers_;
  uint32_t done_ = 0;  // questions
  const argil_brush* brush_ = nullptr;
  void* stroke_ = nullptr;
  const argil_exporter* exporter_ = nullptr;
  void* exporting_ = nullptr;
  argil_export export_{};
  const argil_guide* guide_ = nullptr;
  void* guiding_ = nullptr;
  std::atomic<bool> guideEnds_{false};
  std::thread guideThread_;
  const argil_device* device_ = nullptr;
  void* held_ = nullptr;
  std::atomic<bool> deviceEnds_{false};
  std::thread deviceThread_;
};

}  // namespace argil::plugin
