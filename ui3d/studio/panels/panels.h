#pragma once
// Everything flat in the studio, drawn with Dear ImGui. Knows no window: between ImGui::NewFrame() and ImGui::Render().

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "render/view/image.h"
#include "ui3d/studio/panels/actions.h"
#include "ui3d/studio/view/context.h"

namespace argil::studio {

/// Made after ImGui's context; one thread.
class Panels {
 public:
  Panels();
  ~Panels();
  Panels(const Panels&) = delete;
  Panels& operator=(const Panels&) = delete;

  /// Menus, panels, dialogs, status line, messages that pop up, progress of jobs. Changes `state` and sends edits to
  /// the bench.
  void draw(Context& context);
  /// A file came by drag and drop: asks for units where it has to.
  void dropped(Context& context, const std::string& path);
  /// Pictures that panels show from the next draw() on, for Renderer::setUiTexture(); valid until then. Each is given
  /// once, until forgetPictures().
  [[nodiscard]] std::vector<std::pair<uint32_t, const render::Image*>> takePictures();
  /// The renderer lost what it was given.
  void forgetPictures();
  /// Whether a shortcut is run although a menu, a list or a dialog is open. The first two close, as somebody who knows
  /// the key wants no menu; a dialog lets its own key through, by which it is closed, and what concerns the window
  /// alone. Between two frames.
  [[nodiscard]] bool letsThrough(const Context& context, const Shortcut& shortcut);
  /// Opens the first menu; closes the menus where one is open. Nothing happens while a dialog is open. Between two
  /// frames.
  void turnMenus();
  /// Something changes by itself (progress, a plot, a message that will go, a tooltip that will come): draw again
  /// within a tenth of a second.
  [[nodiscard]] bool moves() const;
  /// The middle part that no panel covers, in interface units: left, top, right, bottom. Of the last draw().
  [[nodiscard]] std::array<float, 4> free() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace argil::studio
