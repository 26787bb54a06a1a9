#include "render/renderer/pipelines.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <span>
#include <utility>

#include "render/renderer/frame.h"
#include "render/surface/surface_layout.h"

namespace argil::render {
namespace {

// SPIR-V words written by the build from shaders/ (see CMakeLists.txt).
constexpr uint32_t kClayVert[] = {
#include "shaders/clay.vert.inc"
};
constexpr uint32_t kClayFrag[] = {
#include "shaders/clay.frag.inc"
};
constexpr uint32_t kShadowVert[] = {
#include "shaders/shadow.vert.inc"
};
constexpr uint32_t kShadowFrag[] = {
#include "shaders/shadow.frag.inc"
};
constexpr uint32_t kFullscreenVert[] = {
#include "shaders/fullscreen.vert.inc"
};
constexpr uint32_t kCapFrag[] = {
#include "shaders/cap.frag.inc"
};
constexpr uint32_t kCavityFrag[] = {
#include "shaders/cavity.frag.inc"
};
constexpr uint32_t kBackdropFrag[] = {
#include "shaders/backdrop.frag.inc"
};
constexpr uint32_t kShadeFrag[] = {
#include "shaders/shade.frag.inc"
};
constexpr uint32_t kGroundVert[] = {
#include "shaders/ground.vert.inc"
};
constexpr uint32_t kGroundFrag[] = {
#include "shaders/ground.frag.inc"
};
constexpr uint32_t kLandingFrag[] = {
#include "shaders/landing.frag.inc"
};
constexpr uint32_t kFillVert[] = {
#include "shaders/fill.vert.inc"
};
constexpr uint32_t kFillFrag[] = {
#include "shaders/fill.frag.inc"
};
constexpr uint32_t kLineVert[] = {
#include "shaders/line.vert.inc"
};
constexpr uint32_t kLineFrag[] = {
#include "shaders/line.frag.inc"
};
constexpr uint32_t kBallVert[] = {
#include "shaders/ball.vert.inc"
};
constexpr uint32_t kBallFrag[] = {
#include "shaders/ball.frag.inc"
};
constexpr uint32_t kShaftVert[] = {
#include "shaders/shaft.vert.inc"
};
constexpr uint32_t kShaftFrag[] = {
#include "shaders/shaft.frag.inc"
};
constexpr uint32_t kResolveFrag[] = {
#include "shaders/resolve.frag.inc"
};

using Words = std::span<const uint32_t>;
enum class Vertices : uint8_t { none, clay, clayShadow, line, fill };
enum class Blend : uint8_t { none, over, premultiplied };

/// Numbers of the specialisation constants, as bits.
enum Uses : uint32_t {
  kUseEye = 1 << 0,
  kUsePerspective = 1 << 1,
  kUseShading = 1 << 2,
  kUseMatcap = 1 << 3,
  kUseKeyShadow = 1 << 4,
  kUseCavity = 1 << 5,
  kUseCursorShadow = 1 << 6,
  kUseDepthFade = 1 << 7,
  kUseSection = 1 << 8,
  kUseGround = 1 << 9,
  kUseStereoMode = 1 << 10,
  kUseSamples = 1 << 11,
  kUsePainted = 1 << 12,  ///< Of the fixed state alone: whether each vertex has a paint of its own.
};

/// What one pass needs, as a row of a table. Depth is reversed (greater is nearer) but in the shadow map.
struct Recipe {
  Pass pass;
  Words vertex, fragment;
  Vertices vertices;
  std::array<VkFormat, 2> colours;
  VkCompareOp depthTest;  ///< NEVER: no depth buffer.
  bool depthWrite;
  Blend blend;
  uint32_t uses;  ///< Which constants its shaders read. A pass over both eyes uses `eye`.
};

constexpr VkFormat kNo = VK_FORMAT_UNDEFINED;
constexpr VkCompareOp kNearer = VK_COMPARE_OP_GREATER, kBehind = VK_COMPARE_OP_LESS_OR_EQUAL,
                      kAlways = VK_COMPARE_OP_ALWAYS, kNoTest = VK_COMPARE_OP_NEVER;
/// Against the far end, where full-screen triangles are drawn: where there is clay, where there is none.
constexpr VkCompareOp kOnClay = VK_COMPARE_OP_LESS, kOffClay = VK_COMPARE_OP_GREATER_OR_EQUAL;

constexpr uint32_t kEyes = kUseEye | kUsePerspective, kLights = kUseKeyShadow | kUseCursorShadow | kUseDepthFade;

constexpr Recipe kRecipes[] = {
    {Pass::shadow,
     kShadowVert,
     kShadowFrag,
     Vertices::clayShadow,
     {kNo, kNo},
     VK_COMPARE_OP_LESS,
     true,
     Blend::none,
     kUseSection},
    {Pass::clay,
     kClayVert,
     kClayFrag,
     Vertices::clay,
     {kNormalFormat, kAlbedoFormat},
     kNearer,
     true,
     Blend::none,
     kUseEye | kUseSection | kUsePainted},
    {Pass::part,
     kClayVert,
     kClayFrag,
     Vertices::clay,
     {kNormalFormat, kAlbedoFormat},
     kNearer,
     true,
     Blend::none,
     kUseEye | kUseSection | kUsePainted},
    {Pass::cap, kFullscreenVert, kCapFrag, Vertices::none, {kNo, kNo}, kAlways, true, Blend::none, kEyes},
    {Pass::cavity,
     kFullscreenVert,
     kCavityFrag,
     Vertices::none,
     {kCavityFormat, kNo},
     kNoTest,
     false,
     Blend::none,
     kEyes},
    {Pass::backdrop,
     kFullscreenVert,
     kBackdropFrag,
     Vertices::none,
     {kColourFormat, kNo},
     kOffClay,
     false,
     Blend::none,
     kUseEye},
    {Pass::shade,
     kFullscreenVert,
     kShadeFrag,
     Vertices::none,
     {kColourFormat, kNo},
     kOnClay,
     false,
     Blend::none,
     kEyes | kLights | kUseShading | kUseMatcap | kUseCavity | kUseSection},
    {Pass::ground,
     kGroundVert,
     kGroundFrag,
     Vertices::none,
     {kColourFormat, kNo},
     kNearer,
     false,
     Blend::none,
     kEyes | kLights | kUseGround},
    {Pass::groundBelow,
     kGroundVert,
     kGroundFrag,
     Vertices::none,
     {kColourFormat, kNo},
     kNearer,
     false,
     Blend::premultiplied,
     kEyes | kLights | kUseGround},
    {Pass::landing,
     kFullscreenVert,
     kLandingFrag,
     Vertices::none,
     {kColourFormat, kNo},
     kAlways,
     false,
     Blend::premultiplied,
     kEyes | kUseGround},
    {Pass::fills, kFillVert, kFillFrag, Vertices::fill, {kColourFormat, kNo}, kNearer, false, Blend::over, kUseEye},
    {Pass::fillsBehind,
     kFillVert,
     kFillFrag,
     Vertices::fill,
     {kColourFormat, kNo},
     kBehind,
     false,
     Blend::over,
     kUseEye},
    {Pass::fillsOnTop,
     kFillVert,
     kFillFrag,
     Vertices::fill,
     {kColourFormat, kNo},
     kAlways,
     false,
     Blend::over,
     kUseEye},
    {Pass::shaft, kShaftVert, kShaftFrag, Vertices::none, {kColourFormat, kNo}, kNearer, true, Blend::none, kEyes},
    {Pass::lines,
     kLineVert,
     kLineFrag,
     Vertices::line,
     {kColourFormat, kNo},
     kNearer,
     false,
     Blend::over,
     kEyes | kUseDepthFade},
    {Pass::linesBehind,
     kLineVert,
     kLineFrag,
     Vertices::line,
     {kColourFormat, kNo},
     kBehind,
     false,
     Blend::over,
     kEyes | kUseDepthFade},
    {Pass::linesOnTop, kLineVert, kLineFrag, Vertices::line, {kColourFormat, kNo}, kAlways, false, Blend::over, kEyes},
    {Pass::ballGhost, kBallVert, kBallFrag, Vertices::none, {kColourFormat, kNo}, kBehind, false, Blend::over, kEyes},
    {Pass::ball, kBallVert, kBallFrag, Vertices::none, {kColourFormat, kNo}, kNearer, true, Blend::over, kEyes},
    {Pass::resolve,
     kFullscreenVert,
     kResolveFrag,
     Vertices::none,
     {kColourFormat, kNo},
     kNoTest,
     false,
     Blend::none,
     kUseStereoMode | kUseSamples},
};
static_assert(std::size(kRecipes) == size_t(Pass::count));
static_assert([] {
  for (size_t i = 0; i < size_t(Pass::count); ++i) {
    if (kRecipes[i].pass != Pass(i)) return false;
  }
  return true;
}());

constexpr size_t kConstants = sizeof(Variant) / sizeof(int32_t);
static_assert(kConstants == 13);

/// Destroys shader modules once the pipelines are made.
class Module {
 public:
  Module(Gpu& gpu, Words words) : gpu_(gpu) {
    auto info = structure<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
    info.codeSize = words.size_bytes();
    info.pCode = words.data();
    check(vkCreateShaderModule(gpu.device(), &info, nullptr, &handle), "loading a shader");
  }
  ~Module() { vkDestroyShaderModule(gpu_.device(), handle, nullptr); }
  Module(const Module&) = delete;
  Module& operator=(const Module&) = delete;
  VkShaderModule handle = VK_NULL_HANDLE;

 private:
  Gpu& gpu_;
};

VkPipeline makePipeline(Gpu& gpu, VkPipelineLayout layout, const Recipe& recipe, const Variant& variant) {
  std::array<VkSpecializationMapEntry, kConstants> entries{};
  for (uint32_t i = 0; i < kConstants; ++i) entries[i] = {i, uint32_t(i * sizeof(int32_t)), sizeof(int32_t)};
  const VkSpecializationInfo constants{kConstants, entries.data(), sizeof variant, &variant};
  const Module vertex(gpu, recipe.vertex);
  VkPipelineShaderStageCreateInfo stages[2]{};
  stages[0] = structure<VkPipelineShaderStageCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO);
  stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
  stages[0].module = vertex.handle;
  stages[0].pName = "main";
  stages[0].pSpecializationInfo = &constants;
  // Without a section the shadow needs no fragments' shader: depth alone is faster.
  const bool hasFragment = recipe.pass != Pass::shadow || variant.section;
  std::optional<Module> fragment;
  if (hasFragment) {
    fragment.emplace(gpu, recipe.fragment);
    stages[1] = stages[0];
    stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
    stages[1].module = fragment->handle;
  }

  VkVertexInputBindingDescription bindings[2] = {{0, 0, VK_VERTEX_INPUT_RATE_VERTEX},
                                                 {1, sizeof(PackedPaint), VK_VERTEX_INPUT_RATE_VERTEX}};
  VkVertexInputBindingDescription& binding = bindings[0];
  uint32_t bindingCount = 1;
  VkVertexInputAttributeDescription attributes[3]{};
  uint32_t attributeCount = 0;
  if (recipe.vertices == Vertices::clay || recipe.vertices == Vertices::clayShadow) {
    binding.stride = sizeof(SurfaceVertex);
    attributes[0] = {0, 0, VK_FORMAT_R32G32B32_SINT, offsetof(SurfaceVertex, x)};
    attributes[1] = {1, 0, VK_FORMAT_R16G16_SNORM, offsetof(SurfaceVertex, normal)};
    attributeCount = recipe.vertices == Vertices::clay ? 3 : 2;
    if (recipe.vertices == Vertices::clay) {
      attributes[2] = {2, 1, VK_FORMAT_R8G8B8A8_UNORM, 0};
      bindingCount = 2;
      // One for all: there is a single instance.
      if (!variant.painted) bindings[1].inputRate = VK_VERTEX_INPUT_RATE_INSTANCE;
    }
  } else if (recipe.vertices == Vertices::line) {
    binding.stride = sizeof(LineInstance);
    binding.inputRate = VK_VERTEX_INPUT_RATE_INSTANCE;
    attributes[0] = {0, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(LineInstance, a)};
    attributes[1] = {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(LineInstance, b)};
    attributes[2] = {2, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(LineInstance, colour)};
    attributeCount = 3;
  } else if (recipe.vertices == Vertices::fill) {
    binding.stride = sizeof(FillVertex);
    attributes[0] = {0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(FillVertex, rel)};
    attributes[1] = {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(FillVertex, colour)};
    attributeCount = 2;
  }
  auto input =
      structure<VkPipelineVertexInputStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO);
  input.vertexBindingDescriptionCount = attributeCount > 0 ? bindingCount : 0;
  input.pVertexBindingDescriptions = bindings;
  input.vertexAttributeDescriptionCount = attributeCount;
  input.pVertexAttributeDescriptions = attributes;

  auto assembly =
      structure<VkPipelineInputAssemblyStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO);
  assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  auto viewport = structure<VkPipelineViewportStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO);
  viewport.viewportCount = viewport.scissorCount = 1;
  auto raster =
      structure<VkPipelineRasterizationStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO);
  raster.polygonMode = VK_POLYGON_MODE_FILL;
  raster.cullMode = recipe.pass == Pass::clay && !variant.section ? VK_CULL_MODE_BACK_BIT : VK_CULL_MODE_NONE;
  raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
  raster.lineWidth = 1;
  auto samples =
      structure<VkPipelineMultisampleStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO);
  samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
  auto depth =
      structure<VkPipelineDepthStencilStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO);
  const bool hasDepth = recipe.depthTest != VK_COMPARE_OP_NEVER;
  depth.depthTestEnable = hasDepth;
  depth.depthWriteEnable = recipe.depthWrite;
  depth.depthCompareOp = recipe.depthTest;
  VkPipelineColorBlendAttachmentState target{};
  target.colorWriteMask = 0xf;
  target.blendEnable = recipe.blend != Blend::none;
  target.srcColorBlendFactor = recipe.blend == Blend::premultiplied ? VK_BLEND_FACTOR_ONE : VK_BLEND_FACTOR_SRC_ALPHA;
  target.dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
  target.srcAlphaBlendFactor = VK_BLEND_FACTOR_ZERO;
  target.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
  const VkPipelineColorBlendAttachmentState targets[] = {target, target};
  const auto colourCount =
      uint32_t(std::count_if(recipe.colours.begin(), recipe.colours.end(), [](VkFormat f) { return f != kNo; }));
  auto blend = structure<VkPipelineColorBlendStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO);
  blend.attachmentCount = colourCount;
  blend.pAttachments = targets;
  const VkDynamicState dynamic[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  auto dynamics = structure<VkPipelineDynamicStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO);
  dynamics.dynamicStateCount = 2;
  dynamics.pDynamicStates = dynamic;
  auto rendering = structure<VkPipelineRenderingCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO);
  rendering.viewMask = variant.eye == kBothEyes ? 3 : 0;
  rendering.colorAttachmentCount = colourCount;
  rendering.pColorAttachmentFormats = recipe.colours.data();
  rendering.depthAttachmentFormat = hasDepth ? kDepthFormat : VK_FORMAT_UNDEFINED;

  auto info = structure<VkGraphicsPipelineCreateInfo>(VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO);
  info.pNext = &rendering;
  info.stageCount = hasFragment ? 2 : 1;
  info.pStages = stages;
  info.pVertexInputState = &input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &samples;
  info.pDepthStencilState = &depth;
  info.pColorBlendState = &blend;
  info.pDynamicState = &dynamics;
  info.layout = layout;
  VkPipeline pipeline = VK_NULL_HANDLE;
  check(vkCreateGraphicsPipelines(gpu.device(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline), "building a pass");
  return pipeline;
}

}  // namespace

Pipelines::Pipelines(Gpu& gpu) : gpu_(gpu) {
  try {
    createLayout();
  } catch (...) {
    destroy();
    throw;
  }
}

Pipelines::~Pipelines() {
  destroy();
}

void Pipelines::destroy() noexcept {
  const VkDevice device = gpu_.device();
  for (const auto& [key, pipeline] : pipelines_) vkDestroyPipeline(device, pipeline, nullptr);
  vkDestroyPipelineLayout(device, layout_, nullptr);
  vkDestroyDescriptorPool(device, pool_, nullptr);
  vkDestroyDescriptorSetLayout(device, setLayout_, nullptr);
  vkDestroySampler(device, nearest_, nullptr);
  vkDestroySampler(device, compare_, nullptr);
}

void Pipelines::createLayout() {
  const VkDevice device = gpu_.device();
  auto sampler = structure<VkSamplerCreateInfo>(VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO);
  sampler.addressModeU = sampler.addressModeV = sampler.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  check(vkCreateSampler(device, &sampler, nullptr, &nearest_), "making a sampler");
  sampler.compareEnable = VK_TRUE;
  sampler.compareOp = VK_COMPARE_OP_LESS_OR_EQUAL;
  check(vkCreateSampler(device, &sampler, nullptr, &compare_), "making a sampler");

  std::array<VkDescriptorSetLayoutBinding, kBindingCount> bindings{};
  for (uint32_t i = 0; i < kBindingCount; ++i) {
    bindings[i].binding = i;
    bindings[i].descriptorCount = 1;
    bindings[i].descriptorType =
        i == kFrame ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER : VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    bindings[i].stageFlags = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
  }
  auto setInfo = structure<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
  setInfo.bindingCount = kBindingCount;
  setInfo.pBindings = bindings.data();
  check(vkCreateDescriptorSetLayout(device, &setInfo, nullptr, &setLayout_), "making a set layout");

  const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1},
                                        {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kBindingCount - 1}};
  auto pool = structure<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
  pool.maxSets = 1;
  pool.poolSizeCount = 2;
  pool.pPoolSizes = sizes;
  check(vkCreateDescriptorPool(device, &pool, nullptr, &pool_), "making a descriptor pool");
  auto allocate = structure<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
  allocate.descriptorPool = pool_;
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &setLayout_;
  check(vkAllocateDescriptorSets(device, &allocate, &set_), "making a descriptor set");

  const VkPushConstantRange range{VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(PieceConstants)};
  auto layout = structure<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
  layout.setLayoutCount = 1;
  layout.pSetLayouts = &setLayout_;
  layout.pushConstantRangeCount = 1;
  layout.pPushConstantRanges = &range;
  check(vkCreatePipelineLayout(device, &layout, nullptr, &layout_), "making a pipeline layout");
}

VkPipeline Pipelines::get(Pass pass, const Variant& variant) {
  const Recipe& recipe = kRecipes[size_t(pass)];
  // What the pass does not use is left at its default, so that it does not ask for another pipeline.
  using Constants = std::array<int32_t, kConstants>;
  const auto wanted = std::bit_cast<Constants>(variant);
  auto used = std::bit_cast<Constants>(Variant());
  uint64_t key = uint64_t(pass);
  for (size_t i = 0; i < kConstants; ++i) {
    if (recipe.uses & (1u << i)) used[i] = wanted[i];
    key = key << 4 | uint64_t(used[i]);
  }
  VkPipeline& pipeline = pipelines_[key];
  if (pipeline == VK_NULL_HANDLE) {
    pipeline = makePipeline(gpu_, layout_, recipe, std::bit_cast<Variant>(used));
  }
  return pipeline;
}

std::array<float, 4> surfaceOf(const PieceLook& look, bool bothSides) {
  const auto linear = [](float c) {
    c = std::clamp(c, 0.0f, 1.0f);
    return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
  };
  // 0 is a cut face; then gloss and roughness by tenths; then the same, dimmed. 8 bits hold it.
  const auto tenths = [](float x) { return std::round(10 * std::clamp(x, 0.0f, 1.0f)); };
  const float code = 1 + (look.dimmed ? 121.0f : 0.0f) + 11 * tenths(look.roughness) + tenths(look.gloss);
  return {linear(look.colour.r), linear(look.colour.g), linear(look.colour.b), (bothSides ? -code : code) / 255};
}

void Pipelines::bind(VkBuffer frame, const std::array<const Texture*, kBindingCount - 1>& images) {
  const VkDescriptorBufferInfo buffer{frame, 0, sizeof(FrameUniforms)};
  std::array<VkDescriptorImageInfo, kBindingCount - 1> infos{};
  std::array<VkWriteDescriptorSet, kBindingCount> writes{};
  for (uint32_t i = 0; i < kBindingCount; ++i) {
    writes[i] = structure<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
    writes[i].dstSet = set_;
    writes[i].dstBinding = i;
    writes[i].descriptorCount = 1;
    if (i == kFrame) {
      writes[i].descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
      writes[i].pBufferInfo = &buffer;
    } else {
      writes[i].descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
      infos[i - 1] = {i == kShadow ? compare_ : nearest_, images[i - 1]->view(),
                      i == kDepth ? VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
      writes[i].pImageInfo = &infos[i - 1];
    }
  }
  vkUpdateDescriptorSets(gpu_.device(), kBindingCount, writes.data(), 0, nullptr);
}

}  // namespace argil::render
