#pragma once
// Disks of quads that could be filled with fewer vertices of other than four quads.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "clay/cage/disk_map.h"
#include "clay/cage/quad_fill.h"
#include "clay/cage/quad_web.h"

namespace argil::clay {

/// A disk of quads, what would be in its place, and how much nearer to four quads around every vertex that would be:
/// Σ (n − 4)² as QuadWeb counts it. Or several disks that lines of creases part.
struct Refill {
  std::vector<uint32_t> quads;
  std::vector<std::array<uint32_t, 4>> made;  ///< Counter-clockwise.
  std::vector<Vec3d> added;                   ///< Where vertices from QuadFill::kAdded on lie: between the border.
  int gain = 0;
  std::vector<BorderSide> lines, newLines;           ///< Of creases between the disks, as they are and would be.
  std::vector<std::pair<QuadDisk, QuadDisk>> disks;  ///< As they are and would be.

  /// Vertices within disks go to places on the quads of `web` that would go: nearer to the surface, and slower.
  void carryOver(const QuadWeb& web);
};

/// Looks for them around one vertex, small ones first. A disk grows until each vertex of its border can be a corner
/// with one quad in it or lie on a side with two and has four quads then, creases counted; no crease leads into it.
/// From there it grows by a row along one of its sides. Where it would be better with another count of edges along a
/// side that is a line of creases, a disk on the other side is looked for of which that line is a side as well, or two
/// of them one after the other, and all change together. The web may be changed between two calls. One thread.
/// Method: Verma and Suresh 2017 (minimum singularity templates).
class QuadPatches {
 public:
  /// `lines`: looks beyond lines of creases as well.
  explicit QuadPatches(const QuadWeb& web, bool lines = false) : web_(web), lines_(lines) {}

  /// Where a line goes along both sides of a quad at a corner, so that the quad is alone on that side and has half a
  /// turn there: it and the next one along the line become four, two of them at that vertex. With `forward` the next
  /// one the way that the quad's sides go. None where those two are not as they must be, and where it is no gain.
  [[nodiscard]] std::optional<Refill> notAlone(uint32_t quad, int corner, bool forward) const;

  /// Calls `take` with each that gains until it says yes; whether it did. At most `most` quads in a disk.
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
  // Disks that grow from the first by rows, small ones first, `count` at most, until `look` says yes. No row is added
  // along the side `but`, nor beside it.
  template <class Look>
  bool grow(const std::vector<uint32_t>& first, size_t most, size_t count, const BorderSide& but, const Look& look);
  // A side that is a line of creases, as one of the two disks has it, with another count of edges.
  struct OtherCount {
    BorderSide line;
    int edges;
  };
  using Disks = std::vector<const Disk*>;
  [[nodiscard]] bool isLine(const BorderSide& side) const;
  [[nodiscard]] static int gainOf(const Disks& disks, const std::vector<OtherCount>& lines);
  bool beyondLines(Disks& disks, std::vector<OtherCount>& lines, size_t most,
                   const std::function<bool(const Refill&)>& take);
  bool beyondLine(const BorderSide& line, const std::array<int, 2>& more, Disks& disks, std::vector<OtherCount>& lines,
                  size_t most, const std::function<bool(const Refill&)>& take);
  // Whether the last disk meets the others along the last line alone, and leaves three quads at its ends.
  [[nodiscard]] bool fits(const Disks& disks, const BorderSide& line) const;
  [[nodiscard]] std::optional<Refill> filledAnew(const Disks& disks, const std::vector<OtherCount>& lines);
  // Whether no edge of a filling that leads from border to border is there outside of the quads already, or twice.
  [[nodiscard]] bool isClear(const Refill& refill, const Disks& disks);
  [[nodiscard]] bool isIn(uint32_t quad) const { return stamp_[quad] == inDisk_; }
  void put(Disk& disk, uint32_t quad);
  AtVertex& at(uint32_t vertex);

  const QuadWeb& web_;
  const bool lines_;
  std::vector<uint64_t> stamp_;
  std::map<std::array<uint32_t, 3>, int> looks_;  // along lines of creases
  uint64_t inDisk_ = 0, now_ = 0;
  std::vector<AtVertex> at_;
  std::vector<uint32_t> vertices_, sector_;
};

}  // namespace argil::clay
