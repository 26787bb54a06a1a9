#pragma once
// The vertex and index buffer on the device. Only for the .cpp files of render/.

#include "render/gpu/gpu.h"
#include "render/surface/surface_layout.h"
#include "render/view/device_work.h"

namespace argil::render {

/// One vertex and one index buffer for all pieces, written through a staging buffer. Grow by copying on the device.
class SurfaceBuffers {
 public:
  /// `forKernels`: kernels may be given their addresses.
  SurfaceBuffers(Gpu& gpu, bool forKernels)
      : gpu_(gpu), usage_(forKernels ? VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT : 0) {}

  /// What `write` sends to the sink lies on the device when this returns.
  template <class Write>
  UploadStats update(Write&& write) {
    Staging staging(*this);
    write(staging);
    staging.flush();
    return staging.stats;
  }
  /// Gives the memory back; no piece may be left.
  void clear();

  [[nodiscard]] BufferRanges& ranges() { return ranges_; }
  [[nodiscard]] VkBuffer vertices() const { return vertices_.handle(); }
  struct Addresses {
    VkDeviceAddress vertices, indices, paint;  ///< paint: where there is some.
  };
  [[nodiscard]] Addresses addresses() const {
    return {vertices_.address(), indices_.address(), painted() ? paint_.address() : 0};
  }
  /// One PackedPaint a vertex where something is painted; else one for all of them.
  [[nodiscard]] VkBuffer paint();
  [[nodiscard]] bool painted() const { return paint_.handle() != VK_NULL_HANDLE; }
  [[nodiscard]] VkBuffer indices() const { return indices_.handle(); }
  [[nodiscard]] uint64_t indexBytes() const { return indices_.size(); }
  [[nodiscard]] uint64_t bytes() const { return vertices_.size() + indices_.size() + paint_.size() + staging_.size(); }

 private:
  /// Gathers writes in one half of the staging buffer while the device copies the other. Nothing is written twice
  /// between two flushes.
  class Staging : public UploadSink {
   public:
    explicit Staging(SurfaceBuffers& owner);
    ~Staging() override;
    Staging(const Staging&) = delete;
    Staging& operator=(const Staging&) = delete;
    void reserve(uint32_t vertices, uint32_t indices) override;
    void writeVertices(uint32_t first, std::span<const SurfaceVertex> vertices) override;
    void writeIndices(uint32_t first, std::span<const uint32_t> indices) override;
    void writePaint(uint32_t first, std::span<const PackedPaint> paint) override;
    void flush() { gpu().wait(send()); }

    UploadStats stats;

   private:
    Gpu& gpu() { return owner_.gpu_; }
    Gpu::Ticket send();
    void growPaint();
    void grow(Buffer& buffer, VkDeviceSize size, VkBufferUsageFlags usage);
    void write(std::vector<VkBufferCopy>& copies, VkDeviceSize offset, std::span<const std::byte> bytes);

    SurfaceBuffers& owner_;
    std::vector<VkBufferCopy> toVertices_, toIndices_, toPaint_;
    VkDeviceSize half_ = 0, filled_ = 0;  // where the half begins; bytes in it
    Gpu::Ticket sent_ = 0;                // what copies the other half
  };

  Gpu& gpu_;
  VkBufferUsageFlags usage_;
  BufferRanges ranges_;
  Buffer vertices_, indices_, paint_, unpainted_, staging_;
};

}  // namespace argil::render
