// argil render: a picture of a mesh as clay, or the frames of a turntable.

#include <algorithm>
#include <cstdio>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/base/job_scope.h"
#include "engine/models/load_document.h"
#include "io/bytes/output_files.h"
#include "render/renderer/renderer.h"
#include "ui3d/cli/mesh_input.h"
#include "ui3d/cli/progress.h"
#include "ui3d/cli/show_document.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {
namespace {

constexpr int kMostFrames = 10000;

template <class Value>
Value chosen(const char* option, const std::string& text, std::optional<Value> value,
             std::span<const std::string_view> names) {
  if (value) return *value;
  throw Error(fmt::format("{} {}: choose one of {}", option, text, fmt::join(names, ", ")));
}

render::Section parseSection(const std::string& text) {
  render::Section section;
  char rest = 0;
  Vec3d &p = section.pointMm, &n = section.normal;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf%c", &p.x(), &p.y(), &p.z(), &n.x(), &n.y(), &n.z(), &rest) !=
          6 ||
      !p.allFinite() || !n.allFinite() || n.squaredNorm() == 0)
    throw Error(fmt::format("--section {}: give X,Y,Z,NX,NY,NZ: a point in mm and a normal that is not zero", text));
  return section;
}

render::Shot shotOf(const RenderOptions& options) {
  using namespace render;
  Shot shot;
  Look& look = shot.look;
  look.shading = chosen("--shading", options.shading, shadingNamed(options.shading), shadingNames());
  look.matcap = chosen("--matcap", options.matcap, matcapNamed(options.matcap), matcapNames());
  look.lightBackground = options.light;
  look.depthFade = options.depthFade.has_value();
  look.depthFadeStrength = options.depthFade.value_or(look.depthFadeStrength);
  if (!options.section.empty()) look.section = parseSection(options.section);
  shot.stereo.mode = chosen("--stereo", options.stereo, stereoModeNamed(options.stereo), stereoModeNames());
  shot.stereo.eyeDistancePart = options.eyeDistance.value_or(shot.stereo.eyeDistancePart);
  shot.stereo.convergencePart = options.convergence.value_or(shot.stereo.convergencePart);
  check(look);
  check(shot.stereo);
  return shot;
}

/// Where a name holds its one %d or %0Nd, and N.
struct NumberPlace {
  size_t at = 0, length = 0;
  int width = 0;
};
NumberPlace numberPlace(const std::string& name) {
  NumberPlace place;
  int found = 0;
  for (size_t at = name.find('%'); at != std::string::npos; at = name.find('%', at + 1)) {
    int width = 0, read = 0;
    const bool padded = std::sscanf(name.c_str() + at, "%%0%1dd%n", &width, &read) == 1 && read > 0;
    if (!padded && name.compare(at, 2, "%d") != 0) continue;
    place = {at, padded ? size_t(read) : 2, padded ? width : 0};
    ++found;
  }
  if (found != 1)
    throw Error(fmt::format("{}: frames need a place for their number in the name, once: turn-%03d.png", name));
  return place;
}

std::string frameName(const std::string& name, const NumberPlace& place, int frame) {
  return name.substr(0, place.at) + fmt::format("{:0{}}", frame, place.width) + name.substr(place.at + place.length);
}

/// A view that holds the model from all sides, so that it keeps its size while it turns.
render::View turntableView(render::View view, const render::Box& bounds, double aspect, int frames) {
  double away = 0;
  for (int i = 0; i < frames; ++i) {
    render::View turned = view.revolved(360.0 * i / frames);
    turned.fit(bounds, aspect);
    away = std::max(away, turned.distance());
  }
  view.position = view.target - away * view.axes().forward;
  return view;
}

}  // namespace

void render(const RenderOptions& options) {
  const clay::JobScope surfaces(options.job);
  static_cast<void>(render::View::named(options.view, {}, 1));  // a wrong name is told before the work
  render::Shot shot = shotOf(options);
  if (options.frames < 1 || options.frames > kMostFrames)
    throw Error(fmt::format("--frames {}: give 1 to {}", options.frames, kMostFrames));
  const std::string name = options.output.string();
  const NumberPlace place = options.frames > 1 ? numberPlace(name) : NumberPlace{};
  if (options.samples < 1 || options.samples > 4)
    throw Error(fmt::format("--samples {}: give 1 to 4", options.samples));

  io::Files pictures;
  for (int i = 0; i < options.frames; ++i) pictures.emplace_back(options.frames > 1 ? frameName(name, place, i) : name);
  requireModel(options.input, options.place);
  io::requireNewFiles({&options.input, 1}, pictures, options.overwrite);
  const engine::LoadedDocument loaded = [&] {
    const ProgressLine line("reading " + options.input.filename().string(), options.job);
    engine::ModelImport how;
    how.voxelMm = options.voxelMm;
    how.units = options.place.units;
    how.up = options.place.up;
    how.heightMm = options.place.heightMm;
    how.stands = options.place.stands;
    return engine::loadDocument(options.input, how, options.job);
  }();
  for (const std::string& note : loaded.notes) fmt::print("{}\n", note);
  render::RendererOptions rendererOptions;
  rendererOptions.quality.supersample = options.samples;
  render::Renderer renderer(rendererOptions);
  showDocument(*loaded.document, options.surface, renderer);
  const double aspect = static_cast<double>(options.size[0]) / options.size[1];
  const auto projection = options.orthographic ? render::Projection::orthographic : render::Projection::perspective;
  render::View view = render::View::named(options.view, renderer.bounds(), aspect, projection);
  if (options.frames > 1) view = turntableView(view, renderer.bounds(), aspect, options.frames);
  for (int i = 0; i < options.frames; ++i) {
    if (options.job) options.job->step(static_cast<double>(i) / options.frames);
    shot.view = view.revolved(360.0 * i / options.frames);
    const render::Image image = renderer.render(shot, options.size[0], options.size[1]);
    render::writePng(image, options.frames > 1 ? frameName(name, place, i) : name);
  }
  const std::string what = options.frames > 1 ? fmt::format("{} frames of ", options.frames) : "";
  fmt::print("{}: {}{} × {} pixels, {} triangles, drawn by {}\n", name, what, options.size[0], options.size[1],
             renderer.triangleCount(), renderer.deviceName());
}

}  // namespace argil::cli
