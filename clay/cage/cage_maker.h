#pragma once
// Cages around a clay, again and again, finer where they were found too coarse.

#include <mutex>
#include <optional>

#include "clay/base/work_part.h"
#include "clay/cage/coarsen_quads.h"
#include "clay/cage/crease_map.h"
#include "clay/cage/quad_mesh.h"
#include "clay/cage/web_on_surface.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/store/version.h"

namespace argil::clay {

struct CoarseCage {
  QuadMesh mesh;
  double edgeMm = 0;  ///< About how long its edges are.
  /// Bodies less handles, counted with cavities: half of the Euler characteristic. The clay's is the same.
  int64_t shape = 0;
};

/// Of CageWishes::maskDensity; its inverse is the least.
inline constexpr double kMostMaskDensity = 16;

/// What the person wants of quads, beside their count.
struct CageWishes {
  /// So many times as many quads a mm² lie where the clay is fully masked, as far as there is room.
  double maskDensity = 1;
  std::vector<GuideLoop> guides;  ///< In the clay's own mm; see CreaseMap.
};

/// How far quads are as the person wished.
struct WishesMet {
  size_t guides = 0;                    ///< That lie on the clay,
  double guidesMm = 0, onGuidesMm = 0;  ///< their length, and that of the edges that follow them.
  double maskDensity = 0;               ///< Quads a mm² where the clay is masked by half and more, of those elsewhere;
                                        ///< 0: not asked for, or there is no such place.
};

/// Holds what all cages of a clay begin with: its surface, a mesh of many quads, and how long edges are to be at each
/// vertex of the surface. One thread.
class CageMaker {
 public:
  /// Sizes are even, but smaller where the clay, or the air in a slit of it, is thin. `creased`: edges of cages follow
  /// the clay's creases and the guides, `end`: and the border of what lies in that plane. Throws as coarseCage().
  CageMaker(const Version& version, size_t most, bool creased, int threads, const WorkPart& part,
            const std::optional<EndPlane>& end = {}, const CageWishes& wishes = {});
  CageMaker(const CageMaker&) = delete;
  CageMaker& operator=(const CageMaker&) = delete;

  /// The fine grade where there are creases to follow, else the draft.
  [[nodiscard]] const TriangleMesh& surface() const { return surface_; }
  [[nodiscard]] Grade grade() const { return creases_->empty() ? Grade::draft : Grade::fine; }
  [[nodiscard]] const NearestTriangle& tree() const { return *tree_; }
  [[nodiscard]] const CreaseMap& creases() const { return *creases_; }
  /// Without creases where their lines need more quads than that. `most`: another number of quads, of the same sizes
  /// in proportion; 0: as many as were asked for. `regular`: as in coarsened(). Any threads.
  [[nodiscard]] CoarseCage make(const WorkPart& part, size_t most = 0, bool regular = false) const;
  /// At most `most` quads from a cage of more, where so few are possible.
  [[nodiscard]] QuadMesh fewer(QuadMesh mesh, size_t most, bool between, const WorkPart& part) const;
  /// Edges along guides are no creases any more: they were followed, and that is all.
  [[nodiscard]] WishesMet settle(QuadMesh& mesh) const;
  /// Sizes become smaller where what was fitted to a cage lies off by more than elsewhere, mm at each vertex of the
  /// surface, and larger where by less.
  void refine(std::vector<float> off);
  [[nodiscard]] const std::vector<float>& sizes() const { return sizes_; }
  /// What cages lie on, with these sizes or others.
  [[nodiscard]] WebGround ground(const std::vector<float>& sizes) const {
    return {surface_, *tree_, *creases_, sizes, walls_, finest_};
  }
  /// Nothing finer than that is looked at, mm.
  [[nodiscard]] double finestMm() const { return finest_; }
  /// Of the clay, as in CoarseCage.
  [[nodiscard]] int64_t shape() const { return shape_; }

 private:
  void evenOut();
  // coarsened() of the fine quads, of which what several counts share is done once.
  [[nodiscard]] QuadMesh fewerOf(size_t most, const WorkPart& part, bool regular) const;

  size_t most_;
  double even_ = 1, finest_ = 0;
  int64_t shape_ = 0;
  TriangleMesh surface_;
  std::optional<NearestTriangle> tree_;
  std::optional<CreaseMap> creases_;
  QuadMesh fine_;
  std::vector<float> sizes_, walls_;
  double maskDensity_ = 1;
  std::vector<uint8_t> masks_;                      // of vertices of the surface, where that counts
  mutable std::mutex mutex_;                        // guards this
  mutable std::optional<SharedCoarsening> shared_;  // with these sizes
};

/// At most `most` quads on the surface, closed, whatever the clay is, and of its shape: the clay's own quads become
/// fewer one by one, and none goes that would change it. Throws Error for empty clay, less than 24 quads, a shape that
/// needs more quads than that; Cancelled. Cost: some seconds for 1 000 quads.
[[nodiscard]] CoarseCage coarseCage(const Version& version, size_t most, const WorkPart& part);

/// The quads that a surface is made of.
[[nodiscard]] QuadMesh quadsOf(const Surface& surface);

}  // namespace argil::clay
