#pragma once
// A change of many bricks that is looked at while it is half done.

#include <optional>
#include <span>
#include <vector>

#include "clay/store/editor.h"

namespace argil::clay {

/// Links bricks in such a way that the surface is closed whatever is linked yet. Between an inside tile and an outside
/// one there is no brick that the surface could belong to (clay/surface/NOTES.md); so what becomes a tile stays a brick
/// until all around it is done. One thread.
class ChangeInParts {
 public:
  /// `bricks`: all that the change may reach, sorted; the same until its end.
  ChangeInParts(Editor& editor, std::span<const Coord> bricks)
      : editor_(editor), bricks_(bricks), endsAs_(bricks.size()) {}

  /// Puts what brick number `i` becomes into its place, as Editor::link().
  void link(size_t i, FloatBrick* brick, bool inBand);
  /// The first `count` bricks are done: linked, or they stay as they were.
  void done(size_t count);

 private:
  Editor& editor_;
  std::span<const Coord> bricks_;
  std::vector<std::optional<Tile>> endsAs_;  // of a brick that stands for a tile
  size_t settled_ = 0;
};

}  // namespace argil::clay
