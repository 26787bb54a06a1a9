#include "bench/tradeoff/work.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>

#include "bench/known_shapes.h"
#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/import/mesh_to_clay.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "engine/saving/session.h"
#include "engine/session/feel.h"
#include "engine/tools/tool_table.h"
#include "io/models/model_file.h"

namespace argil::bench {

namespace {

using clay::Grid;
using clay::Version;
using engine::Quality;
using engine::QualityPart;

// Of places and distances, both ways.
struct Gathered {
  double squares = 0, most = 0;
  uint64_t count = 0;
  void add(double distance) {
    squares += distance * distance;
    most = std::max(most, distance);
    ++count;
  }
  [[nodiscard]] TradeoffError error(double bytes) const {
    return {count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0, most, bytes};
  }
};

TradeoffError offFrom(const Turned& truth, const clay::TriangleMesh& mesh, double bytes) {
  Gathered all;
  for (const Vec3d& p : mesh.positions) all.add(truth.distance(p));
  const clay::NearestTriangle nearest(mesh);
  uint32_t hint = UINT32_MAX;
  for (const Vec3d& p : truth.places()) {
    const auto hit = nearest.nearest(p, hint);
    hint = hit.triangle;
    all.add(std::sqrt(hit.squared));
  }
  return all.error(bytes);
}

class ShapeWork : public TradeoffWork {
 public:
  explicit ShapeWork(const Ring& ring) : ring_(ring) { name = ring.name; }
  void run(const Quality& quality) override {
    version_ = ringOn(ring_, ballOf(quality, gridOf(quality)), quality.strokes);
    surface_.emplace(true, clay::Grade::crisp);
    surface_->update(version_);
  }
  TradeoffError error() override {
    return offFrom(turnedOf(ring_), surface_->toMesh(), static_cast<double>(version_.stats().bytes()));
  }

 private:
  Ring ring_;
  Version version_;
  std::optional<clay::Surface> surface_;
};

// A mesh made clay, or the surface of that alone.
class MeshWork : public TradeoffWork {
 public:
  MeshWork(const std::string& model, clay::TriangleMesh mesh, bool making) : making_(making), mesh_(std::move(mesh)) {
    name = model;
    Vec3d low = mesh_.positions.front(), high = low;
    for (const Vec3d& p : mesh_.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
    const double factor = 2 * kBallMm / (high - low).maxCoeff();
    for (Vec3d& p : mesh_.positions) p = (p - low) * factor;
    // Corners, and of each triangle edges and inside: evenly enough, for a mesh is of triangles alike or of few.
    const size_t each = std::max<size_t>(2, 20'000 / mesh_.triangles.size());
    places_ = mesh_.positions;
    for (const auto& t : mesh_.triangles)
      for (size_t i = 0; i < each; ++i) {
        const Vec3d &a = mesh_.positions[t[0]], &b = mesh_.positions[t[1]], &c = mesh_.positions[t[2]];
        const double u = (static_cast<double>(i) + 0.5) / static_cast<double>(each),
                     v = std::fmod(0.618034 * static_cast<double>(i), 1 - u);
        places_.push_back(i % 2 == 0 ? Vec3d(a + u * (b - a)) : Vec3d(a + u * (b - a) + v * (c - a)));
      }
    if (!making_) version_ = made({});
  }
  void run(const Quality& quality) override {
    if (making_) version_ = made(quality);
    surface_.emplace(true, quality.surface);
    surface_->update(version_);
  }
  TradeoffError error() override {
    const clay::TriangleMesh now = surface_->toMesh();
    const clay::NearestTriangle there(mesh_), here(now);
    Gathered all;
    const auto look = [&](const std::vector<Vec3d>& places, const clay::NearestTriangle& nearest) {
      uint32_t hint = UINT32_MAX;
      for (const Vec3d& p : places) {
        const auto hit = nearest.nearest(p, hint);
        hint = hit.triangle;
        all.add(std::sqrt(hit.squared));
      }
    };
    look(now.positions, there);
    look(places_, here);
    return all.error(making_ ? static_cast<double>(version_.stats().bytes()) : 0);
  }

 private:
  Version made(const Quality& quality) const {
    clay::ImportOptions options;
    options.grid = gridOf(quality);
    options.grid.originMm = Vec3d::Zero();
    options.threads = 1;
    return clay::meshToClay(clay::Store::make(quality.clay.precision()), mesh_, options).version;
  }

  bool making_;
  clay::TriangleMesh mesh_;
  std::vector<Vec3d> places_;
  Version version_;
  std::optional<clay::Surface> surface_;
};

// A box that lies askew.
clay::TriangleMesh askewBox() {
  clay::TriangleMesh mesh;
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(0.297, Vec3d::UnitX()) * Eigen::AngleAxisd(0.506, Vec3d::UnitY()) *
                                Eigen::AngleAxisd(0.716, Vec3d::UnitZ()))
                                   .toRotationMatrix();
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back(turn * Vec3d(i >> 2 ? 10 : -10, i >> 1 & 1 ? 8 : -8, i & 1 ? 6 : -6));
  mesh.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                    {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
  return mesh;
}

std::vector<std::pair<std::string, clay::TriangleMesh>> meshes() {
  std::vector<std::pair<std::string, clay::TriangleMesh>> all{{"box", askewBox()}};
  const char* data = std::getenv("ARGIL_DATA");
  for (const char* model : {"fandisk"}) {
    const auto file = std::filesystem::path(data ? data : "") / "mesh" / (std::string(model) + ".obj");
    if (!data || !std::filesystem::exists(file)) continue;
    io::ModelFile read = io::readModel(file);
    all.emplace_back(model, io::merged(std::move(read.objects)).mesh);
  }
  return all;
}

// A tool drawn over a ball that has a ridge, with sharp turns, beside the same with everything at its dearest.
class StrokeWork : public TradeoffWork {
 public:
  explicit StrokeWork(const char* tool) : tool_(engine::standardTool(*engine::findTool(tool))) {
    name = tool;
    Quality quality;
    quality.clay.voxelsAcross = kAcross;
    start_ = ringOn(kRings[3], ballOf(quality, gridOf(quality)), {});
    tool_.radiusMm = 3;
    tool_.heightMm = tool_.blendMm = 1;
    tool_.radiusByPressure = tool_.strengthByPressure = 0;
  }
  void run(const Quality& quality) override { version_ = stroke(quality.strokes); }
  TradeoffError error() override {
    if (!dearest_) dearest_ = stroke(dearest());
    // Beside the surface, how far that lies off; elsewhere in the band how wrong distances are to the surface there is.
    Gathered all;
    const clay::TriangleMesh mesh = [&] {
      clay::Surface surface(false, clay::Grade::crisp);
      surface.update(version_);
      return surface.toMesh();
    }();
    const clay::NearestTriangle nearest(mesh);
    uint32_t hint = UINT32_MAX;
    const float band = version_.grid().band;
    const double voxelMm = version_.grid().voxelMm;
    dearest_.forEachBrick([&](const clay::Brick& brick) {
      const clay::Slot was = start_.find(brick.coord), one = dearest_.find(brick.coord),
                       other = version_.find(brick.coord);
      if (one == was) return;
      for (int v = 0; v < clay::kBrickVoxels; ++v) {
        const auto p = static_cast<double>(one.phi(v, band)), q = static_cast<double>(other.phi(v, band));
        if (std::abs(p) < 1) {
          all.add(std::abs(p - q) * voxelMm);
        } else if (v % kEvery == 0 && std::abs(q) < static_cast<double>(band)) {
          const Vec3d at((brick.coord.x * clay::kBrickEdge) + (v >> 6),
                         (brick.coord.y * clay::kBrickEdge) + (v >> 3 & 7),
                         (brick.coord.z * clay::kBrickEdge) + (v & 7));
          const auto hit = nearest.nearest(version_.grid().toWorld(at), hint);
          hint = hit.triangle;
          all.add(
              std::abs(std::min(std::sqrt(hit.squared), static_cast<double>(band) * voxelMm) - std::abs(q) * voxelMm));
        }
      }
    });
    return all.error(static_cast<double>(version_.stats().bytes()));
  }
  static engine::StrokeQuality dearest() {
    engine::StrokeQuality quality;
    quality.spacing = 0.02;
    quality.minSpacingVoxels = 0.1;
    quality.clay = {
        .tolerance = 0.01, .passes = 16, .drift = 0.25, .trail = 1, .together = 0, .flowStep = 0.02, .levelRounds = 8};
    return quality;
  }

 private:
  static constexpr double kAcross = 128;
  static constexpr int kEvery = 5;  // voxels of the band that are looked at
  Version stroke(const engine::StrokeQuality& quality) const {
    engine::Session session(start_);
    engine::Tool tool = tool_;
    tool.quality = quality;
    session.beginStroke(tool);
    constexpr int kPoints = 60;
    for (int i = 0; i <= kPoints; ++i) {
      const double t = static_cast<double>(i) / kPoints, zig = std::abs(std::fmod(6 * t, 2.0) - 1);
      const double along = 1.6 * t - 0.8, across = 0.35 * (zig - 0.5);
      session.addPoint(0.01 * i, (kBallMm - 1) * Vec3d(std::cos(along) * std::cos(across),
                                                       std::sin(along) * std::cos(across), std::sin(across)));
    }
    return session.endStroke();
  }

  engine::Tool tool_;
  Version start_, version_, dearest_;
};

// A tool that reads the band far from the surface, beside the same in the widest band, at voxels of one size: what a
// band does is counted in voxels.
class BandWork : public TradeoffWork {
 public:
  explicit BandWork(const char* tool) : tool_(tool) { name = std::string(tool) + " in a band"; }
  void run(const Quality& quality) override { version_ = stroke(quality); }
  TradeoffError error() override {
    if (!truth_) {
      Quality widest;
      widest.clay.band = kWidest;
      truth_ = stroke(widest);
    }
    Gathered all;
    const float band = version_.grid().band;
    truth_.forEachBrick([&](const clay::Brick& brick) {
      const clay::Slot one = truth_.find(brick.coord), other = version_.find(brick.coord);
      for (int v = 0; v < clay::kBrickVoxels; ++v)
        if (const float p = one.phi(v, static_cast<float>(kWidest)); std::abs(p) < 1)
          all.add(std::abs(static_cast<double>(p - other.phi(v, band))) * version_.grid().voxelMm);
    });
    return all.error(static_cast<double>(version_.stats().bytes()));
  }

 private:
  Version stroke(const Quality& quality) const {
    constexpr Ring kWhole{"", "", 3, kBallMm - 1};
    Ring ring = kWhole;
    ring.tool = tool_;
    Quality here = quality;
    here.clay.voxelsAcross = 128;
    return ringOn(ring, ballOf(here, gridOf(here)), {});
  }
  static constexpr double kWidest = 8;
  const char* tool_;
  Version version_, truth_;
};

// A ball felt along a path, beside the same with everything at its dearest.
class TouchWork : public TradeoffWork {
 public:
  TouchWork(const char* what, double speedMms, bool held) : held_(held) {
    name = fmt::format("{} {:g} mm/s{}", what, speedMms, held ? " held" : "");
    unit = "N";
    Quality quality;
    quality.clay.voxelsAcross = kAcross;
    const bool rough = std::string_view(what) == "groove";
    Version ball = ballOf(quality, gridOf(quality));
    scene_.pieces.emplace_back().version = rough ? ringOn(kRings[1], std::move(ball), {}) : std::move(ball);
    scene_.tool.radiusMm = 1;
    // Around the ball across its equator, a little into it.
    const double reach = kBallMm + scene_.tool.radiusMm - 0.7, around = 2 * std::numbers::pi * reach;
    path_ = haptics::HandPath::circle(Vec3d::Zero(), Vec3d(reach, 0, 0), Vec3d(0.1, 1, 0).normalized(),
                                      std::min(1.0, speedMms * kSeconds / around), kSeconds);
  }
  void run(const Quality& quality) override { felt_ = feel(quality); }
  TradeoffError error() override {
    if (dearest_.ticks.empty()) {
      Quality all;
      all.touch = {.contactSteps = 64, .contactSearches = 200, .smoothNormals = true};
      all.servoHz = kDearestHz;
      dearest_ = feel(all);
    }
    // How far it is off, and how much that changes within a time that fingers feel as roughness.
    Gathered off;
    std::vector<Vec3d> before(kRoughTicks, Vec3d::Zero());
    size_t at = 0;
    for (size_t i = 0; i < dearest_.ticks.size(); ++i) {
      const engine::FeelTick& tick = dearest_.ticks[i];
      while (at + 1 < felt_.ticks.size() && felt_.ticks[at + 1].timeS <= tick.timeS + 1e-9) ++at;  // a device holds it
      const Vec3d now = felt_.ticks[at].force - tick.force;
      off.add(now.norm());
      if (i >= kRoughTicks) off.add((now - before[i % kRoughTicks]).norm());
      before[i % kRoughTicks] = now;
    }
    return off.error(0);
  }

 private:
  static constexpr double kSeconds = 1, kAcross = 80, kDearestHz = 8000;
  static constexpr size_t kRoughTicks = 32;  // 4 ms of the dearest
  engine::FeelRun feel(const Quality& quality) {
    scene_.quality = quality.touch;
    engine::FeelOptions options;
    options.rateHz = quality.servoHz;
    options.freeHand = held_;
    return engine::feel(scene_, path_, options);
  }
  bool held_;  // by a simulated hand, in closed loop with a device; else the path is where the ball is
  haptics::Scene scene_;
  haptics::HandPath path_;
  engine::FeelRun felt_, dearest_;
};

// A known shape's surface alone.
class SurfaceWork : public TradeoffWork {
 public:
  explicit SurfaceWork(const Ring& ring) : ring_(ring) {
    name = ring.name;
    const Quality quality;
    version_ = ringOn(ring, ballOf(quality, gridOf(quality)), {});
  }
  void run(const Quality& quality) override {
    surface_.emplace(true, quality.surface);
    surface_->update(version_);
  }
  TradeoffError error() override { return offFrom(turnedOf(ring_), surface_->toMesh(), 0); }

 private:
  Ring ring_;
  Version version_;
  std::optional<clay::Surface> surface_;
};

}  // namespace

std::vector<std::unique_ptr<TradeoffWork>> tradeoffWork(QualityPart part) {
  std::vector<std::unique_ptr<TradeoffWork>> all;
  switch (part) {
    case QualityPart::clay:
      for (const Ring& ring : kRings) all.push_back(std::make_unique<ShapeWork>(ring));
      for (auto& [name, mesh] : meshes()) all.push_back(std::make_unique<MeshWork>(name, std::move(mesh), true));
      for (const char* tool : {"scrape", "inflate", "tug"}) all.push_back(std::make_unique<BandWork>(tool));
      break;
    case QualityPart::strokes:
      for (const char* tool : {"carve", "wax", "smooth", "scrape", "inflate", "tug", "crease", "twist"})
        all.push_back(std::make_unique<StrokeWork>(tool));
      break;
    case QualityPart::touch:
      for (const double speed : {20.0, 100.0, 400.0})
        for (const char* what : {"ball", "groove"})
          for (const bool held : {false, true}) all.push_back(std::make_unique<TouchWork>(what, speed, held));
      break;
    case QualityPart::surface:
      for (const Ring& ring : kRings) all.push_back(std::make_unique<SurfaceWork>(ring));
      for (auto& [name, mesh] : meshes()) all.push_back(std::make_unique<MeshWork>(name, std::move(mesh), false));
      break;
  }
  return all;
}

}  // namespace argil::bench
