#include "clay/unwrap/unwrap.h"

#include <cmath>

#include "clay/unwrap/charts.h"
#include "clay/unwrap/pack.h"

namespace argil::clay {

UvMap unwrapped(const QuadMesh& mesh, const UnwrapOptions& options, const WorkPart& part) {
  const std::vector<Chart> charts = chartsOf(mesh, options.stretch, options.few, options.threads, part.part(0, 0.8));
  std::vector<FlatShape> shapes;
  for (const Chart& each : charts) shapes.push_back({&each.flat.places, &each.disk.triangles});
  const Packing packing = packed(shapes, options.margin, options.threads, part.part(0.8, 1));

  UvMap map;
  map.corners.resize(mesh.quads.size());
  map.chart.resize(mesh.quads.size());
  map.charts = charts.size();
  map.covered = packing.covered;
  map.mmOfSide = packing.sideMm;
  double stretch = 0, area = 0;
  for (size_t c = 0; c < charts.size(); ++c) {
    const Chart& chart = charts[c];
    const Packing::Placed& placed = packing.placed[c];
    const Eigen::Rotation2Dd turn(placed.turn);
    const auto first = static_cast<uint32_t>(map.places.size());
    for (const Vec2d& each : chart.flat.places) map.places.push_back((turn * each + placed.moveMm) / packing.sideMm);
    for (size_t i = 0; i < chart.quads.size(); ++i) {
      map.chart[chart.quads[i]] = static_cast<uint32_t>(c);
      for (size_t k = 0; k < 4; ++k) map.corners[chart.quads[i]][k] = first + chart.vertices[i][k];
    }
    double own = 0;
    for (const auto& t : chart.disk.triangles)
      own += 0.5 * (chart.disk.positions[t[1]] - chart.disk.positions[t[0]])
                       .cross(chart.disk.positions[t[2]] - chart.disk.positions[t[0]])
                       .norm();
    area += own;
    stretch += own * chart.flat.stretch * chart.flat.stretch;
  }
  map.stretch = std::sqrt(stretch / area);
  return map;
}

}  // namespace argil::clay
