#pragma once
// All pieces and parts that a renderer draws. Only for the .cpp files of render/.

#include <map>
#include <utility>
#include <vector>

#include "render/gpu/draw_list.h"
#include "render/gpu/level_kernel.h"
#include "render/gpu/surface_buffers.h"
#include "render/renderer/frame.h"
#include "render/renderer/pipelines.h"
#include "render/surface/part_layout.h"

namespace argil::render {

/// Where a picture is taken from, as far as choosing what to draw goes.
struct Sight {
  Vec3d eye = Vec3d::Zero();
  Vec3d forward = Vec3d::UnitY();
  /// Each eye's own place and direction; the same as above for one.
  std::vector<std::pair<Vec3d, Vec3d>> eyes;
  bool perspective = true;
  double mmPerPixel = 1;               ///< At distance 1 in perspective, else everywhere.
  double detailPixels = 1;             ///< See Quality.
  bool backsSeen = false;              ///< A section shows the inside: triangles that face away count.
  std::vector<FramePlan::Side> sides;  ///< Empty: all is seen.
};

class Model {
 public:
  Model(Gpu& gpu, RendererOptions::Levels levels);

  UploadStats update(PieceId id, const clay::SurfaceDelta& delta);
  UploadStats updatePart(PieceId id, const clay::TriangleMesh& mesh);
  void place(PieceId id, const PieceLook& look);
  void remove(PieceId id);
  void clear();

  [[nodiscard]] Box bounds() const;
  [[nodiscard]] Box bounds(PieceId id) const;
  [[nodiscard]] uint64_t triangleCount() const;
  [[nodiscard]] std::optional<Renderer::Hit> pick(const Vec3d& originMm, const Vec3d& unit,
                                                  const std::optional<Section>& section) const;
  [[nodiscard]] uint64_t bytes() const { return buffers_.bytes() + list_.bytes() + (kernel_ ? kernel_->bytes() : 0); }

  // Drawing (clay_draw.cpp)

  /// Before a picture is recorded: makes some of the levels that it wants and that are not there yet, at most a part of
  /// what drawing takes. Until then finer ones are drawn.
  void prepare(const Sight& sight);
  /// Whether some clay has paint, so that vertices have each their own (Variant::painted).
  [[nodiscard]] bool painted() const { return buffers_.painted(); }
  [[nodiscard]] uint64_t levelBytes() const { return levelBytes_; }  ///< That the last prepare() uploaded.
  enum class Kind : uint8_t { clay, parts };
  /// Records draws of what is in sight, each piece with its constants, into the bound pipeline. `seen`: a level that is
  /// fine enough for that sight will do.
  void draw(VkCommandBuffer commands, VkPipelineLayout layout, const Sight& sight, Kind kind,
            Renderer::DrawStats& stats, const Sight* seen = nullptr);

 private:
  struct Piece {
    std::unique_ptr<SurfaceLayout> clay;
    std::unique_ptr<PartLayout> part;
    mutable std::optional<Box> bounds;  // in the world; found when asked for

    [[nodiscard]] double unitMm() const { return clay ? clay->grid().voxelMm / kUnitsPerVoxel : part->unitMm(); }
    [[nodiscard]] Vec3d originMm() const { return clay ? clay->grid().originMm : part->originMm(); }
  };
  struct Local;
  struct Wish {
    SurfaceLayout* clay;
    size_t chunk;
    int level;
  };

  [[nodiscard]] const PieceLook& lookOf(PieceId id) const;
  [[nodiscard]] const Box& boundsOf(PieceId id, const Piece& piece) const;
  [[nodiscard]] PieceConstants constants(const Piece& piece, const PieceLook& look, const Sight& sight) const;
  [[nodiscard]] Local toLocal(const Piece& piece, const PieceLook& look, const Sight& sight) const;

  void makeKernel();
  [[nodiscard]] std::vector<Wish> wishesOf(const Sight& sight);
  void makeHere(std::span<const Wish> wishes);
  void makeOnDevice(std::span<const Wish> wishes);
  void makeBatch(LevelBatch& batch, std::span<const Wish> wishes);

  Gpu& gpu_;
  bool onDevice_;                      // levels are made there
  SurfaceBuffers buffers_;             // before the pieces: they give their ranges back
  std::optional<LevelKernel> kernel_;  // once there is clay
  DrawList list_;
  std::map<PieceId, Piece> pieces_;
  std::map<PieceId, PieceLook> looks_;
  std::vector<VkDrawIndexedIndirectCommand> commands_;
  uint64_t levelBytes_ = 0;
  uint64_t drawn_ = 0;  // triangles of clay in the last picture
};

}  // namespace argil::render
