#include "engine/text/guide_setup.h"

#include <cmath>
#include <memory>
#include <string_view>

#include "engine/text/script_place.h"
#include "haptics/scene/polyline.h"

namespace argil::engine {
namespace {

using nlohmann::json;
using Kind = GuideSetup::Kind;
using haptics::Polyline;

constexpr double kMostN = 1e4, kMostNmm = 1e4, kMostDrag = 1e3;

// What a kind of guide is made of. One bit a key.
enum Field : uint32_t {
  kAt = 1,
  kDirection = 2,
  kSize = 4,
  kPoints = 8,
  kClosed = 16,
  kInside = 32,
  kRadius = 64,
  kRange = 128,
  kDepth = 256,
  kForce = 512,
  kStiffness = 1024,
  kDrag = 2048
};
struct Row {
  std::string_view name;
  Kind kind;
  uint32_t fields;
};
constexpr Row kRows[] = {
    {"lock_to_point", Kind::lockToPoint, kAt},
    {"lock_to_line", Kind::lockToLine, kAt | kDirection},
    {"lock_to_plane", Kind::lockToPlane, kAt | kDirection},
    {"lock_to_curve", Kind::lockToCurve, kPoints | kClosed},
    {"lock_to_normal", Kind::lockToNormal, 0},
    {"keep_out_box", Kind::keepOutBox, kAt | kSize | kInside},
    {"keep_out_ball", Kind::keepOutBall, kAt | kRadius | kInside},
    {"keep_out_plane", Kind::keepOutPlane, kAt | kDirection},
    {"well_at_points", Kind::wellAtPoints, kPoints | kRange | kForce},
    {"well_at_curve", Kind::wellAtCurve, kPoints | kClosed | kRange | kForce},
    {"well_at_plane", Kind::wellAtPlane, kAt | kDirection | kRange | kForce},
    {"well_at_clay", Kind::wellAtClay, kRange | kForce},
    {"gravity", Kind::gravity, kDirection | kForce},
    {"buoyancy", Kind::buoyancy, kAt | kDirection | kDepth | kForce},
    {"viscosity", Kind::viscosity, kDrag},
    {"ambient_plane", Kind::ambientPlane, kAt | kDirection | kStiffness | kForce},
};

struct Vector {
  const char* key;
  Vec3d GuideSetup::*member;
  uint32_t field;
};
constexpr Vector kVectors[] = {{"at", &GuideSetup::atMm, kAt},
                               {"direction", &GuideSetup::direction, kDirection},
                               {"size_mm", &GuideSetup::sizeMm, kSize}};
struct Number {
  const char* key;
  double GuideSetup::*member;
  uint32_t field;
  double most;
};
constexpr Number kNumbers[] = {{"radius_mm", &GuideSetup::radiusMm, kRadius, kMaxMm},
                               {"range_mm", &GuideSetup::rangeMm, kRange, kMaxMm},
                               {"depth_mm", &GuideSetup::depthMm, kDepth, kMaxMm},
                               {"force_n", &GuideSetup::forceN, kForce, kMostN},
                               {"stiffness_nmm", &GuideSetup::stiffnessNmm, kStiffness, kMostNmm},
                               {"drag_nsmm", &GuideSetup::dragNsmm, kDrag, kMostDrag}};
struct Flag {
  const char* key;
  bool GuideSetup::*member;
  uint32_t field;
};
constexpr Flag kFlags[] = {{"closed", &GuideSetup::closed, kClosed}, {"inside", &GuideSetup::inside, kInside}};

struct Property {
  const char* key;
  double haptics::Material::*member;
  double least, most;
};
constexpr Property kProperties[] = {{"stiffness_nmm", &haptics::Material::stiffnessNmm, 1e-6, 1e4},
                                    {"hardness_nmm2", &haptics::Material::hardnessNmm2, 1e-9, 1e6},
                                    {"viscosity_nsmm", &haptics::Material::viscosityNsmm, 1e-9, 1e6},
                                    {"drag_nsmm", &haptics::Material::dragNsmm, 0, 1e6},
                                    {"static_friction", &haptics::Material::staticFriction, 0, 4},
                                    {"dynamic_friction", &haptics::Material::dynamicFriction, 0, 4},
                                    {"viscous_friction_nsmm", &haptics::Material::viscousFrictionNsmm, 0, 1e3}};

std::vector<std::string_view> keysOf(const Row& row) {
  std::vector<std::string_view> keys;
  for (const Vector& v : kVectors)
    if (row.fields & v.field) keys.push_back(v.key);
  for (const Number& n : kNumbers)
    if (row.fields & n.field) keys.push_back(n.key);
  for (const Flag& f : kFlags)
    if (row.fields & f.field) keys.push_back(f.key);
  if (row.fields & kPoints) keys.push_back("points");
  return keys;
}

json list(const Vec3d& v) {
  return json::array({v.x(), v.y(), v.z()});
}

struct Build {
  const GuideSetup& g;
  [[nodiscard]] haptics::WellShape well() const { return {g.rangeMm, g.forceN}; }
  [[nodiscard]] std::shared_ptr<const Polyline> curve() const {
    return std::make_shared<const Polyline>(g.pointsMm, g.closed);
  }

  [[nodiscard]] decltype(haptics::Guide::shape) shape() const {
    switch (g.kind) {
      case Kind::lockToPoint:
        return haptics::LockToPoint{g.atMm};
      case Kind::lockToLine:
        return haptics::LockToLine{g.atMm, g.direction};
      case Kind::lockToPlane:
        return haptics::LockToPlane{g.atMm, g.direction};
      case Kind::lockToCurve:
        return haptics::LockToCurve{curve()};
      case Kind::lockToNormal:
        return haptics::LockToNormal{};
      case Kind::keepOutBox:
        return haptics::KeepOutBox{haptics::Pose{g.atMm}, 0.5 * g.sizeMm, g.inside};
      case Kind::keepOutBall:
        return haptics::KeepOutBall{g.atMm, g.radiusMm, g.inside};
      case Kind::keepOutPlane:
        return haptics::KeepOutPlane{g.atMm, g.direction};
      case Kind::wellAtPoints:
        return haptics::WellAtPoints{g.pointsMm, well()};
      case Kind::wellAtCurve:
        return haptics::WellAtCurve{curve(), well()};
      case Kind::wellAtPlane:
        return haptics::WellAtPlane{g.atMm, g.direction, well()};
      case Kind::wellAtClay:
        return haptics::WellAtPiece{0, well()};
      case Kind::gravity:
        return haptics::Gravity{g.direction.normalized() * g.forceN};
      case Kind::buoyancy:
        return haptics::Buoyancy{g.atMm, g.direction, g.forceN, g.depthMm};
      case Kind::viscosity:
        return haptics::Viscosity{g.dragNsmm};
      case Kind::ambientPlane:
        return haptics::AmbientPlane{g.atMm, g.direction, g.stiffnessNmm, g.forceN};
    }
    return haptics::LockToPoint{};
  }
};

}  // namespace

GuideSetup readGuide(const Place& place) {
  const Place name = [&] {
    if (!place.value().is_object()) place.fail("must be an object {...}");
    return place.at("guide");
  }();
  const Row* row = nullptr;
  std::string known;
  for (const Row& candidate : kRows) {
    if (name.text() == candidate.name) row = &candidate;
    known += (known.empty() ? "" : ", ") + std::string(candidate.name);
  }
  if (!row) name.fail(fmt::format("unknown {}; known are {}", io::shown(name.text()), known));
  std::vector<std::string_view> keys = keysOf(*row);
  keys.insert(keys.begin(), {"guide", "while_buttons"});
  place.keys(keys);

  GuideSetup guide;
  guide.kind = row->kind;
  for (const Vector& v : kVectors)
    if (row->fields & v.field) guide.*v.member = place.at(v.key).vector();
  if ((row->fields & kDirection) && !(guide.direction.norm() > 1e-6))
    place.at("direction").fail("is no direction; [0, 0, 1] is straight up");
  if ((row->fields & kSize) && !(guide.sizeMm.minCoeff() > 0))
    place.at("size_mm").fail("each side must be more than 0");
  for (const Number& n : kNumbers) {
    if (!(row->fields & n.field)) continue;
    const bool length = n.most == kMaxMm;
    guide.*n.member = length ? place.at(n.key).positive() : place.at(n.key).number(0, n.most);
  }
  for (const Flag& f : kFlags)
    if (const auto flag = row->fields & f.field ? place.maybe(f.key) : std::nullopt) guide.*f.member = flag->truth();
  if (row->fields & kPoints) {
    for (const Place& point : place.at("points").items()) guide.pointsMm.push_back(point.vector());
    const bool curve = guide.kind != Kind::wellAtPoints;
    if (!curve && (guide.pointsMm.empty() || guide.pointsMm.size() > haptics::kMaxWellPoints))
      place.at("points").fail(fmt::format("give 1 to {} points", haptics::kMaxWellPoints));
    if (curve) {
      try {
        (void)Polyline(guide.pointsMm, guide.closed);
      } catch (const Error& error) {
        place.at("points").fail(error.what());
      }
    }
  }
  if (const auto buttons = place.maybe("while_buttons"))
    guide.whileButtons = static_cast<uint32_t>(buttons->number(0, 4294967295.0));
  return guide;
}

json guideJson(const GuideSetup& guide) {
  const Row& row = kRows[static_cast<size_t>(guide.kind)];
  json out = {{"guide", row.name}};
  for (const Vector& v : kVectors)
    if (row.fields & v.field) out[v.key] = list(guide.*v.member);
  for (const Number& n : kNumbers)
    if (row.fields & n.field) out[n.key] = guide.*n.member;
  for (const Flag& f : kFlags)
    if ((row.fields & f.field) && guide.*f.member) out[f.key] = true;
  if (row.fields & kPoints)
    for (const Vec3d& p : guide.pointsMm) out["points"].push_back(list(p));
  if (guide.whileButtons) out["while_buttons"] = guide.whileButtons;
  return out;
}

std::vector<GuideKind> guideKinds() {
  std::vector<GuideKind> kinds;
  for (const Row& row : kRows) kinds.push_back({row.name, keysOf(row)});
  return kinds;
}

std::vector<MaterialKey> materialKeys() {
  std::vector<MaterialKey> keys;
  for (const Property& p : kProperties) keys.push_back({p.key, p.least, p.most});
  return keys;
}

haptics::Material readMaterial(const Place& place) {
  std::vector<std::string_view> keys;
  for (const Property& p : kProperties) keys.push_back(p.key);
  place.keys(keys);
  haptics::Material material;
  for (const Property& p : kProperties)
    if (const auto value = place.maybe(p.key)) material.*p.member = value->number(p.least, p.most);
  if (material.dynamicFriction > material.staticFriction)
    place.fail("sliding friction (dynamic_friction) must be no more than static_friction");
  return material;
}

json materialJson(const haptics::Material& material) {
  json out = json::object();
  for (const Property& p : kProperties) out[p.key] = material.*p.member;
  return out;
}

std::vector<haptics::Guide> sceneGuides(std::span<const GuideSetup> guides) {
  std::vector<haptics::Guide> scene;
  for (const GuideSetup& guide : guides) {
    haptics::Guide& made = scene.emplace_back();
    made.id = static_cast<uint32_t>(scene.size());
    made.shape = Build{guide}.shape();
    made.whileButtons = guide.whileButtons;
    made.check();
  }
  return scene;
}

}  // namespace argil::engine
