#pragma once
// Which vertices of a surface a mould of two halves holds back, followed as the clay changes.

#include <cmath>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "clay/store/brick_set.h"
#include "clay/store/sampler.h"
#include "clay/surface/surface.h"

namespace argil::clay {

/// A vertex is undercut when clay lies above it along the pull, where its face looks that way, or below it where it
/// looks against it; of a face that stands upright within a degree, both. Clay counts that is
/// deeper than a third of a voxel, so that neither an uneven wall nor a crease hides itself. For pictures; pullFaces()
/// is exact. One thread at a time.
class PullMap {
 public:
  /// `pull`: a unit vector in the clay's axes. The surfaces must have normals.
  explicit PullMap(const Vec3d& pull);
  ~PullMap();

  /// After these bricks of `surface` changed, from all of it on: looks again where that may have changed something,
  /// which is in the columns along the pull of what changed, and returns these bricks, sorted. The result does not
  /// depend on the steps nor on `threads`. Cost: some 0.7 µs a vertex in those columns, on two threads.
  std::vector<Coord> follow(const Surface& surface, std::span<const Coord> changed, int threads);

  /// One for each vertex of the brick's mesh, 1 where it is undercut; empty where none is.
  [[nodiscard]] std::span<const uint8_t> undercut(Coord brick) const;

 private:
  using Cell = std::pair<int32_t, int32_t>;
  struct CellHash {
    size_t operator()(const Cell& cell) const noexcept;
  };
  // Bricks whose boxes reach into a column, by where their middles are along the pull, voxels.
  struct InColumn {
    double along;
    Coord brick;
  };
  using Column = std::vector<InColumn>;
  [[nodiscard]] Vec3d middle(Coord brick) const;
  template <class Visit>
  void forCells(Coord brick, const Visit& visit) const;
  void put(Coord brick, bool there);
  [[nodiscard]] bool blocked(Sampler& field, const Vec3d& p, const Column& column, bool against) const;
  void look(const BrickMesh& mesh, const Version& version, std::span<const Cell> cells, bool all,
            std::vector<uint8_t>& undercut) const;

  Vec3d pull_, u_, v_;              // a frame
  double reachU_, reachV_, reach_;  // of a brick's box from its middle, along each
  std::unordered_map<Cell, Column, CellHash> columns_;
  std::unordered_set<Coord, CoordHash> bricks_;
  std::unordered_map<Coord, std::vector<uint8_t>, CoordHash> undercut_;
};

}  // namespace argil::clay
