#pragma once
// What a workbench is made of: the edit thread's side and what both sides share. For engine/workbench*.cpp alone.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

#include "engine/document/jobs.h"
#include "engine/plugins/felt_guides.h"
#include "engine/saving/autosave.h"
#include "engine/saving/session.h"
#include "engine/session/edit_loop.h"
#include "engine/session/force_control.h"
#include "engine/session/workbench.h"
#include "haptics/devices/simulated.h"
#include "haptics/threads/published.h"
#include "io/records/document_presence.h"

namespace argil::engine {

/// Device, servo and what the servo reads: replaced as one.
struct Hand {
  /// `gate` outlives it: stops hold whatever device is in hand.
  Hand(std::unique_ptr<haptics::Device> opened, std::string openedAs, haptics::Published<haptics::Scene>& scene,
       bool realtime, haptics::ForceGate& gate)
      : device(std::move(opened)),
        name(std::move(openedAs)),
        pointer(dynamic_cast<haptics::PointerDevice*>(device.get())),
        simulated(dynamic_cast<haptics::SimulatedDevice*>(device.get())),
        servo(*device, scene, {.realtime = realtime}) {
    device->setGate(gate);
  }
  ~Hand() { servo.stop(); }
  std::unique_ptr<haptics::Device> device;
  std::string name;
  haptics::PointerDevice* pointer;
  haptics::SimulatedDevice* simulated;
  haptics::Servo servo;
  std::string grant;
};

/// How warm the motors of a device were when it was let go.
struct MotorHeat {
  double load = 0;  ///< HeatBudget::load().
  std::chrono::steady_clock::time_point at;
};

inline constexpr size_t kForcePoints = 1000;  ///< Of TouchState::forceN: 2 s.

struct Workbench::State {
  explicit State(const Options& given) : options(given), budget(given.undoBytes) {
    surfaces.setGrade(given.surface);
    wantedSurface = given.surface;
  }

  struct Command {
    std::function<void()> run;
    bool waitsForStroke = true;  ///< Done when the stroke in work has ended.
    /// Does not wait for a tool that is behind the hand: the stroke ends where the clay is.
    bool endsBacklog = false;
  };
  struct Work {
    uint64_t id;
    std::string name;
    std::chrono::steady_clock::time_point begin;
    std::shared_ptr<std::function<void()>> result;  // what the edit thread does when it is done; filled by the job
    std::unique_ptr<BackgroundJob> job;             // last: it uses the result
  };

  using Ready = std::vector<std::shared_ptr<Surfaces::Prepared>>;
  /// Surfaces of pieces that are new to the document: those of the same store as in `before` change little or are made
  /// beside the edit thread. To be held until the pieces are there. Any thread.
  [[nodiscard]] Ready prepare(const std::vector<Piece>& pieces, const Document* before = nullptr);

  void post(std::function<void()> run, bool waitsForStroke = true, bool endsBacklog = false);
  void tell(Message::Level level, std::string text);
  /// Runs `work` on a thread of its own; what it returns is run on the edit thread.
  void begin(std::string name, std::function<std::function<void()>(Job&)> work);

  // The edit thread's.
  void run();
  void runCommands();
  void finishJobs();
  void takeHand(const std::string& name);
  void openFirstHand();
  [[nodiscard]] Vec3d besideClayMm() const;
  /// What a document begins with.
  struct Begin {
    std::vector<HistoryState> states;
    size_t done = 0;
    std::filesystem::path file;  // empty: untitled
    std::string name;            // FileState::name
    std::string readOnly;        // why it must not be saved into that
    std::string face;
    std::shared_ptr<DocumentRecords> documentRecords;  // null: a new one
    std::shared_ptr<const Base> base;
    std::string writer;  // empty: a new one
    std::vector<std::shared_ptr<io::RecordSource>> sources;
    std::optional<Autosave::Continued> continued;
    bool saved = false;  // it is what the file holds, or nothing
  };
  void begin(Begin how);
  void begin(Document document, bool saved = false);
  void save(std::filesystem::path file, const SaveExtras& extras);
  void saveCopy(std::filesystem::path file, const SaveExtras& extras);
  [[nodiscard]] bool isOwn(const std::filesystem::path& target) const;
  void requireNotElsewhere(const std::filesystem::path& target) const;
  void announce();
  void findRecoverable();
  void makeAutosave();
  /// Makes the autosave where there is none yet, and has it begin with the document in work.
  void beginSaving();
  [[nodiscard]] DocumentPtr readSaved(uint64_t kept, const Document& near);
  void keepUndoBudget();
  void makeLoop();
  /// Ends the stroke in work where the clay is, and says what was left out of it, if anything.
  void cutShort(std::string_view why);
  void turn();
  /// Says when the tool falls behind the hand, or samples were lost.
  void tellPace();
  void holdTool();
  /// Puts in the image or the shape that the tool works with; false while it is being read. Throws Error where there is
  /// no file.
  [[nodiscard]] bool takeToolFile(Tool& tool);
  void publish();
  void guarded(const std::function<void()>& what);
  void guardedOnce(std::string& trouble, const std::function<void()>& what) noexcept;
  static std::string sentenceOf(const std::exception& failure);
  void addPiece(const std::string& label, const std::string& name, const clay::Version& version, bool beside);
  /// The move that puts all of them, as they stand, beside what the document has.
  [[nodiscard]] static Vec3d besideAll(const Document& document, const std::vector<Piece>& pieces,
                                       const std::vector<Part>& parts);
  /// The name, with a number where it is taken.
  [[nodiscard]] static std::string nameFor(const Document& document, const std::string& name);
  void noteMade(Id id);
  void tellIdleStrokes();

  const Options options;

  // Shared, guarded by mutex_.
  mutable std::mutex mutex;
  std::condition_variable wake;
  std::deque<Command> commands;
  std::vector<Message> messages;
  std::vector<Work> jobs;
  uint64_t nextJob = 1;
  std::shared_ptr<const Snapshot> snapshot = std::make_shared<const Snapshot>();
  std::vector<float> forces;  // a ring
  size_t forceAt = 0;
  std::shared_ptr<const clay::TriangleMesh> preview;
  std::shared_ptr<const std::vector<Recoverable>> recoverable;
  std::string journalTrouble;
  bool stopping = false;
  bool leaveJournal = false;
  bool busy = false;  // the edit thread is in a command or a turn, or a stroke is on

  std::vector<std::string> guidesFelt;  // ids of `guides`

  haptics::ForceGate gate;  // of whatever device is in hand
  std::mutex handMutex;     // guards `hand` as a pointer: held for a moment by either side
  std::shared_ptr<Hand> hand;

  std::atomic<bool> strokeOn{false};  // as strokeWork() says
  std::atomic<double> strokeLeftS{0};

  Surfaces surfaces;
  std::atomic<clay::Grade> wantedSurface{clay::Grade::draft};

  // The edit thread's alone. The autosave hears of what the session does: it outlives it.
  std::unique_ptr<Autosave> autosave;
  std::filesystem::path file;
  std::string fileName;  // FileState::name
  std::string readOnly;
  uint64_t refused = 0;
  std::string refusal;                                 // why the last save was refused
  std::optional<io::DocumentPresence> presence;        // of the file
  std::chrono::steady_clock::time_point presenceAt{};  // when it was looked at
  void followPresence();
  void tellElsewhere();
  std::shared_ptr<const std::string> face;
  std::shared_ptr<DocumentRecords> documentRecords;
  std::shared_ptr<const Base> base;
  std::string writer;
  std::vector<std::shared_ptr<io::RecordSource>> sources;  // that the document began with
  std::optional<Autosave::Continued> continued;            // a recovered journal that no autosave has taken over yet
  std::string autosaveTrouble, handTrouble;
  bool handOpened = false;                      // the device that the program began with
  std::shared_ptr<SavedHistory> records;        // all places of its steps, while there is an autosave
  std::weak_ptr<const Document> savedDocument;  // a step like any other: it may leave memory
  uint64_t opened = 0;
  bool saving = false;
  std::optional<std::pair<std::filesystem::path, SaveExtras>> saveNext;  // asked for while another was going on
  haptics::Published<haptics::Scene> scene;
  std::map<std::string, std::shared_ptr<PluginGuide>> guides;  // of plugins, that are felt; by id
  std::chrono::steady_clock::time_point guidesAt{};            // when they were looked at
  void feelGuide(const std::string& id, bool on);
  void lookAtGuides();
  void giveGuides();
  std::unique_ptr<Session> session;
  std::unique_ptr<EditLoop> loop;
  std::vector<Command> ran;  // in this turn: what they prepared is there until it has been shown
  bool behindTold = false;   // that the tool cannot keep up with the hand
  uint64_t lostTold = 0;     // samples
  Id madeLast = 0;           // as the snapshot has them
  uint64_t madeCount = 0;
  uint64_t idleTold = 0;  // strokes of the session that changed nothing
  uint64_t keptTold = 0;  // later steps that the session kept
  uint64_t manyTold = 0;  // the document (`opened`) of which it was said that not all its pieces are felt
  Tool wanted;            // as the person has it; fitted to the clay it becomes the loop's
  std::optional<Tool> held;
  bool cutting = true, ready = true;  // the hand holds a tool that can work
  Tool fileRead;                      // the last tool whose file was read
  std::string reading;                // the file that is on its way
  bool oriented = false;              // the device in hand tells how it is turned
  // By the sheet's name: two devices of one kind count as one, which errs to the cool side.
  std::map<std::string, MotorHeat> heats;
  haptics::Workspace workspace;
  /// A document without anything, of the balanced quality.
  [[nodiscard]] static Document fresh();
  haptics::Quality touchQuality;
  haptics::Histogram latency;
  uint64_t sequence = 0, forceEvery = 0;
  DocumentPtr shown;
  std::shared_ptr<const std::vector<std::string>> history = std::make_shared<const std::vector<std::string>>();
  uint64_t historyOf = UINT64_MAX;
  std::chrono::steady_clock::time_point usageAt{};
  uint64_t clayBytes = 0;
  UndoBudget budget;
  UndoUse undo;
  uint64_t undoOf = UINT64_MAX;  // steps of the session when it was looked at
  bool undoTold = false;         // that it takes more than it may

  uint64_t toolWanted = 0;  // number of the setTool() that `wanted` is of

  std::atomic<uint64_t> toolsTaken{0};  // number of the last tool that the servo was given

  // The showing thread's.
  uint64_t toolsAsked = 0;
  haptics::StylusSample newest;
  haptics::ServoStatistics statistics;
  std::chrono::steady_clock::time_point statisticsAt{};

  std::unique_ptr<BackgroundJob> finding;  // what crashed sessions left
  std::thread thread;
};

}  // namespace argil::engine
