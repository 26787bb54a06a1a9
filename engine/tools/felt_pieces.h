#pragma once
// Which pieces the hand feels where a document has more than haptics can hold.

#include <vector>

#include "engine/document/document.h"

namespace argil::engine {

/// Chooses the piece that is worked on and those nearest to the hand, as many as a scene holds (haptics::kMaxPieces). A
/// piece that stays chosen keeps its place in the scene, and one that is chosen goes only for one that is clearly
/// nearer, so the hand does not lose what it touches. One thread.
class FeltPieces {
 public:
  /// Chooses anew when other pieces are there or visible, another one is worked on, or the hand (world mm) has moved by
  /// kMovedMm; true when others are felt than before. Cost: a look at each piece; where more are visible than a scene
  /// holds, and it chooses, the distance to the bounds of each, which are measured when its clay is new (O(its
  /// bricks)).
  bool choose(const Document& document, const Vec3d& handMm);
  /// Where they stand in Document::pieces of the document that choose() saw last, in the order of the scene; for
  /// sceneOf().
  [[nodiscard]] const std::vector<size_t>& places() const { return places_; }
  /// How many pieces of it are visible.
  [[nodiscard]] size_t visible() const { return visible_; }

  static constexpr double kMovedMm = 2;

 private:
  struct Seen {
    Id id = 0;
    bool visible = false, felt = false;
    // Of its clay, in its own mm, measured where not all can be felt.
    clay::Version measured;
    Eigen::AlignedBox3d bounds;
  };
  void look(const Document& document);
  void chooseNearest(const Document& document, const Vec3d& handMm);

  std::vector<Seen> seen_;  // by place in the document
  uint64_t stroke_ = 0;     // of that document
  Id worked_ = 0;
  std::vector<Id> ids_;  // chosen, in the order of the scene
  std::vector<size_t> places_;
  Vec3d chosenAt_ = Vec3d::Constant(1e300);
  size_t visible_ = 0;
};

}  // namespace argil::engine
