// The edit thread of a workbench.

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "clay/error.h"
#include "clay/store.h"
#include "engine/workbench_state.h"
#include "haptics/devices/registry.h"
#include "engine/tool_table.h"
#include "engine/tool_text.h"

namespace argil::engine {
namespace {

constexpr auto kTurn = std::chrono::milliseconds(2);          // at most 500 versions a second
constexpr auto kIdleTurn = std::chrono::milliseconds(10);     // while no servo runs
constexpr auto kUsageEvery = std::chrono::milliseconds(250);
constexpr const char* kPointer = "pointer";

}  // namespace

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
  haptics::Scene touched;
  touched.workspace = workspace;
  touched.quality = touchQuality;
  loop = std::make_unique<EditLoop>(*session, touched, [this](std::unique_ptr<const haptics::Scene> next) { scene.publish(std::move(next)); }, loopOptions);
  loop->setCutting(cutting && ready);
  loop->setOriented(oriented);
  held.reset();
  holdTool();
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
  held = tool;
  // A tool that lacks something touches and does not work; that is said once.
  ready = true;
  try {
    ready = takeToolFile(tool);
    if (ready) (void)brushOf(tool, clay::Grid());
    held = tool;
  } catch (const Error& e) {
    ready = false;
    tell(Message::Level::warning, e.what());
  }
  loop->setTool(tool);
  loop->setCutting(cutting && ready);
}

// A large image takes seconds: it is read beside the strokes of other tools. The last one stays, as keys that are held change the tool for a moment.
bool Workbench::State::takeToolFile(Tool& tool) {
  const ToolFile kind = rowOf(tool).file;
  if (fileRead.file == tool.file && !tool.file.empty()) {
    if (kind == ToolFile::image) tool.image = fileRead.image;
    if (kind == ToolFile::shape) tool.shape = fileRead.shape;
  }
  if (kind == ToolFile::none || tool.file.empty() || tool.image || tool.shape) {
    loadToolFile(tool);  // Says what is missing.
    return true;
  }
  if (std::exchange(reading, tool.file) == tool.file) return false;
  begin("Reading " + std::filesystem::path(tool.file).filename().string(), [this, tool](Job&) -> std::function<void()> {
    auto read = std::make_shared<Tool>(tool);
    std::string trouble;
    try {
      loadToolFile(*read);
    } catch (const std::exception& e) {
      trouble = e.what();
    }
    return [this, read, trouble] {
      if (reading == read->file) reading.clear();
      if (!trouble.empty()) {
        tell(Message::Level::error, trouble);
        return;
      }
      fileRead = *read;
      if (!held || held->file != read->file) return;
      held.reset();
      holdTool();
    };
  });
  return false;
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
  oriented = fresh->device->sheet().dofIn == 6 && !fresh->pointer;
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
    undoOf = UINT64_MAX;
  }
  const bool inStroke = session->inStroke();
  if (!inStroke && undoOf != session->steps()) keepUndoBudget();
  const uint64_t steps = session->undoSteps() + session->redoSteps();
  const uint64_t historyNow = inStroke ? historyOf : session->steps();
  const Snapshot& last = *snapshot;  // written by this thread alone
  FileState kept;
  kept.path = file;
  kept.unsaved = now != savedDocument.lock();
  kept.saving = saving;
  kept.readOnly = readOnly;
  kept.refused = refused;
  kept.opened = opened;
  kept.face = face;
  {
    const std::lock_guard lock(mutex);
    kept.journalTrouble = journalTrouble;
  }
  if (now == shown && last.inStroke == inStroke && historyNow == historyOf && last.done == session->undoSteps() && last.clayBytes == clayBytes && last.undo == undo &&
      last.tool == held.value_or(Tool()) && last.file == kept) {
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
  next->undo = undo;
  next->editP50Us = latency.quantileUs(0.5);
  next->editP99Us = latency.quantileUs(0.99);
  next->file = std::move(kept);
  std::shared_ptr<const Snapshot> old = std::move(next);
  const std::lock_guard lock(mutex);
  snapshot.swap(old);
}

void Workbench::State::run() {
  begin(Document(), true);
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
  session->setWatch(nullptr);
  if (keeper && leaveJournal) keeper->leave();
  keeper.reset();
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

}  // namespace argil::engine
