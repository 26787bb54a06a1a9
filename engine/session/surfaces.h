#pragma once
// The surfaces of a document's pieces, handed from the edit thread to whoever draws them.

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "clay/surface/surface.h"
#include "engine/document/document.h"
#include "engine/print/check_paint.h"

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

/// Follows a document. Little is extracted by follow() itself; what would take longer than a picture (a large piece
/// that is new, the undo of an operation on a whole piece) goes to a helper thread, one piece after the other, and the
/// surface from before is shown until it is ready.
class Surfaces {
 public:
  Surfaces() = default;
  ~Surfaces();
  Surfaces(const Surfaces&) = delete;
  Surfaces& operator=(const Surfaces&) = delete;

  /// Re-extracts what changed in each piece since the last call. The edit thread's. `oldestSampleNs` as above. Throws
  /// what an extraction threw, after all other pieces were followed; that piece comes whole with the next call.
  void follow(const Document& document, int64_t oldestSampleNs, int threads = 1);
  /// The next follow() gives every piece whole, and takes back what its document does not have. The edit thread's.
  void forget();
  /// Of all surfaces from the next follow() on, which gives every piece whole. The edit thread's.
  void setGrade(clay::Grade grade);
  [[nodiscard]] clay::Grade grade() const { return grade_; }
  /// What is too thin, or has too little draft, is coloured from the next follow() on, which gives every piece whole;
  /// none: nothing. The edit thread's.
  void setChecks(const std::optional<CheckLimits>& limits);

  class Prepared;
  /// Extracts a large new clay before it becomes a piece, so that follow() shows both at once: when a piece with this
  /// version, or one of its store and grid, comes in this grade while what is returned is held. Any thread.
  [[nodiscard]] std::shared_ptr<Prepared> prepare(const clay::Version& version, int threads = 1) {
    return prepare(version, threads, grade_);
  }
  [[nodiscard]] std::shared_ptr<Prepared> prepare(const clay::Version& version, int threads, clay::Grade grade);

  /// Something that the helper made waits for the next follow(). Any thread.
  [[nodiscard]] bool arrived() const { return arrived_.load(); }
  /// The helper is at work or what it made waits. Any thread.
  [[nodiscard]] bool behind() const { return away_.load() > 0; }
  /// Bricks that follow() extracted itself so far, about. The edit thread's.
  [[nodiscard]] uint64_t ownBricks() const { return ownBricks_; }
  /// Pieces that follow() looked at so far. In a stroke that is the one that is worked on, also while the helper has
  /// others, and all of them when it brings something. The edit thread's.
  [[nodiscard]] uint64_t looks() const { return looks_; }
  /// follow() extracts so many bricks at most by itself, but for what a hand does in a stroke: about 10 ms.
  static constexpr uint64_t kMostOwnBricks = 8192;

  /// What changed. Any one thread beside follow(); waits for no extraction.
  [[nodiscard]] SurfaceChanges take();

 private:
  struct Waiting {
    bool whole = false, removed = false;
    std::vector<clay::SurfaceDelta> deltas;
  };
  struct Followed {
    Followed(clay::Grade grade, const std::optional<CheckLimits>& limits) : surface(true, grade), checks(limits) {}
    clay::SurfaceDelta update(const clay::Version& to, int threads, bool keepBefore = false);
    clay::Surface surface;
    std::optional<CheckPaint> checks;
    clay::Version version;
    uint64_t away = 0;  // names the helper's task that has the surface; 0: it is here
  };
  struct Task {
    uint64_t name = 0;
    Id piece = 0;  // 0: only what is to be let go of
    std::unique_ptr<Followed> followed;
    std::unique_ptr<Followed> old;  // freeing a large surface takes as long as a picture
    clay::Version version;
    bool whole = false;
    int threads = 1;
    clay::SurfaceDelta delta;
    std::exception_ptr failure;
  };
  struct Seen {
    Id piece = 0;
    const clay::VersionRecord* record = nullptr;                   // that is followed; null: look closer
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // of the piece then
  };
  bool takeArrived(std::exception_ptr& failure);
  bool followPlace(const Document& document, size_t place, bool stroke, int threads, std::exception_ptr& failure);
  void endFollowing(int64_t oldestSampleNs, const std::exception_ptr& failure);
  bool followOne(const Piece& piece, bool stroke, int threads);
  void deliver(Id piece, Waiting one);
  void send(Task task);
  void letGo(std::unique_ptr<Followed> old);
  void help();
  [[nodiscard]] std::shared_ptr<Prepared> takePrepared(const clay::Version& version, bool whole);
  static clay::SurfaceDelta merge(std::vector<clay::SurfaceDelta>& deltas);

  [[nodiscard]] std::unique_ptr<Followed> nothingYet() { return std::make_unique<Followed>(grade_.load(), checks_); }

  std::atomic<clay::Grade> grade_{clay::Grade::draft};
  std::optional<CheckLimits> checks_;
  std::map<Id, std::unique_ptr<Followed>> followed_;
  std::unordered_set<Id> failedNow_;  // what the helper could not extract, as the follow() that runs has learnt
  std::unordered_set<Id> shown_;      // what was delivered and not taken back: it may be in the picture
  bool forgotten_ = false;            // since the last follow()
  std::vector<Seen> seen_;            // by place in the document
  // of the document that was followed last, all of whose pieces were as it has them, but for this place
  uint64_t seenStroke_ = 0;
  uint64_t looks_ = 0;
  size_t seenPlace_ = 0;
  uint64_t nextTask_ = 1, ownBricks_ = 0, ownNow_ = 0;

  std::mutex mutex_;  // guards the rest
  std::map<Id, Waiting> waiting_;
  std::unordered_multimap<const clay::Store*, std::weak_ptr<Prepared>> prepared_;
  int64_t oldestNs_ = 0;

  std::condition_variable work_;  // with mutex_
  std::deque<Task> tasks_, done_;
  bool stop_ = false;
  std::atomic<bool> arrived_{false};
  std::atomic<int> away_{0};
  std::thread helper_;  // begun when there is something for it
};

}  // namespace argil::engine
