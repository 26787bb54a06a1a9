#include "render/gpu/surface_buffers.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "clay/base/error.h"

namespace argil::render {
namespace {

constexpr VkDeviceSize kHalfBytes = VkDeviceSize(8) << 20;

void barrier(VkCommandBuffer commands, VkPipelineStageFlags2 fromStage, VkAccessFlags2 fromAccess,
             VkPipelineStageFlags2 toStage, VkAccessFlags2 toAccess) {
  auto memory = structure<VkMemoryBarrier2>(VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
  memory.srcStageMask = fromStage;
  memory.srcAccessMask = fromAccess;
  memory.dstStageMask = toStage;
  memory.dstAccessMask = toAccess;
  auto dependency = structure<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
  dependency.memoryBarrierCount = 1;
  dependency.pMemoryBarriers = &memory;
  vkCmdPipelineBarrier2(commands, &dependency);
}

}  // namespace

SurfaceBuffers::Staging::Staging(SurfaceBuffers& owner) : owner_(owner) {
  if (owner_.staging_.handle()) return;
  owner_.staging_ = Buffer(owner_.gpu_, 2 * kHalfBytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, Buffer::Memory::upload);
}

// The next update fills the half that the device may still be copying, if this one was broken off.
SurfaceBuffers::Staging::~Staging() {
  try {
    gpu().wait(sent_);
  } catch (const Error&) {  // A lost device copies nothing.
  }
}

void SurfaceBuffers::Staging::reserve(uint32_t vertices, uint32_t indices) {
  flush();
  grow(owner_.vertices_, VkDeviceSize(vertices) * sizeof(SurfaceVertex), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  grow(owner_.indices_, VkDeviceSize(indices) * sizeof(uint32_t), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
  if (owner_.painted()) growPaint();
}

/// As many as there are vertices; new ones are unpainted.
void SurfaceBuffers::Staging::growPaint() {
  const VkDeviceSize before = owner_.paint_.size(),
                     size = owner_.vertices_.size() / sizeof(SurfaceVertex) * sizeof(PackedPaint);
  if (size <= before) return;
  grow(owner_.paint_, size, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  gpu().run([&](VkCommandBuffer commands) {
    vkCmdFillBuffer(commands, owner_.paint_.handle(), before, VK_WHOLE_SIZE, kUnpainted);
    barrier(commands, VK_PIPELINE_STAGE_2_CLEAR_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT,
            VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT);
  });
}

void SurfaceBuffers::Staging::writePaint(uint32_t first, std::span<const PackedPaint> paint) {
  if (!owner_.painted()) {
    flush();
    growPaint();
  }
  write(toPaint_, VkDeviceSize(first) * sizeof(PackedPaint), std::as_bytes(paint));
}

VkBuffer SurfaceBuffers::paint() {
  if (painted()) return paint_.handle();
  if (!unpainted_.handle()) {
    unpainted_ = Buffer(gpu_, sizeof(PackedPaint), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, Buffer::Memory::upload);
    std::memcpy(unpainted_.mapped(), &kUnpainted, sizeof kUnpainted);
  }
  return unpainted_.handle();
}

void SurfaceBuffers::Staging::writeVertices(uint32_t first, std::span<const SurfaceVertex> vertices) {
  write(toVertices_, VkDeviceSize(first) * sizeof(SurfaceVertex), std::as_bytes(vertices));
}

void SurfaceBuffers::Staging::writeIndices(uint32_t first, std::span<const uint32_t> indices) {
  write(toIndices_, VkDeviceSize(first) * sizeof(uint32_t), std::as_bytes(indices));
}

// What is filled goes; the other half is free when this returns. The last submission.
Gpu::Ticket SurfaceBuffers::Staging::send() {
  if (filled_ == 0) return sent_;
  const Gpu::Ticket ticket = gpu().submit([&](VkCommandBuffer commands) {
    // A picture that is still being drawn reads these buffers.
    barrier(commands, VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT, 0, VK_PIPELINE_STAGE_2_COPY_BIT, 0);
    const VkBuffer staging = owner_.staging_.handle();
    if (!toVertices_.empty()) {
      vkCmdCopyBuffer(commands, staging, owner_.vertices_.handle(), uint32_t(toVertices_.size()), toVertices_.data());
    }
    if (!toIndices_.empty()) {
      vkCmdCopyBuffer(commands, staging, owner_.indices_.handle(), uint32_t(toIndices_.size()), toIndices_.data());
    }
    if (!toPaint_.empty()) {
      vkCmdCopyBuffer(commands, staging, owner_.paint_.handle(), uint32_t(toPaint_.size()), toPaint_.data());
    }
    barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT, VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_2_INDEX_READ_BIT);
  });
  toPaint_.clear();
  toVertices_.clear();
  toIndices_.clear();
  gpu().wait(std::exchange(sent_, ticket));
  half_ = kHalfBytes - half_;
  filled_ = 0;
  return sent_;
}

void SurfaceBuffers::Staging::grow(Buffer& buffer, VkDeviceSize size, VkBufferUsageFlags usage) {
  if (size <= buffer.size()) return;
  Buffer larger(owner_.gpu_, size,
                usage | owner_.usage_ | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                Buffer::Memory::device);
  if (buffer.size() > 0) {
    gpu().run([&](VkCommandBuffer commands) {
      const VkBufferCopy all{0, 0, buffer.size()};
      vkCmdCopyBuffer(commands, buffer.handle(), larger.handle(), 1, &all);
      barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
              VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT,
              VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_2_INDEX_READ_BIT);
    });
    stats.copiedBytes += buffer.size();
  }
  buffer = std::move(larger);
}

void SurfaceBuffers::Staging::write(std::vector<VkBufferCopy>& copies, VkDeviceSize offset,
                                    std::span<const std::byte> bytes) {
  stats.bytes += bytes.size();
  ++stats.writes;
  while (!bytes.empty()) {
    if (filled_ == kHalfBytes) send();
    const VkDeviceSize part = std::min<VkDeviceSize>(bytes.size(), kHalfBytes - filled_);
    const VkDeviceSize from = half_ + filled_;
    std::memcpy(owner_.staging_.mapped() + from, bytes.data(), size_t(part));
    VkBufferCopy* const last = copies.empty() ? nullptr : &copies.back();
    if (last && last->srcOffset + last->size == from && last->dstOffset + last->size == offset)
      last->size += part;
    else
      copies.push_back({from, offset, part});
    filled_ += part;
    offset += part;
    bytes = bytes.subspan(size_t(part));
  }
}

void SurfaceBuffers::clear() {
  if (!vertices_.handle()) return;
  gpu_.run([](VkCommandBuffer) {});  // a picture that is still being drawn reads them
  ranges_.clear();
  paint_.reset();
  vertices_.reset();
  indices_.reset();
}

}  // namespace argil::render
