#pragma once
// The window on the desktop: makes events of what a person does with it.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "render/view/image.h"
#include "render/view/window_hooks.h"
#include "ui3d/studio/view/event.h"

namespace argil::studio {

enum class CursorShape : uint8_t { arrow, text, hand, crosshair, resizeHorizontal, resizeVertical, none };

/// One window, on X11. Members are for the thread that made it, which must be the process' first, but for wake() and
/// what hooks() hands out.
class Window {
 public:
  struct Options {
    std::string title = "Argil";
    int width = 0, height = 0;  ///< Pixels; 0: as firstWindow() has it on this screen.
    float scale = 0;            ///< Pixels an interface unit; 0: as the display says.
    int64_t startNs = 0;        ///< Times of events count from here, on CLOCK_MONOTONIC.
  };
  /// Throws Error (work) when there is no display or no window can be had.
  explicit Window(const Options& options);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// What the renderer needs. Throws Error (work) naming the package when there is no Vulkan loader.
  [[nodiscard]] render::WindowHooks hooks() const;

  /// Waits until something happens to the window, wake() is called or one of `descriptors` can be read; at most so
  /// long.
  void wait(double seconds, std::span<const int> descriptors = {});
  /// Appends what happened since the last time.
  void poll(std::vector<Event>& events);
  /// Ends wait(). Any thread.
  void wake() noexcept;
  /// Since startNs.
  [[nodiscard]] double nowS() const;

  [[nodiscard]] std::array<int, 2> pixels() const;  ///< Of the drawable part; kept while minimised.
  [[nodiscard]] bool minimised() const;
  /// Pixels an interface unit: less than is wanted where the window would not hold the interface, see scaleThatFits().
  [[nodiscard]] float scale() const;
  /// 0: as the display says. The next poll() brings a resize event when it changed.
  void setScale(float scale);
  void resize(int width, int height);
  void setTitle(const std::string& title);
  void setIcon(const render::Image& icon);
  void setCursor(CursorShape shape);
  void setClipboard(const std::string& text);
  [[nodiscard]] std::string clipboard() const;
  void toggleFullScreen();
  [[nodiscard]] bool fullScreen() const;
  /// The X window, for those who listen to it on a connection of their own.
  [[nodiscard]] unsigned long x11() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace argil::studio
