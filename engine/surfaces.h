#pragma once
// The surfaces of a document's pieces, handed from the edit thread to whoever draws them.

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
  /// Extracts a large new clay before it becomes a piece, so that follow() has nothing left to do. Any thread; kept until a piece with
  /// this version comes.
  void prepare(const clay::Version& version, int threads = 1);

  /// What changed. Any one thread beside follow(); waits for no extraction.
  [[nodiscard]] SurfaceChanges take();

 private:
  struct Waiting {
    bool whole = false, removed = false;
    std::vector<clay::SurfaceDelta> deltas;
  };
  struct Followed {
    clay::Surface surface;
    clay::Version version;
  };
  struct Prepared {
    Followed followed;
    clay::SurfaceDelta delta;
  };
  [[nodiscard]] std::optional<Prepared> takePrepared(const clay::Version& version);
  static clay::SurfaceDelta merge(std::vector<clay::SurfaceDelta>& deltas);

  std::map<Id, Followed> followed_;
  std::mutex mutex_;  // guards the rest
  std::map<Id, Waiting> waiting_;
  std::vector<Prepared> prepared_;
  int64_t oldestNs_ = 0;
};

}  // namespace argil::engine
