// argil render: a picture of a mesh as clay.

#include <fmt/format.h>

#include "clay/surface.h"
#include "render/renderer.h"
#include "ui3d/cli/mesh_input.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {

void render(const RenderOptions& options) {
  static_cast<void>(render::View::named(options.view, {}, 1));  // a wrong name is told before the work
  const io::MeshFile file = readMeshIn(options.input, "mm", options.job);
  const clay::Imported imported = meshAsClay(options.input, file.mesh, options.voxelMm, options.job);
  clay::Surface surface;
  render::Renderer renderer;
  renderer.update(surface.update(imported.version, 2));
  const double aspect = static_cast<double>(options.size[0]) / options.size[1];
  const auto projection = options.orthographic ? render::Projection::orthographic : render::Projection::perspective;
  const render::View view = render::View::named(options.view, renderer.bounds(), aspect, projection);
  render::writePng(renderer.render(view, {}, options.size[0], options.size[1]), options.output.string());
  fmt::print("{}: {} × {} pixels, {} triangles, drawn by {}\n", options.output.string(), options.size[0], options.size[1], renderer.triangleCount(),
             renderer.deviceName());
}

}  // namespace argil::cli
