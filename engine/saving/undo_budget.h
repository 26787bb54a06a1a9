#pragma once
// How much memory the steps of a history may take, and which of them leave it.

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "engine/saving/session.h"

namespace argil::engine {

/// Bytes of clay and meshes that `document` has and `beside` has not: what would be freed with it. Cost follows the
/// difference.
[[nodiscard]] uint64_t bytesAlone(const Document& document, const Document& beside);

struct UndoUse {
  uint64_t bytes = 0;   ///< Of memory that the newest document does not need: of all steps in memory, undone ones too.
  size_t inMemory = 0;  ///< Documents of the history, without the newest.
  size_t onDisk = 0;
  bool over = false;  ///< More than the budget: the oldest step is not on the disk yet, or cannot get there.
  friend bool operator==(const UndoUse&, const UndoUse&) = default;
};

/// Keeps a session's history within a budget: the oldest steps leave memory first, when none is left those that redo
/// would reach last. What is left is one row of steps around the newest document, so that what each of them alone has
/// is what it does not share with its neighbour on the way to the newest one. The count is of what will be freed; it
/// follows neither the collector nor what else holds a version for a while (a stroke in work, a save, a job). The
/// editing thread's.
class UndoBudget {
 public:
  static constexpr uint64_t kStandard = uint64_t{2} << 30;
  /// `bytes` 0: no limit.
  explicit UndoBudget(uint64_t bytes = kStandard) : bytes_(bytes) {}
  void set(uint64_t bytes) { bytes_ = bytes; }
  [[nodiscard]] uint64_t bytes() const { return bytes_; }

  /// The id under which a document can be read again; 0 while it cannot: then it stays.
  using Kept = std::function<uint64_t(const DocumentPtr&)>;
  /// Counts, and lets go what is too much. Not while a stroke is on. Cost: a word or two a state; where steps are new,
  /// what they changed, of kMostNew of them at most.
  UndoUse keep(Session& session, const Kept& kept);

  static constexpr size_t kMostNew = 32;

 private:
  // Between a state in memory and the next one in memory.
  struct Edge {
    std::weak_ptr<const Document> of, next;
    uint64_t below = 0, above = 0;  // what of() alone has beside next(), and the other way round
  };
  uint64_t bytes_;
  std::vector<Edge> edges_;  // by state
};

}  // namespace argil::engine
