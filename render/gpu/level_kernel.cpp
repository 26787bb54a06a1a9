#include "render/gpu/level_kernel.h"

#include <algorithm>
#include <cstring>

#include "clay/base/error.h"

namespace argil::render {
namespace {

constexpr uint32_t kStandWords[] = {
#include "shaders/level_stand.comp.inc"
};
constexpr uint32_t kCountWords[] = {
#include "shaders/level_count.comp.inc"
};
constexpr uint32_t kWriteWords[] = {
#include "shaders/level_write.comp.inc"
};

/// Of one batch: 32 MB of scratch; and as many work groups as every device takes.
constexpr size_t kMostVertices = size_t{4} << 20, kMostBricks = 65535;
/// That one chunk's triangles name: with those one lower along each axis.
constexpr size_t kMostOfAChunk = 9 * 9 * 9;

/// Push constants of shaders/level.glsl.
struct KernelConstants {
  VkDeviceAddress vertices, indices, paint, standing, placed, bricks, chunks, sizes;
  uint32_t painted;
};

constexpr MemoryUse kKernelWrites{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT};
constexpr MemoryUse kKernelUses{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT};

}  // namespace

bool LevelKernel::possibleOn(const Gpu& gpu) {
  return gpu.hasKernels() && gpu.properties().limits.maxComputeWorkGroupInvocations >= 256;
}

LevelKernel::LevelKernel(Gpu& gpu, SurfaceBuffers& buffers) : gpu_(gpu), buffers_(buffers) {
  try {
    const VkPushConstantRange constants{VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(KernelConstants)};
    auto layout = structure<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &constants;
    gpu_.check(vkCreatePipelineLayout(gpu_.device(), &layout, nullptr, &layout_), "making a kernel's layout");
    const std::array<std::span<const uint32_t>, kSteps> words{kStandWords, kCountWords, kWriteWords};
    for (size_t step = 0; step < kSteps; ++step) {
      auto module = structure<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
      module.codeSize = words[step].size_bytes();
      module.pCode = words[step].data();
      auto info = structure<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
      info.stage = structure<VkPipelineShaderStageCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO);
      info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
      info.stage.pName = "main";
      info.layout = layout_;
      gpu_.check(vkCreateShaderModule(gpu_.device(), &module, nullptr, &info.stage.module), "loading a kernel");
      const VkResult result =
          vkCreateComputePipelines(gpu_.device(), VK_NULL_HANDLE, 1, &info, nullptr, &pipelines_[step]);
      vkDestroyShaderModule(gpu_.device(), info.stage.module, nullptr);
      gpu_.check(result, "making a kernel");
    }
  } catch (...) {
    destroy();
    throw;
  }
}

LevelKernel::~LevelKernel() {
  destroy();
}

void LevelKernel::destroy() noexcept {
  gpu_.settle();
  for (VkPipeline pipeline : pipelines_) vkDestroyPipeline(gpu_.device(), pipeline, nullptr);
  vkDestroyPipelineLayout(gpu_.device(), layout_, nullptr);
}

bool LevelKernel::full(const LevelBatch& batch) {
  return batch.scratch >= kMostVertices || batch.bricks.size() + kMostOfAChunk > kMostBricks;
}

std::span<const LevelSize> LevelKernel::measure(const LevelBatch& batch) {
  const auto grow = [&](Buffer& buffer, size_t bytes, Buffer::Memory memory) {
    if (bytes <= buffer.size()) return;
    buffer.reset();
    buffer = Buffer(gpu_, bytes + bytes / 2, VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT, memory);
  };
  grow(scratch_, batch.scratch * 2 * sizeof(uint32_t), Buffer::Memory::device);
  grow(tables_, batch.bricks.size() * sizeof(LevelBrick) + batch.chunks.size() * sizeof(LevelChunk),
       Buffer::Memory::upload);
  grow(sizes_, batch.chunks.size() * sizeof(LevelSize), Buffer::Memory::readback);
  gpu_.wait(written_);  // it reads the tables
  std::memcpy(tables_.mapped(), batch.bricks.data(), batch.bricks.size() * sizeof(LevelBrick));
  writeChunks(batch);
  gpu_.run([&](VkCommandBuffer commands) {
    record(commands, kStand, batch, batch.bricks.size());
    barrier(commands, kKernelWrites, kKernelUses);
    record(commands, kCount, batch, batch.chunks.size());
    barrier(commands, kKernelWrites, {VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT});
  });
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
  return {reinterpret_cast<const LevelSize*>(sizes_.mapped()), batch.chunks.size()};
}

void LevelKernel::write(const LevelBatch& batch, size_t chunks) {
  writeChunks(batch);
  written_ = gpu_.submit([&](VkCommandBuffer commands) { record(commands, kWrite, batch, chunks); });
}

void LevelKernel::writeChunks(const LevelBatch& batch) {
  std::memcpy(tables_.mapped() + batch.bricks.size() * sizeof(LevelBrick), batch.chunks.data(),
              batch.chunks.size() * sizeof(LevelChunk));
}

void LevelKernel::record(VkCommandBuffer commands, Step step, const LevelBatch& batch, size_t groups) {
  KernelConstants constants{};
  const SurfaceBuffers::Addresses model = buffers_.addresses();
  constants.vertices = model.vertices;
  constants.indices = model.indices;
  constants.paint = model.paint;
  constants.painted = buffers_.painted() ? 1 : 0;
  constants.standing = scratch_.address();
  constants.placed = constants.standing + batch.scratch * sizeof(uint32_t);
  constants.bricks = tables_.address();
  constants.chunks = constants.bricks + batch.bricks.size() * sizeof(LevelBrick);
  constants.sizes = sizes_.address();
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_[step]);
  vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
  vkCmdDispatch(commands, uint32_t(groups), 1, 1);
}

void LevelKernel::release() {
  scratch_.reset();
  tables_.reset();
  sizes_.reset();
}

uint64_t LevelKernel::bytes() const {
  return scratch_.size() + tables_.size() + sizes_.size();
}

}  // namespace argil::render
