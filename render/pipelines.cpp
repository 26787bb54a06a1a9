#include "render/pipelines.h"

#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "render/frame.h"
#include "render/surface_layout.h"

namespace argil::render {
namespace {

// SPIR-V words written by the build from shaders/ (see CMakeLists.txt).
constexpr uint32_t kClayVert[] = {
#include "shaders/clay.vert.inc"
};
constexpr uint32_t kShadowVert[] = {
#include "shaders/shadow.vert.inc"
};
constexpr uint32_t kClayFrag[] = {
#include "shaders/clay.frag.inc"
};
constexpr uint32_t kFullscreenVert[] = {
#include "shaders/fullscreen.vert.inc"
};
constexpr uint32_t kCavityFrag[] = {
#include "shaders/cavity.frag.inc"
};
constexpr uint32_t kShadeFrag[] = {
#include "shaders/shade.frag.inc"
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
enum class Vertices { none, clay, clayShadow, line };

/// What one pass needs, as a row of a table. Depth is reversed (greater is nearer) but in the shadow map.
struct Recipe {
  Pass pass;
  Words vertex, fragment;
  Vertices vertices = Vertices::none;
  VkFormat colour = VK_FORMAT_UNDEFINED;
  VkCompareOp depthTest = VK_COMPARE_OP_NEVER;  ///< NEVER: no depth buffer.
  bool depthWrite = false;
  bool blend = false;
};

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

VkPipeline makePipeline(Gpu& gpu, VkPipelineLayout layout, const Recipe& recipe) {
  const Module vertex(gpu, recipe.vertex);
  VkPipelineShaderStageCreateInfo stages[2]{};
  stages[0] = structure<VkPipelineShaderStageCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO);
  stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
  stages[0].module = vertex.handle;
  stages[0].pName = "main";
  std::optional<Module> fragment;
  if (!recipe.fragment.empty()) {
    fragment.emplace(gpu, recipe.fragment);
    stages[1] = stages[0];
    stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
    stages[1].module = fragment->handle;
  }

  VkVertexInputBindingDescription binding{0, 0, VK_VERTEX_INPUT_RATE_VERTEX};
  VkVertexInputAttributeDescription attributes[3]{};
  uint32_t attributeCount = 0;
  if (recipe.vertices == Vertices::clay || recipe.vertices == Vertices::clayShadow) {
    binding.stride = sizeof(SurfaceVertex);
    attributes[0] = {0, 0, VK_FORMAT_R32G32B32_SINT, offsetof(SurfaceVertex, x)};
    attributes[1] = {1, 0, VK_FORMAT_R16G16_SNORM, offsetof(SurfaceVertex, normal)};
    attributeCount = recipe.vertices == Vertices::clay ? 2 : 1;
  } else if (recipe.vertices == Vertices::line) {
    binding.stride = sizeof(LineInstance);
    binding.inputRate = VK_VERTEX_INPUT_RATE_INSTANCE;
    attributes[0] = {0, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(LineInstance, a)};
    attributes[1] = {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(LineInstance, b)};
    attributes[2] = {2, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(LineInstance, colour)};
    attributeCount = 3;
  }
  auto input =
      structure<VkPipelineVertexInputStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO);
  input.vertexBindingDescriptionCount = attributeCount > 0 ? 1 : 0;
  input.pVertexBindingDescriptions = &binding;
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
  raster.cullMode = recipe.pass == Pass::clay ? VK_CULL_MODE_BACK_BIT : VK_CULL_MODE_NONE;
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
  target.blendEnable = recipe.blend;
  target.srcColorBlendFactor = VK_BLEND_FACTOR_SRC_ALPHA;
  target.dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
  target.srcAlphaBlendFactor = VK_BLEND_FACTOR_ZERO;
  target.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
  const bool hasColour = recipe.colour != VK_FORMAT_UNDEFINED;
  auto blend = structure<VkPipelineColorBlendStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO);
  blend.attachmentCount = hasColour ? 1 : 0;
  blend.pAttachments = &target;
  const VkDynamicState dynamic[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  auto dynamics = structure<VkPipelineDynamicStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO);
  dynamics.dynamicStateCount = 2;
  dynamics.pDynamicStates = dynamic;
  auto rendering = structure<VkPipelineRenderingCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO);
  rendering.colorAttachmentCount = hasColour ? 1 : 0;
  rendering.pColorAttachmentFormats = &recipe.colour;
  rendering.depthAttachmentFormat = hasDepth ? kDepthFormat : VK_FORMAT_UNDEFINED;

  auto info = structure<VkGraphicsPipelineCreateInfo>(VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO);
  info.pNext = &rendering;
  info.stageCount = fragment ? 2 : 1;
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
    createPipelines();
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
  for (VkPipeline pipeline : pipelines_) vkDestroyPipeline(device, pipeline, nullptr);
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

  const VkPushConstantRange range{VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(ChunkConstants)};
  auto layout = structure<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
  layout.setLayoutCount = 1;
  layout.pSetLayouts = &setLayout_;
  layout.pushConstantRangeCount = 1;
  layout.pPushConstantRanges = &range;
  check(vkCreatePipelineLayout(device, &layout, nullptr, &layout_), "making a pipeline layout");
}

void Pipelines::createPipelines() {
  constexpr VkCompareOp nearer = VK_COMPARE_OP_GREATER, hidden = VK_COMPARE_OP_LESS, none = VK_COMPARE_OP_NEVER;
  const Recipe recipes[] = {
      {Pass::shadow, kShadowVert, {}, Vertices::clayShadow, VK_FORMAT_UNDEFINED, VK_COMPARE_OP_LESS, true, false},
      {Pass::clay, kClayVert, kClayFrag, Vertices::clay, kNormalFormat, nearer, true, false},
      {Pass::cavity, kFullscreenVert, kCavityFrag, Vertices::none, kCavityFormat, none, false, false},
      {Pass::shade, kFullscreenVert, kShadeFrag, Vertices::none, kColourFormat, none, false, false},
      {Pass::shaft, kShaftVert, kShaftFrag, Vertices::none, kColourFormat, nearer, true, false},
      {Pass::worldLines, kLineVert, kLineFrag, Vertices::line, kColourFormat, nearer, false, true},
      {Pass::ballGhost, kBallVert, kBallFrag, Vertices::none, kColourFormat, hidden, false, true},
      {Pass::ball, kBallVert, kBallFrag, Vertices::none, kColourFormat, nearer, true, true},
      {Pass::screenLines, kLineVert, kLineFrag, Vertices::line, kColourFormat, VK_COMPARE_OP_ALWAYS, false, true},
      {Pass::resolve, kFullscreenVert, kResolveFrag, Vertices::none, kPictureFormat, none, false, false},
  };
  for (const Recipe& recipe : recipes) pipelines_[size_t(recipe.pass)] = makePipeline(gpu_, layout_, recipe);
}

void Pipelines::bind(VkBuffer frame, const std::array<const Texture*, 5>& images) {
  const VkDescriptorBufferInfo buffer{frame, 0, sizeof(FrameUniforms)};
  std::array<VkDescriptorImageInfo, 5> infos{};
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
                      VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
      writes[i].pImageInfo = &infos[i - 1];
    }
  }
  vkUpdateDescriptorSets(gpu_.device(), kBindingCount, writes.data(), 0, nullptr);
}

}  // namespace argil::render
