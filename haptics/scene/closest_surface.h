#pragma once
// The point of the clay's surface that is closest to a place, whatever the distance.

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>

#include "clay/store/sampler.h"
#include "haptics/base/realtime.h"

namespace argil::haptics {

/// Answer of ClosestSurface::nearest, in voxels.
struct SurfacePoint {
  bool found = false;
  Vec3d point = Vec3d::Zero();  ///< On the trilinear zero surface.
  double distance = 0;          ///< From the place asked for, without sign.
};

/// Finds closest points of the trilinear zero surface of a version. It never trusts a distance read from the field
/// (known only within the band, and near a cut only a bound), only the surface itself: sign changes found by bit
/// operations in the bricks that the sphere of the best answer so far meets, then walked along the surface. Exact to
/// about 0.01 voxel. Method, rejected ideas, figures: NOTES.md, "Closest surface". One thread; holds no version, and 90
/// kB of memory.
class ClosestSurface {
 public:
  /// Reads `version` from now on; somebody else holds it (this very handle too, where it hides). `hideMasked`: where
  /// the mask is above 127 there is no surface.
  void reset(const clay::Version& version, bool hideMasked = false) ARGIL_REALTIME;

  /// Nearest point within `reach` voxels of `p` (at most kMaxReach; more is cut). `hint`: a place near the answer makes
  /// it cheaper, never different by more than the accuracy. Cost: about half a microsecond for a ball of 12 voxels that
  /// touches and moves less than a voxel between calls, 3 µs where nothing is known yet; it grows with the surface
  /// within the reach.
  SurfacePoint nearest(const Vec3d& p, double reach, const Vec3d* hint = nullptr) ARGIL_REALTIME;

  /// True when `p` is in the clay.
  bool inside(const Vec3d& p) ARGIL_REALTIME { return sampler_.trilinear(p) < 0; }

  /// Whether something is hidden, and whether a voxel of the band is.
  [[nodiscard]] bool hides() const noexcept { return hiding_ != nullptr; }
  [[nodiscard]] bool hidden(Coord voxel) ARGIL_REALTIME;
  [[nodiscard]] bool hidden(const Vec3d& p) ARGIL_REALTIME { return hides() && hidden(nearestVoxel(p)); }
  [[nodiscard]] static Coord nearestVoxel(const Vec3d& p) noexcept {
    const auto near = [](double v) { return static_cast<int32_t>(std::floor(v + 0.5)); };
    return {near(p.x()), near(p.y()), near(p.z())};
  }

  [[nodiscard]] clay::Sampler& sampler() ARGIL_REALTIME { return sampler_; }

  static constexpr double kMaxReach = 256;  ///< Voxels; bounds the cost of a tick.

 private:
  struct Candidates;
  // A brick of the version, and what earlier calls learnt: no sign change that it owns is nearer than `bound` to
  // `from`.
  struct Known {
    const clay::Brick* brick = nullptr;
    Coord coord;
    double bound = 0;
    Vec3d from = Vec3d::Zero();
  };
  static constexpr size_t kKnown = 256;
  // Where the edges that a brick owns cross the surface, from the brick's corner, voxels; lanes beyond `count` are far
  // away.
  static constexpr size_t kCrossings = 192, kCrossingSets = 32;
  struct alignas(64) Crossings {
    std::array<float, kCrossings> x{}, y{}, z{};
    const clay::Brick* of = nullptr;
    uint64_t generation = 0;
    size_t count = 0;  // Above kCrossings: too many to keep.
  };

  template <class Meet>
  void eachCrossing(const clay::Brick& brick, Coord coord, const Vec3f& from, float reach, Meet meet) ARGIL_REALTIME;
  const Crossings& crossings(const clay::Brick& brick, Coord coord) ARGIL_REALTIME;
  double scanBrick(const clay::Brick& brick, Coord coord, const Vec3d& p, Candidates& candidates,
                   double look) ARGIL_REALTIME;
  bool walk(const Vec3d& p, Vec3d& point, double& distance) ARGIL_REALTIME;
  template <class Visit>
  void eachBrick(const Vec3d& p, const double& reach2, Visit visit) ARGIL_REALTIME;
  void scan(const Vec3d& p, Candidates& candidates) ARGIL_REALTIME;

  clay::Sampler sampler_;
  float band_ = 3;
  const clay::Version* hiding_ = nullptr;  // Whose mask hides; null: nothing is hidden.
  const void* version_ = nullptr;          // Of what is known,
  uint64_t versionId_ = 0;
  Vec3d centre_ = Vec3d::Zero();  // all bricks that a sphere of
  double covered_ = -1;           // this radius meets.
  uint64_t generation_ = 1;       // Of the version, for what is kept of its bricks.
  struct Memory {
    std::array<Known, kKnown> known{};
    size_t knownCount = 0;
    std::array<Crossings, kCrossingSets> crossings{};
  };
  std::unique_ptr<Memory> memory_ = std::make_unique<Memory>();
};

}  // namespace argil::haptics
