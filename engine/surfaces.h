#pragma once
// The surfaces of a document's pieces, handed from the edit thread to whoever draws them.

#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "clay/surface.h"
#include "engine/document.h"

namespace argil::engine {

/// Changed surface of one piece.
struct SurfaceChange {
  Id piece = 0;
  bool whole = false;    ///< Forget what was there before: the delta is the whole piece.
  bool removed = false;  ///< The piece is gone; no delta.
  clay::SurfaceDelta delta;
};
/// Since the last time they were taken; several changes of a brick are one.
struct SurfaceChanges {
  std::vector<SurfaceChange> pieces;
  /// The oldest sample whose cut is shown with these for the first time: its time on CLOCK_MONOTONIC, ns; 0: none.
  int64_t oldestSampleNs = 0;
};

class Surfaces {
 public:
  /// Re-extracts what changed in each piece since the last call. The edit thread's. `oldestSampleNs` as above.
  void follow(const Document& document, int64_t oldestSampleNs, int threads = 1);
  /// The next follow() gives every piece whole. The edit thread's.
  void forget();
  /// Of all surfaces from the next follow() on, which gives every piece whole. The edit thread's.
  void setGrade(clay::Grade grade);
  [[nodiscard]] clay::Grade grade() const { return grade_; }
  /// Extracts a large new clay before it becomes a piece, so that follow() has little left to do. Any thread; kept until a piece with
  /// this version, or one of its store and grid, comes in this grade.
  void prepare(const clay::Version& version, int threads = 1) { prepare(version, threads, grade_); }
  void prepare(const clay::Version& version, int threads, clay::Grade grade);

  /// What changed. Any one thread beside follow(); waits for no extraction.
  [[nodiscard]] SurfaceChanges take();

 private:
  struct Waiting {
    bool whole = false, removed = false;
    std::vector<clay::SurfaceDelta> deltas;
  };
  struct Followed {
    explicit Followed(clay::Grade grade) : surface(true, grade) {}
    clay::Surface surface;
    clay::Version version;
  };
  struct Prepared {
    Followed followed;
    clay::Grade grade;
    clay::SurfaceDelta delta;
  };
  [[nodiscard]] std::optional<Prepared> takePrepared(const clay::Version& version);
  static clay::SurfaceDelta merge(std::vector<clay::SurfaceDelta>& deltas);

  std::atomic<clay::Grade> grade_{clay::Grade::draft};
  std::map<Id, Followed> followed_;
  std::mutex mutex_;  // guards the rest
  std::map<Id, Waiting> waiting_;
  std::vector<Prepared> prepared_;
  int64_t oldestNs_ = 0;
};

}  // namespace argil::engine
