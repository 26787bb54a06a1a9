#pragma once
// Where whole-piece operations have their colours, materials and masks from. This module's own.

#include "clay/store/channel_reader.h"
#include "clay/store/editor.h"
#include "clay/store/version.h"

namespace argil::clay {

/// Reads the channels of a version at single voxels. One thread; remembers what it looked up, so make one for each
/// region of the work.
class ChannelSource {
 public:
  explicit ChannelSource(const Version& version) : reader_(version) {}

  /// Whether there is anything to read.
  [[nodiscard]] static bool any(const Version& version);

  /// The bytes of a voxel; false where it is not in the band.
  bool read(Coord voxel, ChannelBytes& bytes);
  /// Those of the nearest voxel of the band, up to two voxels off along each axis (of equally near ones the lowest),
  /// and its squared distance; zeros and kNone where there is none.
  int nearest(Coord voxel, ChannelBytes& bytes);
  static constexpr int kNone = 1000;
  /// Between voxels: the mean of colours and masks of the band's voxels around `p`, by their nearness in 64 steps a
  /// voxel, and the material that counts most. False where none of them is in the band.
  bool between(const Vec3d& p, ChannelBytes& bytes);

 private:
  const ChannelPlace& at(Coord brick);

  ChannelReader<Version> reader_;
  Coord last_{INT32_MIN, 0, 0};
  const ChannelPlace* place_ = nullptr;
};

/// Makes all channels of a brick coordinate 0.
void clearChannels(Editor& editor, Coord brick);

}  // namespace argil::clay
