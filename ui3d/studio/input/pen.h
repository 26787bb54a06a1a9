#pragma once
// A tablet's pen: place, pressure and tilt by XInput2, as GLFW knows no pens.

#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "ui3d/studio/view/event.h"

namespace argil::studio {

/// Where a device tells something among its valuators, and from where to where it goes.
struct PenAxis {
  int number = 0;
  double least = 0, most = 1;
};
/// What a device of X has of a pen.
struct PenAxes {
  std::optional<PenAxis> pressure, tiltX, tiltY;
};
struct PenState {
  float pressure = 0;          ///< 0 to 1.
  float tiltX = 0, tiltY = 0;  ///< rad, to the right and towards the person, within ± 1.5.
  bool eraser = false;         ///< The other end of it is at the tablet.
};

/// Drivers show each end of a pen as a device of its own and tell them apart by their names alone.
[[nodiscard]] bool namesEraser(std::string_view device);

/// The valuators of an event: a bit for each in `mask`, values packed in order of the bits. What an event does not tell
/// stays as it was `before`. Tilts come in degrees; values that are not finite count as not told.
[[nodiscard]] PenState decodePen(const PenAxes& axes, std::span<const unsigned char> mask,
                                 std::span<const double> values, PenState before);

/// Listens to all pens over a window of another connection. Without a pen or without XInput 2 it does nothing. One
/// thread.
class Pen {
 public:
  explicit Pen(unsigned long window);
  ~Pen();
  Pen(const Pen&) = delete;
  Pen& operator=(const Pen&) = delete;

  /// Readable when a pen did something; −1: there never will be.
  [[nodiscard]] int descriptor() const;
  /// Appends a `move` for every motion of a pen since the last time: pixels over `scale`.
  void poll(double nowS, float scale, std::vector<Event>& events);
  /// Whether a pen told something in the last tenth of a second: then the window's own motions say the same again,
  /// without pressure.
  [[nodiscard]] bool active(double nowS) const;
  [[nodiscard]] const PenState& state() const;
  [[nodiscard]] int count() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace argil::studio
