#include "engine/document/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "clay/base/error.h"
#include "clay/store/editor.h"
#include "engine/document/guide_table.h"
#include "haptics/scene/polyline.h"

namespace argil::engine {
namespace {

template <class Things>
auto find(Things& things, Id id) -> decltype(things.data()) {
  const auto found = std::find_if(things.begin(), things.end(), [&](const Thing& thing) { return thing.id == id; });
  return found == things.end() ? nullptr : &*found;
}

template <class Things>
bool removeFrom(Things& things, Id id) {
  return std::erase_if(things, [&](const Thing& thing) { return thing.id == id; }) > 0;
}

template <class Things>
bool move(Things& things, Id id, int by) {
  const auto* found = find(things, id);
  if (!found) return false;
  const auto from = found - things.data(), to = from + by;
  if (to < 0 || to >= std::ssize(things)) return false;
  std::swap(things[size_t(from)], things[size_t(to)]);
  return true;
}

}  // namespace

const Piece* Document::piece(Id id) const {
  return find(pieces, id);
}
Piece* Document::piece(Id id) {
  return find(pieces, id);
}
const Part* Document::part(Id id) const {
  return find(parts, id);
}
Part* Document::part(Id id) {
  return find(parts, id);
}
const Guide* Document::guide(Id id) const {
  return find(guides, id);
}
Guide* Document::guide(Id id) {
  return find(guides, id);
}

const Thing* Document::thing(Id id) const {
  return const_cast<Document*>(this)->thing(id);
}
Thing* Document::thing(Id id) {
  if (Piece* found = piece(id)) return found;
  if (Part* found = part(id)) return found;
  return guide(id);
}

const Piece* Document::workedOn() const {
  const Piece* found = piece(active);
  return found && found->visible && !found->locked ? found : nullptr;
}

namespace {

// "Clay", "Clay 2", "Clay 3": the first that nothing of the document has.
void nameAnew(const Document& document, Thing& thing, const std::string& kind) {
  if (!thing.name.empty()) return;
  const auto taken = [&](const std::string& name) {
    const auto has = [&](const Thing& other) { return other.name == name; };
    return std::any_of(document.pieces.begin(), document.pieces.end(), has) ||
           std::any_of(document.parts.begin(), document.parts.end(), has) ||
           std::any_of(document.guides.begin(), document.guides.end(), has);
  };
  thing.name = kind;
  for (int number = 2; taken(thing.name); ++number) thing.name = fmt::format("{} {}", kind, number);
}

}  // namespace

Id Document::add(Piece piece) {
  if (!piece.version) throw Error("a piece without clay cannot be added", Error::Kind::work);
  nameAnew(*this, piece, "Clay");
  piece.id = nextId++;
  pieces.push_back(std::move(piece));
  if (pieces.size() == 1) active = pieces.back().id;
  return pieces.back().id;
}

Id Document::add(Part part) {
  if (!part.mesh) throw Error("a part without a mesh cannot be added", Error::Kind::work);
  nameAnew(*this, part, "Part");
  part.id = nextId++;
  parts.push_back(std::move(part));
  return parts.back().id;
}

Id Document::add(Guide guide) {
  nameAnew(*this, guide, std::string(rowOf(guide.kind).name));
  guide.id = nextId++;
  (void)felt(guide, 1);  // what cannot be felt is refused before it is there
  guides.push_back(std::move(guide));
  return guides.back().id;
}

bool Document::remove(Id id) {
  if (!removeFrom(pieces, id)) return removeFrom(parts, id) || removeFrom(guides, id);
  if (active == id) active = pieces.empty() ? 0 : pieces.front().id;
  return true;
}

bool Document::reorder(Id id, int by) {
  return move(pieces, id, by) || move(parts, id, by) || move(guides, id, by);
}

StrokeImages Document::images() const {
  StrokeImages images;
  const bool on[] = {symmetry.x, symmetry.y, symmetry.z};
  for (int axis = 0; axis < 3; ++axis) {
    if (on[axis]) images.mirrors.push_back({symmetry.pose.translation, symmetry.pose.rotation * Vec3d::Unit(axis)});
  }
  images.turns = symmetry.turns;
  images.axisPointMm = symmetry.pose.translation;
  images.axis = symmetry.pose.rotation * Vec3d::UnitZ();
  return images;
}

std::array<uint8_t, 3> bytesOf(const std::array<float, 3>& colour) {
  std::array<uint8_t, 3> bytes{};
  std::transform(colour.begin(), colour.end(), bytes.begin(),
                 [](float part) { return static_cast<uint8_t>(std::lround(std::clamp(part, 0.0f, 1.0f) * 255)); });
  return bytes;
}

std::vector<std::optional<std::array<uint8_t, 3>>> materialColours(const Piece& piece) {
  std::vector<std::optional<std::array<uint8_t, 3>>> colours;
  for (const MaterialRow& row : piece.materials)
    colours.push_back(row.colour ? std::optional(bytesOf(*row.colour)) : std::nullopt);
  return colours;
}

Piece hideMasked(Piece piece) {
  clay::Editor editor(piece.version);
  piece.version.forEachBrick(clay::Channel::mask, [&](const clay::ChannelBrick& brick) {
    std::array<uint8_t, clay::kBrickVoxels> mask;
    std::transform(std::begin(brick.value), std::end(brick.value), mask.begin(),
                   [](uint8_t value) { return value > 127 ? uint8_t{255} : value; });
    editor.setChannel(clay::Channel::mask, brick.coord, mask);
  });
  piece.version = editor.commit();
  piece.hideMasked = true;
  return piece;
}

Document Document::of(clay::Version version) {
  Document document;
  Piece piece;
  piece.version = std::move(version);
  document.add(std::move(piece));
  return document;
}

std::optional<haptics::Guide> felt(const Guide& guide, uint32_t id) {
  using Kind = Guide::Kind;
  using Feel = Guide::Feel;
  if (guide.feel == Feel::seen) return std::nullopt;
  haptics::Guide out;
  out.id = id;
  const Vec3d& at = guide.pose.translation;
  const haptics::WellShape well{guide.rangeMm, guide.forceN};
  const auto curve = [&] { return std::make_shared<const haptics::Polyline>(guide.pointsMm, guide.closed); };
  const bool attracts = guide.feel == Feel::well;
  switch (guide.kind) {
    case Kind::plane:
      if (guide.feel == Feel::keepOut) {
        out.shape = haptics::KeepOutPlane{at, guide.axis()};
      } else if (attracts) {
        out.shape = haptics::WellAtPlane{at, guide.axis(), well};
      } else {
        out.shape = haptics::LockToPlane{at, guide.axis()};
      }
      break;
    case Kind::line: {
      // A well at a line is one at a curve of two points, as long as what is drawn of it.
      const Vec3d half = 0.5 * guide.sizeMm.z() * guide.axis();
      if (attracts) {
        out.shape = haptics::WellAtCurve{
            std::make_shared<const haptics::Polyline>(std::vector<Vec3d>{at - half, at + half}), well};
      } else {
        out.shape = haptics::LockToLine{at, guide.axis()};
      }
      break;
    }
    case Kind::point:
      if (attracts) {
        out.shape = haptics::WellAtPoints{{at}, well};
      } else {
        out.shape = haptics::LockToPoint{at};
      }
      break;
    case Kind::curve:
      if (attracts) {
        out.shape = haptics::WellAtCurve{curve(), well};
      } else {
        out.shape = haptics::LockToCurve{curve()};
      }
      break;
    case Kind::keepOutBox:
      out.shape = haptics::KeepOutBox{guide.pose, 0.5 * guide.sizeMm, false};
      break;
    case Kind::ruler:
    case Kind::angle:
      return std::nullopt;
  }
  out.check();
  return out;
}

haptics::Scene sceneOf(const Document& document, const haptics::Scene& base, const std::vector<size_t>* felt) {
  haptics::Scene scene = base;
  scene.pieces.clear();
  scene.parts.clear();
  scene.materials.clear();
  const auto material = [&](haptics::Material one) {
    one.texture = -1;
    // Many pieces feel the same.
    const auto same = std::find(scene.materials.begin(), scene.materials.end(), one);
    if (same != scene.materials.end()) return uint32_t(same - scene.materials.begin());
    scene.materials.push_back(one);
    return uint32_t(scene.materials.size() - 1);
  };
  const auto addPiece = [&](const Piece& piece) {
    if (scene.pieces.size() >= haptics::kMaxPieces) return;
    haptics::Piece out{piece.version, piece.pose, material(piece.material), piece.hideMasked};
    if (!piece.materials.empty() && piece.version.has(clay::Channel::material)) {  // Else no voxel asks for a row.
      auto rows = std::make_shared<haptics::MaterialRows>();
      rows->fill(static_cast<uint16_t>(out.material));
      const size_t count = std::min(piece.materials.size(), kMaxMaterialRows);
      for (size_t i = 0; i < count; ++i) (*rows)[i + 1] = static_cast<uint16_t>(material(piece.materials[i].material));
      out.rows = std::move(rows);
    }
    scene.pieces.push_back(std::move(out));
  };
  // The servo takes what is worked on from the front.
  const Piece* worked = document.workedOn();
  scene.workedOn = worked ? 1 : 0;
  if (worked) addPiece(*worked);
  if (felt) {
    for (const size_t place : *felt) {
      const Piece& piece = document.pieces.at(place);
      if (piece.visible && &piece != worked) addPiece(piece);
    }
  } else {
    for (const Piece& piece : document.pieces) {
      if (scene.pieces.size() >= haptics::kMaxPieces) break;
      if (piece.visible && &piece != worked) addPiece(piece);
    }
  }
  for (const Part& part : document.parts) {
    if (part.visible && part.felt && scene.parts.size() < haptics::kMaxParts)
      scene.parts.push_back({part.felt, part.pose, material(part.material)});
  }
  // A guide keeps its id from scene to scene: the hand stays on it.
  uint32_t taken = 0;
  for (const haptics::Guide& guide : scene.guides) taken = std::max(taken, guide.id);
  for (const Guide& guide : document.guides) {
    if (!guide.visible || scene.guides.size() >= haptics::kMaxGuides) continue;
    if (auto one = argil::engine::felt(guide, taken + guide.id)) scene.guides.push_back(std::move(*one));
  }
  if (scene.materials.empty()) scene.materials.emplace_back();
  if (!worked) scene.tool.work.reset();
  return scene;
}

}  // namespace argil::engine
