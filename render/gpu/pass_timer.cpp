#include "render/gpu/pass_timer.h"

#include <algorithm>

namespace argil::render {
namespace {

/// Clocks of graphics queues have at least 36 bits; a picture does not last for a minute.
constexpr uint64_t kClockMask = (uint64_t(1) << 36) - 1;

}  // namespace

PassTimer::PassTimer(Gpu& gpu) : gpu_(gpu) {
  if (!gpu.properties().limits.timestampComputeAndGraphics) return;
  auto info = structure<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
  info.queryType = VK_QUERY_TYPE_TIMESTAMP;
  info.queryCount = kSets * (kMost + 1);
  check(vkCreateQueryPool(gpu.device(), &info, nullptr, &pool_), "making timestamps");
}

PassTimer::~PassTimer() {
  vkDestroyQueryPool(gpu_.device(), pool_, nullptr);
}

void PassTimer::begin(VkCommandBuffer commands) {
  if (!pool_) return;
  ++picture_;
  Set& set = sets_[picture_ % kSets];
  set.picture = picture_;
  set.names.clear();
  vkCmdResetQueryPool(commands, pool_, uint32_t(picture_ % kSets) * (kMost + 1), kMost + 1);
  stamp(commands);
}

void PassTimer::mark(VkCommandBuffer commands, const char* name) {
  if (!pool_ || sets_[picture_ % kSets].names.size() >= kMost) return;
  sets_[picture_ % kSets].names.push_back(name);
  stamp(commands);
}

void PassTimer::stamp(VkCommandBuffer commands) {
  const auto set = uint32_t(picture_ % kSets);
  vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool_,
                       set * (kMost + 1) + uint32_t(sets_[set].names.size()));
}

std::vector<PassTime> PassTimer::read() const {
  struct Stamp {
    uint64_t ticks, available;
  };
  std::array<Stamp, kMost + 1> stamps;
  for (uint64_t back = 0; back < std::min<uint64_t>(kSets, picture_); ++back) {
    const auto at = uint32_t((picture_ - back) % kSets);
    const Set& set = sets_[at];
    const auto count = uint32_t(set.names.size());
    const VkResult result =
        vkGetQueryPoolResults(gpu_.device(), pool_, at * (kMost + 1), count + 1, sizeof stamps, stamps.data(),
                              sizeof(Stamp), VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
    if (result != VK_SUCCESS && result != VK_NOT_READY) return {};
    if (!std::all_of(stamps.begin(), stamps.begin() + count + 1, [](const Stamp& s) { return s.available != 0; })) {
      continue;
    }
    std::vector<PassTime> times;
    const double period = double(gpu_.properties().limits.timestampPeriod) / 1000;
    for (uint32_t i = 0; i < count; ++i) {
      times.push_back({set.names[i], double((stamps[i + 1].ticks - stamps[i].ticks) & kClockMask) * period});
    }
    return times;
  }
  return {};
}

}  // namespace argil::render
