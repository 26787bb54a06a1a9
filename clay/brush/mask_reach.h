#pragma once
// What a mask covers beyond the band, where the channel itself says nothing. This module's own.

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "clay/store/brick_set.h"
#include "clay/store/version.h"

namespace argil::clay {

/// Bytes of a mask in Brick's order; `none` and `whole` where all are 0 or 255.
struct MaskCover {
  bool none = true, whole = false;
  std::array<uint8_t, kBrickVoxels> value{};
};

/// A voxel far from the surface is covered as the places of the surface that are nearest to it (the mean of those
/// within a voxel of the nearest): so a tool larger than the band does not hollow the clay out under a masked surface,
/// nor lay clay over it. Sums of whole numbers, so that mirrored clay has mirrored covers. One thread.
class MaskReach {
 public:
  /// Of the clay as the stroke found it: what the stroke itself brings up stays covered.
  explicit MaskReach(Version start) : start_(std::move(start)) {}

  [[nodiscard]] const Version& start() const { return start_; }
  /// Of a brick coordinate, by the surface within `reach` voxels (beyond: free). Kept; about a millisecond where a
  /// mask's rim is near, else microseconds.
  [[nodiscard]] const MaskCover& at(Coord brick, double reach);

 private:
  struct Place {
    Coord voxel;
    int cover;
  };
  struct BrickPlaces {
    Coord brick;
    int least = 255, most = 0;  // of what covers them
    std::vector<Place> places;
  };
  struct Known {
    double reach = -1;
    MaskCover cover;
  };
  const std::vector<BrickPlaces>& region(Coord region);

  Version start_;
  std::unordered_map<Coord, std::vector<BrickPlaces>, CoordHash> regions_;
  std::unordered_map<Coord, Known, CoordHash> known_;
};

}  // namespace argil::clay
