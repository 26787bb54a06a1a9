// argil sculpt: a script from clay to files, pictures and one table.

#include <map>
#include <optional>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clay/base/job_scope.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/surface/surface_topology.h"
#include "clay/surface/vertex_channels.h"
#include "engine/document/cost.h"
#include "engine/document/size_words.h"
#include "engine/models/load_document.h"
#include "engine/models/prepare_clay.h"
#include "engine/models/script_file.h"
#include "engine/saving/saved_document.h"
#include "engine/session/run.h"
#include "haptics/devices/sheets.h"
#include "io/bytes/atomic_file.h"
#include "io/bytes/input.h"
#include "io/bytes/output_files.h"
#include "io/models/mesh_writer.h"
#include "render/renderer/renderer.h"
#include "ui3d/cli/inspect_print.h"
#include "ui3d/cli/progress.h"
#include "ui3d/cli/show_document.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {

namespace {

using nlohmann::ordered_json;

ordered_json timingJson(const engine::Timing& t) {
  return {{"n", t.n}, {"median_us", t.median}, {"p99_us", t.p99}, {"p999_us", t.p999}, {"max_us", t.max}};
}

std::string timingText(const engine::Timing& t) {
  return fmt::format("{:8.1f} {:8.1f} {:8.1f} µs", t.median, t.p99, t.p999);
}

// A way out of the clay from a place that the tool has cut: of the 26 directions that are free for as long as the
// stylus, the one that points most away from the middle.
Vec3d freeDirection(const clay::Version& version, const Vec3d& fromMm, const Vec3d& outwards) {
  constexpr int kLongVoxels = 120;
  clay::Sampler field(version);
  const Vec3d from = version.grid().toVoxel(fromMm);
  Vec3d best = outwards;
  double bestDot = -2;
  for (int i = 0; i < 27; ++i) {
    if (i == 13) continue;
    const Vec3d way = Vec3d(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1).normalized();
    if (way.dot(outwards) <= bestDot) continue;
    bool isFree = true;
    for (int step = 1; step <= kLongVoxels && isFree; ++step) isFree = field.trilinear(from + step * way) > 0;
    if (!isFree) continue;
    best = way;
    bestDot = way.dot(outwards);
  }
  return best;
}

// The tool just lifted from where a stroke ended, so that the picture shows what made it, and where.
render::Cursor cursorAfter(const engine::ScriptStroke& last, const clay::Version& version, const Vec3d& centreMm) {
  const Vec3d end = last.path.back().mm, outwards = end - centreMm;
  const Vec3d away =
      freeDirection(version, end, outwards.norm() > 1e-9 ? Vec3d(outwards.normalized()) : Vec3d(Vec3d::UnitZ()));
  render::Cursor cursor;
  cursor.radiusMm = last.tool.radiusMm;
  cursor.positionMm = end + 3 * cursor.radiusMm * away;
  cursor.shaft = away;
  cursor.drop = -away;
  return cursor;
}

// The same for the last stroke whose end the picture shows; the very last when it shows none.
std::optional<render::Cursor> shownCursor(const engine::Script& strokes, const clay::Version& version,
                                          const render::Renderer& renderer, const render::View& view) {
  std::optional<render::Cursor> first;
  for (size_t i = strokes.strokes.size(); i-- > 0;) {
    const render::Cursor cursor = cursorAfter(strokes.strokes[i], version, renderer.bounds().centre());
    if (!first) first = cursor;
    const Vec3d landing = cursor.positionMm + 2.5 * cursor.radiusMm * cursor.drop;
    const auto seen = [&](const Vec3d& at) { return !renderer.raycast(at, view.position - at); };
    if (seen(cursor.positionMm) && seen(landing)) return cursor;
  }
  return first;
}

// What changed since the first picture: of each brick the newest mesh alone.
class ChangedSurface {
 public:
  void add(const clay::SurfaceDelta& delta) {
    grid_ = delta.grid;
    for (const clay::BrickMeshPtr& mesh : delta.changed) newest_[mesh->brick] = mesh;
    for (const auto& paint : delta.painted) paint_[paint->brick] = paint;
  }
  [[nodiscard]] clay::SurfaceDelta delta() const {
    clay::SurfaceDelta all;
    all.grid = grid_;
    for (const auto& entry : newest_) all.changed.push_back(entry.second);
    for (const auto& entry : paint_) all.painted.push_back(entry.second);
    return all;
  }
  [[nodiscard]] bool empty() const { return newest_.empty() && paint_.empty(); }

 private:
  clay::Grid grid_;
  std::map<Coord, clay::BrickMeshPtr> newest_;
  std::map<Coord, std::shared_ptr<const clay::BrickPaint>> paint_;
};

// A piece that is seen, with its surface as it lies in the world.
struct Figures {
  std::string name;
  clay::TopologyReport skin;
  clay::Version version;
};

// `worked`: a surface of this grade that one of them may have already; or null.
std::vector<Figures> figuresOf(const engine::Document& document, const clay::Surface* worked, clay::Grade grade) {
  std::vector<Figures> all;
  for (const engine::Piece& piece : document.pieces) {
    if (!piece.visible) continue;
    const auto place = [&](const Vec3d& p) { return piece.pose.apply(p); };
    clay::Surface surface(false, grade);
    const bool known = worked && worked->version() == piece.version;
    if (!known) surface.update(piece.version, 2);
    all.push_back({piece.name, clay::surfaceTopology(known ? *worked : surface, place), piece.version});
  }
  return all;
}

clay::TopologyReport together(const std::vector<Figures>& pieces) {
  clay::TopologyReport sum;
  for (const Figures& piece : pieces) {
    const clay::TopologyReport& each = piece.skin;
    const bool first = sum.triangles == 0;
    sum.low = first ? each.low : sum.low.cwiseMin(each.low).eval();
    sum.high = first ? each.high : sum.high.cwiseMax(each.high).eval();
    sum.triangles += each.triangles;
    sum.vertices += each.vertices;
    sum.degenerateTriangles += each.degenerateTriangles;
    sum.boundaryEdges += each.boundaryEdges;
    sum.nonManifoldEdges += each.nonManifoldEdges;
    sum.flippedEdges += each.flippedEdges;
    sum.boundaryVertices += each.boundaryVertices;
    sum.nonManifoldVertices += each.nonManifoldVertices;
    sum.bodies += each.bodies;
    sum.volume += each.volume;
    sum.area += each.area;
  }
  return sum;
}

void printTable(const engine::RunReport& run, const std::vector<Figures>& pieces, const clay::TopologyReport& skin,
                const SculptOptions& options) {
  const auto row = [](const char* what, const std::string& value) { fmt::print("  {:<26} {}\n", what, value); };
  fmt::print("  {:<26} {:>8} {:>8} {:>8}\n", "", "median", "p99", "p99.9");
  row("strokes",
      fmt::format("{} ({} points, {} stamps, {} versions)", run.strokes, run.points, run.stamps, run.versions));
  row("edit latency", timingText(run.edit));
  if (run.servo) {
    const engine::ServoReport& s = *run.servo;
    row("servo compute", timingText(s.compute));
    if (s.lateness) row("servo lateness", timingText(*s.lateness));
    if (s.bareLateness) row("bare sleep loop", timingText(*s.bareLateness));
    row("servo ticks", fmt::format("{} ({} touching, {} cutting; {} overrun, {} missed, {} samples dropped)", s.ticks,
                                   s.touching, s.cutting, s.overrun, s.missed, s.dropped));
    row("peak force", fmt::format("{:.2f} N of {:.2f} N ({})", s.peakForceN, s.forceLimitN, options.device));
    if (s.stalls > 0)
      row("stalls", fmt::format("{}: the machine stood still so long that the watchdog let go of the force", s.stalls));
    if (s.waiting > 0)
      row("waited", fmt::format("{} ticks: the force was away for long, and the tool rested until the stylus was moved "
                                "away from what it touched",
                                s.waiting));
    if (!s.grant.empty()) row("real time", s.grant);
    if (!s.fault.empty()) row("force stopped", s.fault);
  }
  row("triangles", fmt::format("{} on {} vertices", skin.triangles, skin.vertices));
  row("closed", skin.closed() ? "yes: every edge in two faces, every vertex one fan"
                              : fmt::format("NO: {} boundary edges, {} non-manifold edges, {} non-manifold vertices",
                                            skin.boundaryEdges, skin.nonManifoldEdges, skin.nonManifoldVertices));
  row("volume", engine::figure(skin.volume, 6) + " mm³");
  for (const Figures& piece : pieces) {
    const clay::Version& version = piece.version;
    const std::string clay =
        fmt::format("voxels of {:g} mm, {} bricks, {:.1f} MiB", version.grid().voxelMm, version.stats().bricks,
                    static_cast<double>(version.stats().bytes()) / (1 << 20));
    if (pieces.size() == 1)
      row("clay", clay);
    else
      row(piece.name.c_str(), fmt::format("{} mm³, {}", engine::figure(piece.skin.volume, 6), clay));
  }
}

ordered_json surfaceJson(const clay::TopologyReport& skin) {
  return {{"triangles", skin.triangles},
          {"vertices", skin.vertices},
          {"boundary_edges", skin.boundaryEdges},
          {"non_manifold_edges", skin.nonManifoldEdges + skin.flippedEdges},
          {"non_manifold_vertices", skin.nonManifoldVertices},
          {"closed", skin.closed()},
          {"bodies", skin.bodies},
          {"volume_mm3", skin.volume},
          {"area_mm2", skin.area},
          {"low_mm", {skin.low.x(), skin.low.y(), skin.low.z()}},
          {"high_mm", {skin.high.x(), skin.high.y(), skin.high.z()}}};
}

ordered_json clayJson(const clay::Version& version) {
  return {{"voxel_mm", version.grid().voxelMm},
          {"bricks", version.stats().bricks},
          {"bytes", version.stats().bytes()},
          {"hash", fmt::format("{:016x}", version.hash())}};
}

// What stands in the way of printing the pieces that are seen, told and for the report; null where nobody asked.
ordered_json printOf(const engine::Script& script, const engine::Document& document, Job* job) {
  if (!script.print) return {};
  const engine::PrintProcess process = engine::printProcess(*script.print);
  ordered_json all{{"print", ordered_json::array()}};
  for (const engine::Piece& piece : document.pieces) {
    if (!piece.visible || piece.version.stats().bricks == 0) continue;
    const engine::PrintReport report = engine::checkPrint(piece.version, piece.pose, process, job);
    fmt::print("{}: ", io::displayName(piece.name));
    sayPrint(process, report);
    all["print"].push_back({{"name", piece.name}, {"print", printJson(process, report)}});
  }
  const Meetings met = meetings(document, process.gapMm, job);
  sayMeetings(met, process.gapMm);
  all["pieces_that_meet"] = meetingsJson(met);
  return all;
}

ordered_json reportJson(const engine::RunReport& run, const std::vector<Figures>& pieces,
                        const clay::TopologyReport& skin, const clay::Version& version, const ordered_json& print) {
  ordered_json json;
  json["strokes"] = run.strokes;
  json["points"] = run.points;
  json["stamps"] = run.stamps;
  json["versions"] = run.versions;
  json["unchanged_strokes"] = run.idle;
  json["edit_latency"] = timingJson(run.edit);
  if (run.servo) {
    const engine::ServoReport& s = *run.servo;
    json["servo"] = {{"ticks", s.ticks},
                     {"touching", s.touching},
                     {"cutting", s.cutting},
                     {"overrun", s.overrun},
                     {"missed", s.missed},
                     {"dropped", s.dropped},
                     {"clamped", s.clamped},
                     {"stalls", s.stalls},
                     {"waiting", s.waiting},
                     {"compute", timingJson(s.compute)},
                     {"edit_to_feel", timingJson(s.editToFeel)},
                     {"peak_force_n", s.peakForceN},
                     {"force_limit_n", s.forceLimitN},
                     {"fault", s.fault}};
    if (s.lateness) json["servo"]["lateness"] = timingJson(*s.lateness);
    if (s.bareLateness) json["servo"]["bare_lateness"] = timingJson(*s.bareLateness);
    json["servo"]["real_time"] = s.grant;
  }
  json["surface"] = surfaceJson(skin);
  if (version) json["clay"] = clayJson(version);
  for (const Figures& piece : pieces)
    json["pieces"].push_back(
        {{"name", piece.name}, {"surface", surfaceJson(piece.skin)}, {"clay", clayJson(piece.version)}});
  if (!print.is_null()) json.update(print);
  json["notes"] = run.notes;
  return json;
}

}  // namespace

void sculpt(const SculptOptions& options) {
  const clay::JobScope surfaces(options.job);
  // What is wrong with the call is told before the work.
  static_cast<void>(render::View::named(options.view, {}, 1));
  static_cast<void>(haptics::deviceSheet(options.device));
  for (const std::filesystem::path& file : options.outputs) {
    if (!engine::holdsClay(file.filename())) io::requireWritable(file);
  }
  std::optional<engine::Quality> quality;
  if (!options.quality.empty()) quality = engine::readQualityHere(options.quality);
  engine::Script script = engine::readScript(options.script);
  if (quality) script.use(*quality);
  io::Files inputs{options.script, options.input}, outputs = options.outputs;
  if (const auto* import = std::get_if<engine::ImportSetup>(&script.clay)) inputs.push_back(import->file);
  for (const engine::ScriptStroke& stroke : script.strokes) inputs.emplace_back(stroke.tool.file);
  for (const std::filesystem::path& file : {options.png, options.beforePng, options.report, options.record})
    outputs.push_back(file);
  io::requireNewFiles(inputs, outputs, options.overwrite);
  engine::PrepareOptions prepare;
  prepare.input = options.input;
  prepare.voxelMm = options.voxelMm;
  prepare.job = options.job;
  engine::PreparedClay clay = [&] {
    const ProgressLine line("making clay", options.job);
    return engine::prepareClay(clay::Store::make(options.bits ? precisionOf(*options.bits) : script.bits()), script,
                               prepare);
  }();
  for (const std::string& note : clay.notes) fmt::print("{}\n", note);
  engine::Session session(std::move(clay.document));
  const std::optional<double> voxelMm = clay.version ? std::optional(clay.version.grid().voxelMm) : std::nullopt;
  clay.version = {};
  const engine::Quality used = script.quality.value_or(engine::Quality());
  const clay::Grade drawn = options.surface.value_or(used.surface);
  clay::Surface surface(true, drawn);

  // The clay of the strokes alone is followed in the picture; what is several pieces is drawn anew.
  const engine::DocumentPtr begun = session.document();
  const bool simple = script.operations.empty() && begun->pieces.size() == 1 && begun->parts.empty() &&
                      begun->pieces[0].visible && begun->pieces[0].pose.translation.isZero(0) &&
                      begun->pieces[0].pose.rotation.vec().isZero(0);
  const double aspect = static_cast<double>(options.size[0]) / options.size[1];
  std::optional<render::Renderer> renderer;
  render::View view;
  uint64_t uploaded = 0;
  if (!options.png.empty() || !options.beforePng.empty()) {
    renderer.emplace();
    if (simple) {
      uploaded = renderer->update(surface.update(session.version(), 2)).bytes;
    } else {
      showDocument(*begun, drawn, *renderer);
    }
    view = render::View::named(options.view, renderer->bounds(), aspect);
    if (!options.beforePng.empty())
      render::writePng(renderer->render(view, {}, options.size[0], options.size[1]), options.beforePng.string());
  }

  engine::RunOptions run;
  run.live = options.live;
  run.device = options.device;
  run.job = options.job;
  ChangedSurface changed;
  if (!options.png.empty() && simple) run.onSurface = [&](const clay::SurfaceDelta& delta) { changed.add(delta); };
  const engine::RunReport report = [&] {
    try {
      return engine::runScript(session, surface, script, run);
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& error) {
      throw Error(fmt::format("{}: {}", io::displayName(options.script), error.what()), error.kind());
    }
  }();
  for (const std::string& note : report.notes) fmt::print("{}\n", note);

  // What is told is what is written, where something is.
  const clay::Grade written = options.surface.value_or(used.exported), told = options.outputs.empty() ? drawn : written;
  if (told != drawn) surface = clay::Surface(true, drawn);  // two of them may be more than there is memory
  const std::vector<Figures> pieces = figuresOf(*session.document(), told == drawn ? &surface : nullptr, told);
  if (pieces.empty()) throw Error(fmt::format("{}: leaves no piece that is seen", io::displayName(options.script)));
  const clay::TopologyReport skin = together(pieces);
  printTable(report, pieces, skin, options);
  if (!options.png.empty()) {
    render::Overlays overlays;
    if (simple) {
      const uint64_t bytes = changed.empty() ? 0 : renderer->update(changed.delta()).bytes;
      overlays.cursor = shownCursor(report.recorded, session.version(), *renderer, view);
      fmt::print("  {:<26} {:.1f} MB for the whole model, {:.1f} MB for what changed; drawn by {}\n", "picture",
                 static_cast<double>(uploaded) * 1e-6, static_cast<double>(bytes) * 1e-6, renderer->deviceName());
    } else {
      renderer.emplace();
      showDocument(*session.document(), drawn, *renderer);
      view = render::View::named(options.view, renderer->bounds(), aspect);
    }
    render::writePng(renderer->render(view, overlays, options.size[0], options.size[1]), options.png.string());
  }
  engine::ModelExport how;
  how.grade = written;
  std::vector<std::filesystem::path> models;
  for (const std::filesystem::path& file : options.outputs) {
    if (file.extension() == ".argil") {
      const ProgressLine line("writing " + file.filename().string(), options.job);
      engine::SaveRequest request;
      request.states = session.states();
      request.done = session.undoSteps();
      request.documentRecords = std::make_shared<engine::DocumentRecords>();
      request.writer = engine::newWriter();
      if (const auto base = engine::saveDocument(file, request, options.job); !base->unflushed.empty())
        throw Error(base->unflushed, Error::Kind::work);
    } else {
      models.push_back(file);
    }
  }
  if (!models.empty()) {
    surface = clay::Surface();
    const ProgressLine line("writing " + models.front().filename().string(), options.job);
    for (const std::string& sentence : engine::writeModelFiles(models, *session.document(), how, options.job))
      fmt::print("{}\n", sentence);
  }
  if (!options.record.empty()) {
    engine::Script recorded = script;
    recorded.strokes = report.recorded.strokes;
    recorded.operations = report.recorded.operations;
    recorded.voxelMm = voxelMm;
    if (!options.input.empty()) recorded.clay = engine::ImportSetup{std::filesystem::absolute(options.input)};
    engine::writeScript(options.record, recorded);
  }
  // What cannot be looked at, limits of too many voxels, takes nothing of the work along: it is written by now.
  const ordered_json print = printOf(script, *session.document(), options.job);
  if (!options.report.empty()) {
    const std::string text = reportJson(report, pieces, skin, session.version(), print).dump(2) + "\n";
    io::AtomicFile out(options.report);
    out.write(std::as_bytes(std::span(text)));
    out.commit();
  }
  if (!skin.closed())
    throw Error("the surface is not closed: this is a fault of Argil; please report it with the script",
                Error::Kind::work);
}

}  // namespace argil::cli
