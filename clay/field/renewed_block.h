#pragma once
// Distances of whole pieces made anew, block by block. This module's own.

#include <array>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "clay/field/renewal.h"
#include "clay/store/channel_reader.h"
#include "clay/store/sampler.h"

namespace argil::clay {

/// Bricks along an axis of a block. One more brick around it is worked on too, for its sake alone: that is a quarter
/// more work here, and half as much again with eight.
inline constexpr int kBlockEdge = 16;
inline constexpr int kBlockBits = 4;

/// Bricks of a block and of the layer of bricks around it, with a field that tells the surface and is no distance; and
/// distances from it (Renewal). Room is used again for block after block; one thread each.
class RenewedBlock {
 public:
  /// A block by its first brick over kBlockEdge. Nothing is in it.
  void begin(Coord block, float band);
  [[nodiscard]] Coord first() const { return first_; }  ///< Brick coordinate.
  [[nodiscard]] bool holds(Coord brick) const { return (brick >> kBlockBits) * kBlockEdge == first_; }

  /// A brick to be filled. Valid until the next.
  float* add(Coord brick);
  void dropLast() { fields_.pop_back(); }
  /// What was added last are distances already, and stays.
  void keepLast() { fields_.back().kept = true; }
  /// A brick of the block that is the same all over.
  void addTile(Coord brick, bool inside) { tiles_.emplace_back(brick, inside); }

  /// What stands beside the bricks that were added: 512 values, or null for what `beside` has there. `known`: see
  /// Renewal.
  using Beside = std::function<const float*(Coord)>;
  void solve(Renew how, Sampler& beside, const Beside& instead = nullptr, float known = 0);

  /// What a brick of that number has in its channels.
  using Paint = std::function<ChannelBlock(const FloatBrick&, size_t number)>;
  /// Puts bricks and tiles of the block itself into `editor`, which `editing` guards; the field as it is where nothing
  /// was solved.
  void put(Editor& editor, std::mutex& editing, const Paint& paint = nullptr);

  /// Which way the nearest place of the surface lies from voxels of the brick of that number, by its distances now; in
  /// voxels. Of what was kept: by those of `beside`.
  class Feet {
   public:
    Feet(const RenewedBlock& block, size_t number, Sampler* beside = nullptr);
    [[nodiscard]] Vec3f way(int voxel) const;

   private:
    std::array<float, kWideSize> around_;
  };

 private:
  struct Field {
    Coord brick;
    bool kept = false;
    size_t number = 0;  // in `renewal_`, where it is solved
    std::array<float, kBrickVoxels> phi;
  };

  Coord first_;
  float band_ = 3;
  std::vector<Field> fields_;
  std::vector<std::pair<Coord, bool>> tiles_;
  std::optional<Renewal> renewal_;
};

}  // namespace argil::clay
