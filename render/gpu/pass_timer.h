#pragma once
// How long the device spends on each pass. Only for the .cpp files of render/.

#include <array>
#include <cstdint>
#include <vector>

#include "render/gpu/gpu.h"
#include "render/view/device_work.h"

namespace argil::render {

/// Timestamps between the passes of the last pictures. Several pictures may be under way: each has a set of its own,
/// and a picture that is still being drawn is not waited for. Does nothing on a device without a clock.
class PassTimer {
 public:
  explicit PassTimer(Gpu& gpu);
  ~PassTimer();
  PassTimer(const PassTimer&) = delete;
  PassTimer& operator=(const PassTimer&) = delete;

  /// Before the first pass of a picture. Outside of rendering, as mark() is: within multiview a timestamp would be
  /// several.
  void begin(VkCommandBuffer commands);
  /// After a pass; `name` must live on. Past kMost passes are left out.
  void mark(VkCommandBuffer commands, const char* name);
  /// Of the newest picture that is done.
  [[nodiscard]] std::vector<PassTime> read() const;

 private:
  static constexpr uint32_t kSets = 4, kMost = 31;
  struct Set {
    uint64_t picture = 0;  ///< 0: never used.
    std::vector<const char*> names;
  };

  void stamp(VkCommandBuffer commands);

  Gpu& gpu_;
  VkQueryPool pool_ = VK_NULL_HANDLE;
  std::array<Set, kSets> sets_;
  uint64_t picture_ = 0;
};

}  // namespace argil::render
