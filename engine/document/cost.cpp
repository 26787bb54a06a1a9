#include "engine/document/cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "clay/base/memory_guard.h"
#include "clay/store/store.h"
#include "engine/document/size_words.h"

namespace argil::engine {

namespace {

// Voxels that the crisp surface lies off the rim of a cut, RMS: `argil bench costs`. Edges that meet at a smaller angle
// are nearer.
constexpr double kEdgeVoxels = 0.175;
}  // namespace

ClayCost costOf(const ClayPlan& plan, const MachineSpeed& machine) {
  const double area = plan.areaMm2 / (plan.voxelMm * plan.voxelMm);
  ClayCost cost;
  cost.activeVoxels = 2 * plan.band * area;
  cost.bytes = clay::bytesOfClay(area, plan.precision, plan.band, plan.slant);
  cost.triangles = 2 * plan.slant * area;
  cost.dabMs = machine.dabMs(std::max(plan.tipMm / plan.voxelMm, 0.5), plan.band, plan.slant);
  cost.edgeMm = kEdgeVoxels * plan.voxelMm;
  return cost;
}

Quality machineQuality(const MachineSpeed& machine, std::optional<uint64_t> memoryBytes) {
  constexpr double kTips = 16, kShare = 16, kAcross = 1000;  // mm, of any size
  Quality quality = findQualityPreset("balanced")->quality;
  const QualityAxis& across = *findQualityAxis("voxels-across");
  const auto fits = [&](double voxels) {
    ClayPlan plan;
    plan.areaMm2 = std::numbers::pi * kAcross * kAcross;
    plan.voxelMm = kAcross / voxels;
    plan.tipMm = kAcross / kTips;
    const ClayCost cost = costOf(plan, machine);
    return cost.dabMs <= kMostDabMs && (!memoryBytes || cost.bytes * kShare <= static_cast<double>(*memoryBytes));
  };
  double voxels = across.row.low;
  for (double next = voxels; next <= across.row.high && fits(next); next += 1) voxels = next;
  quality.clay.voxelsAcross = voxels;
  return quality;
}

Quality readQualityHere(std::string_view text) {
  constexpr std::string_view kMachine = "machine";
  if (!text.starts_with(kMachine) || (text.size() > kMachine.size() && text[kMachine.size()] != ','))
    return readQuality(text);
  // Axes behind the name, on what the machine can do instead of on balanced.
  const Quality here = machineQuality(machineSpeed(), memoryRoom().total);
  std::string axes = fmt::format("balanced,voxels-across={:g}", here.clay.voxelsAcross);
  axes += text.substr(kMachine.size());
  return readQuality(axes);
}

std::string sentence(const ClayPlan& plan, const ClayCost& cost) {
  return fmt::format(
      "{:.3g} mm: {} voxels, {}B, a dab of {:.2g} mm {:.2g} ms, rims of cuts within {:.2g} mm, {} triangles",
      plan.voxelMm, counted(cost.activeVoxels), counted(cost.bytes), plan.tipMm, cost.dabMs, cost.edgeMm,
      counted(cost.triangles));
}

}  // namespace argil::engine
