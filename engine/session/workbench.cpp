#include "engine/session/workbench.h"

#include <algorithm>
#include <utility>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/document/beside.h"
#include "engine/models/model_files.h"
#include "engine/models/prepare_clay.h"
#include "engine/models/script_file.h"
#include "engine/session/run.h"
#include "engine/session/workbench_state.h"
#include "io/records/document_file.h"

namespace argil::engine {
namespace {

constexpr auto kStatisticsEvery = std::chrono::milliseconds(500);

}  // namespace

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
  state_->finding.reset();
}

std::shared_ptr<const Snapshot> Workbench::snapshot() const {
  const std::lock_guard lock(state_->mutex);
  return state_->snapshot;
}

SurfaceChanges Workbench::takeSurfaces() {
  return state_->surfaces.take();
}

void Workbench::resendSurfaces() {
  state_->post(
      [s = state_.get()] {
        s->surfaces.forget();
        s->surfaces.follow(*s->session->document(), 0, s->options.surfaceThreads);
      },
      false);
}

void Workbench::setSurface(clay::Grade grade) {
  if (state_->wantedSurface.exchange(grade) == grade) return;
  state_->begin(grade == clay::Grade::fine    ? "Refining the surface"
                : grade == clay::Grade::crisp ? "Sharpening the surface"
                                              : "Drafting the surface",
                [=, this, s = state_.get()](Job& job) -> std::function<void()> {
                  const DocumentPtr document = snapshot()->document;
                  State::Ready ready;
                  for (const Piece& piece : document->pieces) {
                    if (job.cancelled()) throw Cancelled();
                    ready.push_back(s->surfaces.prepare(piece.version, s->options.surfaceThreads, grade));
                  }
                  return [=, ready = std::move(ready)] {
                    s->surfaces.setGrade(s->wantedSurface);  // the last that was asked for, whichever is ready first
                    s->surfaces.follow(*s->session->document(), 0, s->options.surfaceThreads);
                  };
                });
}

void Workbench::showChecks(const std::optional<CheckLimits>& limits) {
  state_->post(
      [s = state_.get(), limits] {
        s->surfaces.setChecks(limits);
        s->surfaces.follow(*s->session->document(), 0, s->options.surfaceThreads);
      },
      false);
}

std::vector<Message> Workbench::takeMessages() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->messages, {});
}

std::shared_ptr<const clay::TriangleMesh> Workbench::preview() const {
  const std::lock_guard lock(state_->mutex);
  return state_->preview;
}

void Workbench::tell(Message::Level level, std::string text) {
  state_->tell(level, std::move(text));
}

void Workbench::edit(std::string label, std::function<void(Document&)> change, std::string merge) {
  state_->post([s = state_.get(), label = std::move(label), change = std::move(change), merge = std::move(merge)] {
    s->session->change(
        label,
        [&](Document& document) {
          change(document);
          (void)sceneOf(document, haptics::Scene());  // what cannot be felt is refused here, not in mid-touch
        },
        merge);
  });
}

void Workbench::setSymmetry(std::function<void(Symmetry&)> change) {
  state_->post([s = state_.get(), change = std::move(change)] {
    Symmetry symmetry = s->session->document()->symmetry;
    change(symmetry);
    s->session->setSymmetry(symmetry);
  });
}

void Workbench::setQuality(const StrokeQuality& quality) {
  state_->post([s = state_.get(), quality] {
    s->session->setQuality(quality);
    s->holdTool();
  });
}

void Workbench::add(std::string label, Things things) {
  if (things.empty()) return;
  state_->post([s = state_.get(), label = std::move(label), things = std::move(things)] {
    Id made = 0;
    s->session->change(label, [&](Document& document) {
      const Vec3d move = s->besideAll(document, things.pieces, things.parts);
      const auto put = [&](auto thing) {
        thing.id = 0;
        thing.name = s->nameFor(document, thing.name);
        if constexpr (!std::is_same_v<decltype(thing), Guide>) thing.pose.translation += move;
        made = document.add(std::move(thing));
      };
      for (const Guide& guide : things.guides) put(guide);
      for (const Part& part : things.parts) put(part);
      for (const Piece& piece : things.pieces) {
        put(piece);
        document.active = made;
      }
      (void)sceneOf(document, haptics::Scene());
    });
    s->noteMade(made);
  });
}

Workbench::StrokeWork Workbench::strokeWork() const {
  return {state_->strokeOn.load(), state_->strokeLeftS.load()};
}

void Workbench::endMerge() {
  state_->post([s = state_.get()] { s->session->endMerge(); });
}

void Workbench::strokeAlong(std::vector<Vec3d> placesMm) {
  state_->post([s = state_.get(), places = std::move(placesMm)] {
    const DocumentPtr now = s->session->document();
    const Piece* piece = now->workedOn();
    s->holdTool();  // one that was taken just now counts
    if (!s->reading.empty() && s->held && s->held->file == s->reading)
      throw Error(s->reading + ": is still being read; try again in a moment", Error::Kind::work);
    if (!piece || !s->held)
      throw Error("there is no piece to work on: choose one that is visible and not locked", Error::Kind::work);
    if (places.size() < 2) throw Error("a stroke along a line needs two places at least");
    const haptics::Pose pose = piece->pose;
    s->session->beginStroke(*s->held);
    try {
      for (size_t i = 0; i < places.size(); ++i) s->session->addPoint(0.001 * double(i), pose.applyInverse(places[i]));
    } catch (...) {
      s->session->endStroke();
      throw;
    }
    s->session->endStroke();
  });
}

void Workbench::undo() {
  state_->post(
      [s = state_.get()] {
        if (!s->session->undo()) s->tell(Message::Level::warning, "There is nothing to undo.");
      },
      true, true);
}

void Workbench::redo() {
  state_->post(
      [s = state_.get()] {
        if (!s->session->redo()) s->tell(Message::Level::warning, "There is nothing to redo.");
      },
      true, true);
}

void Workbench::goTo(size_t done) {
  state_->post([s = state_.get(), done] { s->session->goTo(done, true); }, true, true);
}

void Workbench::setUndoBudget(uint64_t bytes) {
  state_->post(
      [s = state_.get(), bytes] {
        s->budget.set(bytes);
        s->undoOf = UINT64_MAX;
      },
      false);
}

void Workbench::newDocument() {
  state_->post([s = state_.get()] { s->begin(State::fresh(), true); });
}

void Workbench::addBlock(const Vec3d& sizeMm, double roundMm, const NewClay& how) {
  state_->begin("Making a block", [=, s = state_.get()](Job& job) -> std::function<void()> {
    const clay::Grid grid{.voxelMm = how.voxelMm, .originMm = how.centreMm};
    const clay::Version version =
        clay::makeBlock(clay::Store::make(how.precision), grid, how.centreMm, sizeMm, roundMm, &job);
    return [=, ready = s->surfaces.prepare(version)] { s->addPiece("Add block", "Block", version, how.beside); };
  });
}

void Workbench::addSphere(double radiusMm, const NewClay& how) {
  state_->begin("Making a sphere", [=, s = state_.get()](Job& job) -> std::function<void()> {
    const clay::Grid grid{.voxelMm = how.voxelMm, .originMm = how.centreMm};
    const clay::Version version =
        clay::makeSphere(clay::Store::make(how.precision), grid, how.centreMm, radiusMm, &job);
    return [=, ready = s->surfaces.prepare(version)] { s->addPiece("Add sphere", "Sphere", version, how.beside); };
  });
}

void Workbench::import(const std::filesystem::path& file, const ImportOptions& how) {
  state_->begin("Importing " + file.filename().string(), [=, s = state_.get()](Job& job) -> std::function<void()> {
    const std::string name = file.stem().string();
    ModelImport given;
    given.units = how.units;
    given.up = how.up;
    given.heightMm = how.heightMm;
    given.stands = how.stands && !how.fitMm;
    given.look = how.look;
    given.voxelMm = how.voxelMm;
    given.precision = how.precision;
    given.fitMm = how.fitMm;
    given.asPart = how.asPart;
    given.guides = how.guides;
    given.onRead = [=](std::shared_ptr<const clay::TriangleMesh> mesh) {
      const std::lock_guard lock(s->mutex);
      s->preview = std::move(mesh);
    };
    // Shown until the piece is there, or until it is known that none will come.
    struct EndPreview {
      explicit EndPreview(State* of) : state(of) {}
      EndPreview(const EndPreview&) = delete;
      EndPreview& operator=(const EndPreview&) = delete;
      State* state;
      ~EndPreview() {
        std::shared_ptr<const clay::TriangleMesh> old;
        const std::lock_guard lock(state->mutex);
        old.swap(state->preview);
      }
    };
    const auto endPreview = std::make_shared<EndPreview>(s);
    auto imported = std::make_shared<ImportedModel>(importModel(file, given, &job));
    return [=, kept = endPreview, ready = s->prepare(imported->pieces)] {
      Document document = State::fresh();
      Id made = 0;
      const auto add = [&](Document& to) {
        const Vec3d move =
            how.stands && !how.replace ? s->besideAll(to, imported->pieces, imported->parts) : Vec3d(Vec3d::Zero());
        for (Guide guide : imported->guides) {
          guide.pose.translation += move;
          to.add(std::move(guide));
        }
        for (Part part : imported->parts) {
          if (part.name.empty()) part.name = name;
          part.pose.translation += move;
          made = to.add(std::move(part));
        }
        for (Piece piece : imported->pieces) {
          if (piece.name.empty()) piece.name = name;
          piece.pose.translation += move;
          piece.fileOffsetMm -= move;
          made = to.active = to.add(std::move(piece));
        }
      };
      if (how.replace) {
        add(document);
        s->begin(std::move(document));
      } else {
        s->session->change("Import " + name, add);
        s->noteMade(made);
      }
      for (const std::string& note : imported->notes)
        s->tell(Message::Level::done, file.filename().string() + ": " + note);
    };
  });
}

void Workbench::open(const std::filesystem::path& file) {
  if (io::isDocument(file) || file.extension() == ".argil") {
    openSaved(file);
    return;
  }
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
    PreparedClay clay = prepareClay(clay::Store::make(script.bits()), script, prepare);
    // In a session of its own; its newest document is what is opened.
    Session session(std::move(clay.document));
    clay::Surface surface(false);
    RunOptions run;
    run.job = &job;
    RunReport report = runScript(session, surface, script, run);
    Document made = *session.document();
    if (made.pieces.size() == 1) made.pieces[0].name = file.stem().string();
    std::vector<std::string> notes = std::move(clay.notes);
    notes.insert(notes.end(), report.notes.begin(), report.notes.end());
    return [=, ready = s->prepare(made.pieces)] {
      s->begin(made);
      for (const std::string& note : notes) s->tell(Message::Level::done, file.filename().string() + ": " + note);
    };
  });
}

void Workbench::exportTo(const std::vector<std::filesystem::path>& files, const ModelExport& what) {
  if (files.empty()) return;
  const DocumentPtr document = snapshot()->document;
  const std::string first = files.front().filename().string();
  state_->begin("Exporting " + first, [=, s = state_.get()](Job& job) -> std::function<void()> {
    for (const std::string& sentence : writeModelFiles(files, *document, what, &job))
      s->tell(Message::Level::done, sentence);
    return {};
  });
}

bool Workbench::idle() const {
  {
    const std::lock_guard lock(state_->handMutex);
    if (state_->hand && state_->hand->servo.samples().size() > 4) return false;
  }
  const std::lock_guard lock(state_->mutex);
  return state_->commands.empty() && state_->jobs.empty() && !state_->busy && !state_->surfaces.behind() &&
         !state_->snapshot->inStroke;
}

std::vector<JobView> Workbench::jobs() const {
  std::vector<JobView> views;
  const auto now = std::chrono::steady_clock::now();
  const std::lock_guard lock(state_->mutex);
  for (const State::Work& work : state_->jobs) {
    views.push_back(
        {work.id, work.name, work.job->job().fraction(), std::chrono::duration<double>(now - work.begin).count()});
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
  state_->post(
      [s = state_.get(), tool, number = ++state_->toolsAsked] {
        s->wanted = tool;
        s->toolWanted = number;
      },
      false);
}

bool Workbench::toolTaken() const {
  return state_->toolsTaken.load() == state_->toolsAsked;
}

void Workbench::setCutting(bool on) {
  state_->post(
      [s = state_.get(), on] {
        s->cutting = on;
        s->loop->setCutting(on && s->ready);
      },
      false);
}

void Workbench::setWorkspace(const haptics::Workspace& workspace) {
  state_->post(
      [s = state_.get(), workspace] {
        s->loop->setWorkspace(workspace);
        s->workspace = workspace;
      },
      false);
}

void Workbench::setTouchQuality(const haptics::Quality& quality) {
  state_->post(
      [s = state_.get(), quality] {
        s->loop->setQuality(quality);
        s->touchQuality = quality;
      },
      false);
}

void Workbench::feelGuide(const std::string& id, bool on) {
  state_->post([s = state_.get(), id, on] { s->feelGuide(id, on); }, false);
}

std::vector<std::string> Workbench::guidesFelt() const {
  const std::lock_guard lock(state_->mutex);
  return state_->guidesFelt;
}

void Workbench::useDevice(const std::string& name) {
  state_->post([s = state_.get(), name] { s->takeHand(name); });
}

void Workbench::stopForces() {
  state_->gate.stop(haptics::StopOwner::user);
  state_->post(
      [s = state_.get()] {
        if (s->hand) s->loop->gather(s->hand->servo.samples());
        s->guarded([s] { s->cutShort("Stopped"); });
        // A pointer has no motor and goes on; the gate stays shut for the device that comes after it.
        if (s->hand && !s->hand->pointer) restStopped(s->gate, s->hand->servo);
      },
      false);
}

void Workbench::resumeForces() {
  SeenStops seen{state_->gate.generation(haptics::StopOwner::user)};
  {
    const std::lock_guard lock(state_->handMutex);
    if (state_->hand) seen.faults = state_->hand->servo.faults();
  }
  state_->post(
      [s = state_.get(), seen] {
        if (!s->hand || s->hand->pointer) {  // A pointer turns on while forces are stopped.
          (void)s->gate.resume(haptics::StopOwner::user, seen.user);
          return;
        }
        if (!resumeSeen(s->gate, seen, s->hand->servo)) return;
        std::string grant = s->hand->servo.grant();
        {
          const std::lock_guard lock(s->handMutex);
          s->hand->grant.swap(grant);
        }
        s->loop->restartClock();
      },
      false);
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

bool Workbench::usesSimulated() const {
  const std::lock_guard lock(state_->handMutex);
  return state_->hand && state_->hand->simulated != nullptr;
}

void Workbench::steerSimulated(const haptics::HandPoint& wanted) {
  const std::lock_guard lock(state_->handMutex);
  if (state_->hand && state_->hand->simulated && wanted.position.allFinite()) state_->hand->simulated->steer(wanted);
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
      const bool stopped = !hand->pointer && state_->gate.stoppedBy(haptics::StopOwner::user);
      view.device = hand->name;
      view.sheet = hand->device->sheet();
      view.deviceStatus = hand->device->status();
      view.state = stopped ? haptics::ServoState::stopped : hand->servo.state();
      view.sentence = stopped ? "Forces are stopped by you; resume when you are ready."
                      : hand->servo.fault() != haptics::Fault::none ? haptics::sentence(hand->servo.fault())
                      : hand->pointer && view.state == haptics::ServoState::running
                          ? "Mouse or pen works the clay; no force is felt."
                          : haptics::sentence(view.state);
      view.grant = hand->grant;
      view.rateHz = hand->servo.rateHz();
      view.heat = hand->servo.heat();
      view.delayS = hand->device->delayS();
      view.stiffnessNmm = haptics::coupleTo(view.sheet, 1 / view.rateHz, view.delayS).stiffnessNmm;
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
    for (size_t i = 0; i < kForcePoints; ++i)
      view.forceN.push_back(state_->forces[(state_->forceAt + i) % kForcePoints]);
  }
  return view;
}

}  // namespace argil::engine
