// argil convert: from one mesh format to another, straight or by way of clay.

#include <cstdio>

#include <fmt/format.h>

#include "clay/surface.h"
#include "io/mesh_writer.h"
#include "ui3d/cli/mesh_input.h"
#include "ui3d/cli/progress.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {

void convert(const ConvertOptions& options) {
  io::requireWritable(options.output);
  clay::TriangleMesh mesh = readMeshIn(options.input, options.units, options.job).mesh;
  io::WriteOptions write;
  if (options.voxelMm) {
    const clay::Imported imported = meshAsClay(options.input, mesh, options.voxelMm, options.job);
    mesh = {};
    clay::Surface surface(false);
    surface.update(imported.version, 2);
    mesh = surface.toMesh();
    write.tolerance = 0.1 * *options.voxelMm;
    write.distinct = true;
  } else {
    write.tolerance = 1e-3;
  }
  const ProgressLine line("writing " + options.output.filename().string(), options.job);
  const io::WriteReport report = io::writeMesh(options.output, mesh, write, options.job);
  if (!report.warning.empty()) fmt::print(stderr, "{}\n", report.warning);
  fmt::print("{}: {} triangles, {} vertices, {} bytes, {}\n", options.output.string(), report.triangles, report.vertices, report.bytes, report.format);
}

}  // namespace argil::cli
