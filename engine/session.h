#pragma once
// A piece of clay in work: what it is now, how it came to be, and the way back.

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "clay/brush.h"
#include "clay/store.h"
#include "clay/version.h"
#include "engine/script.h"
#include "engine/stroke_path.h"

namespace argil::engine {

/// Frees in the background, in small batches, what dropped versions alone used.
class Collector {
 public:
  explicit Collector(std::shared_ptr<clay::Store> store);
  ~Collector();
  /// Something was dropped. Any thread but the servo's; does not wait.
  void wake();

 private:
  void run();
  std::shared_ptr<clay::Store> store_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool dirty_ = false, stop_ = false;
  std::thread thread_;  // last: it uses the others
};

/// Holds the current version and the history. One thread edits (every member without a note); version() is for all.
/// A stroke is one undo step however many versions were published in it and however often the tool was lifted; what is
/// left of it when it ends is its first and its last version. The result of a stroke depends on its points and lifts
/// alone. A new stroke ends the redo branch.
class Session {
 public:
  /// Begins with `first`, which cannot be undone.
  explicit Session(clay::Version first, const StrokeQuality& quality = {});
  ~Session();

  /// The newest version, in the middle of a stroke the last published one. Any thread but the servo's.
  [[nodiscard]] clay::Version version() const;

  /// Throws Error when the tool does not fit this clay, or while a stroke is on.
  void beginStroke(const Tool& tool);
  /// The tool's centre, world mm; the time is for the recording alone. Throws Error for what StrokePath refuses; then
  /// nothing changed and the stroke goes on.
  void addPoint(double timeS, const Vec3d& mm);
  /// The tool left the clay: the path ends here, the next point begins another one of the same stroke.
  void liftTool();
  /// Makes what was added so far the newest version. Cheap; call at most 500 times a second.
  clay::Version publish();
  /// The stroke becomes an undo step (none when it changed nothing); its last version.
  clay::Version endStroke();
  [[nodiscard]] bool inStroke() const { return step_.has_value(); }
  /// How many points of this stroke the next publish() will show; all of them after liftTool().
  [[nodiscard]] uint64_t coveredPoints() const;

  /// One step back or forth; false when there is none. Pointer swaps. Throws Error while a stroke is on.
  bool undo();
  bool redo();
  [[nodiscard]] size_t undoSteps() const { return done_.size(); }
  [[nodiscard]] size_t redoSteps() const { return undone_.size(); }

  /// The strokes that lead from the first version to the newest, without those undone, as a tip-driven script: run on the
  /// first version it gives equal bits. A lifted tool begins a new script stroke. Not while a stroke is on.
  [[nodiscard]] Script recording() const;

  /// Of all strokes so far, undone or not.
  struct Counts {
    uint64_t strokes = 0, points = 0, stamps = 0;
    clay::Editor::Counts clay;
  };
  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  struct Step {
    clay::Version before, after;
    std::vector<ScriptStroke> strokes;
  };
  void apply();
  void setVersion(const clay::Version& version);
  void requireNoStroke(const char* what) const;

  StrokeQuality quality_;
  mutable std::mutex mutex_;      // guards newest_ alone
  clay::Version newest_;
  std::vector<Step> done_, undone_;
  Counts counts_;

  // The stroke in work. path_ and brush_ are there between its first point and the next lift.
  std::optional<Step> step_;
  Tool tool_;
  clay::Version lifted_;          // what the paths before this one left
  std::optional<StrokePath> path_;
  std::unique_ptr<clay::BrushStroke> brush_;
  uint64_t pointsBefore_ = 0;     // of paths that were lifted
  std::vector<clay::Stamp> stamps_;
  std::unique_ptr<Collector> collector_;
};

}  // namespace argil::engine
