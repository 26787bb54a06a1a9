// Where an event goes: panels first, then widgets, then clay or camera.

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "ui3d/studio/session_window.h"
#include "ui3d/studio/view/cursor.h"

namespace argil::studio {
namespace {

using Kind = Event::Kind;

constexpr float kClickUnits = 4;   // A press that moves less is a click.
constexpr float kSizeUnits = 160;  // A drag so long makes the tool e times as large.
constexpr float kZoomUnits = 30;   // A drag so long in the ring zooms as a click of the wheel.
constexpr double kTapS = 0.6;      // A key that is down for longer was held.
constexpr double kLongestMotionS = 0.1;
// Of the hand of a simulated device, mm of the device: how far it stays above the clay, and how deep it pushes: 2 N at
// the hand's stiffness of 0.5 N/mm.
constexpr double kSteeredAboveMm = 2, kSteeredDepthMm = 4;
constexpr double kLongestEndS = 0.25;  // From a release to the tick that sees it.
// A press waits no longer for its tool, as if the edit thread hung: then the stroke has that of the one before.
constexpr double kToolPatienceS = 5;

bool isModifier(Key key) {
  return key == Key::shift || key == Key::control || key == Key::alt || key == Key::super;
}

}  // namespace

// Where each eye has a half of the window: the place in its picture, as it would be in all of the window.
Event SessionWindow::inEye(Event event) const {
  if (!state_.stereo.splits()) return event;
  const bool beside = state_.stereo.mode == render::StereoMode::sideBySide;
  float& at = beside ? event.x : event.y;
  const float whole = beside ? width_ : height_;
  at = at < whole / 2 ? 2 * at : 2 * at - whole;
  return event;
}

Camera::Ray SessionWindow::ray(const Event& event) const {
  const Event in = inEye(event);
  return camera_.ray(in.x, in.y, width_, height_);
}

Grip SessionWindow::grip(const Event& event, bool down) const {
  const Camera::Ray r = ray(event);
  Grip grip;
  grip.origin = r.origin;
  grip.direction = r.direction;
  grip.down = down;
  grip.snapOff = (event.modifiers & kControl) != 0;
  grip.adds = grip.snapOff;
  grip.constrain = (event.modifiers & kShift) != 0;
  return grip;
}

std::optional<render::Renderer::Hit> SessionWindow::pick(const Camera::Ray& r) const {
  return renderer_.pick(r.origin, r.direction, state_.look.section);
}

// The hand of a simulated device, which the mouse moves: over the clay it hovers, pressed it pushes into the clay as it
// was when the button went down.
void SessionWindow::steer(const Event& event, bool down) {
  const Camera::Ray r = ray(event);
  std::optional<Vec3d> surface;
  if (steered_) {
    const Event at = inEye(event);
    if (const std::vector<Vec3d> places = Hand::placesUnder(*steered_, at, at, false); !places.empty())
      surface = places.front();
  } else if (const auto hit = pick(r)) {
    surface = Vec3d(r.origin + hit->distanceMm * r.direction);
  }
  const double radius = state_.effectiveTool(false).radiusMm, scale = state_.workspace.scale;
  const double above = down ? -kSteeredDepthMm * scale : radius + kSteeredAboveMm * scale;
  if (surface) steeredAt_ = *surface - above * r.direction;
  steerTo(steeredAt_, down);
}

void SessionWindow::steerTo(const Vec3d& world, bool down) {
  steeredAt_ = world;
  haptics::Workspace workspace = state_.workspace;
  if (workspace.frame == haptics::Handedness::either) workspace.frame = bench_.touch(false).sheet.handedness;
  haptics::HandPoint wanted;
  wanted.position = workspace.toDevice(world);
  wanted.pressure = down ? 1.0f : 0.0f;
  wanted.buttons = down ? 1u : 0u;
  bench_.steerSimulated(wanted);
}

// What is under the cursor; where nothing is, a point as far away as the target.
Vec3d SessionWindow::under(const Event& event) const {
  const Camera::Ray r = ray(event);
  if (const auto hit = pick(r)) return r.origin + hit->distanceMm * r.direction;
  const render::View& view = camera_.view();
  const Vec3d forward = view.axes().forward;
  const double along = forward.dot(r.direction);
  return along > 1e-6 ? Vec3d(r.origin + (forward.dot(view.target - r.origin) / along) * r.direction) : view.target;
}

// While a picture is drawn, only what the renderer is not needed for.
bool SessionWindow::handleQuickly(const Event& event) {
  if (drag_ != Drag::stroke || !hand_.pressed()) return false;
  if (event.kind == Kind::move) {
    mouse_ = event;
    hand_.move(inEye(event));
  } else if (event.kind == Kind::release && event.button == Button::left) {
    mouse_ = event;
    hand_.end(inEye(event));
    held_.erase(Button::left);
    ui_.feed(event);
    uiSteps_ = 2;
    drag_ = Drag::none;
    hoverStale_ = true;
  } else {
    return false;
  }
  changed();
  return true;
}

void SessionWindow::handle(const Event& event) {
  activeS_ = std::max(activeS_, event.timeS);
  tapAlt(event);
  if (handleQuickly(event)) return;
  switch (event.kind) {
    case Kind::move:
      move(event);
      break;
    case Kind::press:
      press(event);
      break;
    case Kind::release:
      release(event);
      break;
    case Kind::wheel:
      wheel(event);
      break;
    case Kind::keyDown:
    case Kind::keyUp:
      key(event);
      break;
    case Kind::enter:
      inWindow_ = true;
      mouse_ = event;
      ui_.feed(event);
      break;
    case Kind::leave:
      if (drag_ != Drag::none) break;  // A drag goes on outside.
      inWindow_ = false;
      footprint_.reset();
      hand_.leave();
      ui_.feed(event);
      break;
    case Kind::resize:
      scale_ = event.scale;
      width_ = float(std::max(event.width, 1)) / scale_;
      height_ = float(std::max(event.height, 1)) / scale_;
      shotShown_ = 0;  // Also one of the same size: something uncovered the window.
      changed();
      break;
    case Kind::drop: {
      Context c = context();
      panels_.dropped(c, event.text);
      break;
    }
    case Kind::close:
      state_.quit = true;
      break;  // The panels ask where work would be lost.
    case Kind::motion6: {
      std::array<float, 6> axes = event.axes;
      for (float& axis : axes) axis = std::clamp(std::isfinite(axis) ? axis : 0.0f, -1.0f, 1.0f);
      camera_.motion(axes, std::clamp(event.timeS - motionS_, 0.0, kLongestMotionS));
      motionS_ = event.timeS;
      hoverStale_ = true;
      changed();
      break;
    }
    case Kind::lose:
      renderer_.simulateDeviceLoss();
      break;
    default:
      ui_.feed(event);
      break;
  }
  // A text field that a key opened has the keyboard in the third frame.
  uiSteps_ = event.kind == Kind::keyDown ? 3 : 2;
}

// Alt pressed and let go alone opens the menus, to be gone through by arrows, or closes them. Alt held turns the view
// by a drag.
void SessionWindow::tapAlt(const Event& event) {
  switch (event.kind) {
    case Kind::keyDown:
      if (event.key != Key::alt || !event.repeat)
        altS_ = event.key == Key::alt && held_.empty() && drag_ == Drag::none ? event.timeS : -1;
      break;
    case Kind::keyUp:
      if (event.key != Key::alt) break;
      if (altS_ >= 0 && event.timeS - altS_ < kTapS) panels_.turnMenus();
      altS_ = -1;
      break;
    case Kind::press:
    case Kind::wheel:
    case Kind::focus:
      altS_ = -1;
      break;
    default:
      break;
  }
}

// Ctrl or the eraser end of a pen turn the tool over, Shift makes it smooth. What cannot be turned over is smoothed
// away.
void SessionWindow::holdKeys(const Event& held) {
  const bool inPicture = (drag_ == Drag::none || drag_ == Drag::click) && !ui_.wantsText();
  const engine::ToolRow* row = engine::findTool(state_.toolId);
  state_.inverted = inPicture && ((held.modifiers & kControl) != 0) != held.eraser;
  state_.smoothing = inPicture && ((held.modifiers & kShift) != 0 || (held.eraser && row && row->opposite.empty()));
}

bool SessionWindow::toolDiffers(const Event& held) {
  const bool inverted = state_.inverted, smoothing = state_.smoothing;
  holdKeys(held);
  const bool differs = !toolSent_ || !(*toolSent_ == state_.effectiveTool(bench_.usesPointer()));
  state_.inverted = inverted;
  state_.smoothing = smoothing;
  return differs;
}

// A stroke keeps the tool that it began with, until the servo has seen its end.
void SessionWindow::takeTool(const Event& held) {
  const double now = window_.nowS();
  if (hand_.active()) strokeS_ = now;
  if (hand_.active() || sizing_ || drag_ == Drag::line) return;
  if (bench_.usesPointer() && now - strokeS_ < kLongestEndS && (bench_.latest().buttons & 1) != 0) return;
  holdKeys(held);
  const engine::Tool tool = state_.effectiveTool(bench_.usesPointer());
  if (toolSent_ && *toolSent_ == tool) return;
  bench_.setTool(tool);
  toolSent_ = tool;
}

// A press that may begin a stroke waits until the stroke before it has ended and its own tool is in the hand: some
// milliseconds. Without that a stroke would begin with the tool of the one before.
bool SessionWindow::waits(const Event& event) {
  if (event.kind != Kind::press || event.button != Button::left || drag_ != Drag::none || !bench_.usesPointer())
    return false;
  if (sizeKey_) return false;  // It sizes the tool.
  if (window_.nowS() - event.timeS > kToolPatienceS) return false;
  if (toolDiffers(event)) {
    takeTool(event);
    if (toolDiffers(event)) return true;  // The stroke before is not over.
  }
  return !bench_.toolTaken();
}

void SessionWindow::move(const Event& event) {
  const Event before = mouse_;
  mouse_ = event;
  inWindow_ = true;
  const float dx = event.x - before.x, dy = event.y - before.y;
  ui_.feed(event);
  hoverStale_ = true;
  if (sizing(event)) return;
  switch (drag_) {
    case Drag::orbit:
      camera_.orbit(dx, dy, height_, pivot_);
      break;
    case Drag::pan:
      camera_.pan(dx, dy, height_, panDepthMm_);
      break;
    case Drag::widget: {
      Context c = context();
      widgets_.handle(c, grip(event, true));
      break;
    }
    case Drag::curve:
      if (state_.drawnCurve)
        state_.drawnCurve->move(camera_, event.x, event.y, width_, height_, (event.modifiers & kShift) != 0);
      break;
    case Drag::ring:
      dragRing(event, dx, dy);
      break;
    case Drag::steer:
      steer(event, true);
      break;
    case Drag::size:
      scaleTool(event);
      break;
    case Drag::click:
      // Beside the clay a drag turns the view, so that one button is enough.
      if (std::abs(event.x - dragFrom_.x) + std::abs(event.y - dragFrom_.y) > kClickUnits && !footprint_)
        drag_ = Drag::orbit;
      break;
    default:
      break;
  }
  changed();
}

// F and a drag: the ring grows and shrinks where it was.
bool SessionWindow::sizing(const Event& event) {
  if (!sizeKey_ || sizeDragged_ || drag_ != Drag::none) return false;
  if (!sizing_ && std::abs(event.x - sizeFromX_) <= kClickUnits) return false;
  sizing_ = true;
  scaleTool(event);
  changed();
  return true;
}

// With F held a drag with the left button sizes the tool as well: it touches neither clay nor widgets, and goes on when
// F comes up first.
bool SessionWindow::pressSize(const Event& event) {
  if (!sizeKey_ || drag_ != Drag::none || event.button != Button::left) return false;
  held_.insert(event.button);
  drag_ = Drag::size;
  sizing_ = sizeDragged_ = true;
  sizeFromMm_ = state_.tool().radiusMm;
  sizeFromX_ = event.x;
  return true;
}

void SessionWindow::scaleTool(const Event& event) {
  const double wanted = sizeFromMm_ * std::exp(double(event.x - sizeFromX_) / kSizeUnits);
  const engine::ToolRow* row = engine::findTool(state_.toolId);
  if (const auto* radius = row ? engine::findParameter(*row, "radius") : nullptr) radius->change(state_.tool(), wanted);
}

// The ring stands over everything: what is pressed in it is for nothing else.
bool SessionWindow::pressRing(const Event& event) {
  if (!ring_ || drag_ != Drag::none) return false;
  if (event.button != Button::left) {  // Put away; a drag turns the view as ever.
    ring_.reset();
    ringClosed_ = true;
    return false;
  }
  held_.insert(event.button);
  dragFrom_ = event;
  ringItem_ = ring_->at(event.x, event.y);
  if (ringItem_ == QuickRing::Item::none) {
    ring_.reset();
    drag_ = Drag::panel;  // Nothing is carved by a press that puts the ring away.
    return true;
  }
  drag_ = Drag::ring;
  Event centre = event;
  centre.x = ring_->x;
  centre.y = ring_->y;
  pivot_ = under(centre);
  panDepthMm_ = camera_.view().axes().forward.dot(pivot_ - camera_.view().position);
  footprint_.reset();
  if (ringItem_ == QuickRing::Item::size) {
    const Camera::Ray r = ray(centre);
    const auto hit = pick(r);
    footprint_ = hit ? render::Cursor::Footprint{r.origin + hit->distanceMm * r.direction, hit->normal}
                     : render::Cursor::Footprint{pivot_, -camera_.view().axes().forward};
    sizing_ = true;
    sizeFromMm_ = state_.tool().radiusMm;
    sizeFromX_ = event.x;
  }
  return true;
}

void SessionWindow::dragRing(const Event& event, float dx, float dy) {
  switch (ringItem_) {
    case QuickRing::Item::move:
      camera_.pan(dx, dy, height_, panDepthMm_);
      break;
    case QuickRing::Item::zoom:
      camera_.zoom((dx - dy) / kZoomUnits, pivot_);
      break;
    case QuickRing::Item::size:
      scaleTool(event);
      break;
    default:
      break;
  }
}

void SessionWindow::releaseRing(const Event& event) {
  const QuickRing::Item item = std::exchange(ringItem_, QuickRing::Item::none);
  drag_ = Drag::none;
  sizing_ = false;
  if (QuickRing::dragged(item)) {
    ring_.reset();
    return;
  }
  if (!ring_ || ring_->at(event.x, event.y) != item) return;
  Context c = context();
  const char* id = item == QuickRing::Item::undo   ? "edit.undo"
                   : item == QuickRing::Item::redo ? "edit.redo"
                                                   : "view.all";
  if (item == QuickRing::Item::all) ring_.reset();  // Undo is often wanted again.
  const Action* action = findAction(id);
  if (action && (!action->enabled || action->enabled(c))) action->run(c, action->argument);
}

void SessionWindow::press(const Event& event) {
  mouse_ = event;
  if (pressRing(event)) {
    changed();
    return;
  }
  Event place = event;
  place.kind = Kind::move;
  ui_.feed(place);
  settleUi();  // Now it is known what the cursor is over.
  const bool overPanel = ui_.wantsMouse();
  ui_.feed(event);
  held_.insert(event.button);
  if (drag_ == Drag::panel || (drag_ == Drag::none && overPanel)) {
    drag_ = Drag::panel;
    return;
  }
  if (pressSize(event)) {
    changed();
    return;
  }
  Context c = context();
  const bool second = drag_ != Drag::none;
  if (second && (drag_ == Drag::stroke || drag_ == Drag::line || drag_ == Drag::steer || drag_ == Drag::widget ||
                 drag_ == Drag::curve || drag_ == Drag::size))
    return;
  dragFrom_ = event;
  pivot_ = under(event);
  panDepthMm_ = camera_.view().axes().forward.dot(pivot_ - camera_.view().position);
  // Two buttons pan, as do Shift and one of the buttons that orbit.
  if (second || (event.button != Button::left && (event.modifiers & kShift)))
    drag_ = Drag::pan;
  else if (event.button != Button::left || (event.modifiers & kAlt))
    drag_ = Drag::orbit;
  else
    pressLeft(event, c);
  changed();
}

void SessionWindow::pressLeft(const Event& event, Context& c) {
  if (state_.drawnCurve) {
    drag_ = state_.drawnCurve->press(camera_, event.x, event.y, width_, height_) ? Drag::curve : Drag::panel;
    return;
  }
  placing_ = widgets_.placing();
  if (widgets_.handle(c, grip(event, true))) {
    drag_ = Drag::widget;
    return;
  }
  drag_ = Drag::click;
  footprint_.reset();
  const Camera::Ray r = ray(event);
  const auto hit = pick(r);
  if (!hit) return;
  footprint_ = render::Cursor::Footprint{r.origin + hit->distanceMm * r.direction, hit->normal};
  const engine::Piece* piece = now_->document->workedOn();
  // A piece that is not worked on is beside the clay: a click on it chooses it, a drag turns the view.
  if (!piece || piece->id != hit->piece) footprint_.reset();
  if (state_.planeCut) footprint_.reset();  // A drag beside the plane's handles turns the view.
  // Beside a point of the box nothing is carved by mistake.
  if (piece && piece->id == hit->piece && bench_.usesSimulated() && !state_.deformBox && !state_.planeCut) {
    steered_ = strokeHere();
    drag_ = Drag::steer;
    steer(event, true);
    return;
  }
  if (!piece || piece->id != hit->piece || !bench_.usesPointer() || state_.deformBox || state_.planeCut) return;
  takeTool(event);
  if (state_.straight) {
    line_ = strokeHere();
    drag_ = Drag::line;
  } else {
    hand_.begin(strokeHere(), inEye(event), window_.nowS());
    drag_ = Drag::stroke;
  }
}

// What a stroke that begins now meets.
Hand::Stroke SessionWindow::strokeHere() const {
  Hand::Stroke stroke;
  stroke.clay = PinnedClay(*now_->document, [this](engine::Id id) { return renderer_.bounds(id); });
  stroke.camera = camera_;
  stroke.width = width_;
  stroke.height = height_;
  stroke.section = state_.look.section;
  const engine::Tool tool = toolSent_.value_or(engine::Tool());
  stroke.radiusMm = tool.radiusMm;
  stroke.cuts = engine::workOf(tool) == haptics::Work::cut;
  stroke.depthPart = stroke.cuts ? std::clamp(state_.pointerDepthMm, 0.0, 1.0) : 0;
  return stroke;
}

void SessionWindow::endLine(const Event& event) {
  const Hand::Stroke stroke = std::move(*line_);
  line_.reset();
  if (std::vector<Vec3d> places = Hand::placesUnder(stroke, inEye(dragFrom_), inEye(event), true); places.size() >= 2)
    bench_.strokeAlong(std::move(places));
}

void SessionWindow::release(const Event& event) {
  mouse_ = event;
  settleUi();  // ImGui sees presses and releases of different frames only.
  ui_.feed(event);
  held_.erase(event.button);
  if (drag_ == Drag::panel) {  // What was clicked is clicked before the next motion of the same batch leaves it.
    uiSteps_ = 2;
    settleUi();
  }
  const bool click = std::abs(event.x - dragFrom_.x) + std::abs(event.y - dragFrom_.y) <= kClickUnits;
  const bool closedRing = std::exchange(ringClosed_, false);
  const bool opensRing = click && drag_ == Drag::orbit && event.button != Button::left && held_.empty() &&
                         !closedRing && !(event.modifiers & (kShift | kAlt | kControl)) && !widgets_.placing();
  if (opensRing) ring_ = QuickRing::around(event.x, event.y, width_, height_);
  if (drag_ == Drag::ring && event.button == Button::left) {
    releaseRing(event);
  } else if (drag_ == Drag::size && event.button == Button::left) {
    drag_ = Drag::none;
    if (!sizeKey_) sizing_ = false;
  } else if (drag_ == Drag::line && event.button == Button::left) {
    if (!click) endLine(event);
    line_.reset();
    drag_ = Drag::none;
  } else if (drag_ == Drag::steer && event.button == Button::left) {
    steered_.reset();
    steer(event, false);
    drag_ = Drag::none;
  } else if (drag_ == Drag::curve && event.button == Button::left) {
    if (state_.drawnCurve) state_.drawnCurve->release(camera_, width_, height_);
    drag_ = Drag::none;
  } else if (drag_ == Drag::widget && event.button == Button::left) {
    Context c = context();
    widgets_.handle(c, grip(event, false));
    if (std::exchange(placing_, false)) widgets_.click(c, grip(event, false));  // Its press was a point already.
    drag_ = Drag::none;
  } else if (drag_ == Drag::click && event.button == Button::left) {
    Context c = context();
    const Grip last = grip(event, false);
    if (click && widgets_.click(c, last) && !last.adds) workOnSelected();
    drag_ = Drag::none;
  } else if (held_.empty()) {
    drag_ = Drag::none;
  } else if (drag_ == Drag::pan && held_.size() == 1 && !(event.modifiers & kShift)) {
    drag_ = *held_.begin() == Button::left && !(event.modifiers & kAlt) ? Drag::none : Drag::orbit;
  }
  hoverStale_ = true;
  changed();
}

// What is clicked in the picture is worked on from now on, as in the list.
void SessionWindow::workOnSelected() {
  const engine::Piece* piece = now_->document->piece(state_.selected);
  if (!piece || piece->id == now_->document->active || piece->locked) return;
  bench_.edit(
      "Work on " + piece->name,
      [id = piece->id](engine::Document& d) {
        if (d.piece(id)) d.active = id;
      },
      "active");
  bench_.tell(engine::Message::Level::done, piece->name + " is worked on now.");
}

void SessionWindow::wheel(const Event& event) {
  settleUi();
  ui_.feed(event);
  if (ui_.wantsMouse() || drag_ == Drag::stroke || drag_ == Drag::line || drag_ == Drag::steer || drag_ == Drag::curve)
    return;
  camera_.zoom(event.dy, under(mouse_));
  hoverStale_ = true;
  changed();
}

void SessionWindow::key(const Event& event) {
  settleUi();
  const bool typing = ui_.wantsText();
  ui_.feed(event);
  mouse_.modifiers = event.modifiers;
  changed();
  const bool down = event.kind == Kind::keyDown;
  if (typing) {
    Context c = context();
    if (down && (event.modifiers & kControl) && panels_.letsThrough(c, {event.key, event.modifiers}))
      runShortcut(c, {event.key, event.modifiers});
    sizeKey_ = sizing_ = false;
    return;
  }
  Event held = mouse_;
  held.modifiers = event.modifiers;
  takeTool(held);
  const Shortcut shortcut{event.key, event.modifiers};
  const bool dialog = ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel);
  if (event.key == Key('F') && event.modifiers == 0 && !dialog) {
    // Alone it focuses; with a drag it sizes the tool. Which of them is known when it comes up.
    if (down && !event.repeat) {
      sizeKey_ = true;
      sizing_ = sizeDragged_ = false;
      sizeFromMm_ = state_.tool().radiusMm;
      sizeFromX_ = mouse_.x;
    } else if (!down && sizeKey_) {
      const bool sized = sizing_;
      sizeKey_ = false;
      sizing_ = drag_ == Drag::size;
      Context c = context();
      if (!sized) runShortcut(c, shortcut);
    }
    return;
  }
  if (!down || isModifier(event.key)) return;
  Context c = context();
  // For what is on top: the panels have seen it.
  if (dialog && (event.key == Key::escape || event.key == Key::enter)) return;
  if (event.key == Key::escape) {
    if (state_.stereo.splits() && !dialog && !ring_ && drag_ == Drag::none && !widgets_.held()) {
      state_.stereo.mode = render::StereoMode::mono;
      return;
    }
    if (ring_) {
      if (sizing_) state_.tool().radiusMm = sizeFromMm_;
      ring_.reset();
      sizing_ = false;
      if (drag_ == Drag::ring) drag_ = Drag::panel;
      return;
    }
    if (state_.shown.firstStart && !widgets_.placing()) return;  // The start page closes.
    if (!state_.over.empty() && drag_ == Drag::none) return;     // They fold it.
    if (drag_ == Drag::line) {
      line_.reset();
      drag_ = Drag::panel;  // Until the button comes up.
      return;
    }
    if (state_.drawnCurve && !dialog) {
      if (drag_ == Drag::curve) {
        state_.drawnCurve->clear();
        drag_ = Drag::panel;
      } else {
        state_.drawnCurve->cancel = true;
      }
      return;
    }
    const bool free = !dialog && drag_ == Drag::none && !widgets_.held() && !widgets_.placing();
    if (state_.planeCut && free) {
      state_.planeCut->cancel = true;
      return;
    }
    if (state_.deformBox && free) {
      state_.deformBox->cancel = true;
      return;
    }
    if (sizing_) {
      state_.tool().radiusMm = sizeFromMm_;
      sizeKey_ = sizing_ = false;
      if (drag_ == Drag::size) drag_ = Drag::panel;
      return;
    }
    if (widgets_.held() || widgets_.placing()) {
      widgets_.escape(c);
      if (drag_ == Drag::widget) drag_ = Drag::none;
      return;
    }
  }
  if (event.key == Key::enter && !state_.drawnCurve && widgets_.finish(c)) return;
  if (event.key == Key::enter && !state_.drawnCurve && state_.planeCut && !dialog) {
    state_.planeCut->apply = true;
    return;
  }
  if (event.key == Key::enter && !state_.drawnCurve && state_.deformBox && !dialog) {
    state_.deformBox->apply = true;
    return;
  }
  if (event.key == Key::remove && widgets_.removePoint(c)) return;
  if (!dialog || panels_.letsThrough(c, shortcut)) runShortcut(c, shortcut);
}

// What the free cursor is over: once a picture, when something moved.
void SessionWindow::hover() {
  if (!hoverStale_ || drag_ == Drag::stroke || drag_ == Drag::line || drag_ == Drag::steer || drag_ == Drag::widget ||
      drag_ == Drag::curve || sizing_)
    return;
  hoverStale_ = false;
  footprint_.reset();
  overWidget_ = false;
  state_.otherPiece = 0;
  if (!inWindow_ || ui_.wantsMouse() || drag_ != Drag::none || state_.drawnCurve || ring_) return;
  Context c = context();
  overWidget_ = widgets_.handle(c, grip(mouse_, false));
  const Camera::Ray r = ray(mouse_);
  double surface = std::numeric_limits<double>::quiet_NaN();
  if (const auto hit = pick(r)) {
    surface = hit->distanceMm;
    footprint_ = render::Cursor::Footprint{r.origin + surface * r.direction, hit->normal};
    const engine::Piece* piece = now_->document->piece(hit->piece);
    if (piece && !piece->locked && piece->id != now_->document->active) state_.otherPiece = piece->id;
  }
  if (bench_.usesPointer())
    hand_.hover(r, surface, mouse_);
  else if (bench_.usesSimulated() && !overWidget_)
    steer(mouse_, false);
}

}  // namespace argil::studio
