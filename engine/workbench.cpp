#include "engine/workbench.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include "clay/error.h"
#include "clay/primitives.h"
#include "clay/store.h"
#include "engine/edit_loop.h"
#include "engine/jobs.h"
#include "engine/mesh_files.h"
#include "engine/prepare_clay.h"
#include "engine/run.h"
#include "engine/session.h"
#include "haptics/clock.h"
#include "haptics/devices/registry.h"
#include "haptics/published.h"

namespace argil::engine {
namespace {

constexpr auto kTurn = std::chrono::milliseconds(2);          // at most 500 versions a second
constexpr auto kIdleTurn = std::chrono::milliseconds(10);     // while no servo runs
constexpr auto kUsageEvery = std::chrono::milliseconds(250);
constexpr auto kStatisticsEvery = std::chrono::milliseconds(500);
constexpr size_t kForcePoints = 1000;                         // 2 s
constexpr const char* kPointer = "pointer";

/// Device, servo and what the servo reads: replaced as one.
struct Hand {
  Hand(std::unique_ptr<haptics::Device> opened, std::string openedAs, haptics::Published<haptics::Scene>& scene, bool realtime)
      : device(std::move(opened)),
        name(std::move(openedAs)),
        pointer(dynamic_cast<haptics::PointerDevice*>(device.get())),
        servo(*device, scene, {.realtime = realtime}) {}
  ~Hand() { servo.stop(); }
  std::unique_ptr<haptics::Device> device;
  std::string name;
  haptics::PointerDevice* pointer;
  haptics::Servo servo;
  std::string grant;
};

}  // namespace

struct Workbench::State {
  explicit State(const Options& given) : options(given) {}

  struct Command {
    std::function<void()> run;
    bool waitsForStroke = true;  ///< Done when the stroke in work has ended.
  };
  struct Work {
    uint64_t id;
    std::string name;
    std::chrono::steady_clock::time_point begin;
    std::shared_ptr<std::function<void()>> result;  // what the edit thread does when it is done; filled by the job
    std::unique_ptr<BackgroundJob> job;             // last: it uses the result
  };

  void post(std::function<void()> run, bool waitsForStroke = true);
  void tell(Message::Level level, std::string text);
  /// Runs `work` on a thread of its own; what it returns is run on the edit thread.
  void begin(std::string name, std::function<std::function<void()>(Job&)> work);

  // The edit thread's.
  void run();
  void runCommands();
  void finishJobs();
  void takeHand(const std::string& name);
  void begin(Document document);
  void makeLoop();
  void holdTool();
  void publish();
  void guarded(const std::function<void()>& what);
  void addPiece(const std::string& label, const std::string& name, const clay::Version& version);

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
  bool stopping = false;
  bool busy = false;          // the edit thread is in a command or a turn, or a stroke is on

  std::mutex handMutex;       // guards `hand` as a pointer: held for a moment by either side
  std::shared_ptr<Hand> hand;
  std::atomic<bool> stopped{false};  // forces, by the person

  Surfaces surfaces;

  // The edit thread's alone.
  haptics::Published<haptics::Scene> scene;
  std::unique_ptr<Session> session;
  std::unique_ptr<EditLoop> loop;
  Tool wanted;                // as the person has it; fitted to the clay it becomes the loop's
  std::optional<Tool> held;
  haptics::Workspace workspace;
  haptics::Quality touchQuality;
  haptics::Histogram latency;
  uint64_t sequence = 0, forceEvery = 0;
  DocumentPtr shown;
  std::shared_ptr<const std::vector<std::string>> history = std::make_shared<const std::vector<std::string>>();
  uint64_t historyOf = UINT64_MAX;
  std::chrono::steady_clock::time_point usageAt{};
  uint64_t clayBytes = 0;

  // The showing thread's.
  haptics::StylusSample newest;
  haptics::ServoStatistics statistics;
  std::chrono::steady_clock::time_point statisticsAt{};

  std::thread thread;
};

void Workbench::State::post(std::function<void()> run, bool waitsForStroke) {
  {
    const std::lock_guard lock(mutex);
    commands.push_back({std::move(run), waitsForStroke});
  }
  wake.notify_one();
}

void Workbench::State::tell(Message::Level level, std::string text) {
  const std::lock_guard lock(mutex);
  messages.push_back({level, std::move(text)});
}

void Workbench::State::guarded(const std::function<void()>& what) {
  try {
    what();
  } catch (const Cancelled&) {
    tell(Message::Level::warning, "Cancelled; nothing was changed.");
  } catch (const std::bad_alloc&) {
    tell(Message::Level::error, "There is not enough memory for that; use a larger voxel or close another document. Nothing was changed.");
  } catch (const std::exception& e) {
    tell(Message::Level::error, e.what());
  }
}

void Workbench::State::begin(std::string name, std::function<std::function<void()>(Job&)> work) {
  auto result = std::make_shared<std::function<void()>>();
  Work entry{0, std::move(name), std::chrono::steady_clock::now(), result, nullptr};
  const std::lock_guard lock(mutex);
  entry.id = nextJob++;
  entry.job = std::make_unique<BackgroundJob>([this, result, work = std::move(work)](Job& job) {
    struct Wake {
      std::condition_variable& wake;
      ~Wake() { wake.notify_one(); }
    } const notify{wake};
    *result = work(job);
  });
  jobs.push_back(std::move(entry));
}

void Workbench::State::finishJobs() {
  std::vector<Work> done;
  {
    const std::lock_guard lock(mutex);
    for (auto at = jobs.begin(); at != jobs.end();) {
      if (!at->job->done()) {
        ++at;
        continue;
      }
      done.push_back(std::move(*at));
      at = jobs.erase(at);
    }
    busy = busy || !done.empty();
  }
  for (Work& work : done) {
    guarded([&] {
      work.job->wait();
      if (*work.result) post(std::move(*work.result));
    });
  }
}

void Workbench::State::runCommands() {
  std::deque<Command> kept;
  for (;;) {
    Command next;
    {
      const std::lock_guard lock(mutex);
      if (commands.empty()) {
        // In the order in which they came, those first that waited.
        commands.swap(kept);
        return;
      }
      next = std::move(commands.front());
      commands.pop_front();
      busy = true;
    }
    // Behind one that waits, all that waits too: their order matters.
    if (next.waitsForStroke && session->inStroke()) {
      kept.push_back(std::move(next));
    } else {
      guarded(next.run);
    }
  }
}

void Workbench::State::makeLoop() {
  EditLoop::Options loopOptions;
  loopOptions.onDocument = [this](const DocumentPtr& document, int64_t oldestNs) { surfaces.follow(*document, oldestNs, options.surfaceThreads); };
  loopOptions.onSample = [this](const haptics::StylusSample& sample) {
    if (++forceEvery % 2 != 0) return;
    const std::lock_guard lock(mutex);
    if (forces.size() < kForcePoints) forces.resize(kForcePoints, 0);
    forces[forceAt++ % kForcePoints] = static_cast<float>(sample.forceN.norm());
  };
  loopOptions.latency = &latency;
  loopOptions.paced = true;
  haptics::Scene base;
  base.workspace = workspace;
  base.quality = touchQuality;
  loop = std::make_unique<EditLoop>(*session, base, [this](std::unique_ptr<const haptics::Scene> next) { scene.publish(std::move(next)); }, loopOptions);
  held.reset();
  holdTool();
}

void Workbench::State::begin(Document document) {
  if (loop) loop->finish();
  loop.reset();
  session = std::make_unique<Session>(std::move(document));
  surfaces.forget();
  historyOf = UINT64_MAX;
  makeLoop();
  latency.clear();
}

// A tool's size must fit the voxels of the piece that it is used on.
void Workbench::State::holdTool() {
  Tool tool = wanted;
  const DocumentPtr now = session->document();
  if (const Piece* piece = now->workedOn()) {
    const double voxel = piece->version.grid().voxelMm;
    tool.radiusMm = std::clamp(tool.radiusMm, kLeastToolVoxels * voxel, kMostToolVoxels * voxel);
  }
  if (held == tool) return;
  loop->setTool(tool);
  held = tool;
}

void Workbench::State::takeHand(const std::string& name) {
  std::shared_ptr<Hand> old;
  {
    const std::lock_guard lock(handMutex);
    old = std::exchange(hand, nullptr);
  }
  if (loop) loop->finish();
  if (old) {
    old->servo.stop();
    while (old.use_count() > 1) std::this_thread::yield();  // the other side holds it for a moment only
    old.reset();                                            // the same hardware may be opened again
  }
  const auto open = [&](const std::string& as) {
    haptics::OpenDeviceOptions how;
    how.falconFirmware = options.falconFirmware;
    std::unique_ptr<haptics::Device> device =
        as == kPointer ? std::make_unique<haptics::PointerDevice>() : haptics::openDevice(as, how);
    return std::make_shared<Hand>(std::move(device), as, scene, options.realtime);
  };
  std::shared_ptr<Hand> fresh;
  try {
    fresh = open(name);
  } catch (const Error& e) {
    tell(Message::Level::error, fmt::format("{} The mouse stands in.", e.what()));
    fresh = open(kPointer);
  }
  makeLoop();  // the new servo counts its samples from zero
  fresh->grant = fresh->servo.start().sentence;
  stopped.store(false);
  const std::lock_guard lock(handMutex);
  hand = std::move(fresh);
}

void Workbench::State::publish() {
  const DocumentPtr now = session->document();
  const auto time = std::chrono::steady_clock::now();
  if (time - usageAt > kUsageEvery) {
    usageAt = time;
    uint64_t bytes = 0;
    std::vector<const clay::Store*> stores;
    for (const Piece& piece : now->pieces) {
      const clay::Store* store = piece.version.store().get();
      if (std::find(stores.begin(), stores.end(), store) != stores.end()) continue;
      stores.push_back(store);
      bytes += store->usage().bytes();
    }
    clayBytes = bytes;
  }
  const bool inStroke = session->inStroke();
  const uint64_t steps = session->undoSteps() + session->redoSteps();
  const uint64_t historyNow = inStroke ? historyOf : session->steps();
  const Snapshot& last = *snapshot;  // written by this thread alone
  if (now == shown && last.inStroke == inStroke && historyNow == historyOf && last.done == session->undoSteps() && last.clayBytes == clayBytes &&
      last.tool == held.value_or(Tool())) {
    return;
  }
  if (historyNow != historyOf || history->size() != steps) {
    history = std::make_shared<const std::vector<std::string>>(session->history());
    historyOf = historyNow;
  }
  shown = now;
  auto next = std::make_shared<Snapshot>();
  next->sequence = ++sequence;
  next->document = now;
  next->history = history;
  next->done = session->undoSteps();
  next->inStroke = inStroke;
  next->tool = held.value_or(Tool());
  next->strokes = session->counts().strokes;
  next->points = session->counts().points;
  next->versions = loop->versions();
  next->clayBytes = clayBytes;
  next->editP50Us = latency.quantileUs(0.5);
  next->editP99Us = latency.quantileUs(0.99);
  std::shared_ptr<const Snapshot> old = std::move(next);
  const std::lock_guard lock(mutex);
  snapshot.swap(old);
}

void Workbench::State::run() {
  begin(Document());
  guarded([this] { takeHand(options.device); });
  publish();
  auto next = std::chrono::steady_clock::now();
  for (;;) {
    finishJobs();
    runCommands();
    guarded([this] {
      try {
        holdTool();
        // Nobody but this thread replaces the hand.
        if (hand) {
          loop->turn(hand->servo.samples());
        } else {
          haptics::SampleRing none(1);
          loop->turn(none);
        }
      } catch (...) {
        // What a stroke has done so far stays.
        if (session->inStroke()) session->endStroke();
        throw;
      }
    });
    publish();
    std::unique_lock lock(mutex);
    busy = session->inStroke();
    if (stopping) break;
    const auto turn = hand && hand->servo.running() ? kTurn : kIdleTurn;
    next = std::max(next + turn, std::chrono::steady_clock::now());
    wake.wait_until(lock, next, [this] { return stopping || (!commands.empty() && !busy); });
  }
  guarded([this] { loop->finish(); });
  {
    const std::lock_guard lock(handMutex);
    hand.reset();
  }
  publish();
  shown.reset();
}

void Workbench::State::addPiece(const std::string& label, const std::string& name, const clay::Version& version) {
  session->change(label, [&](Document& document) {
    Piece piece;
    piece.name = name;
    piece.version = version;
    document.active = document.add(std::move(piece));
  });
}

Workbench::Workbench(const Options& options) : state_(std::make_unique<State>(options)) {
  Snapshot first;
  first.document = std::make_shared<const Document>();
  first.history = state_->history;
  state_->snapshot = std::make_shared<const Snapshot>(std::move(first));
  state_->thread = std::thread([state = state_.get()] { state->run(); });
}

Workbench::~Workbench() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stopping = true;
  }
  state_->wake.notify_one();
  state_->thread.join();
  state_->jobs.clear();  // cancels and waits
}

std::shared_ptr<const Snapshot> Workbench::snapshot() const {
  const std::lock_guard lock(state_->mutex);
  return state_->snapshot;
}

SurfaceChanges Workbench::takeSurfaces() { return state_->surfaces.take(); }

void Workbench::resendSurfaces() {
  state_->post([s = state_.get()] {
    s->surfaces.forget();
    s->surfaces.follow(*s->session->document(), 0, s->options.surfaceThreads);
  }, false);
}

std::vector<Message> Workbench::takeMessages() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->messages, {});
}

void Workbench::tell(Message::Level level, std::string text) { state_->tell(level, std::move(text)); }

void Workbench::edit(std::string label, std::function<void(Document&)> change, std::string merge) {
  state_->post([s = state_.get(), label = std::move(label), change = std::move(change), merge = std::move(merge)] {
    s->session->change(label, [&](Document& document) {
      change(document);
      (void)sceneOf(document, haptics::Scene());  // what cannot be felt is refused here, not in mid-touch
    }, merge);
  });
}

void Workbench::endMerge() {
  state_->post([s = state_.get()] { s->session->endMerge(); });
}

void Workbench::undo() {
  state_->post([s = state_.get()] {
    if (!s->session->undo()) s->tell(Message::Level::warning, "There is nothing to undo.");
  });
}

void Workbench::redo() {
  state_->post([s = state_.get()] {
    if (!s->session->redo()) s->tell(Message::Level::warning, "There is nothing to redo.");
  });
}

void Workbench::goTo(size_t done) {
  state_->post([s = state_.get(), done] { s->session->goTo(done); });
}

void Workbench::newDocument() {
  state_->post([s = state_.get()] { s->begin(Document()); });
}

void Workbench::addBlock(const Vec3d& sizeMm, double roundMm, double voxelMm, const Vec3d& centreMm) {
  state_->begin("Making a block", [=, s = state_.get()](Job&) -> std::function<void()> {
    clay::Grid grid;
    grid.voxelMm = voxelMm;
    grid.originMm = centreMm;
    const clay::Version version = clay::makeBlock(clay::Store::make(), grid, centreMm, sizeMm, roundMm);
    return [=] { s->addPiece("Add block", "Block", version); };
  });
}

void Workbench::addSphere(double radiusMm, double voxelMm, const Vec3d& centreMm) {
  state_->begin("Making a sphere", [=, s = state_.get()](Job&) -> std::function<void()> {
    clay::Grid grid;
    grid.voxelMm = voxelMm;
    grid.originMm = centreMm;
    const clay::Version version = clay::makeSphere(clay::Store::make(), grid, centreMm, radiusMm);
    return [=] { s->addPiece("Add sphere", "Sphere", version); };
  });
}

void Workbench::import(const std::filesystem::path& file, const ImportOptions& how) {
  state_->begin("Importing " + file.filename().string(), [=, s = state_.get()](Job& job) -> std::function<void()> {
    const std::string name = file.stem().string();
    MeshImport given;
    given.units = how.units;
    given.voxelMm = how.voxelMm;
    given.fitMm = how.fitMm;
    given.asPart = how.asPart;
    auto imported = std::make_shared<ImportedThing>(importMesh(file, given, &job));
    return [=] {
      Document document;
      const auto add = [&](Document& to) {
        if (imported->part) {
          imported->part->name = name;
          to.add(*imported->part);
        } else {
          Piece piece;
          piece.name = name;
          piece.version = imported->version;
          to.active = to.add(std::move(piece));
        }
      };
      if (how.replace) {
        add(document);
        s->begin(std::move(document));
      } else {
        s->session->change("Import " + name, add);
      }
      for (const std::string& note : imported->notes) s->tell(Message::Level::done, file.filename().string() + ": " + note);
    };
  });
}

void Workbench::open(const std::filesystem::path& file) {
  if (file.extension() != ".json") {
    ImportOptions how;
    how.replace = true;
    import(file, how);
    return;
  }
  state_->begin("Opening " + file.filename().string(), [=, s = state_.get()](Job& job) -> std::function<void()> {
    const Script script = readScript(file);
    PrepareOptions prepare;
    prepare.job = &job;
    PreparedClay clay = prepareClay(clay::Store::make(), script, prepare);
    Document document = Document::of(clay.version);
    document.pieces[0].name = file.stem().string();
    document.pieces[0].material = script.material;
    // In a session of its own; its newest document is what is opened.
    Session session(std::move(document));
    clay::Surface surface(false);
    RunOptions run;
    run.job = &job;
    runScript(session, surface, script, run);
    const DocumentPtr made = session.document();
    return [=] {
      s->begin(*made);
      for (const std::string& note : clay.notes) s->tell(Message::Level::done, file.filename().string() + ": " + note);
    };
  });
}

void Workbench::exportTo(const ExportOptions& how) {
  if (how.files.empty()) return;
  const DocumentPtr document = snapshot()->document;
  const std::string first = how.files.front().filename().string();
  state_->begin("Exporting " + first, [=, s = state_.get()](Job& job) -> std::function<void()> {
    const clay::TriangleMesh mesh = meshOf(*document, how.piece, how.visibleOnly, &job);
    for (const std::filesystem::path& file : how.files) {
      const std::string sentence = writeMeshFile(file, mesh, &job);
      s->tell(Message::Level::done, sentence);
    }
    return {};
  });
}

bool Workbench::idle() const {
  {
    const std::lock_guard lock(state_->handMutex);
    if (state_->hand && state_->hand->servo.samples().size() > 4) return false;
  }
  const std::lock_guard lock(state_->mutex);
  return state_->commands.empty() && state_->jobs.empty() && !state_->busy && !state_->snapshot->inStroke;
}

std::vector<JobView> Workbench::jobs() const {
  std::vector<JobView> views;
  const auto now = std::chrono::steady_clock::now();
  const std::lock_guard lock(state_->mutex);
  for (const State::Work& work : state_->jobs) {
    views.push_back({work.id, work.name, work.job->job().fraction(), std::chrono::duration<double>(now - work.begin).count()});
  }
  return views;
}

void Workbench::cancelJob(uint64_t id) {
  const std::lock_guard lock(state_->mutex);
  for (State::Work& work : state_->jobs) {
    if (work.id == id) work.job->job().cancel();
  }
}

void Workbench::setTool(const Tool& tool) {
  state_->post([s = state_.get(), tool] { s->wanted = tool; }, false);
}

void Workbench::setWorkspace(const haptics::Workspace& workspace) {
  state_->post([s = state_.get(), workspace] {
    s->loop->setWorkspace(workspace);
    s->workspace = workspace;
  }, false);
}

void Workbench::setTouchQuality(const haptics::Quality& quality) {
  state_->post([s = state_.get(), quality] {
    s->loop->setQuality(quality);
    s->touchQuality = quality;
  }, false);
}

void Workbench::useDevice(const std::string& name) {
  state_->post([s = state_.get(), name] { s->takeHand(name); });
}

void Workbench::stopForces() {
  state_->stopped.store(true);
  {
    const std::lock_guard lock(state_->handMutex);
    if (state_->hand) state_->hand->device->cut();
  }
  state_->post([s = state_.get()] {
    s->loop->finish();
    if (s->hand && s->stopped.load()) s->hand->servo.stop();
  }, false);
}

void Workbench::resumeForces() {
  state_->post([s = state_.get()] {
    s->stopped.store(false);
    if (!s->hand) return;
    s->hand->servo.stop();
    s->hand->servo.reset();
    s->hand->device->rearm();
    s->hand->grant = s->hand->servo.start().sentence;
    s->loop->restartClock();
  }, false);
}

void Workbench::feedPointer(const haptics::PointerSample& sample) {
  const std::lock_guard lock(state_->handMutex);
  if (state_->hand && state_->hand->pointer) state_->hand->pointer->feed(sample);
}

void Workbench::pointerLeft() {
  const std::lock_guard lock(state_->handMutex);
  if (state_->hand && state_->hand->pointer) state_->hand->pointer->leave();
}

bool Workbench::usesPointer() const {
  const std::lock_guard lock(state_->handMutex);
  return !state_->hand || state_->hand->pointer != nullptr;
}

haptics::StylusSample Workbench::latest() {
  const std::lock_guard lock(state_->handMutex);
  if (state_->hand) state_->hand->servo.latest().load(state_->newest);
  return state_->newest;
}

TouchState Workbench::touch(bool statistics) {
  TouchState view;
  view.latest = latest();
  {
    const std::lock_guard lock(state_->handMutex);
    if (Hand* hand = state_->hand.get()) {
      view.device = hand->name;
      view.sheet = hand->device->sheet();
      view.deviceStatus = hand->device->status();
      view.state = hand->servo.state();
      view.sentence = state_->stopped.load()                         ? "Forces are stopped by you; resume when you are ready."
                      : hand->servo.fault() != haptics::Fault::none ? haptics::sentence(hand->servo.fault())
                                                                     : haptics::sentence(view.state);
      view.grant = hand->grant;
      view.rateHz = hand->servo.rateHz();
      view.droppedSamples = hand->servo.samples().dropped();
      view.watchdogCuts = hand->servo.watchdogCuts();
      const auto now = std::chrono::steady_clock::now();
      if (statistics && now - state_->statisticsAt > kStatisticsEvery) {
        state_->statisticsAt = now;
        hand->servo.copyStatistics(state_->statistics);
      }
    } else {
      view.sentence = "No device is open.";
    }
  }
  if (statistics) view.statistics = state_->statistics;
  const std::lock_guard lock(state_->mutex);
  view.forceN.reserve(kForcePoints);
  if (!state_->forces.empty()) {
    for (size_t i = 0; i < kForcePoints; ++i) view.forceN.push_back(state_->forces[(state_->forceAt + i) % kForcePoints]);
  }
  return view;
}

}  // namespace argil::engine
