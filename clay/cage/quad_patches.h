#pragma once
// Disks of quads that could be filled with fewer vertices of other than four quads.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "clay/cage/quad_fill.h"
#include "clay/cage/quad_web.h"

namespace argil::clay {

/// A disk of quads, what would be in its place, and how much nearer to four quads around every vertex that would be:
/// Σ (n − 4)² as QuadWeb counts it.
struct Refill {
  std::vector<uint32_t> quads;
  QuadFill fill;
  int gain = 0;
};

/// Looks for them around one vertex, small ones first. A disk grows until each vertex of its border can be a corner
/// with one quad in it or lie on a side with two and has four quads then, creases counted; no crease leads into it.
/// From there it grows by a row along one of its sides. The web may be changed between two calls. One thread.
/// Method: Verma and Suresh 2017 (minimum singularity templates).
class QuadPatches {
 public:
  explicit QuadPatches(const QuadWeb& web) : web_(web) {}

  /// Where a line goes along both sides of a quad at a corner, so that the quad is alone on that side and has half a
  /// turn there: it and the next one along the line become four, two of them at that vertex. With `forward` the next
  /// one the way that the quad's sides go. None where those two are not as they must be, and where it is no gain.
  [[nodiscard]] std::optional<Refill> notAlone(uint32_t quad, int corner, bool forward) const;

  /// Calls `take` with each that gains, until it says yes; whether it did. At most `most` quads in a disk.
  bool around(uint32_t vertex, size_t most, const std::function<bool(const Refill&)>& take);

 private:
  struct Disk {
    std::vector<uint32_t> quads;
    std::vector<BorderSide> sides = {};
    int uneven = 0;  // of what could become better
    size_t found = 0;
  };
  struct Side {
    uint32_t to = 0, quad = 0;
    bool isCrease = false;
  };
  // Of the disk that is looked at: sides of its quads that begin here, and where its border goes on.
  struct AtVertex {
    uint64_t stamp = 0;
    size_t sides = 0, begins = 0;
    std::array<Side, QuadWeb::kMostOnCrease> of;
    Side next;
    bool isCorner = false;
  };
  bool from(const std::vector<uint32_t>& first, size_t most, const std::function<bool(const Refill&)>& take);
  // False: it cannot be a disk with straight sides.
  bool straighten(Disk& disk, size_t most);
  [[nodiscard]] bool isIn(uint32_t quad) const { return stamp_[quad] == inDisk_; }
  void put(Disk& disk, uint32_t quad);
  AtVertex& at(uint32_t vertex);

  const QuadWeb& web_;
  std::vector<uint64_t> stamp_;
  uint64_t inDisk_ = 0, now_ = 0;
  std::vector<AtVertex> at_;
  std::vector<uint32_t> vertices_, sector_;
};

}  // namespace argil::clay
