#include "tests/counts/counted/pieces_of_work.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>

#include "clay/field/primitives.h"
#include "clay/kernels/brush_kernels.h"
#include "clay/kernels/smoothing_kernels.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"
#include "clay/whole/resample.h"
#include "clay/whole/smooth_all.h"
#include "engine/saving/session.h"
#include "engine/tools/added_tools.h"
#include "engine/tools/tool_table.h"
#include "haptics/devices/hand_path.h"
#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/scene/texture.h"
#include "haptics/servo/servo.h"

namespace argil::tests {
namespace {

using clay::Grid;
using clay::Version;
using engine::Document;
using engine::Session;

constexpr double kRadius = 12, kVoxel = 0.25, kTip = 3, kStep = 0.4;  // mm
constexpr double kSmallTip = 0.75;

Version ball(const Vec3d& at = Vec3d::Zero(), double radius = kRadius) {
  Grid grid;
  grid.voxelMm = kVoxel;
  return clay::makeSphere(clay::Store::make(), grid, at, radius);
}

engine::Piece pieceOf(Version version) {
  engine::Piece piece;
  piece.version = std::move(version);
  return piece;
}

// A place on the way around the ball, and no two rounds are the same.
Vec3d onTheWay(double mm) {
  const double angle = mm / kRadius, tilt = 0.3 * std::sin(angle * 0.37);
  return kRadius * Vec3d(std::cos(angle) * std::cos(tilt), std::sin(angle) * std::cos(tilt), std::sin(tilt));
}

// A hand that works on a document: so many points of one stroke.
struct Hand {
  Session session;
  engine::Tool tool;
  int step = 0;

  Hand(Document document, std::string_view id, double radiusMm)
      : session(std::move(document)), tool(engine::standardTool(*engine::findTool(id))) {
    tool.radiusMm = radiusMm;
  }
  void stroke(int points) {
    session.beginStroke(tool);
    for (int i = 0; i < points; ++i, ++step) session.addPoint(0.002 * i, onTheWay(step * kStep * tool.radiusMm / kTip));
    session.endStroke();
  }
};

PieceOfWork strokesOf(std::string name, std::string_view tool, const std::function<Document()>& document, int times,
                      double radiusMm = kTip) {
  return {std::move(name), times, [=] {
            auto hand = std::make_shared<Hand>(document(), tool, radiusMm);
            return [hand](int points) { hand->stroke(points); };
          }};
}

Document plain() {
  return Document::of(ball());
}

// The same with another piece beside it, which has what `change` gives it.
Document beside(const std::function<void(engine::Piece&)>& change = nullptr) {
  Document document = plain();
  engine::Piece other = pieceOf(ball({60, 0, 0}, 5));
  if (change) change(other);
  document.add(std::move(other));
  return document;
}

void fill(engine::Piece& piece, clay::Channel channel) {
  clay::Editor editor(piece.version);
  std::array<uint8_t, clay::kBrickVoxels> values;
  values.fill(200);
  piece.version.forEachBrick([&](const clay::Brick& brick) { editor.setChannel(channel, brick.coord, values); });
  piece.version = editor.commit();
}

// A servo whose hand presses into a block and slides along it.
struct Touch {
  haptics::Published<haptics::Scene> published;
  haptics::SimulatedDevice device;
  haptics::Servo servo;

  static haptics::HandPath path() {
    std::vector<haptics::HandPoint> points;
    for (int i = 0; i < 200; ++i) {
      haptics::HandPoint point;
      point.timeS = 0.05 * i;
      point.position = Vec3d(0.1 * i - 10, 0, i == 0 ? 5 : 2);
      points.push_back(point);
    }
    return haptics::HandPath(std::move(points));
  }
  explicit Touch(haptics::Scene scene)
      : device(haptics::deviceSheet("touchx"), path(), {}), servo(device, published, {.measureCompute = false}) {
    scene.tool.radiusMm = kTip;
    published.publish(std::make_unique<const haptics::Scene>(std::move(scene)));
  }
};

Document block() {
  Grid grid;
  grid.voxelMm = kVoxel;
  return Document::of(clay::makeBlock(clay::Store::make(), grid, {0, 0, -5}, {40, 20, 10}, 1));
}

PieceOfWork ticksOf(std::string name, const std::function<haptics::Scene()>& scene) {
  return {std::move(name), 1000, [=] {
            auto touch = std::make_shared<Touch>(scene());
            return [touch](int ticks) { touch->servo.runVirtual(static_cast<uint64_t>(ticks)); };
          }};
}

// Where a slowdown of a part would be a small share of the whole.
void addKernels(std::vector<PieceOfWork>& all) {
  struct Room {
    float broad[clay::kBroadSize] = {}, wide[clay::kWideSize] = {}, padded[clay::kPaddedSize] = {};
    clay::BrickValues out;
    clay::Editor editor{Version::empty(clay::Store::make(), Grid{})};
    clay::FloatBrick* brick = editor.newBrick({0, 0, 0});
    uint64_t frozen[clay::kBrickEdge] = {};
  };
  const auto kernel = [&](const char* name, const std::function<void(Room&)>& work) {
    all.push_back({name, 1000, [=] {
                     auto room = std::make_shared<Room>();
                     // The distances to a plane that lies across.
                     const auto phi = [](int x, int y, int z) { return 0.6f * x + 0.64f * y + 0.48f * z - 6; };
                     for (int x = 0; x < 16; ++x)
                       for (int y = 0; y < 16; ++y)
                         for (int z = 0; z < 16; ++z) room->broad[clay::broadOffset(x, y, z)] = phi(x, y, z);
                     for (int x = 0; x < 12; ++x)
                       for (int y = 0; y < 12; ++y)
                         for (int z = 0; z < 12; ++z) room->wide[clay::wideOffset(x, y, z)] = phi(x, y, z);
                     for (int x = 0; x < 10; ++x)
                       for (int y = 0; y < 10; ++y)
                         for (int z = 0; z < 10; ++z)
                           room->padded[clay::paddedOffset(x, y, z)] = std::abs(phi(x, y, z));
                     return [=](int times) {
                       for (int i = 0; i < times; ++i) work(*room);
                     };
                   }});
  };
  const clay::SweptBall tip{3, 3, 3, 2, 1, 0, 0.2f, 4, 0};
  kernel("carve-kernel", [=](Room& r) {
    clay::BrickValues solid;
    clay::ballDistances(tip, solid);
    (void)clay::takeAwaySolid(solid, 3, r.out, *r.brick);
  });
  kernel("mean-kernel", [](Room& r) { (void)clay::broadMeans(r.broad, 4, 0, 3, r.out); });
  kernel("distance-kernel", [](Room& r) { (void)clay::eikonalPass(r.padded, r.frozen, ~uint64_t{0}, 3, r.out); });
  kernel("wide-distance-kernel", [](Room& r) { (void)clay::widePass(r.wide, r.frozen, ~uint64_t{0}, 3, r.out); });
}

// A hundred tools of plugins, which stay: behind all that is counted without them.
void addTools() {
  for (int i = 0; i < 100; ++i) {
    engine::AddedTool tool;
    tool.id = fmt::format("counted.{}", i);
    tool.name = "Counted", tool.help = "Adds.", tool.formula = "phi - weight";
    (void)engine::addedTools().add(tool);
  }
}

haptics::Scene felt(const Document& document) {
  return sceneOf(document, {});
}

}  // namespace

std::vector<PieceOfWork> piecesOfWork() {
  std::vector<PieceOfWork> all;
  // What the program does most of its time.
  for (const auto& [tool, points] : {std::pair("carve", 100), std::pair("add", 100), std::pair("smooth", 10),
                                     std::pair("scrape", 40), std::pair("inflate", 40), std::pair("tug", 20)})
    all.push_back(strokesOf(tool, tool, plain, points));
  all.push_back({"surface", 100, [] {
                   auto hand = std::make_shared<Hand>(plain(), "carve", kTip);
                   auto surface = std::make_shared<clay::Surface>(true, clay::Grade::crisp);
                   surface->update(hand->session.version());
                   return [=](int times) {
                     for (int i = 0; i < times; ++i) {
                       hand->stroke(1);
                       surface->update(hand->session.version());
                     }
                   };
                 }});
  const auto wholePiece = [&](const char* name, const std::function<void(const Version&)>& work) {
    all.push_back({name, 20, [=] {
                     const Version small = ball(Vec3d::Zero(), 1.5);
                     return [=](int times) {
                       for (int i = 0; i < times; ++i) work(small);
                     };
                   }});
  };
  const Version second = ball({1, 0.3, 0.2}, 1.2);
  wholePiece("join", [second](const Version& v) { (void)clay::combine(v, second, clay::Combination::join); });
  wholePiece("smooth-all", [](const Version& v) { (void)clay::smoothAll(v, 4, true, 1); });
  wholePiece("resample", [](const Version& v) {
    Grid coarse = v.grid();
    coarse.voxelMm *= 1.5;
    (void)clay::resample(v, coarse, Eigen::Isometry3d::Identity(), 1);
  });
  all.push_back(ticksOf("tick", [] { return felt(block()); }));
  addKernels(all);

  // What a scene does not use: each beside the same without it (docs/figures/instructions.md).
  const auto carving = [&](const char* feature, const std::function<Document()>& document) {
    all.push_back(strokesOf(std::string("dab:") + feature, "carve", document, 100, kSmallTip));
  };
  carving("none", plain);
  carving("second-piece", [] { return beside(); });
  carving("mask", [] { return beside([](engine::Piece& p) { fill(p, clay::Channel::mask); }); });
  carving("channel", [] { return beside([](engine::Piece& p) { fill(p, clay::Channel::red); }); });
  carving("material", [] {
    Document document = plain();
    document.pieces[0].materials.resize(3);
    return document;
  });
  carving("guide", [] {
    Document document = plain();
    engine::Guide guide;
    guide.feel = engine::Guide::Feel::lock;
    document.add(guide);
    return document;
  });
  carving("mirror", [] {
    Document document = plain();
    document.symmetry.pose.translation = Vec3d(3, 0, 0);
    return document;
  });
  all.push_back({"dab:history", 100, [] {
                   auto hand = std::make_shared<Hand>(plain(), "carve", kSmallTip);
                   for (int i = 0; i < 300; ++i)
                     hand->session.change("Rename", [&](Document& d) { d.pieces[0].name = std::to_string(i); });
                   return [hand](int points) { hand->stroke(points); };
                 }});
  const auto touching = [&](const char* feature, const std::function<void(haptics::Scene&)>& change,
                            const std::function<void(Document&)>& document) {
    all.push_back(ticksOf(std::string("tick:") + feature, [=] {
      Document made = block();
      if (document) document(made);
      haptics::Scene scene = felt(made);
      if (change) change(scene);
      return scene;
    }));
  };
  touching("none", nullptr, nullptr);
  touching("second-piece", nullptr, [](Document& d) {
    d.add(pieceOf(ball({200, 0, 0}, 5)));
    d.pieces.back().visible = false;
  });
  // Not off: it can be felt, and how far it is has to be known.
  touching("piece-far-away", nullptr, [](Document& d) { d.add(pieceOf(ball({200, 0, 0}, 5))); });
  touching("mask", nullptr, [](Document& d) {
    engine::Piece masked = pieceOf(ball({200, 0, 0}, 5));
    fill(masked, clay::Channel::mask);
    masked.visible = false;
    d.add(std::move(masked));
  });
  touching("material", nullptr, [](Document& d) { d.pieces[0].materials.resize(3); });
  touching(
      "texture",
      [](haptics::Scene& s) { s.textures.push_back(std::make_shared<const haptics::Texture>(haptics::Ridges{})); },
      nullptr);
  touching("guide", nullptr, [](Document& d) {
    engine::Guide guide;  // seen, not felt
    d.add(guide);
  });
  touching("mirror", nullptr, [](Document& d) { d.symmetry.pose.translation = Vec3d(3, 0, 0); });
  carving("plugins", [] { return addTools(), plain(); });
  touching("plugins", nullptr, [](Document&) { addTools(); });
  return all;
}

}  // namespace argil::tests
