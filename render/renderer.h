#pragma once
// Pictures of clay, without a window.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clay/surface.h"
#include "render/image.h"
#include "render/overlays.h"
#include "render/quality.h"
#include "render/view.h"

namespace argil::render {

struct DeviceInfo {
  std::string name;
  bool software = false;  ///< Draws on the CPU.
};

/// The Vulkan 1.3 devices of this machine, best first: discrete, integrated, virtual, software. Empty without a driver.
[[nodiscard]] std::vector<DeviceInfo> devices();

struct RendererOptions {
  std::string device;  ///< Part of a device's name, any case; empty: the environment's ARGIL_GPU, else the best device.
  bool validation = false;  ///< Vulkan's validation layer with synchronization validation, where it is installed.
  Quality quality;
};

/// What one update sent to the device.
struct UploadStats {
  uint64_t bytes = 0;        ///< Vertices and indices written.
  uint64_t copiedBytes = 0;  ///< Moved on the device because a buffer grew.
  uint64_t writes = 0;       ///< Ranges written.
};

/// Draws one clay model and its overlays. Holds the model on the device and follows it by deltas. Any one thread at a
/// time; the same calls give the same picture on the same device. Every member throws Error (work) when the device
/// fails; the renderer is unusable then, the clay untouched.
class Renderer {
 public:
  /// Throws Error when there is no driver (saying what to install) or no device of that name.
  explicit Renderer(const RendererOptions& options = {});
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  /// Uploads what changed. Cost follows the delta. Deltas must come in order, from one Surface.
  UploadStats update(const clay::SurfaceDelta& delta);
  /// Forgets the model.
  void clear();

  /// Tight box of the clay in world mm; empty without clay. O(bricks).
  [[nodiscard]] Box bounds() const;
  [[nodiscard]] uint64_t triangleCount() const;
  /// Distance in mm from a point along a direction (any length) to the clay's surface, or nothing.
  [[nodiscard]] std::optional<double> raycast(const Vec3d& originMm, const Vec3d& direction) const;

  /// A picture of `width` × `height` pixels, 16 to 8192 each. The key light comes over the viewer's left shoulder.
  /// Throws Error for a bad view, size, or overlay that is not finite.
  [[nodiscard]] Image render(const View& view, const Overlays& overlays, int width, int height);

  [[nodiscard]] const std::string& deviceName() const;
  /// Bytes of buffers and images on the device.
  [[nodiscard]] uint64_t deviceBytes() const;
  /// Chunks drawn and chunks outside of the picture, of the last picture.
  struct DrawStats {
    uint64_t chunksDrawn = 0, chunksCulled = 0, trianglesDrawn = 0;
  };
  [[nodiscard]] DrawStats drawStats() const;
  /// Validation was asked for and its layer is there.
  [[nodiscard]] bool validating() const;
  /// Everything that the validation layer said so far.
  [[nodiscard]] std::vector<std::string> validationMessages() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace argil::render
