#include "ui3d/studio/files/new_clay.h"

#include <algorithm>
#include <cmath>

#include "engine/document/beside.h"

namespace argil::studio {

void NewClay::fit(const engine::Document& document) {
  const clay::BoxMm box = engine::boundsOf(document);
  const double longest = (box.high - box.low).maxCoeff();
  if (!(longest > 0) || !std::isfinite(longest)) return;
  // From a half of what is there to a quarter more.
  const double wanted = longest / (0.8 * NewClay().xMm), decade = std::pow(10, std::floor(std::log10(wanted)));
  const double digits = wanted / decade, series = (digits >= 5 ? 5 : digits >= 2 ? 2 : 1) * decade;
  const double fits = std::clamp(series, 0.002, 2000.0);  // Voxels of 0.001 to 1000 mm, as grids allow.
  const double factor = fits / scale;
  if (std::abs(factor - 1) < 1e-9) return;
  scale = fits;
  for (double* length : {&xMm, &yMm, &zMm, &roundMm, &radiusMm, &voxelMm}) *length *= factor;
}

void NewClay::add(engine::Workbench& bench) const {
  const engine::Workbench::NewClay how{.voxelMm = voxelMm,
                                       .precision = halfMemory ? clay::Precision::fixed16 : clay::Precision::float32,
                                       .beside = true};
  if (shape == 0)
    bench.addBlock(Vec3d(xMm, yMm, zMm), roundMm, how);
  else
    bench.addSphere(radiusMm, how);
}

}  // namespace argil::studio
