#pragma once
// Between the studio's events and Dear ImGui, and from its triangles to the renderer's panels. There is no backend:
// recordings and tests take the same way as a real window.

#include <string>

#include "render/view/ui_frame.h"
#include "ui3d/studio/view/event.h"

struct ImDrawData;
struct ImGuiContext;

namespace argil::studio {

class Window;

/// Owns the one ImGui context. One thread.
class UiInput {
 public:
  UiInput();
  ~UiInput();
  UiInput(const UiInput&) = delete;
  UiInput& operator=(const UiInput&) = delete;

  /// Text is copied to and from the desktop's clipboard; without a window inside the program only.
  void useClipboardOf(Window* window);
  /// Takes over what the event says. A click that begins and ends between two frames is lost on ImGui: give it a frame
  /// in between.
  void feed(const Event& event);
  /// Sizes in interface units; `scale` pixels each.
  void beginFrame(double seconds, float width, float height, float scale);
  /// After ImGui::Render().
  [[nodiscard]] render::UiFrame frame() const;

  /// The mouse is over a panel or held by one: of the last frame.
  [[nodiscard]] bool wantsMouse() const;
  /// A text is being typed.
  [[nodiscard]] bool wantsText() const;

 private:
  ImGuiContext* context_ = nullptr;
  Window* window_ = nullptr;
  std::string clipboard_;
  static const char* readClipboard(void* self);
  static void writeClipboard(void* self, const char* text);
};

}  // namespace argil::studio
