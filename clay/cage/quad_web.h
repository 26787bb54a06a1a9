#pragma once
// A closed mesh of quads that is edited in place.

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "clay/cage/quad_mesh.h"

namespace argil::clay {

/// Whatever is done to it, it stays closed, 2-manifold and of the same genus: what would change that is refused, and so
/// is what would leave a vertex of fewer than 3 or more than kMostAround quads. One thread.
class QuadWeb {
 public:
  static constexpr size_t kMostAround = 6;

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
  /// Vertices at the other ends of its edges, in no order.
  void beside(uint32_t vertex, std::vector<uint32_t>& out) const;

  /// How much nearer to four quads around every vertex the mesh would be, Σ (n − 4)² before less after; none where the
  /// change is refused.
  [[nodiscard]] std::optional<int> gainOfCollapse(uint32_t quad, int corner) const;
  /// Corner and the one opposite become one vertex, which is returned (the corner's), and the quad is gone; where that
  /// leaves two quads around another vertex these become one. Only what gainOfCollapse() allows.
  uint32_t collapse(uint32_t quad, int corner);
  /// The edge that leaves `corner` turns within the six vertices around it, `step` 1 or −1.
  [[nodiscard]] std::optional<int> gainOfTurn(uint32_t quad, int corner, int step) const;
  void turn(uint32_t quad, int corner, int step);
  /// Where the edge goes then.
  [[nodiscard]] std::array<uint32_t, 2> endsOfTurn(uint32_t quad, int corner, int step) const;

  /// Without what is gone.
  [[nodiscard]] QuadMesh mesh() const;

 private:
  static constexpr uint32_t kGone = UINT32_MAX;
  struct Six {
    uint32_t other = 0;                // the quad on the other side
    std::array<uint32_t, 6> vertices;  // around both, the edge from 0 to 3
  };
  [[nodiscard]] uint32_t across(uint32_t from, uint32_t to) const;
  [[nodiscard]] Six sixAround(uint32_t quad, int corner) const;
  [[nodiscard]] bool areBeside(uint32_t a, uint32_t b) const;
  void removeFrom(uint32_t vertex, uint32_t quad);

  std::vector<Vec3d> positions_;
  std::vector<std::array<uint32_t, 4>> quads_;
  std::vector<std::vector<uint32_t>> around_;
  size_t alive_ = 0;
};

}  // namespace argil::clay
