#pragma once
// What a mask covers beyond the band, where the channel itself says nothing. This module's own.

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "clay/kernels/cover_kernels.h"
#include "clay/store/brick_set.h"
#include "clay/store/editor.h"

namespace argil::clay {

/// Bytes of a mask in Brick's order; `none` and `whole` where all are 0 or 255.
struct MaskCover {
  bool none = true, whole = false;
  std::array<uint8_t, kBrickVoxels> value{};
};

/// A voxel far from the surface is covered as the places of the surface that are nearest to it (the mean of those
/// within a voxel of the nearest): so a tool larger than the band does not hollow the clay out under a masked surface,
/// nor lay clay over it. Farther than 12 voxels from the surface that is found at places 3 voxels apart, farther
/// than 64 at places 7 apart, and interpolated between them. Sums of whole numbers, so that mirrored clay has mirrored
/// covers. One thread.
class MaskReach {
 public:
  /// Of the clay as the stroke found it: what the stroke itself brings up stays covered.
  explicit MaskReach(Version start) : start_(std::move(start)) {}

  [[nodiscard]] const Version& start() const { return start_; }
  /// Of a brick coordinate, by the surface within `reach` voxels and at most half as far again (beyond: free). Kept, so
  /// that a reach that grows from stamp to stamp looks again a few times in all. Some 30 microseconds; half a
  /// millisecond where a mask's rim is near.
  [[nodiscard]] const MaskCover& at(Coord brick, double reach);
  /// Places of the surface that were compared with voxels until now: what this costs.
  [[nodiscard]] uint64_t compared() const { return compared_; }

 private:
  // Voxels, the last ones too.
  struct Box {
    Coord low, high;
  };
  struct Place {
    Coord voxel;
    int cover;
  };
  // Those in a box of at most 4×4×4 voxels.
  struct Places {
    Box box;
    int least = 255, most = 0;  // of what covers them
    std::vector<Place> places;
  };
  struct BrickPlaces {
    Box box;
    int least = 255, most = 0;
    std::vector<Places> parts;
  };
  struct Known {
    double reach = -1;
    MaskCover cover;
  };
  // Voxels between two boxes at least and at most, squared.
  static int64_t leastBetween(const Box& a, const Box& b) {
    const Coord low{std::max(a.low.x, b.low.x), std::max(a.low.y, b.low.y), std::max(a.low.z, b.low.z)},
        high{std::min(a.high.x, b.high.x), std::min(a.high.y, b.high.y), std::min(a.high.z, b.high.z)};
    return squared({std::max(low.x - high.x, 0), std::max(low.y - high.y, 0), std::max(low.z - high.z, 0)});
  }
  static int64_t mostBetween(const Box& a, const Box& b) {
    const Coord low{std::min(a.low.x, b.low.x), std::min(a.low.y, b.low.y), std::min(a.low.z, b.low.z)},
        high{std::max(a.high.x, b.high.x), std::max(a.high.y, b.high.y), std::max(a.high.z, b.high.z)};
    return squared(high - low);
  }
  static int64_t squared(Coord d) { return int64_t{d.x} * d.x + int64_t{d.y} * d.y + int64_t{d.z} * d.z; }
  template <class Group>
  static void keepNearest(const Box& box, int64_t limit, std::vector<const Group*>& groups, int64_t& nearest);
  const std::vector<BrickPlaces>& region(Coord region);
  std::vector<const BrickPlaces*> around(const Box& box, double reach);
  void coverBox(const Box& box, Coord low, int64_t limit, const std::vector<const BrickPlaces*>& around,
                MaskCover& cover);
  // Of a voxel of the brick whose places are the candidates.
  uint8_t coverAt(Coord in, int64_t limit);

  Version start_;
  uint64_t compared_ = 0;
  ValuedPlaces candidates_;  // from the brick's first voxel
  std::unordered_map<Coord, std::vector<BrickPlaces>, CoordHash> regions_;
  std::unordered_map<Coord, Known, CoordHash> known_;
};

/// Of a brick of a stroke in work, by a tip of that radius: where the band was when the stroke began the mask itself,
/// elsewhere what it means there too (`reach`; null where nothing looks so far): clay that comes up beside a mask must
/// not let the next stamp creep over it. Nothing where all is free.
[[nodiscard]] std::optional<MaskCover> coverDuring(const Editor& editor, MaskReach* reach, Coord coord, double radius);

/// What a mask covers goes back from `value` to what it was, by as much as it covers; at 255 to the bit. `inPart`: also
/// what is covered in part.
void putBack(const MaskCover& mask, bool inPart, const float* source, float (&value)[kBrickVoxels]);

}  // namespace argil::clay
