#pragma once
// Clay and gaps of air that are too thin for voxels: one rule for all operations on whole pieces.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "clay/field/brick_parts.h"
#include "clay/store/brick_set.h"
#include "clay/store/editor.h"
#include "clay/store/sampler.h"

namespace argil::clay {

/// Voxels: clay that is thinner goes, and gaps of air that are thinner become clay. Faces that coincide leave either,
/// as the last digit of a distance of zero decides.
inline constexpr float kThinnest = 0.25f;
/// Voxels by which two surfaces may overlap and still hide distances to others: what lies between them is no deeper
/// than half of it by either, and a voxel beside a surface lies up to one below it.
inline constexpr float kHiding = 2.0f;

/// Amounts of clay and air that an operation dropped because they were thinner than kThinnest.
struct ThinParts {
  uint64_t clayVoxels = 0;  ///< Voxels of clay that went.
  double clayVolume = 0;    ///< Volume of that clay, voxels³.
  uint64_t airVoxels = 0;   ///< Voxels of gaps that became clay.
  double airVolume = 0;     ///< Volume of those gaps, voxels³.
  double seamArea = 0;      ///< Area of faces that touched and were joined, voxels².
  /// Least volume of clay that went because it was thinner than a voxel and lay between voxels, voxels³. Not in
  /// clayVolume.
  double betweenVoxels = 0;

  ThinParts& operator+=(const ThinParts& other) {
    clayVoxels += other.clayVoxels;
    clayVolume += other.clayVolume;
    airVoxels += other.airVoxels;
    airVolume += other.airVolume;
    seamArea += other.seamArea;
    betweenVoxels += other.betweenVoxels;
    return *this;
  }
};

/// Voxels between faces that are the same, but for rounding.
inline constexpr float kCoincident = 0.01f;

/// Tells whether the surfaces of two solids face each other at a voxel and are so near that the distance to their
/// intersection says nothing there: the intersection is thinner than kThinnest, or the solids are apart by less than
/// kHiding. `pa`, `pb`: distances to both solids; `a(axis, step)`, `b(axis, step)`: those a step (−1 or 1) along an
/// axis.
template <class A, class B>
[[nodiscard]] bool faceEachOther(float pa, float pb, float band, const A& a, const B& b) {
  constexpr float kSame = 0.12f;     // voxels that what lies between them differs by, a voxel farther
  constexpr float kOpposite = 0.9f;  // cosine between surfaces that face each other
  constexpr float kKnown = 0.84f;    // slope of a distance whose direction is known,
  constexpr float kAtEdge = 0.5f;    // and beside an edge that both solids have
  constexpr int kAllAround = 5;      // of the six voxels beside
  constexpr float kBeside = 0.02f;   // voxels: a distance that does not change
  const float apart = pa + pb;
  if (!(apart > -kThinnest && apart < kHiding) || std::abs(pa) >= band || std::abs(pb) >= band) return false;
  Vec3f slopeA = Vec3f::Zero(), slopeB = Vec3f::Zero();
  int alike = 0;
  for (int axis = 0; axis < 3; ++axis) {
    float countA = 0, countB = 0;
    for (const int step : {-1, 1}) {
      const float nextA = a(axis, step), nextB = b(axis, step), riseA = nextA - pa, riseB = nextB - pb;
      if (std::abs(nextA) >= band || std::abs(nextB) >= band) continue;
      // Distances outside of a solid lead to its other faces where the intersection begins, and rise less.
      const bool same = std::abs(riseA + riseB) <= kSame, fallsA = riseA < -kBeside && riseB > kBeside,
                 fallsB = riseB < -kBeside && riseA > kBeside;
      const auto way = static_cast<float>(step);
      alike += same ? 1 : 0;
      if (same || fallsA) slopeA[axis] += way * riseA, ++countA;
      if (same || fallsB) slopeB[axis] += way * riseB, ++countB;
    }
    slopeA[axis] /= std::max(countA, 1.0f);
    slopeB[axis] /= std::max(countB, 1.0f);
  }
  const float known = alike >= kAllAround ? kAtEdge : kKnown;
  const float lengthA = slopeA.squaredNorm(), lengthB = slopeB.squaredNorm();
  return std::min(lengthA, lengthB) > known * known && slopeA.dot(slopeB) < -kOpposite * std::sqrt(lengthA * lengthB);
}

/// Voxels that an operation left without a distance that means anything, because what it was measured to is too thin.
/// One thread.
class ThinVoxels {
 public:
  /// `becomes`: the side that all of them come to lie on, as far as no other surface lies there.
  explicit ThinVoxels(Tile becomes) : becomes_(becomes) {}

  /// `thin`: the voxel lies on the other side now.
  void add(Coord voxel, bool thin);
  /// Adds voxels of `bricks` on the other side where that is thinner than kThinnest, by the editor's field alone.
  void find(const Editor& editor, std::span<const Coord> bricks);

  [[nodiscard]] bool empty() const { return bricks_.empty(); }
  /// The bricks that have some, sorted.
  [[nodiscard]] std::vector<Coord> bricks() const;
  [[nodiscard]] bool holds(Coord voxel) const;
  /// Calls `visit(voxel)` for each, in a fixed order.
  template <class Visit>
  void forEach(const Visit& visit) const {
    for (const Coord brick : bricks()) {
      const BrickMask& all = bricks_.at(brick).all;
      for (int v = 0; v < kBrickVoxels; ++v)
        if (clay::holds(all, v)) visit(brick * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7});
    }
  }

  /// Gives each of them the distance that the surfaces beside have there: beside voxels of the other side that go on
  /// from the field beyond those, elsewhere the band's end, for redistance() to fill. Adds what went to `gone`: voxels,
  /// and volumes of those that find() added.
  void settle(Editor& editor, ThinParts& gone) const;

 private:
  struct Marks {
    BrickMask thin{}, all{};
  };
  [[nodiscard]] float settled(Sampler& field, Coord voxel, float own, bool thin) const;

  Tile becomes_;
  std::unordered_map<Coord, Marks, CoordHash> bricks_;
  std::unordered_map<Coord, float, CoordHash> volumes_;  // of voxels that find() added
};

/// Takes out of `bricks` what is thinner than kThinnest on both sides of the surface, with distances again beside it.
/// Returns what went; `changed` gets the bricks that may have changed.
ThinParts removeThin(Editor& editor, std::span<const Coord> bricks, std::vector<Coord>& changed);

/// Voxels from a voxel beside clay that is thinner than one to either of its surfaces, at most.
inline constexpr float kThinReach = 2.5f;

/// Volume, voxels³, of the intersection of two solids in `bricks` that `editor`, made to hold it, does not hold: clay
/// without a voxel near it that is inside, such as a cap that is lower than a voxel. Beside clay that is held nothing
/// counts, so of a cap of one to two voxels, whose brim is lost too, it is less than what went. `a(p)`, `b(p)`:
/// distances to both solids anywhere, in voxels, nearly linear along a voxel; `isNear(voxel)`: whether both surfaces
/// may be within kThinReach, so that most voxels cost a look. One thread.
template <class Near, class A, class B>
[[nodiscard]] double volumeBetweenVoxels(const Editor& editor, std::span<const Coord> bricks, const Near& isNear,
                                         const A& a, const B& b) {
  constexpr int kLines = 4;  // across a voxel, each way
  Sampler field(editor);
  const auto isHeld = [&](Coord cell) {
    for (int i = 0; i < 64; ++i)
      if (field.voxel(cell + Coord{(i >> 4) - 1, ((i >> 2) & 3) - 1, (i & 3) - 1}) < 0) return true;
    return false;
  };
  double volume = 0;
  for (const Coord brick : bricks) {
    for (int v = 0; v < kBrickVoxels; ++v) {
      const Coord cell = brick * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
      if (!isNear(cell) || field.voxel(cell) < 0) continue;
      const Vec3d low = cell.toVec3d(), middle = low + Vec3d::Constant(0.5);
      const auto mayLie = [](double distance) { return distance > -kThinReach && distance < 1; };
      if (!mayLie(b(middle)) || !mayLie(a(middle)) || isHeld(cell)) continue;
      // Along the axis that is nearest to square to b both are linear, so what is inside of both is a part of a line.
      Vec3d slope;
      for (int axis = 0; axis < 3; ++axis)
        slope[axis] = std::abs(b(middle + 0.5 * Vec3d::Unit(axis)) - b(middle - 0.5 * Vec3d::Unit(axis)));
      int along = 0;
      slope.maxCoeff(&along);
      const Vec3d step = Vec3d::Unit(along), right = Vec3d::Unit((along + 1) % 3), up = Vec3d::Unit((along + 2) % 3);
      for (int line = 0; line < kLines * kLines; ++line) {
        const Vec3d from = low + ((line / kLines + 0.5) * right + (line % kLines + 0.5) * up) / kLines,
                    to = from + step;
        double begin = 0, end = 1;
        const auto clip = [&](double there, double beyond) {
          if (there >= 0 && beyond >= 0) end = 0;
          if ((there < 0) == (beyond < 0)) return;
          const double zero = there / (there - beyond);
          if (there < 0)
            end = std::min(end, zero);
          else
            begin = std::max(begin, zero);
        };
        clip(a(from), a(to));
        clip(b(from), b(to));
        volume += std::max(end - begin, 0.0) / (kLines * kLines);
      }
    }
  }
  return volume;
}

}  // namespace argil::clay
