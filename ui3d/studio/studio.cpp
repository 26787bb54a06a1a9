#include "ui3d/studio/studio.h"

#include "ui3d/studio/files/file_kinds.h"

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_internal.h>  // ErrorCheckEndFrameRecover

#include <algorithm>
#include <cmath>
#include <utility>

#include "clay/base/error.h"
#include "haptics/base/clock.h"
#include "ui3d/studio/files/settings.h"
#include "ui3d/studio/kit/kit.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/session_window.h"
#include "ui3d/studio/view/icon.h"
#include "ui3d/studio/widgets/picture_labels.h"

namespace argil::studio {
namespace {

// While a picture is drawn events may arrive unnoticed by poll(): the drawing thread reads the same connection.
constexpr double kBusyS = 0.002;
constexpr double kWaitS = 0.001;  // For the tool that a press is to have.
constexpr double kIdleS = 0.05;   // Nothing to do: a look at jobs and stylus.
// So long after the person's last act panels are drawn ten times a second, for what fades or blinks.
constexpr double kLivelyS = 5;
constexpr double kSettledS = 10;  // A start is over.
constexpr double kUiS = 0.1, kQuietUiS = 1;
constexpr float kHintUnits = 28;  // Below the upper edge of the picture.
constexpr double kRestS = 0.3;    // Longer than the pause before the full picture.

render::RendererOptions rendererOptions(const StudioOptions& options) {
  render::RendererOptions result;
  result.validation = options.validate;
  return result;
}

engine::Workbench::Options benchOptions(const StudioOptions& options, const StudioState& state) {
  engine::Workbench::Options result;
  result.undoBytes = state.undoBytes();
  result.surface = state.surface;
  result.device = options.device;
  result.journal = options.play.empty();  // A recording is no work of anybody.
  return result;
}

Window::Options windowOptions(const StudioOptions& options, const StudioState& state, int64_t startNs) {
  Window::Options result;
  result.width = options.width;
  result.height = options.height;
  result.scale = options.scale > 0 ? options.scale : state.interfaceScale;
  result.startNs = startNs;
  return result;
}

StudioState firstState(const StudioOptions& options) {
  StudioState state;
  if (options.play.empty()) {
    loadSettings(state);
  } else {
    // A recording begins as a first day does, whoever plays it; what its pictures may cost is the machine's affair.
    StudioState own;
    loadSettings(own);
    state.quality = own.quality;
    state.framesPerSecond = own.framesPerSecond;
  }
  if (options.theme) {
    state.keptTheme = {state.theme, state.look.lightBackground};
    state.theme = *options.theme;
    state.look.lightBackground = state.theme == Theme::light;
  }
  state.shown.firstStart = options.file.empty() && state.startPage;
  if (!options.file.empty()) {
    if (options.play.empty()) state.remember(options.file);
  }
  state.offersRecovery = options.play.empty();
  return state;
}

}  // namespace

SessionWindow::SessionWindow(const StudioOptions& options)
    : options_(options),
      startNs_(haptics::nowNs()),
      state_(firstState(options)),
      bench_(benchOptions(options, state_)),
      player_(options.play.empty() ? std::nullopt
                                   : std::optional<Player>(std::in_place, options.play, options.playSpeed)),
      window_(windowOptions(options, state_, startNs_)),
      pen_(window_.x11()),
      renderer_(rendererOptions(options)),
      hand_(bench_),
      pictures_([this] { window_.wake(); }) {
  if (!options.record.empty()) recording_.emplace(options.record);
  // A model is asked about, where there is somebody to be asked.
  if (const FileKind* kind = options.file.empty() ? nullptr : kindOf(options.file);
      kind && kind->imports && options.play.empty())
    state_.wishes.open = options.file;
  else if (!options.file.empty())
    bench_.open(options.file);
  window_.setIcon(icon(64));
  renderer_.attach(window_.hooks());
  ui_.useClipboardOf(&window_);
  state_.figures.deviceName = renderer_.deviceName();
  now_ = bench_.snapshot();
  sizedBy_ = state_.sizeBy;
  bench_.setWorkspace(state_.workspace);
  bench_.setTouchQuality(state_.touchQuality);
  const auto [w, h] = window_.pixels();
  Event first;
  first.kind = Event::Kind::resize;
  first.width = w;
  first.height = h;
  first.scale = window_.scale();
  handle(first);
  applyTheme();
}

SessionWindow::~SessionWindow() {
  if (!leave_) bench_.leaveJournal();  // Something went wrong.
}

void SessionWindow::applyTheme() {
  if (themeShown_ == state_.theme && scaleShown_ == scale_) return;
  themeShown_ = state_.theme;
  scaleShown_ = scale_;
  studio::applyTheme(state_.theme, scale_);
  sendFont();
  uiSteps_ = 2;
}

Context SessionWindow::context() {
  const double now = window_.nowS();
  return {bench_, *now_, state_, camera_, renderer_, now, now - uiS_, width_, height_, scale_};
}

// One frame of the panels; what they ask of others is done after it.
void SessionWindow::uiStep() {
  applyTheme();
  const double now = window_.nowS();
  now_ = bench_.snapshot();
  Context c = context();
  ui_.beginFrame(now - uiS_, width_, height_, scale_);
  // Where the panels stood in the last frame; in the first one nobody knows.
  const std::array<float, 4> free = panels_.free();
  const bool split = state_.stereo.splits();  // Texts would stand between the two pictures.
  if (state_.look.scaleBar && free[2] > free[0] && !split) drawScaleBar(camera_.view(), free, width_, height_, state_);
  if (!split)
    for (const Widgets::Label& label : widgets_.labels(c)) drawLabel(label, state_.theme);
  std::string hint = sizing_             ? "Radius " + kit::written(state_.tool().radiusMm) + " mm"
                     : state_.drawnCurve ? state_.drawnCurve->hint()
                     : state_.planeCut   ? state_.planeCut->hint()
                                         : widgets_.hint();
  if (hint.empty() && split && now - activeS_ < kLivelyS) hint = "A picture for each eye. Esc brings the panels back";
  if (!hint.empty()) {
    const float grey = state_.theme == Theme::light ? 0.1f : 0.95f;
    drawLabel({(free[0] + free[2]) / 2, free[1] + kHintUnits, hint, {grey, grey, grey, 1}}, state_.theme);
  }
  attempt([&] { panels_.draw(c); });
  if (ring_ && !(drag_ == Drag::ring && QuickRing::dragged(ringItem_))) ring_->draw(ring_->at(mouse_.x, mouse_.y));
  for (const auto& [texture, image] : panels_.takePictures()) {
    renderer_.setUiTexture(texture, image->width, image->height, 4, image->rgba.data());
    uiSteps_ = std::max(uiSteps_, 2);
  }
  ImGui::ErrorCheckEndFrameRecover(nullptr);  // What a panel that threw left open.
  ImGui::Render();
  uiS_ = now;
  if (uiSteps_ > 0) --uiSteps_;
  serveWishes(c);
}

// Twice: what was laid out anew in the first frame stands in the second.
void SessionWindow::settleUi() {
  while (uiSteps_ > 0) uiStep();
}

void SessionWindow::serveWishes(Context& context) {
  if (!state_.wishes.place.empty()) widgets_.place(context, std::exchange(state_.wishes.place, {}));
  if (std::exchange(state_.wishes.quickRing, false)) ring_ = QuickRing::around(mouse_.x, mouse_.y, width_, height_);
  if (state_.fullScreen != window_.fullScreen()) {
    window_.toggleFullScreen();
    state_.fullScreen = window_.fullScreen();
  }
  if (options_.scale == 0) window_.setScale(state_.interfaceScale);
  if (state_.leave) leave_ = true;
}

// Everything that happened since the last time, in order.
void SessionWindow::gather() {
  const double now = window_.nowS();
  const size_t first = events_.size();
  std::vector<Event> real;
  window_.poll(real);
  if (player_) {
    // A recording plays alone; only the window itself stays real.
    std::erase_if(real, [](const Event& e) { return e.kind != Event::Kind::resize && e.kind != Event::Kind::close; });
    events_.insert(events_.end(), real.begin(), real.end());
    player_->poll(now, events_);
    for (size_t i = first + real.size(); i < events_.size(); ++i) {
      Event& e = events_[i];
      if (e.kind != Event::Kind::resize) continue;
      if (options_.scale == 0) window_.setScale(e.scale);
      window_.resize(e.width, e.height);  // The window's own event follows.
      e.kind = Event::Kind::focus;
      e.on = true;
    }
    return;
  }
  std::vector<Event> pen;
  pen_.poll(now, scale_, pen);
  if (pen_.active(now)) {
    std::erase_if(real, [](const Event& e) { return e.kind == Event::Kind::move; });
    for (Event& e : real) {
      if (e.kind != Event::Kind::press && e.kind != Event::Kind::release) continue;
      e.pressure = pen_.state().pressure;
      e.tiltX = pen_.state().tiltX;
      e.tiltY = pen_.state().tiltY;
      e.eraser = pen_.state().eraser;
    }
  }
  // Recordings hold what it counted as, so that they need no setting to give the same again.
  for (std::vector<Event>* events : {&pen, &real})
    for (Event& e : *events)
      if (e.pressure >= 0)
        e.pressure = float(engine::curvedPressure(state_.penCurve, std::min(double(e.pressure), 1.0)));
  events_.insert(events_.end(), pen.begin(), pen.end());
  events_.insert(events_.end(), real.begin(), real.end());
  if (const auto axes = spaceMouse_.poll(now)) {
    Event e;
    e.kind = Event::Kind::motion6;
    e.timeS = now;
    e.axes = *axes;
    events_.push_back(e);
  }
  if (recording_)
    for (size_t i = first; i < events_.size(); ++i) recording_->write(events_[i]);
}

// Whether something is under way that somebody asked for.
bool SessionWindow::acting() const {
  return !events_.empty() || hand_.active() || !waiting_.pieces.empty() || !partsWaiting_.empty() || !bench_.idle() ||
         state_.wishes.save || state_.wishes.copy || deforming_.busy() || uiSteps_ > 0 ||
         (pictures_.busy() && frame_.clay) || !(stillShown_ || window_.minimised());
}

bool SessionWindow::atRest() const {
  return !acting() && !pictures_.busy();
}

void SessionWindow::tellRest() {
  if (!restSign_.wanted()) return;
  if (acting())
    restSign_.tell(false);
  else if (!pictures_.busy() && window_.nowS() >= nextClayS_)  // Else panels alone are drawn: a cursor may blink.
    restSign_.tell(true);
}

// Checks and screenshots of a recording. Between two pictures.
void SessionWindow::serveRecording(double now) {
  if (!player_) return;
  const Event* wanted = player_->waiting();
  if (!wanted) {
    if (player_->over() && atRest()) leave_ = true;
    return;
  }
  // The edit thread may just be about to say that it has work: what rests has done so for a moment.
  if (atRest() && now - changedS_ > kRestS) {
    if (wanted->kind == Event::Kind::screenshot) render::writePng(renderer_.lastPresented(), wanted->text);
    player_->passed(window_.nowS());
  } else if (player_->stuck(now)) {
    throw Error(fmt::format("{}: event {} has waited for {:.0f} s: {}", options_.play.string(), player_->position(),
                            Player::kCheckSeconds,
                            jobs_                              ? "a job is still running"
                            : now_->inStroke || hand_.active() ? "a stroke has not ended"
                                                               : "the picture does not come to rest"),
                Error::Kind::work);
  }
}

// The tip of a device that is no pointer: a hand on widgets too.
void SessionWindow::followStylus(double now) {
  const haptics::StylusSample before = std::exchange(stylus_, bench_.latest());
  // The hand is on a widget, or draws, or waits for what the drawn curve, the plane or the box around the clay is to
  // do.
  const bool cuts = bench_.usesPointer() || !(overWidget_ || state_.drawnCurve || state_.deformBox || state_.planeCut);
  if (std::exchange(cuts_, cuts) != cuts) bench_.setCutting(cuts);
  if (bench_.usesPointer() || (stylus_.flags & haptics::kStale)) return;
  if (stylus_.proxy == before.proxy && stylus_.buttons == before.buttons) return;
  activeS_ = now;
  if (drag_ != Drag::none) return;
  Grip tip;
  tip.origin = stylus_.proxy;
  tip.direction = -(stylus_.device.rotation * Vec3d::UnitZ());
  tip.stylus = true;
  tip.down = (stylus_.buttons & 1) != 0;
  Context c = context();
  overWidget_ = widgets_.handle(c, tip);
}

void SessionWindow::followDeformBox() {
  const Deforming::Edit edit = [this](std::string label, std::function<void(engine::Document&)> change,
                                      std::string merge) {
    bench_.edit(std::move(label), std::move(change), std::move(merge));
  };
  if (!deforming_.update(state_.deformBox, *now_->document, widgets_.held(), edit, [this] { bench_.endMerge(); }))
    return;
  hoverStale_ = true;
  uiSteps_ = std::max(uiSteps_, 1);
}

// Between two pictures: events, panels, and what is to be drawn next.
void SessionWindow::turn() {
  const double now = window_.nowS();
  const auto before = now_;
  now_ = bench_.snapshot();
  if (now_ != before) {
    uiSteps_ = std::max(uiSteps_, 1);
    if (now_->document != before->document) hoverStale_ = true;
  }
  followFile();
  attempt([&] { followToolSizes(); });  // Before what the hand did: a model that is seen has tools of its size.
  const std::vector<Event> happened = std::exchange(events_, {});
  for (size_t i = 0; i < happened.size(); ++i) {
    if (waits(happened[i])) {
      events_.assign(happened.begin() + std::ptrdiff_t(i), happened.end());
      tickS_ = now;
      return;
    }
    attempt([&] { handle(happened[i]); });
  }
  if (camera_.tick(std::min(now - tickS_, 0.1))) {
    changed();
    hoverStale_ = true;
    uiSteps_ = std::max(uiSteps_, 1);  // Labels and the scale bar go with it.
  }
  tickS_ = now;
  takeTool(mouse_);
  const std::vector<engine::JobView> jobs = bench_.jobs();
  if (jobs.size() != jobs_) changed();
  jobs_ = jobs.size();
  attempt([&] {
    followStylus(now);
    followDeformBox();
    Context c = context();
    if (followDrawnCurve(c) || followPlaneCut(c)) {
      hoverStale_ = true;
      uiSteps_ = std::max(uiSteps_, 1);
    }
    hover();
    if (!window_.minimised()) follow();
  });
  if (now >= nextUiS_) uiSteps_ = std::max(uiSteps_, 1);
  if (uiSteps_ > 0) {
    settleUi();
    spaceMouse_.yield(bench_.touch(false).device.rfind("spacemouse", 0) != 0);
    const bool lively = now - activeS_ < kLivelyS || panels_.moves() || ui_.wantsText();
    nextUiS_ = now + (lively ? kUiS : kQuietUiS);
    panelsFrame_ = ui_.frame();
    constexpr std::array kShapes = {CursorShape::arrow, CursorShape::text, CursorShape::arrow,
                                    CursorShape::resizeVertical, CursorShape::resizeHorizontal};
    const int wanted = ImGui::GetMouseCursor();
    const bool overClay = (footprint_ || state_.drawnCurve) && !ui_.wantsMouse() && !overWidget_;
    window_.setCursor(overClay                                         ? CursorShape::crosshair
                      : overWidget_ || wanted == ImGuiMouseCursor_Hand ? CursorShape::hand
                      : wanted >= 0 && size_t(wanted) < kShapes.size() ? kShapes[size_t(wanted)]
                                                                       : CursorShape::arrow);
  }
  serveRecording(now);
  if (serveSave() || servePicture()) return;
  if (!leave_ && window_.nowS() >= nextFrameS_) attempt([&] { draw(); });
}

// How long nothing needs to be done.
double SessionWindow::restS(double now) {
  if (pictures_.busy()) return kBusyS;
  if (!events_.empty()) return kWaitS;
  if (uiSteps_ > 0) return 0;
  const bool lively = now - changedS_ < kRestS || hand_.active() || jobs_ > 0 || !waiting_.pieces.empty() ||
                      !bench_.usesPointer() || spaceMouse_.there() || (player_ && player_->waiting());
  if (window_.minimised()) return kIdleS;
  double next = lively ? std::max(nextFrameS_, now + 0.004) : now + kIdleS;
  if (player_) next = std::min(next, player_->nextS());
  return std::max(0.0, next - now);
}

void SessionWindow::run() {
  if (!options_.notice.empty()) bench_.tell(engine::Message::Level::warning, options_.notice);
  bool settled = !options_.settled;
  while (!leave_) {
    if (!settled && window_.nowS() > kSettledS) {
      settled = true;
      options_.settled();
    }
    const int64_t began = haptics::nowNs(), core = haptics::threadWorkNs();
    gather();
    size_t done = 0;
    while (done < events_.size() && handleQuickly(events_[done])) ++done;
    events_.erase(events_.begin(), events_.begin() + std::ptrdiff_t(done));
    if (collect()) turn();
    const double due = hand_.pump(window_.nowS());
    if (options_.interrupted && options_.interrupted()) {
      bench_.leaveJournal();  // Nobody was asked: what is not saved can be had at the next start.
      leave_ = true;
    }
    if (leave_) break;
    log_.turned(haptics::nowNs() - began, haptics::threadWorkNs() - core);
    const double now = window_.nowS();
    tellRest();
    const int descriptors[] = {pen_.descriptor()};
    window_.wait(std::min(restS(now), due - now), std::span(descriptors, pen_.descriptor() >= 0 ? 1 : 0));
  }
  pictures_.finish();
  writeReport();
  if (options_.play.empty()) saveSettings(state_);
}

void SessionWindow::writeReport() {
  if (options_.report.empty()) return;
  FrameLog::Facts facts;
  facts.device = renderer_.deviceName();
  facts.deviceBytes = renderer_.deviceBytes();
  facts.validating = renderer_.validating();
  facts.validation = renderer_.validationMessages();
  facts.firstPictureMs = firstPictureMs_;
  facts.openedMs = openedMs_;
  facts.rssBytes = residentBytes();
  facts.droppedSamples = bench_.touch(true).droppedSamples;
  facts.losses = losses_;
  std::ofstream out(options_.report);
  out << log_.report(facts, *now_) << std::flush;
  if (!out) throw Error(fmt::format("--report {}: cannot be written", options_.report.string()), Error::Kind::work);
}

void runStudio(const StudioOptions& options) {
  if (!options.file.empty() && !std::filesystem::is_regular_file(options.file))
    throw Error(fmt::format("{}: there is no such file", options.file.string()));
  SessionWindow window(options);
  window.run();
}

}  // namespace argil::studio
