#pragma once
// The passes' shaders and fixed state. Only for the .cpp files of render/.

#include <array>

#include "render/gpu.h"

namespace argil::render {

inline constexpr VkFormat kNormalFormat = VK_FORMAT_R16G16_SFLOAT;
inline constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;
inline constexpr VkFormat kCavityFormat = VK_FORMAT_R8G8_UNORM;
inline constexpr VkFormat kColourFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
inline constexpr VkFormat kPictureFormat = VK_FORMAT_R8G8B8A8_UNORM;

/// Push constants of shaders/chunk.glsl.
struct ChunkConstants {
  int32_t corner[3];
  float unit;
  float cornerRel[3];
  float unused = 0;
};
static_assert(sizeof(ChunkConstants) == 32);

enum class Pass : size_t {
  shadow,
  clay,
  cavity,
  shade,
  shaft,
  worldLines,
  ballGhost,
  ball,
  screenLines,
  resolve,
  count
};

/// Bindings of the one descriptor set.
enum Binding : uint32_t { kFrame, kDepth, kNormal, kCavity, kShadow, kPicture, kBindingCount };

class Pipelines {
 public:
  explicit Pipelines(Gpu& gpu);
  ~Pipelines();
  Pipelines(const Pipelines&) = delete;
  Pipelines& operator=(const Pipelines&) = delete;

  [[nodiscard]] VkPipeline operator[](Pass pass) const { return pipelines_[size_t(pass)]; }
  [[nodiscard]] VkPipelineLayout layout() const { return layout_; }
  [[nodiscard]] VkDescriptorSet set() const { return set_; }

  /// Points the set at a uniform buffer and at images (in the order depth, normal, cavity, shadow, picture).
  void bind(VkBuffer frame, const std::array<const Texture*, 5>& images);

 private:
  void createLayout();
  void createPipelines();
  void destroy() noexcept;

  Gpu& gpu_;
  VkSampler nearest_ = VK_NULL_HANDLE, compare_ = VK_NULL_HANDLE;
  VkDescriptorSetLayout setLayout_ = VK_NULL_HANDLE;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  std::array<VkPipeline, size_t(Pass::count)> pipelines_{};
};

}  // namespace argil::render
