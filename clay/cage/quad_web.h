#pragma once
// A closed mesh of quads that is edited in place.

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "clay/cage/quad_mesh.h"

namespace argil::clay {

/// Those at these places, which ascend, and nothing else.
template <class Each>
void keepOnly(std::vector<Each>& all, const std::vector<uint32_t>& places) {
  for (size_t i = 0; i < places.size(); ++i)
    if (places[i] != i) all[i] = std::move(all[places[i]]);
  all.resize(places.size());
  all.shrink_to_fit();
}

/// Whatever is done to it, it stays closed, 2-manifold and of the same genus: what would change that is refused, and so
/// is what would leave a vertex of fewer than 3 or more than kMostAround quads. One thread.
class QuadWeb {
 public:
  static constexpr size_t kMostAround = 6, kMostOnCrease = 8;

  /// Throws Error for a mesh that is not closed.
  explicit QuadWeb(QuadMesh mesh);

  [[nodiscard]] size_t count() const { return alive_; }
  /// Numbers of vertices and quads, those that are gone counted.
  [[nodiscard]] size_t vertices() const { return positions_.size(); }
  [[nodiscard]] size_t quads() const { return quads_.size(); }
  [[nodiscard]] bool isThere(uint32_t quad) const { return quads_[quad][0] != kGone; }
  [[nodiscard]] const std::array<uint32_t, 4>& quad(uint32_t quad) const { return quads_[quad]; }
  [[nodiscard]] const Vec3d& at(uint32_t vertex) const { return positions_[vertex]; }
  void move(uint32_t vertex, const Vec3d& to) { positions_[vertex] = to; }
  /// Quads around a vertex, in no order; empty when it is gone.
  [[nodiscard]] const std::vector<uint32_t>& around(uint32_t vertex) const { return around_[vertex]; }
  /// Of a quad, which sides are creases, by bits.
  [[nodiscard]] uint8_t creases(uint32_t quad) const { return creases_[quad]; }
  /// Those of its neighbours that a crease leads to, in no order.
  void alongCreases(uint32_t vertex, std::vector<uint32_t>& out) const;
  /// Stays on its place whatever becomes of its line: ends of creases, where several meet, and what was marked.
  [[nodiscard]] bool isCorner(uint32_t vertex) const;
  void markCorner(uint32_t vertex, bool isOne = true) { marked_[vertex] = isOne; }
  [[nodiscard]] bool isOnCrease(uint32_t vertex) const { return creasesAt(vertex) != 0; }
  /// Vertices at the other ends of its edges, in no order.
  void beside(uint32_t vertex, std::vector<uint32_t>& out) const;
  /// Of a vertex of four quads: the ends of the two lines of edges that cross there.
  [[nodiscard]] std::array<std::array<uint32_t, 2>, 2> linesThrough(uint32_t vertex) const;

  /// Of a quad that is a face for itself, the two sides that meet at one of its corners, or those at the opposite one,
  /// are creases no more, whichever turn less: it joins that face. Where no other line meets it, all four are none.
  /// Whether it was such a quad, and no line ends there.
  bool joinFace(uint32_t quad, int corner);

  /// How much nearer to four quads around every vertex the mesh would be, Σ (n − 4)² before less after; none where the
  /// change is refused. On a crease the quads between two of its edges count for themselves: two on a line, at a corner
  /// one for each right angle.
  /// `last`: a line will hardly lose more edges, so that one quad alone on a side of it, whose corner is half a turn,
  /// is worse than anything else.
  [[nodiscard]] std::optional<int> gainOfCollapse(uint32_t quad, int corner, bool last = false) const;
  /// Corner and the one opposite become one vertex, which is returned (the corner's), and the quad is gone; where that
  /// leaves two quads around another vertex these become one. Only what gainOfCollapse() allows.
  uint32_t collapse(uint32_t quad, int corner);
  /// A quad whose four vertices have three quads each lies within another, to which it and the four around it become.
  /// Whether it was one.
  bool removeInset(uint32_t quad);
  /// The edge that leaves `corner` turns within the six vertices around it, `step` 1 or −1.
  [[nodiscard]] std::optional<int> gainOfTurn(uint32_t quad, int corner, int step, bool last = false) const;
  void turn(uint32_t quad, int corner, int step);
  /// Where the edge goes then.
  [[nodiscard]] std::array<uint32_t, 2> endsOfTurn(uint32_t quad, int corner, int step) const;

  /// The quads around a vertex that no crease parts from `quad`, one of them, and how many of them would be right.
  struct Sector {
    int count = 0, right = 4;
    [[nodiscard]] int uneven(int more = 0, bool last = false) const {
      const int off = count + more - right;
      return last && right == 2 && off == -1 ? kHalfTurn : off * off;
    }
  };
  [[nodiscard]] Sector sectorOf(uint32_t vertex, uint32_t quad, std::vector<uint32_t>* quads = nullptr) const;
  /// The quad that has the side from `from` to `to`, which is one.
  [[nodiscard]] uint32_t across(uint32_t from, uint32_t to) const;
  [[nodiscard]] bool areBeside(uint32_t a, uint32_t b) const;

  /// A vertex without quads.
  uint32_t add(const Vec3d& at);
  /// The vertices from `first` on, which have no quads, were never added.
  void takeBack(uint32_t first);
  /// Other quads within the same border, which must be of the same shape and not join what is joined outside: that is
  /// not looked at. Sides that were creases are, and those along `lines`. They get the numbers `free`, of quads that
  /// are gone or go now, and new ones beyond. Returns their numbers.
  std::vector<uint32_t> replace(const std::vector<uint32_t>& going, const std::vector<std::array<uint32_t, 4>>& quads,
                                const std::vector<uint32_t>& free,
                                const std::vector<std::vector<uint32_t>>& lines = {});

  /// Without what is gone.
  [[nodiscard]] QuadMesh mesh() const;
  /// The vertices and quads that are there, by the numbers that they had.
  struct Kept {
    std::vector<uint32_t> vertices, quads;
  };
  /// What is gone takes no memory any more: those that are there get new numbers, in the same order.
  Kept forgetGone();

 private:
  static constexpr uint32_t kGone = UINT32_MAX;
  static constexpr int kHalfTurn = 12;
  struct Six {
    uint32_t other = 0;                // the quad on the other side
    std::array<uint32_t, 6> vertices;  // around both, the edge from 0 to 3
  };
  [[nodiscard]] size_t creasesAt(uint32_t vertex) const;
  [[nodiscard]] bool isCrease(uint32_t quad, int side) const { return (creases_[quad] >> (side & 3) & 1) != 0; }
  void setCrease(uint32_t from, uint32_t to, bool crease);
  [[nodiscard]] Six sixAround(uint32_t quad, int corner) const;
  void removeFrom(uint32_t vertex, uint32_t quad);

  std::vector<Vec3d> positions_;
  std::vector<std::array<uint32_t, 4>> quads_;
  std::vector<uint8_t> creases_;
  std::vector<bool> marked_;
  std::vector<std::vector<uint32_t>> around_;
  size_t alive_ = 0;
};

}  // namespace argil::clay
