#include "engine/saving/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "clay/base/error.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "engine/tools/tool_table.h"

namespace argil::engine {
namespace {

// Bricks and nodes freed at a time: well below a millisecond, so that a collector on the only free core is never a
// stall.
constexpr size_t kCollectBatch = 1024;
constexpr auto kCollectPause = std::chrono::milliseconds(2);
// Between two looks of a watch at what a stroke has made so far.
constexpr auto kTellMade = std::chrono::milliseconds(50);
constexpr size_t kManyStores = 64;  // not to be looked at with every version
constexpr auto kManyPause = std::chrono::milliseconds(10);

}  // namespace

Collector::Collector() : thread_([this] { run(); }) {}

Collector::~Collector() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void Collector::add(const std::vector<Piece>& pieces) {
  const std::lock_guard lock(mutex_);
  for (const Piece& piece : pieces) {
    const std::shared_ptr<clay::Store>& store = piece.version.store();
    if (known_.insert(store.get()).second) fresh_.push_back(store);
  }
}

void Collector::wake() {
  {
    const std::lock_guard lock(mutex_);
    dirty_ = true;
  }
  wake_.notify_one();
}

// The lock is held for a moment only: whoever edits wakes this thread with every version.
void Collector::run() {
  std::vector<std::shared_ptr<clay::Store>> stores;
  std::unique_lock lock(mutex_);
  while (!stop_) {
    wake_.wait(lock, [this] { return dirty_ || stop_; });
    dirty_ = false;
    stores.insert(stores.end(), std::make_move_iterator(fresh_.begin()), std::make_move_iterator(fresh_.end()));
    fresh_.clear();
    lock.unlock();
    // With a thousand pieces most have nothing to free: those cost one look.
    bool stop = false;
    for (size_t i = 0; i < stores.size() && !stop; ++i) {
      if (!stores[i]->wantsCollecting()) continue;
      for (bool more = true; more && !stop;) {
        more = stores[i]->collect(kCollectBatch);
        lock.lock();
        if (more) wake_.wait_for(lock, kCollectPause, [this] { return stop_; });
        stop = stop_;
        lock.unlock();
      }
    }
    // A store that nobody else holds goes here, not on a thread that somebody waits for.
    const auto dead =
        std::partition(stores.begin(), stores.end(), [](const auto& store) { return store.use_count() != 1; });
    std::vector<std::shared_ptr<clay::Store>> gone(std::make_move_iterator(dead),
                                                   std::make_move_iterator(stores.end()));
    stores.erase(dead, stores.end());
    lock.lock();
    for (const auto& store : gone) known_.erase(store.get());
    lock.unlock();
    gone.clear();
    lock.lock();
    if (stores.size() > kManyStores) wake_.wait_for(lock, kManyPause, [this] { return stop_; });
  }
}

Session::Session(Document first)
    : Session({{.label = {}, .document = std::make_shared<const Document>(std::move(first))}}, 0) {}

Session::Session(std::vector<HistoryState> states, size_t done)
    : newest_(states.at(done).document),
      states_(std::move(states)),
      strokes_(states_.size()),
      done_(done),
      threads_(strokeThreads()),
      collector_(std::make_unique<Collector>()) {
  collector_->add(newest_->pieces);
}

Session::~Session() = default;

int Session::strokeThreads() noexcept {
  constexpr int kMost = 4;  // The servo and the picture want theirs.
  return std::clamp(int(std::thread::hardware_concurrency()), 1, kMost);
}

DocumentPtr Session::document() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

clay::Version Session::version() const {
  const DocumentPtr now = document();
  const Piece* active = now->piece(now->active);
  return active ? active->version : clay::Version();
}

void Session::setDocument(DocumentPtr document) {
  collector_->add(document->pieces);
  swapNewest(std::move(document));
}

void Session::swapNewest(DocumentPtr document) {
  {
    const std::lock_guard lock(mutex_);
    newest_.swap(document);
  }
  document.reset();
  collector_->wake();
}

// A document like the newest one but for the clay of the piece in work.
std::shared_ptr<Document> Session::spareDocument() {
  std::unique_ptr<Document> made;
  {
    const std::lock_guard lock(spares_->mutex);
    if (!spares_->documents.empty()) {
      made = std::move(spares_->documents.back());
      spares_->documents.pop_back();
    }
  }
  if (!made) made = std::make_unique<Document>(*newest_);
  made->stroke = strokeNumber_;
  return {made.release(), [spares = spares_, stroke = strokeNumber_, place = place_](Document* mine) {
            std::unique_ptr<Document> document(mine);
            const std::lock_guard lock(spares->mutex);
            if (spares->stroke != stroke || spares->documents.size() == Spares::kMost) return;
            document->pieces[place].version = {};  // a spare pins no clay of the stroke
            spares->documents.push_back(std::move(document));
          }};
}

void Session::setVersion(const clay::Version& version) {
  if (newest_->pieces[place_].version == version) return;  // the same document says that nothing changed
  std::shared_ptr<Document> next = spareDocument();
  next->pieces[place_].version = version;
  swapNewest(std::move(next));  // a stroke stays within its piece's store
}

void Session::endSpares() {
  std::vector<std::unique_ptr<Document>> spares;
  const std::lock_guard lock(spares_->mutex);
  spares_->stroke = 0;
  spares.swap(spares_->documents);
}

// The steps behind the newest document stay where they are: it is repeated after them, as a step of its own.
void Session::keepLaterSteps() {
  if (!std::exchange(keepsLater_, false) || redoSteps() == 0 || records_) return;
  const std::string label =
      done_ == 0 ? "Back to the beginning" : fmt::format("Back to step {}: {}", done_, states_[done_].label);
  counts_.kept += redoSteps();
  done_ = states_.size() - 1;
  if (watch_) watch_->went(done_);
  push(label, newest_, {});
}

void Session::push(const std::string& label, DocumentPtr after, std::vector<ScriptStroke> strokes) {
  states_.resize(done_ + 1);
  strokes_.resize(done_ + 1);
  states_.push_back({label, std::move(after), 0});
  strokes_.push_back(std::move(strokes));  // nothing without record()
  ++done_;
  ++steps_;
  if (watch_) watch_->stepped(label, states_.back().document, std::exchange(toldMade_, false));
}

void Session::requireNoStroke(const char* what) const {
  if (stroke_) throw Error(fmt::format("{} has to wait until the stroke has ended", what), Error::Kind::work);
}

void Session::beginStroke(const Tool& tool, StrokeImages images) {
  requireNoStroke("another stroke");
  const Piece* piece = newest_->workedOn();
  if (!piece) throw Error("there is no piece to work on: choose one that is visible and not locked", Error::Kind::work);
  const clay::Grid& grid = piece->version.grid();
  (void)StrokePath(grid, tool);  // throws before anything is changed
  strokeBrush_ = brushOf(tool, grid, morphGoal(tool, *piece));
  keepLaterSteps();
  piece_ = piece->id;
  place_ = static_cast<size_t>(piece - newest_->pieces.data());
  strokeNumber_ = nextStroke_++;
  {
    const std::lock_guard lock(spares_->mutex);
    spares_->stroke = strokeNumber_;
    spares_->documents.reserve(Spares::kMost);
  }
  tool_ = tool;
  lifted_ = piece->version;
  images_ = std::move(images);
  maps_ = ImageMaps(images_, grid, piece->pose);
  normal_ = Vec3d::UnitZ();
  stroke_.emplace();
  stroke_->before = newest_;
  stroke_->start = lifted_;
  pointsBefore_ = 0;
  const ToolRow& row = rowOf(tool_);
  tellsMade_ = row.origin && !row.formula;
  toldMade_ = false;
  if (watch_ && !tellsMade_) watch_->strokeBegan(tool_, images_);
}

std::string Session::strokeLabel() const {
  const ToolRow& row = rowOf(tool_);
  if (!row.origin || row.formula) return std::string(row.name);
  // What made it is in the history, as nothing else tells of it.
  return fmt::format("{} ({} {} {})", row.name, row.origin->id, row.origin->version, row.origin->checksum.substr(0, 8));
}

void Session::tellMade() {
  const auto now = std::chrono::steady_clock::now();
  if (!watch_ || !tellsMade_ || (toldMade_ && now - toldAt_ < kTellMade)) return;
  if (newest_->pieces[place_].version == stroke_->before->pieces[place_].version) return;
  watch_->stepped(strokeLabel(), newest_, std::exchange(toldMade_, true));
  toldAt_ = now;
}

// What a morphing tool goes back to: the piece as it was after so many steps, where that step is in memory.
clay::Version Session::morphGoal(const Tool& tool, const Piece& piece) const {
  const auto operations = rowOf(tool).operations;
  if (std::none_of(operations.begin(), operations.end(),
                   [](const clay::Operation& each) { return each.method == clay::Method::morph; }))
    return {};
  if (tool.morphTo < 0 || size_t(tool.morphTo) > done_)
    throw Error(fmt::format("there is no step {} to go back to; {} are done", tool.morphTo, done_));
  for (size_t step = size_t(tool.morphTo); step <= done_; ++step) {
    DocumentPtr then = states_[step].document;
    if (!then && reader_) then = reader_(states_[step].kept, *newest_);
    const Piece* was = then ? then->piece(piece.id) : nullptr;
    if (was && was->version.store() == piece.version.store() && was->version.grid() == piece.version.grid())
      return was->version;
  }
  return piece.version;
}

// A tip that no stylus turns stands on the surface. Its x lies as near to the world's as it can.
Eigen::Quaterniond Session::standing(const Vec3d& mm) {
  clay::Sampler sampler(lifted_);
  Vec3f gradient;
  (void)sampler.tricubic(lifted_.grid().toVoxel(mm), gradient);  // trilinear ones jump from cell to cell
  if (gradient.squaredNorm() > 0.25f) normal_ = gradient.cast<double>().normalized();
  const Vec3d side = std::abs(normal_.x()) < 0.9 ? Vec3d::UnitX() : Vec3d::UnitY();
  const Vec3d x = (side - side.dot(normal_) * normal_).normalized();
  Eigen::Matrix3d axes;
  axes << x, normal_.cross(x), normal_;
  return Eigen::Quaterniond(axes);
}

void Session::addPoint(const PathPoint& given) {
  queuePoint(given);
  applyAll();
}

void Session::queuePoint(const PathPoint& given) {
  if (!stroke_) throw Error("a point needs a stroke that it belongs to", Error::Kind::work);
  if (!std::isfinite(given.timeS)) throw Error("a point of a stroke has a time that is not finite");
  applyAll();
  coveredBefore_ = path_ ? path_->covered() : 0;
  PathPoint point = given;
  if (tool_.stabiliseMm > 0 && point.mm.allFinite()) {
    // Drawn on a string: the tool stays where it is until the string is tight.
    const Vec3d from = drawn_.value_or(point.mm);
    const double length = (point.mm - from).norm();
    point.mm =
        length > tool_.stabiliseMm ? Vec3d(from + (point.mm - from) * ((length - tool_.stabiliseMm) / length)) : from;
  }
  if (!point.rotation && StrokePath::reaches(lifted_.grid(), point.mm)) point.rotation = standing(point.mm);
  if (!path_) {
    // throws before anything is begun
    auto brush = std::make_unique<clay::BrushStroke>(lifted_, strokeBrush_, stroke_->start, threads_);
    StrokePath path(lifted_.grid(), tool_);
    path.add(point, stamps_);
    path_ = path;
    brush_ = std::move(brush);
    if (records_) {
      stroke_->strokes.push_back({tool_, Drive::tip, {}});
      stroke_->strokes.back().images = images_;
    }
  } else {
    path_->add(point, stamps_);
  }
  drawn_ = point.mm;
  if (records_) {
    auto& record = stroke_->strokes.back().path;
    // A script's times never decrease; the stamps do not depend on them.
    record.push_back(given);
    if (record.size() > 1) record.back().timeS = std::max(given.timeS, record[record.size() - 2].timeS);
  }
  ++counts_.points;
  if (watch_ && !tellsMade_) watch_->strokePoint(given);
}

bool Session::applyStamp() {
  if (!stampsWait()) return false;
  try {
    maps_.apply(stamps_[nextStamp_], stampImages_);
    if (brush_->step(stampImages_)) return true;
    ++nextStamp_;
  } catch (...) {
    // Whatever is thrown, none comes a second time.
    stamps_.clear();
    nextStamp_ = 0;
    throw;
  }
  counts_.stamps += maps_.count();
  if (!stampsWait()) {
    stamps_.clear();
    nextStamp_ = 0;
  }
  return true;
}

void Session::applyAll() {
  while (applyStamp()) {
  }
}

void Session::liftTool() {
  if (!path_) return;
  applyAll();
  path_->finish(stamps_);
  applyAll();
  pointsBefore_ += path_->covered();
  lifted_ = brush_->finish();
  const auto made = brush_->counts();
  counts_.clay.bricksMade += made.bricksMade;
  counts_.clay.nodesMade += made.nodesMade;
  counts_.clay.channelBricksMade += made.channelBricksMade;
  brush_.reset();
  path_.reset();
  drawn_.reset();
  if (watch_ && !tellsMade_) watch_->toolLifted();
}

std::vector<clay::WallAhead> Session::wallsAhead() {
  if (!brush_) return {};
  std::vector<clay::WallAhead> walls = brush_->wallsAhead();
  for (clay::WallAhead& each : walls) maps_.bringBack(each);
  return walls;
}

clay::Version Session::publish() {
  if (brush_) {
    setVersion(brush_->publish());
    tellMade();
  } else if (stroke_) {
    setVersion(lifted_);
  }
  return version();
}

clay::Version Session::endStroke() {
  if (!stroke_) throw Error("there is no stroke to end", Error::Kind::work);
  liftTool();
  setVersion(lifted_);
  endSpares();
  // What was told of has to be a step, even if it came to nothing.
  if (toldMade_ || newest_->pieces[place_].version != stroke_->before->pieces[place_].version) {
    push(strokeLabel(), newest_, std::move(stroke_->strokes));
  } else {
    setDocument(stroke_->before);
    ++counts_.idle;
  }
  merge_.clear();
  ++counts_.strokes;
  stroke_.reset();
  if (watch_ && !tellsMade_) watch_->strokeEnded();
  const clay::Version last = std::exchange(lifted_, {});
  collector_->wake();
  return last;
}

void Session::abandonStroke() {
  if (!stroke_) throw Error("there is no stroke to leave out", Error::Kind::work);
  stamps_.clear();
  nextStamp_ = 0;
  brush_.reset();
  path_.reset();
  drawn_.reset();
  endSpares();
  swapNewest(stroke_->before);
  if (toldMade_) push(strokeLabel(), newest_, {});
  stroke_.reset();
  lifted_ = {};
  if (watch_ && !tellsMade_) watch_->strokeEnded();
  collector_->wake();
}

uint64_t Session::coveredPoints() const {
  return pointsBefore_ + (!path_ ? 0 : stampsWait() ? coveredBefore_ : path_->covered());
}

void Session::change(const std::string& label, const std::function<void(Document&)>& change, const std::string& merge) {
  requireNoStroke("a change of the document");
  auto next = std::make_shared<Document>(*newest_);
  next->stroke = 0;
  change(*next);
  if (!merge.empty() && merge == merge_ && done_ > 0 && redoSteps() == 0) {
    states_.back().document = next;
    states_.back().kept = 0;
    if (watch_) watch_->stepped(states_.back().label, next, true);
  } else {
    keepLaterSteps();
    push(label, next, {});
  }
  merge_ = merge;
  setDocument(std::move(next));
}

// With the symmetry that is switched, at the place that the document has it, and the quality that was chosen.
DocumentPtr Session::withSettings(DocumentPtr document) const {
  const Symmetry& was = document->symmetry;
  const bool turned = symmetry_ && !(was.x == symmetry_->x && was.y == symmetry_->y && was.z == symmetry_->z &&
                                     was.turns == symmetry_->turns);
  if (!turned && (!quality_ || document->quality == *quality_)) return document;
  auto next = std::make_shared<Document>(*document);
  if (turned) {
    next->symmetry = *symmetry_;
    next->symmetry.pose = was.pose;
  }
  if (quality_) next->quality = *quality_;
  return next;
}

void Session::setQuality(const StrokeQuality& quality) {
  requireNoStroke("a change of quality");
  quality.check();
  quality_ = quality;
  if (DocumentPtr next = withSettings(newest_); next != newest_) setDocument(std::move(next));
}

void Session::setSymmetry(const Symmetry& symmetry) {
  requireNoStroke("a change of symmetry");
  symmetry_ = symmetry;
  if (DocumentPtr next = withSettings(newest_); next != newest_) setDocument(std::move(next));
}

bool Session::undo() {
  requireNoStroke("undo");
  if (done_ == 0) return false;
  goTo(done_ - 1);
  return true;
}

bool Session::redo() {
  requireNoStroke("redo");
  if (redoSteps() == 0) return false;
  goTo(done_ + 1);
  return true;
}

void Session::goTo(size_t steps, bool keeps) {
  requireNoStroke("undo");
  if (steps >= states_.size()) throw Error("there are not so many steps to go to", Error::Kind::work);
  HistoryState& at = states_[steps];
  if (!at.document) {
    if (!reader_) throw Error("that step is not at hand any more", Error::Kind::work);
    at.document = reader_(at.kept, nearest(steps));
    if (watch_) watch_->cameBack(steps, at.document);
  }
  merge_.clear();
  ++steps_;
  if (steps != done_ && watch_) watch_->went(steps);
  done_ = steps;
  keepsLater_ = (keeps || keepsLater_) && redoSteps() > 0;
  if (at.document != newest_) setDocument(withSettings(at.document));
}

const Document& Session::nearest(size_t state) const {
  for (size_t away = 1; away < states_.size(); ++away) {
    const bool below = away <= state && states_[state - away].document,
               above = state + away < states_.size() && states_[state + away].document;
    if (below && (!above || state > done_)) return *states_[state - away].document;
    if (above) return *states_[state + away].document;
  }
  return *newest_;
}

void Session::spill(size_t state, uint64_t kept) {
  HistoryState& at = states_.at(state);
  if (state == done_ || kept == 0)
    throw Error("the newest document cannot leave memory, nor one that no file has", Error::Kind::work);
  at.kept = kept;
  at.document.reset();
  if (watch_) watch_->spilled(state);
  collector_->wake();
}

std::vector<std::string> Session::history() const {
  std::vector<std::string> labels;
  for (size_t i = 1; i < states_.size(); ++i) labels.push_back(states_[i].label);
  return labels;
}

Script Session::recording() const {
  requireNoStroke("the recording");
  if (!records_)
    throw Error("this session holds no recording of its strokes: it was not asked to before they were drawn",
                Error::Kind::work);
  Script script;
  if (const clay::Version now = version()) {
    script.voxelMm = now.grid().voxelMm;
    script.precision = now.store()->precision();
    if (const auto band = static_cast<double>(now.grid().band); band != Quality().clay.band)
      script.quality.emplace().clay.band = band;
  }
  for (size_t i = 1; i <= done_; ++i)
    script.strokes.insert(script.strokes.end(), strokes_[i].begin(), strokes_[i].end());
  return script;
}

}  // namespace argil::engine
