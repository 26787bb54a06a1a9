// argil feel: what a hand feels along a recorded path.

#include <memory>
#include <optional>
#include <span>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/store/store.h"
#include "engine/models/import_place.h"
#include "engine/models/prepare_clay.h"
#include "engine/session/feel.h"
#include "engine/text/texture_text.h"
#include "haptics/contact/contact.h"
#include "haptics/devices/sheets.h"
#include "haptics/scene/part_mesh.h"
#include "haptics/threads/sample_ring.h"
#include "io/bytes/atomic_file.h"
#include "io/bytes/input.h"
#include "io/bytes/output_files.h"
#include "io/models/mesh_file.h"
#include "ui3d/cli/progress.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {

namespace {

haptics::HandPath readPath(const FeelOptions& options) {
  const io::FileBytes file = io::readFile(options.path, options.job);
  const std::string_view text(reinterpret_cast<const char*>(file.data.get()), file.size);
  const std::string name = io::displayName(options.path);
  const bool other = !options.layout.units.empty() || !options.layout.columns.empty() || !options.layout.rows.empty();
  return other ? haptics::HandPath::fromCsv(text, name, options.layout) : haptics::HandPath::fromCsv(text, name);
}

haptics::Material material(const FeelOptions& options) {
  haptics::Material material;
  if (options.stiffnessNmm) material.stiffnessNmm = *options.stiffnessNmm;
  if (!(material.stiffnessNmm > 0 && material.stiffnessNmm <= 1e4))
    throw Error(fmt::format("--stiffness {:g}: give more than 0 and at most 10 000 N/mm", material.stiffnessNmm));
  if (!(options.friction >= 0 && options.friction <= 4))
    throw Error(fmt::format("--friction {:g}: give 0 to 4", options.friction));
  material.staticFriction = material.dynamicFriction = options.friction;
  return material;
}

clay::Version makeClay(const FeelOptions& options) {
  const ProgressLine line("making clay", options.job);
  engine::PrepareOptions prepare;
  prepare.input = options.input;
  prepare.voxelMm = options.voxelMm;
  prepare.job = options.job;
  engine::Script script;
  script.fitMm = options.sizeMm;
  engine::PreparedClay clay = engine::prepareClay(clay::Store::make(), script, prepare);
  for (const std::string& note : clay.notes) fmt::print("{}\n", note);
  return clay.version;
}

std::shared_ptr<const haptics::PartMesh> makePart(const FeelOptions& options) {
  const ProgressLine line("reading the part", options.job);
  io::MeshFile file = io::readMesh(options.input, options.job);
  clay::TriangleMesh* const meshes[] = {&file.mesh};
  if (options.sizeMm) fmt::print("{}\n", engine::fitMeshes(meshes, *options.sizeMm));
  try {
    return std::make_shared<const haptics::PartMesh>(file.mesh, options.job);
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", io::displayName(options.input), e.what()), e.kind());
  }
}

void print(const engine::FeelSummary& s, const FeelOptions& options, const haptics::DeviceSheet& sheet,
           double stiffness) {
  const auto row = [](const char* what, const std::string& value) { fmt::print("  {:<18} {}\n", what, value); };
  row("contact", fmt::format("{}, ball of {:g} mm, {:g} N/mm, {} ({:g} N)", options.contact, options.radiusMm,
                             std::min(stiffness, sheet.topStiffnessNmm), sheet.name, sheet.peakForceN));
  row("hand", options.freeHand ? "free: simulated hand and device in closed loop" : "on the path, whatever the force");
  row("ticks",
      fmt::format("{} ({} touching, {} clamped, {} incomplete)", s.ticks, s.touching, s.clamped, s.incomplete));
  row("largest force", fmt::format("{:.3f} N, deepest {:.3f} mm", s.peakN, s.deepestMm));
  row("tick to tick", fmt::format("{:.3f} % of it RMS; median {:.3f}, p99 {:.3f}, largest {:.3f} %", s.jumpRms,
                                  s.jumpP50, s.jumpP99, s.jumpMax));
  row(options.freeHand ? "tick compute" : "contact compute",
      fmt::format("median {:.2f}, p99 {:.2f}, p99.9 {:.2f} µs", s.compute.median, s.compute.p99, s.compute.p999));
  if (!s.fault.empty()) row("force stopped", s.fault);
}

}  // namespace

void feel(const FeelOptions& options) {
  // What is wrong with the call is told before the work.
  static_cast<void>(haptics::makeContact(options.contact));
  const haptics::DeviceSheet& sheet = haptics::deviceSheet(options.device);
  if (!(options.radiusMm > 0 && options.radiusMm <= 1e4))
    throw Error(fmt::format("--radius {:g}: give more than 0 and at most 10 000 mm", options.radiusMm));
  if (options.part && options.contact != "proxy")
    throw Error(fmt::format("--part: only the proxy touches a mesh as it is, not {}", options.contact));
  haptics::Scene scene;
  scene.materials[0] = material(options);
  if (!options.texture.empty()) {
    scene.textures.push_back(engine::parseTexture(options.texture));
    scene.materials[0].texture = 0;
  }
  if (options.sizeMm && !(*options.sizeMm >= 1e-2 && *options.sizeMm <= 1e6))
    throw Error(fmt::format("--size {:g}: give 0.01 to 1 000 000 mm", *options.sizeMm));
  engine::PathPlacement placement;
  placement.fit = options.fit;
  placement.pressMm = options.pressMm;
  if (!options.move.empty()) placement.moveMm = Vec3d(engine::parseNumbers(options.move, 3, "--move").data());
  if (!options.onto.empty()) {
    placement.onto = Vec3d(engine::parseNumbers(options.onto, 3, "--onto").data());
    if (!(placement.onto->norm() > 1e-9)) throw Error("--onto: the direction must not be zero");
  }
  io::Files inputs{options.input, options.path};
  if (const auto& texture = options.texture; texture.starts_with("image:"))
    inputs.emplace_back(texture.substr(6, texture.find(':', 6) - 6));
  io::requireNewFiles(inputs, {&options.output, 1}, options.overwrite);
  haptics::HandPath path = readPath(options);
  std::optional<io::AtomicFile> out;
  if (!options.output.empty()) out.emplace(options.output);

  clay::Version clay;
  if (!options.part || placement.fit || placement.onto) clay = makeClay(options);
  if (options.part)
    scene.parts.push_back({makePart(options), {}, 0});
  else
    scene.pieces.push_back({clay, {}, 0});
  scene.tool.radiusMm = options.radiusMm;
  path = engine::placePath(path, clay, options.radiusMm, placement);

  engine::FeelOptions how;
  how.contact = options.contact;
  how.device = options.device;
  how.rateHz = options.rateHz;
  how.freeHand = options.freeHand;
  how.job = options.job;
  const engine::FeelRun run = [&] {
    const ProgressLine line("feeling", options.job);
    return engine::feel(scene, path, how);
  }();
  print(run.summary, options, sheet, scene.materials[0].stiffnessNmm);
  if (!out) return;
  const std::string text = engine::feelCsv(run);
  out->write(std::as_bytes(std::span(text)));
  out->commit();
}

}  // namespace argil::cli
