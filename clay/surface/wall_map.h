#pragma once
// How thick the clay's walls and how wide its gaps are, at each vertex of its surface; measured again where it changed.

#include <algorithm>
#include <limits>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "clay/base/work_part.h"
#include "clay/kernels/wall_kernels.h"
#include "clay/store/brick_set.h"
#include "clay/surface/surface.h"

namespace argil::clay {

enum class SideOf : uint8_t { wall, gap };

/// Of a vertex: the diameter of the largest ball in the clay (a wall) or in the air (a gap) that touches the surface
/// there and, opposite to it (normals that differ by more than 120°), in another place. In voxels; infinity where there
/// is none up to the limit: edges and corners are no walls. One thread at a time. Method: NOTES.md, "Walls and gaps".
class WallMap {
 public:
  /// Looks so far: voxels, 0 (not at all) to 256 each. The surfaces must have normals.
  WallMap(double wallVoxels, double gapVoxels);
  ~WallMap();

  /// After one surface changed by `delta`, from all of it on: measures again in the bricks that changed and in those
  /// within the limits of them, and returns these, sorted. The result does not depend on the steps nor on `threads`.
  /// Cost: about 0.1 µs a vertex where nothing is near, more the more there is within the limits. Throws Cancelled
  /// within some 0.1 s of the job's; then the map is good for nothing any more.
  std::vector<Coord> follow(const SurfaceDelta& delta, int threads, const WorkPart& part = WorkPart(nullptr));

  /// One for each vertex of the brick's mesh; empty where it has none.
  [[nodiscard]] std::span<const float> sizes(Coord brick, SideOf side) const;
  /// What is opposite to a vertex.
  struct Partner {
    uint32_t vertex;  ///< Of this brick.
    Coord brick;
    uint32_t other;  ///< Vertex of that one.
  };
  /// Of those vertices of a brick whose size is not infinite, in their order.
  [[nodiscard]] std::span<const Partner> partners(Coord brick, SideOf side) const;

 private:
  struct Points;
  struct Room;
  // A ball through a vertex beside the place where it touches is too large, by less than a voxel where that counts.
  [[nodiscard]] float reach() const { return std::max(limits_[0], limits_[1]) + 1; }
  void put(const BrickMesh& mesh);
  void measure(Points& mine, Room& room) const;
  template <class Visit>
  void near(const Points& to, const Visit& visit) const;

  float limits_[2];
  int shift_ = 0;  // blocks of 2^shift bricks along each axis are as wide as the reach
  std::unordered_map<Coord, std::unique_ptr<Points>, CoordHash> bricks_;
  std::unordered_map<Coord, std::vector<Points*>, CoordHash> blocks_;
};

/// A part of the surface that hangs together, where walls are thinner, or gaps narrower, than asked.
struct ThinPart {
  Vec3d atMm = Vec3d::Zero();  ///< Where it is least, not counting what borders on what is not thin.
  double leastMm = 0;
  double areaMm2 = 0;  ///< Of both its sides.
};
struct ThinParts {
  std::vector<ThinPart> parts;  ///< The thinnest first.
  double areaMm2 = 0;           ///< Of all of them,
  double surfaceMm2 = 0;        ///< and of the whole surface.
  [[nodiscard]] double share() const { return surfaceMm2 > 0 ? areaMm2 / surfaceMm2 : 0; }
};

/// Both sides of a wall are one part. A strip of a voxel or two is none: rims are round by that, and seem thinner than
/// what they bound. `limitMm`: up to what `map` looked for. O(surface).
[[nodiscard]] ThinParts thinParts(const Surface& surface, const WallMap& map, SideOf side, double limitMm);

}  // namespace argil::clay
