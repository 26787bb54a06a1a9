#pragma once
// What reaches the studio from a person: from a real window, from a pen, or from a recording. One path for all of them.

#include <array>
#include <cstdint>
#include <string>

namespace argil::studio {

enum class Key : uint16_t {
  none = 0,
  // Printable keys are their capital letter, digit or sign in ASCII: 'A', '7', '[', ' '.
  escape = 256,
  enter,
  tab,
  backspace,
  insert,
  remove,
  right,
  left,
  down,
  up,
  pageUp,
  pageDown,
  home,
  end,
  f1 = 290,
  f2,
  f3,
  f4,
  f5,
  f6,
  f7,
  f8,
  f9,
  f10,
  f11,
  f12,
  keypad0 = 320,
  keypad1,
  keypad2,
  keypad3,
  keypad4,
  keypad5,
  keypad6,
  keypad7,
  keypad8,
  keypad9,
  shift = 340,
  control,
  alt,
  super,
};

enum Modifier : uint8_t { kShift = 1, kControl = 2, kAlt = 4, kSuper = 8 };
enum class Button : uint8_t { left, right, middle };

/// Positions are in interface units from the top left corner of the window's drawable part: pixels over the scale.
struct Event {
  enum class Kind : uint8_t {
    move,  ///< x, y; pressure and tilt of a pen.
    press,
    release,  ///< button, modifiers, x, y.
    wheel,    ///< dx, dy in clicks; up and right positive.
    keyDown,
    keyUp,  ///< key, modifiers; repeat.
    text,   ///< A character, UTF-32 in `character`.
    enter,
    leave,       ///< The cursor came into the window or left it.
    resize,      ///< width, height in pixels; scale.
    drop,        ///< A file was dropped: text is its path.
    focus,       ///< on: the window has the keyboard.
    close,       ///< The person wants to leave.
    motion6,     ///< A 3D mouse: six axes, −1 to 1.
    screenshot,  ///< Of recordings: save what is shown to the path in `text`.
    check,       ///< Of recordings: wait until nothing is under way (no job, no stroke, picture at rest).
    lose,        ///< Of recordings: the graphics device fails with the next picture.
  };
  Kind kind = Kind::move;
  double timeS = 0;  ///< Since the studio began.
  float x = 0, y = 0;
  float dx = 0, dy = 0;
  Button button = Button::left;
  uint8_t modifiers = 0;  ///< Modifier bits at that time.
  Key key = Key::none;
  bool repeat = false, on = false;
  uint32_t character = 0;
  int width = 0, height = 0;
  float scale = 1;
  float pressure = -1;         ///< 0 to 1; negative: not a pen.
  float tiltX = 0, tiltY = 0;  ///< rad, to the right and towards the person.
  bool eraser = false;         ///< The other end of a pen.
  std::array<float, 6> axes{};
  std::string text;
};

}  // namespace argil::studio
