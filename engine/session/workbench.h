#pragma once
// A document in work: the thread that edits it, the servo that feels it, the jobs beside it, and what a face needs to
// show it.

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/document/document.h"
#include "engine/document/tool.h"
#include "engine/models/import_place.h"
#include "engine/models/model_files.h"
#include "engine/saving/undo_budget.h"
#include "engine/session/recovery.h"
#include "engine/session/surfaces.h"
#include "engine/tools/piece_jobs.h"
#include "haptics/base/device.h"
#include "haptics/devices/hand_path.h"
#include "haptics/devices/pointer.h"
#include "haptics/servo/servo.h"
#include "haptics/threads/sample_ring.h"

namespace argil::engine {

/// Where the document is kept.
struct FileState {
  std::filesystem::path path;  ///< Of the saved document; empty: untitled.
  std::string name;            ///< File name of what an untitled document was recovered from; empty: it has none.
  bool unsaved = false;  ///< The document is not what that file holds (an empty untitled document counts as saved).
  bool saving = false;
  std::string journalTrouble;  ///< A sentence while the journal cannot be written; empty while all is well.
  std::string readOnly;        ///< Why it must not be saved into that file, a sentence; empty: it may be.
  uint64_t refused = 0;        ///< Grows with every save into that file that failed: another name is worth offering.
  std::string refusal;         ///< Why the last of them failed, a sentence.
  bool elsewhere = false;      ///< That file is open in another window too.
  uint64_t opened = 0;         ///< Grows with every document that is opened, recovered or begun.
  std::shared_ptr<const std::string> face;  ///< As SaveExtras::face was when it was saved; null without.
  friend bool operator==(const FileState&, const FileState&) = default;
};

/// What the face adds to a saved document.
struct SaveExtras {
  /// Views, tool and whatever else it wants back, as a JSON object; empty: what the file has stays.
  std::string face;
  std::vector<std::byte> thumbnail;  ///< PNG, at most 256 pixels an edge; empty: none.
};

/// All that a face shows of the model: immutable, of one moment.
struct Snapshot {
  uint64_t sequence = 0;  ///< Grows with every change.
  DocumentPtr document;
  std::shared_ptr<const std::vector<std::string>> history;  ///< Labels of steps, oldest first, undone ones too.
  size_t done = 0;  ///< So many of them are done; the next is what redo would do.
  bool inStroke = false;
  Tool tool;  ///< As the edit thread has it.
  uint64_t strokes = 0, points = 0, versions = 0;
  Id made = 0;             ///< What was added last by being asked for: made, imported, copied; 0: nothing yet.
  uint64_t madeCount = 0;  ///< Grows with each such thing.
  uint64_t clayBytes = 0;  ///< Of the pieces and their undo steps.
  UndoUse undo;            ///< What the steps take of memory, and how many are on disk alone.
  double editP50Us = 0, editP99Us = 0;  ///< From a sample that cuts to its changed triangles.
  FileState file;
};

/// What the person sees of touch.
struct TouchState {
  std::string device;  ///< As it was opened: "pointer", "haply", "simulated:touch".
  haptics::DeviceSheet sheet;
  std::string deviceStatus;  ///< One sentence.
  haptics::ServoState state = haptics::ServoState::noScene;
  std::string sentence;  ///< What the servo does or why it stopped, and what to do.
  std::string grant;     ///< What the system granted the servo.
  double rateHz = 1000;
  double heat = 0;          ///< Of the motors' heat budget in use: 0 cold, 1 all of it.
  double delayS = 0;        ///< haptics::Device::delayS.
  double stiffnessNmm = 0;  ///< What the device is coupled at, at that rate and delay.
  haptics::StylusSample latest;
  std::vector<float> forceN;            ///< Size of the force of the last 2 s, oldest first, 500 a second.
  haptics::ServoStatistics statistics;  ///< At most half a second old while somebody asks.
  uint64_t droppedSamples = 0, watchdogCuts = 0;
};

struct JobView {
  uint64_t id = 0;
  std::string name;     ///< "Exporting bunny.stl".
  double fraction = 0;  ///< 0 to 1.
  double seconds = 0;   ///< Since it began.
};

struct Message {
  enum class Level : uint8_t { done, warning, error };
  Level level = Level::done;
  std::string text;  ///< One sentence, and what to do where something is wrong.
};

/// Members may be called from the thread that shows it, one thread; none waits for edits, files or devices. What goes
/// wrong later comes as a message. The destructor ends the stroke in work, cancels jobs, stops the servo (force zero)
/// and waits.
class Workbench {
 public:
  struct Options {
    std::string device = "pointer";
    bool realtime = true;
    std::string falconFirmware;
    int surfaceThreads = Session::strokeThreads();
    bool journal = true;                         ///< False: nothing is kept but what is saved.
    std::filesystem::path journalFolder;         ///< Empty: io::journalFolder().
    uint64_t undoBytes = UndoBudget::kStandard;  ///< As setUndoBudget() takes it.
    clay::Grade surface = clay::Grade::draft;    ///< As setSurface() takes it.
    /// The edit thread begins no more stamps at a time, 500 times a second; 0: as many as 8 ms hold.
    int stampsATurn = 0;
  };
  explicit Workbench(const Options& options);
  Workbench() : Workbench(Options()) {}
  ~Workbench();
  Workbench(const Workbench&) = delete;
  Workbench& operator=(const Workbench&) = delete;

  [[nodiscard]] std::shared_ptr<const Snapshot> snapshot() const;
  /// Changed surface since the last time.
  [[nodiscard]] SurfaceChanges takeSurfaces();
  /// Everything anew with the next takeSurfaces(): the renderer lost it.
  void resendSurfaces();
  /// Where the vertices of all surfaces stand. Those that are there are made in the background and come whole when all
  /// are ready.
  void setSurface(clay::Grade grade);
  /// What is thinner than this is coloured on all surfaces, from now on and while strokes go on; none: nothing is.
  void showChecks(const std::optional<CheckLimits>& limits);
  [[nodiscard]] std::vector<Message> takeMessages();
  /// A mesh that was read and is being made clay, to be shown meanwhile; null when there is none. World mm.
  [[nodiscard]] std::shared_ptr<const clay::TriangleMesh> preview() const;
  /// Into the list of messages.
  void tell(Message::Level level, std::string text);

  // Edits. Each is one undo step, named by its label; refused with a message while it cannot be done.

  /// Any change of the document but of clay in a stroke. A step with the same `merge` as the last one joins it
  /// (dragging a slider or a widget is one step); empty: never joins. `change` runs on the edit thread on a copy:
  /// capture by value. It may throw Error.
  void edit(std::string label, std::function<void(Document&)> change, std::string merge = {});
  /// From now on edits with this merge key begin a new step: the drag has ended.
  void endMerge();
  /// Switches symmetry: a setting of the hand, no step. Undo and redo leave it as it is. `change` runs on the edit
  /// thread.
  void setSymmetry(std::function<void(Symmetry&)> change);
  /// Of strokes from now on: a setting of the hand as well, saved with the document.
  void setQuality(const StrokeQuality& quality);
  /// Copies of things, as one step: each gets an id and a name of its own. Pieces and parts stand together beside what
  /// is there; the last one becomes Snapshot::made, a piece the active one. Clay is shared with what it was copied
  /// from.
  struct Things {
    std::vector<Piece> pieces;
    std::vector<Part> parts;
    std::vector<Guide> guides;
    [[nodiscard]] bool empty() const { return pieces.empty() && parts.empty() && guides.empty(); }
  };
  void add(std::string label, Things things);
  void undo();
  void redo();
  /// So many steps done: 0 is the beginning. The later ones are kept where another step is made then.
  void goTo(size_t done);
  /// Steps may take so much memory beside the newest document; 0: no limit. The oldest leave it for the disk (the
  /// journal, or a file without a name where there is no journal) and are read again when they are gone to. While the
  /// disk does not take them they stay, with a message.
  void setUndoBudget(uint64_t bytes);

  /// A stroke of the tool in hand along these places (world mm, two at least), as one step: a straight line, a curve.
  void strokeAlong(std::vector<Vec3d> placesMm);

  /// An operation on whole pieces (engine/tools/piece_jobs.h), as a job whose result is one undo step; what it finds
  /// out comes as messages. The pieces may not change meanwhile, or its result is left out. A message when there is no
  /// such operation or it cannot be done.
  void operate(const std::string& id, PieceArguments arguments);

  // Clay that comes and goes, as jobs.

  void newDocument();
  struct NewClay {
    double voxelMm = 0.5;
    Vec3d centreMm = Vec3d::Zero();
    clay::Precision precision = clay::Precision::float32;
    bool beside = false;  ///< Beside what is there, on its ground, wherever `centreMm` is.
  };
  void addBlock(const Vec3d& sizeMm, double roundMm, const NewClay& how);
  void addSphere(double radiusMm, const NewClay& how);
  struct ImportOptions {
    /// These as ImportPlace has them: a model stands upright on the ground, as it is guessed to.
    std::string units = "auto";
    std::string up = "auto";
    std::optional<double> heightMm;
    bool stands = true;                     ///< And beside the pieces that are there.
    std::shared_ptr<const ModelLook> look;  ///< The file, where it was read already.
    std::optional<double> voxelMm;          ///< None: 256 voxels along the longest side.
    clay::Precision precision = clay::Precision::float32;
    std::optional<double> fitMm;  ///< Centred and scaled to this.
    bool asPart = false;          ///< Kept as a mesh: seen and felt, not clay.
    bool guides = false;          ///< Of the faces of a CAD model (ModelImport::guides).
    bool replace = false;         ///< A new document of it.
  };
  void import(const std::filesystem::path& file, const ImportOptions& options);
  /// A saved document (.argil), a script's clay and strokes (.json), a level set or a mesh, as a new document.
  void open(const std::filesystem::path& file);

  // Keeping. See engine/saving/autosave.h for what is durable when.

  /// Saves to where it was opened or saved last, or to another file. A message when it is done or has failed; then the
  /// old file stands. A file that somebody else wrote since it was opened or saved here is not written to
  /// (FileState::refused), nor is one replaced that is open in another window. That a file which is opened here is open
  /// in another window too is told.
  void save(const SaveExtras& extras);
  void saveAs(const std::filesystem::path& file, const SaveExtras& extras);
  /// The document as it is now, without its history, to another file; work goes on with the one that it has. What was
  /// taken out or undone is nowhere in that file.
  void saveCopy(const std::filesystem::path& file, const SaveExtras& extras);
  /// What crashed sessions left, newest first; read in the background once after start. Null until then.
  [[nodiscard]] std::shared_ptr<const std::vector<Recoverable>> recoverable() const;
  /// Opens it as it was, with its steps; it stays unsaved. The journal goes once the recovered document has a journal
  /// of its own.
  void recover(const Recoverable& what, const RecoverChoice& choice = {});
  /// Deletes the journal for good.
  void discard(const Recoverable& what);
  /// This session ends against the person's will: its journal stays behind, to be recovered.
  void leaveJournal();
  void exportTo(const std::vector<std::filesystem::path>& files, const ModelExport& what = {});

  /// The work that is left of a stroke.
  struct StrokeWork {
    bool on = false;  ///< A stroke is in work, or samples of one wait.
    /// So much of the hand's path, in seconds of the hand, is not in the clay yet. It does not grow once the hand has
    /// ended.
    double leftS = 0;
  };
  [[nodiscard]] StrokeWork strokeWork() const;
  /// Nothing is under way: no job, no stroke, no edit or sample that waits. A moment later something may be.
  [[nodiscard]] bool idle() const;
  [[nodiscard]] std::vector<JobView> jobs() const;
  void cancelJob(uint64_t id);

  // The hand

  /// From the next tick on. Sizes that this clay cannot have are brought within its limits.
  void setTool(const Tool& tool);
  /// The hand holds the tool of the last setTool(): what is pressed from now on is done with it.
  [[nodiscard]] bool toolTaken() const;
  /// While false the tool touches and does not cut: the hand is on a widget.
  void setCutting(bool on);
  void setWorkspace(const haptics::Workspace& workspace);
  void setTouchQuality(const haptics::Quality& quality);
  /// A guide of a plugin (FeltGuides) is felt, or no longer. What goes wrong with it is told, and it is off then.
  void feelGuide(const std::string& id, bool on);
  /// Ids of those that are felt. Any thread.
  [[nodiscard]] std::vector<std::string> guidesFelt() const;
  /// By the names of `argil devices`; "pointer": mouse and pen. Closes the one before. Stopped forces stay stopped.
  void useDevice(const std::string& name);
  /// Zero force until a resumeForces() that is called later, whatever else was asked for before or is done meanwhile.
  /// At once, in the calling thread, which may be any. The servo and the stroke in work end as soon as the edit thread
  /// gets to it. A mouse or a pen has no motor: it goes on; the stop waits for the device that is taken after it.
  void stopForces();
  /// Undoes the stops and the faults that there are now, none that comes before it is done: forces begin anew, from
  /// zero. Any thread.
  void resumeForces();
  /// The mouse or the pen, while the device is "pointer".
  void feedPointer(const haptics::PointerSample& sample);
  void pointerLeft();
  [[nodiscard]] bool usesPointer() const;
  /// A simulated device is in hand: steerSimulated() says where its hand wants to be, in the device's frame.
  [[nodiscard]] bool usesSimulated() const;
  void steerSimulated(const haptics::HandPoint& wanted);
  /// Cheap: the newest tick.
  [[nodiscard]] haptics::StylusSample latest();
  /// `statistics` asks for histograms too.
  [[nodiscard]] TouchState touch(bool statistics);

 private:
  struct State;
  void openSaved(const std::filesystem::path& file);
  std::unique_ptr<State> state_;
};

}  // namespace argil::engine
