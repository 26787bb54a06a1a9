#pragma once
// The clay's vertices and indices on the device. Only for the .cpp files of render/.

#include "render/gpu.h"
#include "render/surface_layout.h"

namespace argil::render {

/// Follows a surface by its deltas and uploads what changed through a staging buffer. Grows by copying on the device.
class SurfaceBuffers {
 public:
  explicit SurfaceBuffers(Gpu& gpu) : gpu_(gpu) {}

  UploadStats update(const clay::SurfaceDelta& delta);
  void clear();

  [[nodiscard]] const SurfaceLayout& layout() const { return layout_; }
  [[nodiscard]] VkBuffer vertices() const { return vertices_.handle(); }
  [[nodiscard]] VkBuffer indices() const { return indices_.handle(); }
  [[nodiscard]] uint64_t bytes() const { return vertices_.size() + indices_.size() + staging_.size(); }

 private:
  class Staging;

  Gpu& gpu_;
  SurfaceLayout layout_;
  Buffer vertices_, indices_, staging_;
};

}  // namespace argil::render
