#pragma once
// What a widget changes, as a value: read from the world, changed as the hand moves, written back.

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "ui3d/studio/widgets/world.h"

namespace argil::studio {

/// Names what a widget belongs to.
struct Target {
  enum class Kind : uint8_t { none, thing, symmetry, section, workspace, lattice, scale, cut };
  Kind kind = Kind::none;
  engine::Id id = 0;  ///< Of a thing, also of one that is scaled; of a lattice or a cut its piece.
  friend bool operator==(const Target&, const Target&) = default;
};

/// The lattice of the deform box, and the place of the piece that it is around.
struct HeldLattice {
  clay::Lattice lattice;
  haptics::Pose pose;
  std::vector<Vec3d> clayPlaces;                 ///< DeformBox::clayPlaces.
  std::shared_ptr<const clay::Warp> after = {};  ///< DeformBox::warpAfterLattice().
};

/// How much larger a piece or part is to be along the world's axes, about a place of the world.
struct HeldScale {
  Vec3d factors = Vec3d::Ones();
  Vec3d aboutMm = Vec3d::Zero();
};

/// A guide, the place of a piece or part, or what stands once in the studio.
using Subject = std::variant<std::monostate, engine::Guide, haptics::Pose, engine::Symmetry, render::Section,
                             haptics::Workspace, HeldLattice, HeldScale, engine::MirrorPlane>;

/// std::monostate when there is no such thing.
[[nodiscard]] Subject readSubject(const World& world, const Target& target);
/// Sends it on its way: an edit of the document that joins others of the same `merge`, or a setting of the studio.
void writeSubject(World& world, const Target& target, const Subject& subject, const std::string& label,
                  const std::string& merge);
/// Nothing that a widget can change differs, but for rounding.
[[nodiscard]] bool sameSubject(const Subject& a, const Subject& b);
/// Directions that look for right angles when it is turned.
[[nodiscard]] std::vector<Vec3d> axesOf(const Subject& subject);

void move(Subject& subject, const Vec3d& by);
/// By an angle in rad about a unit axis through a point.
void turn(Subject& subject, const Vec3d& pivot, const Vec3d& axis, double angle);

inline constexpr double kLeastSizeMm = 1e-3;  ///< Of what a widget makes smaller.

}  // namespace argil::studio
