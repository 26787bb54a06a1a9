#include "render/gpu/ui_pass.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <string>

#include "clay/base/error.h"

namespace argil::render {
namespace {

constexpr uint32_t kUiVert[] = {
#include "shaders/ui.vert.inc"
};
constexpr uint32_t kUiFrag[] = {
#include "shaders/ui.frag.inc"
};

constexpr ImageUse kFresh{VK_PIPELINE_STAGE_2_NONE, 0, VK_IMAGE_LAYOUT_UNDEFINED};
constexpr ImageUse kFill{VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                         VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};
constexpr ImageUse kSample{VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                           VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};

/// Room for half as much again, so that panels that open do not make buffers anew each frame.
void fit(Gpu& gpu, Buffer& buffer, VkDeviceSize bytes, VkBufferUsageFlags usage) {
  if (buffer.size() < bytes) {
    buffer.reset();
    buffer = Buffer(gpu, bytes + bytes / 2, usage, Buffer::Memory::upload);
  }
}

VkShaderModule makeModule(Gpu& gpu, const uint32_t* words, size_t bytes) {
  auto info = structure<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
  info.codeSize = bytes;
  info.pCode = words;
  VkShaderModule module = VK_NULL_HANDLE;
  check(vkCreateShaderModule(gpu.device(), &info, nullptr, &module), "loading a shader");
  return module;
}

}  // namespace

UiPass::UiPass(Gpu& gpu, VkFormat picture) : gpu_(gpu) {
  try {
    createPipeline(picture);
    const uint8_t white = 255;  // until a font comes, panels are plain faces
    setTexture(0, 1, 1, 1, &white);
  } catch (...) {
    destroy();
    throw;
  }
}

UiPass::~UiPass() {
  destroy();
}

void UiPass::destroy() noexcept {
  gpu_.settle();
  const VkDevice device = gpu_.device();
  for (auto& [name, panel] : textures_) vkDestroyDescriptorPool(device, panel.pool, nullptr);
  vkDestroyPipeline(device, pipeline_, nullptr);
  vkDestroyPipelineLayout(device, layout_, nullptr);
  vkDestroyDescriptorSetLayout(device, setLayout_, nullptr);
  vkDestroySampler(device, linear_, nullptr);
}

void UiPass::createPipeline(VkFormat picture) {
  const VkDevice device = gpu_.device();
  auto sampler = structure<VkSamplerCreateInfo>(VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO);
  sampler.magFilter = sampler.minFilter = VK_FILTER_LINEAR;
  sampler.addressModeU = sampler.addressModeV = sampler.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  render::check(vkCreateSampler(device, &sampler, nullptr, &linear_), "making a sampler");

  VkDescriptorSetLayoutBinding binding{};
  binding.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  binding.descriptorCount = 1;
  binding.stageFlags = VK_SHADER_STAGE_FRAGMENT_BIT;
  auto setInfo = structure<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
  setInfo.bindingCount = 1;
  setInfo.pBindings = &binding;
  render::check(vkCreateDescriptorSetLayout(device, &setInfo, nullptr, &setLayout_), "making a set layout");
  const VkPushConstantRange range{VK_SHADER_STAGE_VERTEX_BIT, 0, 2 * sizeof(float)};
  auto layout = structure<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
  layout.setLayoutCount = 1;
  layout.pSetLayouts = &setLayout_;
  layout.pushConstantRangeCount = 1;
  layout.pPushConstantRanges = &range;
  render::check(vkCreatePipelineLayout(device, &layout, nullptr, &layout_), "making a pipeline layout");

  VkPipelineShaderStageCreateInfo stages[2]{};
  stages[0] = structure<VkPipelineShaderStageCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO);
  stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
  stages[0].pName = "main";
  stages[1] = stages[0];
  stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
  const VkVertexInputBindingDescription vertex{0, sizeof(UiVertex), VK_VERTEX_INPUT_RATE_VERTEX};
  const VkVertexInputAttributeDescription attributes[] = {
      {0, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(UiVertex, x)},
      {1, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(UiVertex, u)},
      {2, 0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(UiVertex, rgba)},
  };
  auto input =
      structure<VkPipelineVertexInputStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO);
  input.vertexBindingDescriptionCount = 1;
  input.pVertexBindingDescriptions = &vertex;
  input.vertexAttributeDescriptionCount = 3;
  input.pVertexAttributeDescriptions = attributes;
  auto assembly =
      structure<VkPipelineInputAssemblyStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO);
  assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  auto viewport = structure<VkPipelineViewportStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO);
  viewport.viewportCount = viewport.scissorCount = 1;
  auto raster =
      structure<VkPipelineRasterizationStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO);
  raster.lineWidth = 1;
  auto samples =
      structure<VkPipelineMultisampleStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO);
  samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
  VkPipelineColorBlendAttachmentState target{};
  target.colorWriteMask = 0xf;
  target.blendEnable = VK_TRUE;
  target.srcColorBlendFactor = VK_BLEND_FACTOR_SRC_ALPHA;
  target.dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
  target.srcAlphaBlendFactor = VK_BLEND_FACTOR_ZERO;  // the picture stays opaque
  target.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
  auto blend = structure<VkPipelineColorBlendStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO);
  blend.attachmentCount = 1;
  blend.pAttachments = &target;
  const VkDynamicState dynamic[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  auto dynamics = structure<VkPipelineDynamicStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO);
  dynamics.dynamicStateCount = 2;
  dynamics.pDynamicStates = dynamic;
  auto rendering = structure<VkPipelineRenderingCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO);
  rendering.colorAttachmentCount = 1;
  rendering.pColorAttachmentFormats = &picture;

  auto info = structure<VkGraphicsPipelineCreateInfo>(VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO);
  info.pNext = &rendering;
  info.stageCount = 2;
  info.pStages = stages;
  info.pVertexInputState = &input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &samples;
  info.pColorBlendState = &blend;
  info.pDynamicState = &dynamics;
  info.layout = layout_;
  stages[0].module = makeModule(gpu_, kUiVert, sizeof kUiVert);
  VkResult result = VK_SUCCESS;
  try {
    stages[1].module = makeModule(gpu_, kUiFrag, sizeof kUiFrag);
    result = vkCreateGraphicsPipelines(device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_);
  } catch (...) {
    vkDestroyShaderModule(device, stages[0].module, nullptr);
    throw;
  }
  for (const auto& stage : stages) vkDestroyShaderModule(device, stage.module, nullptr);
  render::check(result, "building the panels' pass");
}

void UiPass::makeSet(Panel& panel) {
  // A pool a texture: there are few, and none can run out.
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1};
  auto pool = structure<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
  pool.maxSets = pool.poolSizeCount = 1;
  pool.pPoolSizes = &size;
  render::check(vkCreateDescriptorPool(gpu_.device(), &pool, nullptr, &panel.pool), "making a descriptor pool");
  auto allocate = structure<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
  allocate.descriptorPool = panel.pool;
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &setLayout_;
  render::check(vkAllocateDescriptorSets(gpu_.device(), &allocate, &panel.set), "making a descriptor set");
}

void UiPass::setTexture(uint32_t texture, int width, int height, int channels, const uint8_t* pixels) {
  const auto limit = int(gpu_.properties().limits.maxImageDimension2D);
  if (width < 1 || height < 1 || width > limit || height > limit || (channels != 1 && channels != 4) || !pixels) {
    throw Error("a panel's picture of " + std::to_string(width) + "x" + std::to_string(height) + " pixels with " +
                std::to_string(channels) + " channels cannot be drawn; give 1 or 4 channels and at most " +
                std::to_string(limit) + " pixels along each side");
  }
  const VkDeviceSize bytes = VkDeviceSize(width) * VkDeviceSize(height) * VkDeviceSize(channels);
  Buffer staging(gpu_, bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, Buffer::Memory::upload);
  std::memcpy(staging.mapped(), pixels, size_t(bytes));

  gpu_.settle();  // its set is written below
  Panel& panel = textures_[texture];
  const VkExtent2D extent{uint32_t(width), uint32_t(height)};
  if (panel.channels != channels || panel.image.extent().width != extent.width ||
      panel.image.extent().height != extent.height) {
    constexpr VkComponentMapping coverage{VK_COMPONENT_SWIZZLE_ONE, VK_COMPONENT_SWIZZLE_ONE, VK_COMPONENT_SWIZZLE_ONE,
                                          VK_COMPONENT_SWIZZLE_R};
    Texture image(gpu_, channels == 1 ? VK_FORMAT_R8_UNORM : VK_FORMAT_R8G8B8A8_UNORM, extent.width, extent.height,
                  VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, 0, VK_FORMAT_UNDEFINED,
                  channels == 1 ? coverage : VkComponentMapping{});
    if (!panel.pool) makeSet(panel);
    panel.image = std::move(image);
    panel.channels = channels;
    const VkDescriptorImageInfo sampled{linear_, panel.image.view(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    auto write = structure<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
    write.dstSet = panel.set;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    write.pImageInfo = &sampled;
    vkUpdateDescriptorSets(gpu_.device(), 1, &write, 0, nullptr);
  }
  gpu_.run([&](VkCommandBuffer commands) {
    transition(commands, panel.image, kFresh, kFill);
    VkBufferImageCopy copy{};
    copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    copy.imageExtent = {extent.width, extent.height, 1};
    vkCmdCopyBufferToImage(commands, staging.handle(), panel.image.image(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                           &copy);
    transition(commands, panel.image, kFill, kSample);
  });
}

void UiPass::check(const UiFrame& frame) const {
  if (frame.empty()) return;
  if (!(frame.width > 0) || !(frame.height > 0) || !std::isfinite(frame.width) || !std::isfinite(frame.height)) {
    throw Error("a frame of panels has no size above zero; give the size of the interface");
  }
  for (const UiCommand& command : frame.commands) {
    const auto texture = textures_.find(command.texture);
    if (texture == textures_.end() || !texture->second.set) {
      throw Error("panels name picture " + std::to_string(command.texture) +
                  ", which was not set; call setUiTexture first");
    }
    if (size_t(command.firstIndex) + command.indexCount > frame.indices.size()) {
      throw Error("panels name more indices than their frame has; give the indices of all commands");
    }
    if (command.indexCount == 0) continue;
    const auto first = frame.indices.begin() + command.firstIndex;
    const uint16_t most = *std::max_element(first, first + command.indexCount);
    if (size_t(command.firstVertex) + most >= frame.vertices.size()) {
      throw Error("panels name more vertices than their frame has; give the vertices of all commands");
    }
  }
}

void UiPass::upload(const UiFrame& frame, size_t slot) {
  if (frame.empty() || frame.vertices.empty() || frame.indices.empty()) return;
  Slot& to = slots_[slot];
  const size_t vertexBytes = frame.vertices.size() * sizeof(UiVertex),
               indexBytes = frame.indices.size() * sizeof(uint16_t);
  fit(gpu_, to.vertices, vertexBytes, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  fit(gpu_, to.indices, indexBytes, VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
  std::memcpy(to.vertices.mapped(), frame.vertices.data(), vertexBytes);
  std::memcpy(to.indices.mapped(), frame.indices.data(), indexBytes);
}

void UiPass::draw(VkCommandBuffer commands, const UiFrame& frame, size_t slot, const Texture& picture) const {
  if (frame.empty() || frame.vertices.empty() || frame.indices.empty()) return;
  const VkExtent2D extent = picture.extent();
  auto colour = structure<VkRenderingAttachmentInfo>(VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO);
  colour.imageView = picture.view();
  colour.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
  colour.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
  colour.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  auto info = structure<VkRenderingInfo>(VK_STRUCTURE_TYPE_RENDERING_INFO);
  info.renderArea.extent = extent;
  info.layerCount = 1;
  info.colorAttachmentCount = 1;
  info.pColorAttachments = &colour;
  vkCmdBeginRendering(commands, &info);
  const VkViewport viewport{0, 0, float(extent.width), float(extent.height), 0, 1};
  vkCmdSetViewport(commands, 0, 1, &viewport);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
  const float size[] = {frame.width, frame.height};
  vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof size, size);
  const VkBuffer vertices = slots_[slot].vertices.handle();
  const VkDeviceSize offset = 0;
  vkCmdBindVertexBuffers(commands, 0, 1, &vertices, &offset);
  vkCmdBindIndexBuffer(commands, slots_[slot].indices.handle(), 0, VK_INDEX_TYPE_UINT16);

  const auto pixel = [](float place, float whole, uint32_t pixels) {
    const double at = double(place) / double(whole) * pixels;
    return std::isnan(at) ? 0 : int32_t(std::lround(std::clamp(at, 0.0, double(pixels))));
  };
  VkDescriptorSet bound = VK_NULL_HANDLE;
  for (const UiCommand& command : frame.commands) {
    const int32_t left = pixel(command.clip[0], frame.width, extent.width);
    const int32_t top = pixel(command.clip[1], frame.height, extent.height);
    const int32_t right = pixel(command.clip[2], frame.width, extent.width);
    const int32_t bottom = pixel(command.clip[3], frame.height, extent.height);
    if (right <= left || bottom <= top || command.indexCount == 0) continue;
    const VkRect2D scissor{{left, top}, {uint32_t(right - left), uint32_t(bottom - top)}};
    vkCmdSetScissor(commands, 0, 1, &scissor);
    const VkDescriptorSet set = textures_.at(command.texture).set;
    if (set != bound) {
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &set, 0, nullptr);
      bound = set;
    }
    vkCmdDrawIndexed(commands, command.indexCount, 1, command.firstIndex, int32_t(command.firstVertex), 0);
  }
  vkCmdEndRendering(commands);
}

}  // namespace argil::render
