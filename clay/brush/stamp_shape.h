#pragma once
// Any solid as the tip of a tool.

#include <memory>
#include <vector>

#include "clay/base/job.h"
#include "clay/mesh/triangle_mesh.h"
#include "clay/store/version.h"

namespace argil::clay {

/// A solid's distances on dense grids, each half as fine as the one before. Its middle is that of its box; it fills the
/// unit ball. Immutable; read from any thread.
class StampShape {
 public:
  /// What the mesh bounds, sound or not, as meshToClay() takes it; at 96 cells along its longest side. About a second;
  /// 8 MB. Throws Error where nothing is inside; Cancelled when the job was.
  [[nodiscard]] static std::shared_ptr<const StampShape> of(const TriangleMesh& mesh, Job* job = nullptr);
  /// The same of a piece of clay.
  [[nodiscard]] static std::shared_ptr<const StampShape> of(const Version& version, Job* job = nullptr);

  struct Level {
    std::vector<float> distance;  ///< In cells of the level, negative inside; [x][y][z].
    int size[3] = {0, 0, 0};
    Vec3f middle = Vec3f::Zero();  ///< Of the solid, in cells from the first sample.
    float cell = 0;                ///< Edge of a cell; 1 is the radius of the ball around the solid.
  };
  /// The coarsest level whose cells are at most half a voxel at `radius` voxels, or the finest there is.
  [[nodiscard]] const Level& level(double radius) const;

 private:
  std::vector<Level> levels_;
};

}  // namespace argil::clay
