#pragma once
// A document in work: what it is now, how it came to be, and the way back.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <unordered_set>
#include <vector>

#include "clay/brush/brush.h"
#include "clay/store/store.h"
#include "clay/store/version.h"
#include "engine/document/document.h"
#include "engine/text/script.h"
#include "engine/tools/stroke_path.h"

namespace argil::engine {

/// Frees in the background, in small batches, what dropped versions alone used, and in the end the stores themselves.
class Collector {
 public:
  Collector();
  ~Collector();
  /// Takes care of the stores of pieces; again is fine. Any thread but the servo's. Cost does not grow with the stores
  /// that are there.
  void add(const std::vector<Piece>& pieces);
  /// Something was dropped. Any thread but the servo's; does not wait.
  void wake();

 private:
  void run();
  std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::shared_ptr<clay::Store>> fresh_;  // that its thread does not know yet
  std::unordered_set<const clay::Store*> known_;     // all
  bool dirty_ = false, stop_ = false;
  std::thread thread_;  // last: it uses the others
};

/// Hears what happens in a session, in order, on its editing thread: a journal. Must not throw.
class SessionWatch {
 public:
  virtual ~SessionWatch() = default;
  /// Strokes and their points are told where repeating them gives the same clay. Of a brush that is computed elsewhere
  /// (a plugin's) nothing is told but what it has made so far: a step, and again and again what it leads to by then.
  virtual void strokeBegan(const Tool& tool, const StrokeImages& images) = 0;
  virtual void strokePoint(const PathPoint& point) = 0;
  virtual void toolLifted() = 0;
  /// A stroke that changed something is told by stepped() first.
  virtual void strokeEnded() = 0;
  /// A step was done, or (`merged`) the last one is now another; what was undone before is gone.
  virtual void stepped(const std::string& label, const DocumentPtr& after, bool merged) = 0;
  virtual void went(size_t done) = 0;
  /// The document of a state has left memory; or it is there again, just before it is gone to.
  virtual void spilled(size_t /*state*/) {}
  virtual void cameBack(size_t /*state*/, const DocumentPtr& /*document*/) {}
};

/// A document that the history holds: the first one, or what a step led to.
struct HistoryState {
  std::string label;     ///< Of the step; empty for the first.
  DocumentPtr document;  ///< Null: kept in a file, under `kept`; read when it is gone to.
  uint64_t kept = 0;     ///< 0: in no file yet.
};

/// Holds the current document and the history. One thread edits (every member without a note); document() and version()
/// are for all. A stroke works on one piece and is one undo step however many versions were published in it and however
/// often the tool was lifted; what is left of it when it ends is its first and its last version. The result of a stroke
/// depends on its points and lifts alone. A new step ends the redo branch, but
/// where goTo() keeps it.
class Session {
 public:
  /// Begins with `first`, which cannot be undone.
  explicit Session(Document first);
  explicit Session(clay::Version first) : Session(Document::of(std::move(first))) {}
  /// Goes on with a history: at least one state, the one at `done` has its document.
  Session(std::vector<HistoryState> states, size_t done);
  ~Session();

  /// Threads that share a large stamp, and the surface that it changed: the machine's, at most 4. Any thread.
  [[nodiscard]] static int strokeThreads() noexcept;

  /// The newest document, in the middle of a stroke the last published one. Any thread but the servo's.
  [[nodiscard]] DocumentPtr document() const;
  /// The newest version of the active piece; none without one. Any thread but the servo's.
  [[nodiscard]] clay::Version version() const;

  /// Throws Error when the tool does not fit the clay, when there is no piece that can be worked on, or while a stroke
  /// is on. Stamps are repeated as mirror images in these planes, world mm; without any in the document's.
  void beginStroke(const Tool& tool) { beginStroke(tool, newest_->images()); }
  void beginStroke(const Tool& tool, StrokeImages images);
  /// The tool's centre, in the piece's mm; the time is for the recording alone. A point without a rotation gets that of
  /// the surface there. Throws Error for what StrokePath refuses; then nothing changed and the stroke goes on.
  void addPoint(const PathPoint& point);
  void addPoint(double timeS, const Vec3d& mm) { addPoint(PathPoint{timeS, mm}); }
  /// As addPoint(), but the stamps that the point gives wait for applyStamp(): for those who may not take long at a
  /// time. Stamps that still wait are applied first. However a stroke is fed, the same points leave the same clay.
  void queuePoint(const PathPoint& point);
  /// Applies the next stamp that waits, or what has to be done before that where it takes as long; false when none
  /// waits. What it throws ends the waiting: the rest is not applied.
  bool applyStamp();
  [[nodiscard]] bool stampsWait() const { return nextStamp_ < stamps_.size(); }
  /// The tool left the clay: the path ends here, the next point begins another one of the same stroke.
  void liftTool();
  /// Makes what was applied so far the newest version. Cheap; call at most 500 times a second.
  clay::Version publish();
  /// The stroke becomes an undo step (none when it changed nothing); its last version. When it throws (no memory), the
  /// stroke is still on.
  clay::Version endStroke();
  /// The stroke leaves no trace: the document is the one that it began with. For when endStroke() failed.
  void abandonStroke();
  [[nodiscard]] bool inStroke() const { return stroke_.has_value(); }
  /// What holds the tool of the stroke in work (clay::BrushStroke::wallsAhead), for all images where the hand is: in
  /// voxels of the piece, image 0. Empty when the tool is lifted.
  [[nodiscard]] std::vector<clay::WallAhead> wallsAhead();
  /// How many points of this stroke the next publish() will show; all of them after liftTool().
  [[nodiscard]] uint64_t coveredPoints() const;

  /// Any other change: `change` gets a copy, which becomes the newest document and one undo step named `label`. With
  /// the `merge` of the step before, not empty, it joins that step. What `change` throws comes out and nothing changed.
  /// Throws Error while a stroke is on.
  void change(const std::string& label, const std::function<void(Document&)>& change, const std::string& merge = {});
  /// Switches symmetry without a step: it is a setting of the hand. Undo and redo leave it as it is; whoever saves
  /// takes document() for the state in work. The pose of `symmetry` is not read: moving planes is a step. Throws Error
  /// while a stroke is on.
  void setSymmetry(const Symmetry& symmetry);
  /// The same for Document::quality. Throws Error for what is out of range, or while a stroke is on.
  void setQuality(const StrokeQuality& quality);
  /// The next change joins no step.
  void endMerge() { merge_.clear(); }

  /// One step back or forth; false when there is none. Pointer swaps. Throws Error while a stroke is on.
  bool undo();
  bool redo();
  /// So many steps done. Throws Error for more than there are, or while a stroke is on. `keeps`: a step that is made
  /// from there ends no redo branch: the later steps stay, and "Back to step …" comes between them and the new one.
  /// That holds until the last step is reached again.
  void goTo(size_t steps, bool keeps = false);
  [[nodiscard]] size_t undoSteps() const { return done_; }
  [[nodiscard]] size_t redoSteps() const { return states_.size() - 1 - done_; }
  /// Grows whenever the steps or how many are done change.
  [[nodiscard]] uint64_t steps() const { return steps_; }
  /// Labels of all steps, oldest first, those that are undone too.
  [[nodiscard]] std::vector<std::string> history() const;
  /// The first document and what each step led to.
  [[nodiscard]] const std::vector<HistoryState>& states() const { return states_; }

  /// The document of a state leaves memory: it is read again under `kept` when it is gone to. Throws Error for the
  /// newest one. Its clay is freed in the background.
  void spill(size_t state, uint64_t kept);

  /// Reads a state that is kept in a file, given the document in memory that is the fewest steps away; what it throws
  /// comes out of undo(), redo() and goTo(), and nothing changed.
  void setReader(std::function<DocumentPtr(uint64_t kept, const Document& near)> reader) {
    reader_ = std::move(reader);
  }
  /// Null: nobody. It must outlive its time here.
  void setWatch(SessionWatch* watch) { watch_ = watch; }

  /// From now on the points of every stroke are held for recording(): memory grows with all that is drawn. A session in
  /// front of a user leaves that to its journal.
  void record() { records_ = true; }
  /// The strokes since record() that lead to the newest version, without those undone, as a tip-driven script: run on
  /// the first version it gives equal bits, where all steps are strokes on one piece. A lifted tool begins a new script
  /// stroke. Throws Error while a stroke is on, and without record().
  [[nodiscard]] Script recording() const;

  /// Of all strokes so far, undone or not.
  struct Counts {
    uint64_t strokes = 0, points = 0, stamps = 0;
    uint64_t idle = 0;  ///< Strokes that changed nothing.
    uint64_t kept = 0;  ///< Later steps that goTo() kept when another was made.
    clay::Editor::Counts clay;
  };
  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  void applyAll();
  [[nodiscard]] clay::Version morphGoal(const Tool& tool, const Piece& piece) const;
  [[nodiscard]] Eigen::Quaterniond standing(const Vec3d& mm);
  void setDocument(DocumentPtr document);
  void swapNewest(DocumentPtr document);
  void setVersion(const clay::Version& version);
  [[nodiscard]] DocumentPtr withSettings(DocumentPtr document) const;
  void keepLaterSteps();
  void push(const std::string& label, DocumentPtr after, std::vector<ScriptStroke> strokes);
  void requireNoStroke(const char* what) const;
  [[nodiscard]] std::string strokeLabel() const;
  void tellMade();
  [[nodiscard]] const Document& nearest(size_t state) const;

  mutable std::mutex mutex_;  // guards newest_ alone
  DocumentPtr newest_;
  std::vector<HistoryState> states_;                // states_[done_] is newest_ but in a stroke
  std::vector<std::vector<ScriptStroke>> strokes_;  // that led to each state; empty ones without record()
  bool records_ = false;
  size_t done_ = 0;
  bool keepsLater_ = false;  // as goTo() was asked to
  std::function<DocumentPtr(uint64_t, const Document&)> reader_;
  SessionWatch* watch_ = nullptr;
  std::string merge_;  // of the last step
  // As they were chosen; none: each state's own.
  std::optional<Symmetry> symmetry_;
  std::optional<StrokeQuality> quality_;
  uint64_t steps_ = 0;
  Counts counts_;

  // Documents of the stroke in work that nobody holds any more, to be used again: a copy of a document costs as much as
  // it has pieces. The last holder brings them, on whatever thread that is.
  struct Spares {
    std::mutex mutex;
    uint64_t stroke = 0;  // whose documents these are
    std::vector<std::unique_ptr<Document>> documents;
    static constexpr size_t kMost = 4;
  };
  [[nodiscard]] std::shared_ptr<Document> spareDocument();
  void endSpares();
  std::shared_ptr<Spares> spares_ = std::make_shared<Spares>();
  static inline std::atomic<uint64_t> nextStroke_{1};  // of all sessions together
  uint64_t strokeNumber_ = 0;
  size_t place_ = 0;  // of piece_ in the document

  // The stroke in work. path_ and brush_ are there between its first point and the next lift.
  struct Stroke {
    DocumentPtr before;
    clay::Version start;
    std::vector<ScriptStroke> strokes;
  };
  std::optional<Stroke> stroke_;
  Id piece_ = 0;
  Tool tool_;
  int threads_ = 1;  // that help with large stamps; the result does not depend on it
  std::shared_ptr<const clay::Brush> strokeBrush_;
  // Of a stroke that the watch is told of by what it makes: whether it was told, and when.
  bool tellsMade_ = false, toldMade_ = false;
  std::chrono::steady_clock::time_point toldAt_{};
  StrokeImages images_;  // world, for the recording
  ImageMaps maps_;
  std::optional<Vec3d> drawn_;     // end of the string on which the tool is drawn
  Vec3d normal_ = Vec3d::UnitZ();  // of the surface at the last point, for a tip without a stylus
  clay::Version lifted_;           // what the paths before this one left
  std::optional<StrokePath> path_;
  std::unique_ptr<clay::BrushStroke> brush_;
  uint64_t pointsBefore_ = 0;                      // of paths that were lifted
  std::vector<clay::Stamp> stamps_, stampImages_;  // stamps_: of the last point, or the path's end
  size_t nextStamp_ = 0;                           // of stamps_: those before it are applied
  uint64_t coveredBefore_ = 0;                     // points of the path that the clay shows while stamps wait
  std::unique_ptr<Collector> collector_;
};

}  // namespace argil::engine
