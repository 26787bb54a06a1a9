// The one window that a renderer draws in, and what follows when the device is lost.

#include <algorithm>
#include <chrono>

#include "clay/base/error.h"
#include "render/renderer/renderer_state.h"

namespace argil::render {
namespace {

constexpr uint32_t kLeastEdge = 16, kMostEdge = 8192;

constexpr ImageUse kWanted{VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, 0, VK_IMAGE_LAYOUT_UNDEFINED};
constexpr ImageUse kCopyTo{VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                           VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};
constexpr ImageUse kShow{VK_PIPELINE_STAGE_2_NONE, 0, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR};

/// Into the window's image, pixel for pixel; only the order of the channels may change.
void copyToWindow(VkCommandBuffer commands, const Texture& picture, const WindowTarget& window, VkImage image) {
  transition(commands, image, VK_IMAGE_ASPECT_COLOR_BIT, kWanted, kCopyTo);
  const VkExtent2D have = picture.extent(), room = window.extent();
  const uint32_t width = std::min(have.width, room.width), height = std::min(have.height, room.height);
  const VkImageSubresourceLayers layers{VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  if (window.format() == picture.format()) {
    VkImageCopy copy{};
    copy.srcSubresource = copy.dstSubresource = layers;
    copy.extent = {width, height, 1};
    vkCmdCopyImage(commands, picture.image(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, image,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
  } else {
    VkImageBlit blit{};
    blit.srcSubresource = blit.dstSubresource = layers;
    blit.srcOffsets[1] = blit.dstOffsets[1] = {int32_t(width), int32_t(height), 1};
    vkCmdBlitImage(commands, picture.image(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, image,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &blit, VK_FILTER_NEAREST);
  }
  transition(commands, image, VK_IMAGE_ASPECT_COLOR_BIT, kCopyTo, kShow);
}

}  // namespace

void Renderer::attach(const WindowHooks& window) {
  State& s = *state_;
  detach();
  s.hooks = window;
  s.window = std::make_unique<WindowTarget>(s.gpu, s.hooks);
  s.attached = true;
}

void Renderer::detach() {
  State& s = *state_;
  s.window.reset();
  s.hooks = {};
  s.attached = s.showing = false;
  s.shown = {};
}

bool Renderer::present(const Shot& shot, const UiFrame& panels) {
  return presentFrame(&shot, panels);
}

bool Renderer::presentPanels(const UiFrame& panels) {
  return holdsPicture() && presentFrame(nullptr, panels);
}

bool Renderer::holdsPicture() const {
  return state_->showing;
}

int64_t Renderer::waitedNs() const {
  return state_->waitedNs;
}

// Without a shot: the picture that is there with other panels.
bool Renderer::presentFrame(const Shot* shot, const UiFrame& panels) {
  using Clock = std::chrono::steady_clock;
  State& s = *state_;
  if (s.gpu.lost()) s.gpu.check(VK_ERROR_DEVICE_LOST, "drawing the window");
  if (!s.window) throw Error("there is no window to draw in; attach one first");
  // A window that changes its size between two steps is asked again, now and at the next frame.
  for (int attempt = 0; attempt < 2; ++attempt) {
    const std::optional<VkExtent2D> extent = s.window->prepare();
    if (!extent) return false;
    const int width = int(std::clamp(extent->width, kLeastEdge, kMostEdge)),
              height = int(std::clamp(extent->height, kLeastEdge, kMostEdge));
    FramePlan plan;
    if (shot) {
      plan = s.prepare(*shot, width, height, &panels);
      s.model.prepare(s.sight(plan));
    } else {
      if (s.targets.width != width || s.targets.height != height) return false;
      s.ui.check(panels);
      s.takeSlot();
      s.ui.upload(panels, s.slot);
    }
    const auto asked = Clock::now();
    const std::optional<WindowTarget::Turn> turn = s.window->take(s.slot);
    const int64_t forImageNs = std::chrono::nanoseconds(Clock::now() - asked).count();
    if (!turn) continue;
    auto submitted = asked;
    try {
      s.frame().ticket = s.gpu.submit(
          [&](VkCommandBuffer commands) {
            if (shot)
              s.recordFrame(commands, plan, &panels);
            else
              s.recordPanels(commands, panels);
            copyToWindow(commands, s.targets.framed, *s.window, turn->image);
          },
          {turn->free, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, turn->drawn});
      submitted = Clock::now();
      s.window->show(*turn);
    } catch (...) {
      s.window->giveUp();
      throw;
    }
    // Where the device has a clock, its work is told by that: whatever else takes time is a wait for it or for the
    // screen.
    const int64_t showNs = std::chrono::nanoseconds(Clock::now() - submitted).count();
    s.waitedNs = s.timer.read().empty() ? forImageNs : s.waitedNs + forImageNs + showNs;
    s.showing = true;
    s.shown = {};
    return true;
  }
  return false;
}

void Renderer::State::keepShown() {
  if (!showing) return;
  shown = readBack(targets.framed);
  showing = false;
}

Image Renderer::lastPresented() {
  State& s = *state_;
  if (s.showing) return s.readBack(s.targets.framed);
  if (s.shown.rgba.empty()) throw Error("the window has shown nothing yet; present a picture first");
  return s.shown;
}

void Renderer::setUiTexture(uint32_t texture, int width, int height, int channels, const uint8_t* pixels) {
  state_->ui.setTexture(texture, width, height, channels, pixels);
}

void Renderer::recover() {
  State& old = *state_;
  // The window's images first: a window takes those of one device at a time.
  old.window.reset();
  old.showing = false;
  RendererOptions options = old.options;
  options.quality = old.quality;
  auto made = std::make_unique<State>(options, old.log);
  made->hooks = old.hooks;
  made->attached = old.attached;
  made->shown = std::move(old.shown);
  state_ = std::move(made);
  if (state_->attached) state_->window = std::make_unique<WindowTarget>(state_->gpu, state_->hooks);
}

bool Renderer::deviceLost() const {
  return state_->gpu.lost();
}
void Renderer::simulateDeviceLoss() {
  state_->gpu.loseAtNextSubmit();
}

}  // namespace argil::render
