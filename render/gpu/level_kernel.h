#pragma once
// Levels of detail made on the device, from what lies in its buffers. Only for the .cpp files of render/.

#include "render/gpu/surface_buffers.h"
#include "render/surface/level_batch.h"

namespace argil::render {

/// What SurfaceLayout::prepareChunk makes on the CPU, to the bit, for many chunks at once; cones may differ by
/// rounding. Nothing is uploaded but the tables of a batch. Costs 8 bytes of device memory for each vertex of the
/// largest batch.
class LevelKernel {
 public:
  /// Whether the device can: by Vulkan 1.3 all should.
  [[nodiscard]] static bool possibleOn(const Gpu& gpu);
  /// `buffers` were made for kernels, and outlive this.
  LevelKernel(Gpu& gpu, SurfaceBuffers& buffers);
  ~LevelKernel();
  LevelKernel(const LevelKernel&) = delete;
  LevelKernel& operator=(const LevelKernel&) = delete;

  /// Kernels count with signs: up to 8.6 GB of indices.
  [[nodiscard]] bool reachesAll() const { return buffers_.indexBytes() / sizeof(uint32_t) <= INT32_MAX; }
  /// Whether one more chunk might make a batch too large.
  [[nodiscard]] static bool full(const LevelBatch& batch);
  /// The sizes of the batch's levels, one a chunk, valid until the next call. Waits for the device. Throws Error (work)
  /// as Gpu does.
  [[nodiscard]] std::span<const LevelSize> measure(const LevelBatch& batch);
  /// Writes the levels of the first `chunks` of the batch that was measured last to where they say now. Does not wait.
  void write(const LevelBatch& batch, size_t chunks);
  [[nodiscard]] uint64_t bytes() const;
  /// Gives its memory back, until it is needed again.
  void release();

 private:
  enum Step : size_t { kStand, kCount, kWrite, kSteps };
  void record(VkCommandBuffer commands, Step step, const LevelBatch& batch, size_t groups);
  void writeChunks(const LevelBatch& batch);
  void destroy() noexcept;

  Gpu& gpu_;
  SurfaceBuffers& buffers_;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  std::array<VkPipeline, kSteps> pipelines_{};
  Buffer scratch_, tables_, sizes_;
  Gpu::Ticket written_ = 0;
};

}  // namespace argil::render
