// The clay's draw calls: which chunks are in the picture.

#include "render/renderer_state.h"

namespace argil::render {
namespace {

bool outside(const FramePlan& plan, const Vec3d& min, const Vec3d& max) {
  for (const FramePlan::Side& side : plan.sides) {
    // The corner that lies farthest inwards.
    const Vec3d corner = (side.normal.array() > 0).select(min, max);
    if (side.normal.dot(corner - plan.eye) > side.offset) return true;
  }
  return false;
}

}  // namespace

void Renderer::State::drawClay(VkCommandBuffer commands, const FramePlan& plan, bool intoShadow) {
  const SurfaceLayout& layout = surface.layout();
  if (layout.draws().empty()) return;
  bind(commands, intoShadow ? Pass::shadow : Pass::clay);
  const VkBuffer vertices = surface.vertices();
  const VkDeviceSize offset = 0;
  vkCmdBindVertexBuffers(commands, 0, 1, &vertices, &offset);
  vkCmdBindIndexBuffer(commands, surface.indices(), 0, VK_INDEX_TYPE_UINT32);
  const clay::Grid& grid = layout.grid();
  for (const ChunkDraw& draw : layout.draws()) {
    if (!intoShadow) {
      if (outside(plan, grid.toWorld(draw.min), grid.toWorld(draw.max))) {
        ++stats.chunksCulled;
        continue;
      }
      ++stats.chunksDrawn;
      stats.trianglesDrawn += draw.indexCount / 3;
    }
    const Vec3f rel = (grid.toWorld(draw.firstVoxel.toVec3d()) - plan.eye).cast<float>();
    const Coord corner = draw.firstVoxel * kUnitsPerVoxel;
    const ChunkConstants constants{
        {corner.x, corner.y, corner.z}, float(grid.voxelMm / kUnitsPerVoxel), {rel.x(), rel.y(), rel.z()}, 0, surfaceOf(PieceLook{})};
    push(commands, pipelines.layout(), constants);
    vkCmdDrawIndexed(commands, draw.indexCount, 1, draw.firstIndex, 0, 0);
  }
}

}  // namespace argil::render
