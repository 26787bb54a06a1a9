#pragma once
// The solid beside a rim as two or three curved faces: where edges leave it and where its faces meet.

#include <array>

#include "clay/base/vec.h"
#include "clay/surface/rim_kernels.h"

namespace argil::clay {

/// Two or three faces. Positions are in voxels from the middle of the fit.
class RimModel {
 public:
  explicit RimModel(const RimFit& fit) : fit_(fit) {}

  [[nodiscard]] const RimFit& fit() const { return fit_; }

  /// The signed distance of a face at p, voxels, and its gradient, about a unit vector.
  float distance(int face, const Vec3f& p, Vec3f& gradient) const;
  /// The solid's signed distance where its faces have these.
  [[nodiscard]] float joined(const std::array<float, kMostRimFaces>& distances) const;
  [[nodiscard]] float distance(const Vec3f& p) const;

  /// Distances of the faces at the corners of a cell, and of the solid there.
  struct Corners {
    float face[kMostRimFaces][8];
    [[nodiscard]] std::array<float, kMostRimFaces> at(int corner) const {
      return {face[0][corner], face[1][corner], face[2][corner]};
    }
  };
  [[nodiscard]] Corners corners(const Vec3f& low) const;

  /// The face through which the way from an inside corner to an outside one leaves the solid, and the part of the way
  /// up to there.
  struct Crossing {
    int face = 0;
    float along = 0;
  };
  [[nodiscard]] Crossing crossing(const Corners& corners, int inside, int outside) const;

  /// Moves p to the nearest point where the faces of `which` (bits: one, two or three of them) meet, and tells their
  /// gradients there. False where they do not meet, or meet farther than `reach` voxels away; p is then lost.
  bool meet(unsigned which, float reach, Vec3f& p, std::array<Vec3f, kMostRimFaces>& gradients) const;

 private:
  RimFit fit_;
};

}  // namespace argil::clay
