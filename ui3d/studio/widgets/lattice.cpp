// The deform box: the grid that the clay follows, and its points.

#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

constexpr int kSteps = 6;        // Of a line between two points of the grid.
constexpr int kPlainCounts = 4;  // Lines of a box without points of its own.
constexpr float kBehind = 0.45f;
constexpr double kLeastPart = 0.05;  // Of a drag of the clay that the point above it takes.

/// The point follows the hand exactly. What moves is the clay below it, as little of the rest as possible: a corner
/// alone would move but its own surroundings, where there may be no clay.
void applyPoint(Subject& subject, const Handle& handle, const Change& change) {
  auto* held = std::get_if<HeldLattice>(&subject);
  if (!held) return;
  const auto index = static_cast<size_t>(handle.index);
  const Vec3d rest = held->lattice.restPoint(index);
  const Vec3d clay = index < held->clayPlaces.size() ? held->clayPlaces[index] : rest;
  Eigen::Matrix3d slope;
  Vec3d by = held->pose.rotation.conjugate() * change.move;
  if (held->after) {
    (void)held->after->map(held->lattice.map(rest, slope), slope);
    by = slope.inverse() * by;
  }
  if (!by.allFinite()) return;
  // Points are moved in proportion, so that of a unit's drag the rest point's part is found in a lattice at rest.
  clay::Lattice trial(held->lattice.box(), held->lattice.counts());
  trial.drag(clay, Vec3d::UnitX());
  const double part = trial.map(rest, slope).x() - rest.x();
  held->lattice.drag(clay, part > kLeastPart ? Vec3d(by / part) : by);
}

}  // namespace

void buildLattice(Build& build) {
  const auto& box = build.world.state.deformBox;
  if (!box) return;
  const bool points = box->kind == DeformBox::Kind::lattice;
  const clay::Lattice grid = points || box->lattice.moved()
                                 ? box->lattice
                                 : clay::Lattice(box->lattice.box(), {kPlainCounts, kPlainCounts, kPlainCounts});
  const auto warp = box->warp();
  const auto place = [&](const Vec3d& p) {
    Eigen::Matrix3d unused;
    return box->pose.apply(warp ? warp->map(p, unused) : p);
  };
  const std::array<int, 3> counts = grid.counts();
  const Vec3d low = grid.box().low, size = grid.box().high - low;
  for (int along = 0; along < 3; ++along) {
    const int v = (along + 1) % 3, w = (along + 2) % 3;
    for (int i = 0; i < counts[size_t(v)]; ++i)
      for (int j = 0; j < counts[size_t(w)]; ++j) {
        const bool edgeV = i == 0 || i == counts[size_t(v)] - 1, edgeW = j == 0 || j == counts[size_t(w)] - 1;
        if (!edgeV && !edgeW) continue;  // Within: only the faces' lines are drawn, or the clay could not be seen.
        std::vector<Vec3d> line;
        const int steps = kSteps * (counts[size_t(along)] - 1);
        for (int k = 0; k <= steps; ++k) {
          Vec3d t;
          t[along] = double(k) / steps;
          t[v] = double(i) / (counts[size_t(v)] - 1);
          t[w] = double(j) / (counts[size_t(w)] - 1);
          line.push_back(place(low + t.cwiseProduct(size)));
        }
        const bool edge = edgeV && edgeW;
        build.line(std::move(line), faded(widget_colours::kWorkspace, edge ? 0.9f : 0.4f), edge ? 2.2f : 1.2f);
      }
  }
  if (!points) return;
  const Vec3d middle = place(low + 0.5 * size);
  for (size_t i = 0; i < box->lattice.points().size(); ++i) {
    Handle dot;
    dot.target = {Target::Kind::lattice, box->piece};
    dot.name = "lattice point";
    dot.index = static_cast<int>(i);
    dot.anchor = place(box->lattice.restPoint(i));
    dot.points = {dot.anchor};
    dot.colour = faded(widget_colours::kHandle,
                       (dot.anchor - middle).dot(build.world.screen.toEye(dot.anchor)) > 0 ? 1.f : kBehind);
    dot.apply = applyPoint;
    build.handles.push_back(dot);
  }
}

}  // namespace argil::studio
