#include "engine/document/cost.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/document/size_words.h"

namespace argil::engine {

namespace {

// Voxels that the crisp surface lies off the rim of a cut, RMS: `argil bench costs`. Edges that meet at a smaller angle
// are nearer.
constexpr double kEdgeVoxels = 0.175;
// A brick is there where one of its voxels is in the band: it is 7 voxels wide along an axis.
constexpr double kBrickWidth = 7, kMiddle = 0.15;
// Of a brick's share of nodes, and of a quad with its vertex and its part of a mesh's head.
constexpr double kNodesOfBrick = 50, kBytesOfQuad = 32;

// "8.1 M", "412 k".
std::string counted(double count) {
  if (count >= 1e9) return fmt::format("{:.3g} G", count * 1e-9);
  if (count >= 1e6) return fmt::format("{:.3g} M", count * 1e-6);
  if (count >= 1e3) return fmt::format("{:.3g} k", count * 1e-3);
  return fmt::format("{:.0f}", count);
}

}  // namespace

ClayCost costOf(const ClayPlan& plan, const MachineSpeed& machine) {
  const double area = plan.areaMm2 / (plan.voxelMm * plan.voxelMm);
  const double bricks = area * (2 * plan.band + kBrickWidth * plan.slant + kMiddle) / clay::kBrickVoxels,
               quads = area * plan.slant;
  ClayCost cost;
  cost.activeVoxels = 2 * plan.band * area;
  cost.bytes = bricks * (static_cast<double>(clay::brickBytes(plan.precision)) + kNodesOfBrick) + quads * kBytesOfQuad;
  cost.triangles = 2 * quads;
  cost.dabMs = machine.dabMs(std::max(plan.tipMm / plan.voxelMm, 0.5), plan.band, plan.slant);
  cost.edgeMm = kEdgeVoxels * plan.voxelMm;
  return cost;
}

std::string sentence(const ClayPlan& plan, const ClayCost& cost) {
  return fmt::format(
      "{:.3g} mm: {} voxels, {}B, a dab of {:.2g} mm {:.2g} ms, rims of cuts within {:.2g} mm, {} triangles",
      plan.voxelMm, counted(cost.activeVoxels), counted(cost.bytes), plan.tipMm, cost.dabMs, cost.edgeMm,
      counted(cost.triangles));
}

}  // namespace argil::engine
