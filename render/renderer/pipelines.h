#pragma once
// The passes' shaders and fixed state. Only for the .cpp files of render/.

#include <array>
#include <unordered_map>

#include "render/gpu/gpu.h"
#include "render/renderer/renderer.h"

namespace argil::render {

inline constexpr VkFormat kNormalFormat = VK_FORMAT_R16G16_SFLOAT;
/// Square roots of display-linear; alpha: material's code.
inline constexpr VkFormat kAlbedoFormat = VK_FORMAT_R8G8B8A8_UNORM;
inline constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;
inline constexpr VkFormat kCavityFormat = VK_FORMAT_R8G8_UNORM;
/// What passes draw colours into: they write display-linear, blending is linear, memory holds sRGB.
inline constexpr VkFormat kColourFormat = VK_FORMAT_B8G8R8A8_SRGB;
/// The finished picture's bytes, which are sRGB, in the order that windows take.
inline constexpr VkFormat kPictureFormat = VK_FORMAT_B8G8R8A8_UNORM;

/// Push constants of shaders/chunk.glsl.
struct PieceConstants {
  int32_t anchor[3];
  float unit;
  float anchorRel[3];
  float grown;  ///< mm.
  float rotation[4];
  float scale[4];                ///< The last is not read.
  std::array<float, 4> surface;  ///< surfaceOf().
};
static_assert(sizeof(PieceConstants) == 80);

/// What shaders/clay.frag needs of a piece: display-linear colour, the code of its material (negative: its back is
/// drawn too).
[[nodiscard]] std::array<float, 4> surfaceOf(const PieceLook& look, bool bothSides = false);

/// Push constants of lines, fills and the ball.
struct OverlayConstants {
  float mode = 0;      ///< Lines: 1 on the screen. Ball: 1 the part that clay hides.
  float strength = 1;  ///< Of what is drawn.
};

enum class Pass : size_t {
  shadow,
  clay,
  part,  ///< As clay, both sides of the faces.
  cap,
  cavity,
  backdrop,
  shade,
  ground,
  groundBelow,  ///< Seen through, over clay.
  landing,
  fills,
  fillsBehind,  ///< What clay hides.
  fillsOnTop,
  shaft,
  lines,
  linesBehind,
  linesOnTop,
  ballGhost,
  ball,
  resolve,
  count
};

/// What shaders are specialised for, so that what a picture does not use costs nothing. Mirrors the constants of
/// shaders/frame.glsl, by their numbers.
struct Variant {
  int32_t eye = 0, perspective = 1, shading = 0, matcap = 0, keyShadow = 0, cavity = 0, cursorShadow = 0, depthFade = 0,
          section = 0, ground = 0, stereoMode = 0, samples = 1, painted = 0;
};

/// Variant::eye of a multiview pass.
inline constexpr int kBothEyes = 2;

/// Bindings of the one descriptor set.
enum Binding : uint32_t { kFrame, kDepth, kNormal, kCavity, kShadow, kColour, kAlbedo, kBindingCount };

class Pipelines {
 public:
  explicit Pipelines(Gpu& gpu);
  ~Pipelines();
  Pipelines(const Pipelines&) = delete;
  Pipelines& operator=(const Pipelines&) = delete;

  /// Made when first asked for.
  [[nodiscard]] VkPipeline get(Pass pass, const Variant& variant);
  [[nodiscard]] VkPipelineLayout layout() const { return layout_; }
  [[nodiscard]] VkDescriptorSet set() const { return set_; }

  /// Points the set at a uniform buffer and at images (in the order of Binding).
  void bind(VkBuffer frame, const std::array<const Texture*, kBindingCount - 1>& images);

 private:
  void createLayout();
  void destroy() noexcept;

  Gpu& gpu_;
  VkSampler nearest_ = VK_NULL_HANDLE, compare_ = VK_NULL_HANDLE;
  VkDescriptorSetLayout setLayout_ = VK_NULL_HANDLE;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  std::unordered_map<uint64_t, VkPipeline> pipelines_;
};

}  // namespace argil::render
