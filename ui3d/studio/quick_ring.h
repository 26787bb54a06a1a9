#pragma once
// What a hand without a keyboard needs at hand: a ring around the cursor, opened by a click of a pen's barrel button.

#include <array>
#include <cstdint>

#include "ui3d/studio/view/studio_state.h"

namespace argil::studio {

/// Undo, redo and all are clicked; zoom, move and size are dragged, as long as the tip stays down. Interface units.
struct QuickRing {
  enum class Item : uint8_t { none, zoom, redo, all, move, size, undo };
  static constexpr int kItems = 6;
  static constexpr float kInner = 22, kOuter = 92;

  float x = 0, y = 0;
  float shown = 1;  ///< Size of all of it; smaller than 1 where the window has no room.

  /// Around a place, wholly within a window.
  [[nodiscard]] static QuickRing around(float x, float y, float width, float height);
  /// What stands at a place; `none`: in the middle or outside.
  [[nodiscard]] Item at(float px, float py) const;
  /// The middle of an item.
  [[nodiscard]] std::array<float, 2> place(Item item) const;
  [[nodiscard]] static const char* name(Item item);
  [[nodiscard]] static bool dragged(Item item) {
    return item == Item::zoom || item == Item::move || item == Item::size;
  }
  /// In a frame of the panels, over everything.
  void draw(Item hot) const;
};

}  // namespace argil::studio
