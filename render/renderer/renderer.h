#pragma once
// Pictures of clay, as images and in one window.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clay/mesh/triangle_mesh.h"
#include "clay/surface/surface.h"
#include "render/view/device_work.h"
#include "render/view/image.h"
#include "render/view/look.h"
#include "render/view/overlays.h"
#include "render/view/quality.h"
#include "render/view/renderer_options.h"
#include "render/view/stereo.h"
#include "render/view/ui_frame.h"
#include "render/view/view.h"
#include "render/view/window_hooks.h"

namespace argil::render {

/// Names a piece of clay or a part, chosen by the caller.
using PieceId = uint32_t;

/// How a piece stands in the picture.
struct PieceLook {
  /// From the piece's millimetres to the world's, with translationMm.
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Vec3d translationMm = Vec3d::Zero();
  Vec3d scale = Vec3d::Ones();  ///< Along the world's axes about the piece's zero, above 0; after the rotation.
  Colour colour{0.80f, 0.62f, 0.50f, 1};  ///< Alpha is ignored.
  float roughness = 0.6f, gloss = 0.3f;   ///< 0 to 1: Shading::material.
  bool visible = true;
  bool dimmed = false;      ///< Paler: locked or not the one that is worked on.
  bool hideMasked = false;  ///< Clay whose mask is above half is not drawn.
  /// Clay is drawn thicker by this, 0 and more: its vertices move along their normals, on the device. What an offset
  /// would come to, but where it meets itself; edges are not rounded. pick() knows nothing of it.
  double grownMm = 0;
  MaterialColours materials = {};  ///< Under what is painted.
};

/// A whole picture, but for the model.
struct Shot {
  View view;
  Look look;
  Stereo stereo;
  Overlays overlays;
};

/// Draws pieces of clay, parts and overlays, to images and to one window. Holds the model on the device and follows it
/// by deltas. Any one thread at a time; the same calls give the same picture on the same device. Every member throws
/// Error (work) when the device fails; then the renderer is unusable, the clay untouched: see recover().
class Renderer {
 public:
  /// Throws Error when there is no driver (saying what to install) or no device of that name.
  explicit Renderer(const RendererOptions& options = {});
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  // The model (renderer_model.cpp)

  /// Uploads what changed in a piece, which is made when it is new. Cost follows the delta. Deltas of a piece must come
  /// in order, from one Surface. When graphics memory does not hold it, the Error says so and the piece is gone: send
  /// it whole again, or leave it out.
  UploadStats update(PieceId piece, const clay::SurfaceDelta& delta);
  UploadStats update(const clay::SurfaceDelta& delta) { return update(0, delta); }
  /// A mesh as it is, in place of what was there under that name. Both sides of its faces are drawn.
  UploadStats updatePart(PieceId part, const clay::TriangleMesh& mesh);
  /// Changes how a piece or part stands in the picture; one that is not there yet gets it when it comes. Free of cost,
  /// but for a change of hideMasked: painted bricks. Throws Error for numbers that are not finite.
  void place(PieceId piece, const PieceLook& look);
  void remove(PieceId piece);
  /// Forgets all pieces.
  void clear();

  /// Tight box in world mm of what is visible, of one piece; empty without any. O(bricks) after a change, else O(1).
  [[nodiscard]] Box bounds() const;
  [[nodiscard]] Box bounds(PieceId piece) const;
  [[nodiscard]] uint64_t triangleCount() const;
  struct Hit {
    PieceId piece = 0;
    double distanceMm = 0;
    bool fromOutside = true;
    Vec3d normal = Vec3d::UnitZ();  ///< Of the triangle, towards its front, world.
  };
  /// The first visible surface along a direction (any length) from a point, or nothing. What a section cuts away does
  /// not count: pass it.
  [[nodiscard]] std::optional<Hit> pick(const Vec3d& originMm, const Vec3d& direction,
                                        const std::optional<Section>& section = {}) const;
  [[nodiscard]] std::optional<double> raycast(const Vec3d& originMm, const Vec3d& direction) const;

  // Pictures

  /// Of the next pictures. Throws Error when out of range. Cheap: images are made anew only when their size changes.
  void setQuality(const Quality& quality);
  /// A picture of `width` × `height` pixels, 16 to 8192 each, with panels over it if given. Throws Error for a bad
  /// view, size, look, or overlay that is not finite.
  [[nodiscard]] Image render(const Shot& shot, int width, int height, const UiFrame* ui = nullptr);
  [[nodiscard]] Image render(const View& view, const Overlays& overlays, int width, int height);

  // One window (renderer_window.cpp)

  /// From now on present() draws there, until detach(): call that before the window closes. Throws Error when this
  /// device cannot show pictures in it; then no window is attached.
  void attach(const WindowHooks& window);
  void detach();
  /// Draws the next frame into the window; waits for the frame before the last to be done, not for this one. False when
  /// there was nothing to draw on (minimised, hidden, changing its size just now). Follows the window's size by itself.
  /// Shows at most one picture a refresh of the screen where the screen has one, else as many as are asked for: the
  /// caller paces.
  bool present(const Shot& shot, const UiFrame& ui);
  /// The picture that the window shows with other panels over it: no pass over the clay. False too when that picture is
  /// no longer held.
  bool presentPanels(const UiFrame& ui);
  /// From present() until another picture is drawn or the window is detached.
  [[nodiscard]] bool holdsPicture() const;
  /// How long the last of these two calls waited for the screen, and for the device where that has a clock of its own.
  [[nodiscard]] int64_t waitedNs() const;
  /// What the window showed last, panels included, as an image. Waits for it to be drawn and copies it; drawing another
  /// picture by render() first costs such a copy too. Throws Error when nothing was shown yet.
  [[nodiscard]] Image lastPresented();
  /// Font and pictures of the panels: 8-bit coverage (channels 1) or RGBA (4), sRGB, straight alpha. Texture 0 is the
  /// font; until it is set, panels are plain faces. Replaces what was there under that name. Waits for the device: not
  /// for each frame.
  void setUiTexture(uint32_t texture, int width, int height, int channels, const uint8_t* pixels);

  /// The device was lost (deviceLost() is true after the Error): makes everything anew on it or on another one. The
  /// model has to be sent again: whole surfaces by update(), parts, places, panels' textures; the window stays
  /// attached. Throws Error when there is no device left.
  void recover();
  [[nodiscard]] bool deviceLost() const;
  /// For tests: the next submission fails as if the device were lost.
  void simulateDeviceLoss();

  // What it did

  [[nodiscard]] const std::string& deviceName() const;
  /// Bytes of buffers and images on the device.
  [[nodiscard]] uint64_t deviceBytes() const;
  /// Chunks drawn and chunks outside of the picture, of the last picture.
  struct DrawStats {
    uint64_t chunksDrawn = 0, chunksCulled = 0, trianglesDrawn = 0, drawCalls = 0;
    uint64_t shadowTriangles = 0;  ///< Drawn into the shadow's map.
    uint64_t pictures = 0;         ///< Since the start: pictures whose clay was drawn.
    uint64_t levelBytes = 0;       ///< Uploaded for coarser levels that the picture was the first to want.
  };
  [[nodiscard]] DrawStats drawStats() const;
  [[nodiscard]] std::vector<PassTime> passTimes() const;
  /// Validation was asked for and its layer is there.
  [[nodiscard]] bool validating() const;
  /// Everything that the validation layer said so far.
  [[nodiscard]] std::vector<std::string> validationMessages() const;

 private:
  bool presentFrame(const Shot* shot, const UiFrame& ui);

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace argil::render
