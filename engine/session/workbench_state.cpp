// The edit thread of a workbench.

#include "engine/session/workbench_state.h"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <system_error>
#include <unordered_set>
#include <utility>

#include "clay/base/error.h"
#include "clay/store/store.h"
#include "clay/whole/deform.h"
#include "engine/document/beside.h"
#include "engine/models/tool_file.h"
#include "engine/text/tool_text.h"
#include "engine/tools/tool_table.h"
#include "haptics/devices/registry.h"

namespace argil::engine {
namespace {

constexpr auto kTurn = std::chrono::milliseconds(2);       // at most 500 versions a second
constexpr auto kIdleTurn = std::chrono::milliseconds(10);  // while no servo runs
constexpr auto kUsageEvery = std::chrono::milliseconds(250);
constexpr auto kPresenceEvery = std::chrono::seconds(1);  // Other windows come and go.
constexpr const char* kPointer = "pointer";
constexpr double kAnswerS = 0.1;   // a tool that is no farther behind the hand ends its stroke soon enough by itself
constexpr double kBehindTold = 1;  // seconds: less is a computer that was busy for a moment
constexpr size_t kMostWaiting = 200'000;  // samples, 40 MB: what coalescing cannot bound

}  // namespace

void Workbench::State::post(std::function<void()> run, bool waitsForStroke, bool endsBacklog) {
  {
    const std::lock_guard lock(mutex);
    commands.push_back({std::move(run), waitsForStroke, endsBacklog});
  }
  wake.notify_one();
}

Workbench::State::Ready Workbench::State::prepare(const std::vector<Piece>& pieces, const Document* before) {
  Ready made;
  for (const Piece& piece : pieces) {
    const Piece* was = before ? before->piece(piece.id) : nullptr;
    if (was && was->version.store() == piece.version.store() && was->version.grid() == piece.version.grid()) continue;
    made.push_back(surfaces.prepare(piece.version));
  }
  return made;
}

void Workbench::State::tell(Message::Level level, std::string text) {
  const std::lock_guard lock(mutex);
  messages.push_back({level, std::move(text)});
}

std::string Workbench::State::sentenceOf(const std::exception& failure) {
  if (dynamic_cast<const std::bad_alloc*>(&failure))
    return "There is not enough memory for that; use a larger voxel or close another document. Nothing was changed.";
  if (dynamic_cast<const std::system_error*>(&failure))
    return fmt::format(
        "The system refused what that needs ({}); close other programs and try again. Nothing was changed.",
        failure.what());
  return failure.what();
}

void Workbench::State::guarded(const std::function<void()>& what) {
  try {
    what();
  } catch (const Cancelled&) {
    tell(Message::Level::warning, "Cancelled; nothing was changed.");
  } catch (const std::exception& e) {
    tell(Message::Level::error, sentenceOf(e));
  }
}

// For what is done again every few milliseconds: the same trouble is told once, until it has worked again. Nothing
// leaves it, as nobody is left to catch it.
void Workbench::State::guardedOnce(std::string& trouble, const std::function<void()>& what) noexcept {
  try {
    try {
      what();
      trouble.clear();
    } catch (const std::exception& e) {
      const std::string sentence = sentenceOf(e);
      if (std::exchange(trouble, sentence) != sentence) tell(Message::Level::error, sentence);
    }
  } catch (const std::exception&) {  // no memory even for the sentence: it is tried again
  }
}

void Workbench::State::begin(std::string name, std::function<std::function<void()>(Job&)> work) {
  guarded([&] {
    auto result = std::make_shared<std::function<void()>>();
    Work entry{0, std::move(name), std::chrono::steady_clock::now(), result, nullptr};
    entry.job = std::make_unique<BackgroundJob>([this, result, work = std::move(work)](Job& job) {
      struct Wake {
        std::condition_variable& wake;
        ~Wake() { wake.notify_one(); }
      } const notify{wake};
      *result = work(job);
    });
    const std::lock_guard lock(mutex);
    entry.id = nextJob++;
    jobs.push_back(std::move(entry));
  });
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

void Workbench::State::cutShort(std::string_view why) {
  const double seconds = loop ? loop->cutShort() : 0;
  if (seconds >= kAnswerS)
    tell(Message::Level::warning,
         fmt::format("{}: the stroke ends where the clay was, {:.1f} s behind the hand.", why, seconds));
}

void Workbench::State::tellPace() {
  const double behind = loop->behindS();
  if (behind < kAnswerS) {
    behindTold = false;
  } else if (behind > kBehindTold && !behindTold) {
    behindTold = true;
    tell(Message::Level::warning, fmt::format("The tool cannot keep up: {} is {:.0f} s behind the hand and goes on. A "
                                              "smaller radius is faster; undo ends the stroke where the clay is.",
                                              held ? rowOf(*held).name : "the clay", behind));
  }
  if (loop->lost() > lostTold) {
    tell(Message::Level::warning, fmt::format("The computer was too busy to follow the hand: {} positions of it were "
                                              "lost, and the stroke has a gap there.",
                                              loop->lost() - lostTold));
    lostTold = loop->lost();
  }
  if (loop->visiblePieces() > haptics::kMaxPieces && manyTold != opened) {
    manyTold = opened;
    tell(Message::Level::warning, fmt::format("{} pieces are visible: the hand feels the {} that are nearest to it. "
                                              "Hide some, or join them, to feel all.",
                                              loop->visiblePieces(), haptics::kMaxPieces));
  }
  if (loop->waiting() > kMostWaiting) cutShort("The tool cannot keep up");
}

void Workbench::State::turn() {
  // Where there was no memory or no thread for them a moment ago.
  if (!session) begin(fresh(), true);
  if (!loop) makeLoop();
  if (!handOpened) openFirstHand();
  // Samples of a ring that nobody empties would be lost.
  if (hand) loop->gather(hand->servo.samples());
  finishJobs();
  runCommands();
  lookAtGuides();
  if (!loop) return;  // the next turn makes it
  try {
    holdTool();
    // Nobody but this thread replaces the hand.
    if (hand) {
      loop->turn(hand->servo.samples());
    } else {
      haptics::SampleRing none(1);
      loop->turn(none);
    }
    toolsTaken.store(toolWanted);
    tellIdleStrokes();
    if (surfaces.arrived()) surfaces.follow(*session->document(), 0, options.surfaceThreads);
    tellPace();
  } catch (...) {
    // What a stroke has done so far stays; one that cannot even be ended leaves no trace.
    if (session->inStroke()) {
      try {
        (void)loop->cutShort();
      } catch (const std::exception&) {  // said below, once
      }
    }
    throw;
  }
}

// Those of plugins, in the loop that there is.
void Workbench::State::giveGuides() {
  std::vector<haptics::Guide> felt;
  std::vector<std::string> ids;
  for (const auto& [id, guide] : guides) {
    felt.push_back({static_cast<uint32_t>(felt.size() + 1), haptics::FollowModel{guide}});
    ids.push_back(id);
  }
  if (loop) loop->setGuides(std::move(felt));
  const std::lock_guard lock(mutex);
  guidesFelt = std::move(ids);
}

void Workbench::State::feelGuide(const std::string& id, bool on) {
  if (on && !guides.contains(id)) {
    const FeltGuide* guide = feltGuides().find(id);
    if (!guide) throw Error(fmt::format("there is no guide {}", id));
    guides[id] = guide->begin();
  } else if (!on) {
    guides.erase(id);
  }
  giveGuides();
}

// One whose plugin has ended has faded by itself: it goes, and it is told.
void Workbench::State::lookAtGuides() {
  constexpr auto kEvery = std::chrono::milliseconds(100);
  if (guides.empty()) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - guidesAt < kEvery) return;
  guidesAt = now;
  for (auto it = guides.begin(); it != guides.end(); ++it) {
    try {
      it->second->look();
    } catch (const Error& error) {
      tell(Message::Level::error, fmt::format("{}; its guide is felt no longer", error.what()));
      guides.erase(it);
      return giveGuides();
    }
  }
}

void Workbench::State::runCommands() {
  bool ends = false;
  {
    const std::lock_guard lock(mutex);
    ends = std::any_of(commands.begin(), commands.end(), [](const Command& each) { return each.endsBacklog; });
  }
  if (ends && loop->behindS() > kAnswerS) guarded([this] { cutShort("Undone while the tool was behind"); });
  std::deque<Command> kept;
  for (;;) {
    Command next;
    {
      const std::lock_guard lock(mutex);
      if (commands.empty() || !loop) {
        // In the order in which they came, those first that waited.
        commands.insert(commands.begin(), std::make_move_iterator(kept.begin()), std::make_move_iterator(kept.end()));
        return;
      }
      next = std::move(commands.front());
      commands.pop_front();
      busy = true;
    }
    // Behind one that waits, all that waits too: their order matters.
    // Samples that wait were there before it: what the hand did first comes first.
    if (next.waitsForStroke && (session->inStroke() || loop->behind())) {
      kept.push_back(std::move(next));
    } else {
      guarded(next.run);
      ran.push_back(std::move(next));
    }
  }
}

Document Workbench::State::fresh() {
  Document document;
  document.quality = findQualityPreset("balanced")->quality.strokes;
  return document;
}

void Workbench::State::makeLoop() {
  EditLoop::Options loopOptions;
  loopOptions.onDocument = [this](const DocumentPtr& document, int64_t oldestNs) {
    surfaces.follow(*document, oldestNs, options.surfaceThreads);
  };
  loopOptions.onSample = [this](const haptics::StylusSample& sample) {
    if (++forceEvery % 2 != 0) return;
    const std::lock_guard lock(mutex);
    if (forces.size() < kForcePoints) forces.resize(kForcePoints, 0);
    forces[forceAt++ % kForcePoints] = static_cast<float>(sample.forceN.norm());
  };
  loopOptions.latency = &latency;
  loopOptions.paced = true;
  loopOptions.budgetNs = EditLoop::kTurnBudgetNs;
  loopOptions.budgetStamps = options.stampsATurn;
  haptics::Scene touched;
  touched.workspace = workspace;
  touched.quality = touchQuality;
  loop = std::make_unique<EditLoop>(
      *session, touched, [this](std::unique_ptr<const haptics::Scene> next) { scene.publish(std::move(next)); },
      loopOptions);
  loop->setCutting(cutting && ready);
  loop->setOriented(oriented);
  giveGuides();
  lostTold = 0;
  held.reset();
  holdTool();
}

// A tool's size must fit the voxels of the piece that it is used on.
void Workbench::State::holdTool() {
  Tool tool = wanted;
  const DocumentPtr now = session->document();
  tool.quality = now->quality;
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

// A large image takes seconds: it is read beside the strokes of other tools. The last one stays, as keys that are held
// change the tool for a moment.
bool Workbench::State::takeToolFile(Tool& tool) {
  const ToolFile kind = rowOf(tool).file;
  if (fileRead.file == tool.file && !tool.file.empty()) {
    if (kind == ToolFile::image) tool.content.image = fileRead.content.image;
    if (kind == ToolFile::shape) tool.content.shape = fileRead.content.shape;
  }
  if (kind == ToolFile::none || tool.file.empty() || tool.content.image || tool.content.shape) {
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
  if (loop) guarded([this] { cutShort("Another device was chosen"); });
  if (old) {
    old->servo.stop();
    heats[old->device->sheet().name] = {old->servo.tick().heat().load(), std::chrono::steady_clock::now()};
    while (old.use_count() > 1) std::this_thread::yield();  // the other side holds it for a moment only
    old.reset();                                            // the same hardware may be opened again
  }
  const auto open = [&](const std::string& as) {
    haptics::OpenDeviceOptions how;
    how.falconFirmware = options.falconFirmware;
    std::unique_ptr<haptics::Device> device =
        as == kPointer ? std::make_unique<haptics::PointerDevice>() : haptics::openDevice(as, how);
    return std::make_shared<Hand>(std::move(device), as, scene, options.realtime, gate);
  };
  std::shared_ptr<Hand> fresh;
  try {
    fresh = open(name);
  } catch (const Error& e) {
    tell(Message::Level::error, fmt::format("{} The mouse stands in.", e.what()));
    fresh = open(kPointer);
  }
  oriented = fresh->device->sheet().dofIn == 6 && !fresh->pointer;
  // Nobody holds it: within the clay it would be pushed out, and push back.
  if (fresh->simulated) fresh->simulated->startAt(workspace.toDevice(besideClayMm()));
  makeLoop();  // the new servo counts its samples from zero
  if (const auto warm = heats.find(fresh->device->sheet().name); warm != heats.end()) {
    const double restedS = std::chrono::duration<double>(std::chrono::steady_clock::now() - warm->second.at).count();
    fresh->servo.tick().heat().begin(warm->second.load, restedS);
  }
  if (fresh->pointer)
    fresh->servo.start();  // It has no force that could be stopped.
  else if (!beginUnlessStopped(gate, fresh->servo))
    tell(Message::Level::warning, "Forces are still stopped; resume when you are ready.");
  fresh->grant = fresh->servo.grant();
  const std::lock_guard lock(handMutex);
  hand = std::move(fresh);
}

// Above all clay, in the world: where a tool that nobody moves touches nothing.
Vec3d Workbench::State::besideClayMm() const {
  constexpr double kAboveMm = 15;
  Eigen::AlignedBox3d box;
  if (session)
    for (const Piece& piece : session->document()->pieces) {
      if (!piece.version || piece.version.stats().bricks == 0) continue;
      const clay::BoxMm own = clay::boundsOf(piece.version);
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3d p(corner & 1 ? own.high.x() : own.low.x(), corner & 2 ? own.high.y() : own.low.y(),
                      corner & 4 ? own.high.z() : own.low.z());
        box.extend(piece.pose.apply(p));
      }
    }
  if (box.isEmpty()) return workspace.toWorld(Vec3d::Zero());
  return {box.center().x(), box.center().y(), box.max().z() + kAboveMm + wanted.radiusMm};
}

void Workbench::State::openFirstHand() {
  guardedOnce(handTrouble, [this] {
    takeHand(options.device);
    handOpened = true;
  });
}

void Workbench::State::publish() {
  if (!session || !loop) return;
  const DocumentPtr now = session->document();
  const auto time = std::chrono::steady_clock::now();
  if (time - presenceAt > kPresenceEvery) {
    presenceAt = time;
    followPresence();
  }
  if (time - usageAt > kUsageEvery) {
    usageAt = time;
    uint64_t bytes = 0;
    std::unordered_set<const clay::Store*> stores;
    for (const Piece& piece : now->pieces) {
      const clay::Store* store = piece.version.store().get();
      if (!stores.insert(store).second) continue;
      bytes += store->usage().bytes();
    }
    clayBytes = bytes;
    undoOf = UINT64_MAX;
    if (options.journal && !autosave) guardedOnce(autosaveTrouble, [this] { beginSaving(); });
  }
  const bool inStroke = session->inStroke();
  if (!inStroke && undoOf != session->steps()) keepUndoBudget();
  const uint64_t steps = session->undoSteps() + session->redoSteps();
  const uint64_t historyNow = inStroke ? historyOf : session->steps();
  const Snapshot& last = *snapshot;  // written by this thread alone
  FileState kept;
  kept.path = file;
  kept.name = fileName;
  kept.unsaved = now != savedDocument.lock();
  kept.saving = saving;
  kept.readOnly = readOnly;
  kept.refused = refused;
  kept.refusal = refusal;
  kept.elsewhere = presence && presence->elsewhere();
  kept.opened = opened;
  kept.face = face;
  {
    const std::lock_guard lock(mutex);
    kept.journalTrouble = journalTrouble.empty() ? autosaveTrouble : journalTrouble;
  }
  if (now == shown && last.inStroke == inStroke && historyNow == historyOf && last.done == session->undoSteps() &&
      last.clayBytes == clayBytes && last.undo == undo && last.tool == held.value_or(Tool()) && last.file == kept &&
      last.madeCount == madeCount) {
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
  next->made = madeLast;
  next->madeCount = madeCount;
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
  (void)pthread_setname_np(pthread_self(), "argil-session");
  std::string turnTrouble, publishTrouble;
  const auto show = [&] { guardedOnce(publishTrouble, [this] { publish(); }); };
  guardedOnce(turnTrouble, [this] { begin(fresh(), true); });
  if (session && loop) openFirstHand();
  show();
  auto next = std::chrono::steady_clock::now();
  for (;;) {
    guardedOnce(turnTrouble, [this] { turn(); });
    ran.clear();
    show();
    std::unique_lock lock(mutex);
    busy = session && loop && (session->inStroke() || loop->behind());
    strokeOn = busy;
    strokeLeftS = busy ? loop->leftS() : 0;
    if (stopping) break;
    const auto turn = hand && hand->servo.running() ? kTurn : kIdleTurn;
    next = std::max(next + turn, std::chrono::steady_clock::now());
    wake.wait_until(lock, next, [this] { return stopping || (!commands.empty() && !busy); });
  }
  // What the hand did that the clay does not show yet is left out: whoever ends the program does not wait for a slow
  // tool.
  if (loop) guarded([this] { (void)loop->cutShort(); });
  if (session) session->setWatch(nullptr);
  if (autosave && leaveJournal) autosave->leave();
  autosave.reset();
  {
    const std::lock_guard lock(handMutex);
    hand.reset();
  }
  show();
  shown.reset();
}

void Workbench::State::addPiece(const std::string& label, const std::string& name, const clay::Version& version,
                                bool beside) {
  Id id = 0;
  session->change(label, [&](Document& document) {
    Piece piece;
    piece.name = nameFor(document, name);
    piece.version = version;
    if (beside) piece.pose.translation = moveBeside(document, boundsOf(piece));
    id = document.active = document.add(std::move(piece));
  });
  noteMade(id);
}

Vec3d Workbench::State::besideAll(const Document& document, const std::vector<Piece>& pieces,
                                  const std::vector<Part>& parts) {
  Document fresh;
  fresh.pieces = pieces;
  fresh.parts = parts;
  return moveBeside(document, boundsOf(fresh));
}

std::string Workbench::State::nameFor(const Document& document, const std::string& name) {
  const auto taken = [&](const std::string& candidate) {
    const auto has = [&](const Thing& thing) { return thing.name == candidate; };
    return std::any_of(document.pieces.begin(), document.pieces.end(), has) ||
           std::any_of(document.parts.begin(), document.parts.end(), has) ||
           std::any_of(document.guides.begin(), document.guides.end(), has);
  };
  // "Block 3" after "Block 2", not "Block 2 2".
  constexpr size_t kMostDigits = 6;
  const size_t blank = name.find_last_not_of("0123456789");
  const bool numbered = blank != std::string::npos && blank > 0 && name[blank] == ' ' && blank + 1 < name.size() &&
                        name.size() - blank - 1 <= kMostDigits;
  const std::string plain = numbered ? name.substr(0, blank) : name;
  int number = numbered ? std::stoi(name.substr(blank + 1)) : 1;
  std::string free = name;
  while (!free.empty() && taken(free)) free = fmt::format("{} {}", plain, ++number);
  return free;
}

void Workbench::State::noteMade(Id id) {
  madeLast = id;
  ++madeCount;
}

// A stroke along which the tool met nothing looks like one that did its work.
void Workbench::State::tellIdleStrokes() {
  const uint64_t idle = session->counts().idle, kept = session->counts().kept;
  if (const uint64_t before = std::exchange(keptTold, kept); before < kept)
    tell(Message::Level::done,
         fmt::format("{} later step{} kept: the history has {} above \"Back to …\".", kept - before,
                     kept - before == 1 ? " is" : "s are", kept - before == 1 ? "it" : "them"));
  if (std::exchange(idleTold, idle) >= idle) return;
  tell(Message::Level::warning, fmt::format("{} changed nothing: it met no clay that it can change there.",
                                            held ? rowOf(*held).name : "The tool"));
}

}  // namespace argil::engine
