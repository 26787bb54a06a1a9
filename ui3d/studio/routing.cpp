// Where an event goes: panels first, then widgets, then clay or camera.

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "ui3d/studio/cursor.h"
#include "ui3d/studio/session_window.h"

namespace argil::studio {
namespace {

using Kind = Event::Kind;

constexpr float kClickUnits = 4;       // A press that moves less is a click.
constexpr float kSizeUnits = 160;      // A drag so long makes the tool e times as large.
constexpr double kLongestMotionS = 0.1;

bool isModifier(Key key) { return key == Key::shift || key == Key::control || key == Key::alt || key == Key::super; }

}  // namespace

Camera::Ray SessionWindow::ray(const Event& event) const { return camera_.ray(event.x, event.y, width_, height_); }

Grip SessionWindow::grip(const Event& event, bool down) const {
  const Camera::Ray r = ray(event);
  Grip grip;
  grip.origin = r.origin;
  grip.direction = r.direction;
  grip.down = down;
  grip.snapOff = (event.modifiers & kControl) != 0;
  grip.constrain = (event.modifiers & kShift) != 0;
  return grip;
}

std::optional<render::Renderer::Hit> SessionWindow::pick(const Camera::Ray& r) const {
  return renderer_.pick(r.origin, r.direction, state_.look.section);
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
    hand_.move(event);
  } else if (event.kind == Kind::release && event.button == Button::left) {
    mouse_ = event;
    hand_.end(event);
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
  if (handleQuickly(event)) return;
  switch (event.kind) {
    case Kind::move: move(event); break;
    case Kind::press: press(event); break;
    case Kind::release: release(event); break;
    case Kind::wheel: wheel(event); break;
    case Kind::keyDown:
    case Kind::keyUp: key(event); break;
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
    case Kind::close: state_.quit = true; break;  // The panels ask where work would be lost.
    case Kind::motion6: {
      std::array<float, 6> axes = event.axes;
      for (float& axis : axes) axis = std::clamp(std::isfinite(axis) ? axis : 0.0f, -1.0f, 1.0f);
      camera_.motion(axes, std::clamp(event.timeS - motionS_, 0.0, kLongestMotionS));
      motionS_ = event.timeS;
      hoverStale_ = true;
      changed();
      break;
    }
    case Kind::lose: renderer_.simulateDeviceLoss(); break;
    default: ui_.feed(event); break;
  }
  // A text field that a key opened has the keyboard in the third frame.
  uiSteps_ = event.kind == Kind::keyDown ? 3 : 2;
}

// Keys that are held turn the tool over or make it smooth; a stroke keeps the tool that it began with.
void SessionWindow::takeTool(uint8_t modifiers) {
  if (hand_.active() || sizing_ || drag_ == Drag::line) return;
  const bool inPicture = drag_ == Drag::none && !ui_.wantsText();
  state_.inverted = inPicture && (modifiers & kControl) != 0;
  state_.smoothing = inPicture && (modifiers & kShift) != 0;
  const engine::Tool tool = state_.effectiveTool();
  if (toolSent_ && *toolSent_ == tool) return;
  bench_.setTool(tool);
  toolSent_ = tool;
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
    case Drag::orbit: camera_.orbit(dx, dy, height_, pivot_); break;
    case Drag::pan: camera_.pan(dx, dy, height_, panDepthMm_); break;
    case Drag::widget: {
      Context c = context();
      widgets_.handle(c, grip(event, true));
      break;
    }
    case Drag::curve:
      if (state_.drawnCurve) state_.drawnCurve->move(camera_, event.x, event.y, width_, height_, (event.modifiers & kShift) != 0);
      break;
    case Drag::click:
      // Beside the clay a drag turns the view, so that one button is enough.
      if (std::abs(event.x - dragFrom_.x) + std::abs(event.y - dragFrom_.y) > kClickUnits && !footprint_) drag_ = Drag::orbit;
      break;
    default: break;
  }
  changed();
}

// F and a drag: the ring grows and shrinks where it was.
bool SessionWindow::sizing(const Event& event) {
  if (!sizeKey_ || drag_ != Drag::none) return false;
  if (!sizing_ && std::abs(event.x - sizeFromX_) <= kClickUnits) return false;
  sizing_ = true;
  engine::Tool& tool = state_.tool();
  const double wanted = sizeFromMm_ * std::exp(double(event.x - sizeFromX_) / kSizeUnits);
  if (const engine::ToolRow* row = engine::findTool(state_.toolId))
    for (const auto& parameter : row->parameters)
      if (parameter.id == "radius") parameter.change(tool, wanted);
  changed();
  return true;
}

void SessionWindow::press(const Event& event) {
  mouse_ = event;
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
  Context c = context();
  const bool second = drag_ != Drag::none;
  if (second && (drag_ == Drag::stroke || drag_ == Drag::line || drag_ == Drag::widget || drag_ == Drag::curve)) return;
  dragFrom_ = event;
  pivot_ = under(event);
  panDepthMm_ = camera_.view().axes().forward.dot(pivot_ - camera_.view().position);
  // Two buttons pan, as do Shift and one of the buttons that orbit.
  if (second || (event.button != Button::left && (event.modifiers & kShift))) drag_ = Drag::pan;
  else if (event.button != Button::left || (event.modifiers & kAlt)) drag_ = Drag::orbit;
  else pressLeft(event, c);
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
  if (!piece || piece->id != hit->piece || !bench_.usesPointer() || state_.deformBox) return;  // Beside a point of the box nothing is carved by mistake.
  takeTool(event.modifiers);
  if (state_.straight) {
    line_ = strokeHere();
    drag_ = Drag::line;
  } else {
    hand_.begin(strokeHere(), event, window_.nowS());
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
  stroke.depthPart = engine::rowOf(tool).work == haptics::Work::cut ? std::clamp(state_.pointerDepthMm, 0.0, 1.0) : 0;
  return stroke;
}

void SessionWindow::endLine(const Event& event) {
  const Hand::Stroke stroke = std::move(*line_);
  line_.reset();
  if (std::vector<Vec3d> places = Hand::placesUnder(stroke, dragFrom_, event, true); places.size() >= 2) bench_.strokeAlong(std::move(places));
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
  if (drag_ == Drag::line && event.button == Button::left) {
    if (!click) endLine(event);
    line_.reset();
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
    if (click) widgets_.click(c, grip(event, false));
    drag_ = Drag::none;
  } else if (held_.empty()) {
    drag_ = Drag::none;
  } else if (drag_ == Drag::pan && held_.size() == 1 && !(event.modifiers & kShift)) {
    drag_ = *held_.begin() == Button::left && !(event.modifiers & kAlt) ? Drag::none : Drag::orbit;
  }
  hoverStale_ = true;
  changed();
}

void SessionWindow::wheel(const Event& event) {
  settleUi();
  ui_.feed(event);
  if (ui_.wantsMouse() || drag_ == Drag::stroke || drag_ == Drag::line || drag_ == Drag::curve) return;
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
    if (down && (event.modifiers & kControl) && panels_.letsThrough(c, {event.key, event.modifiers})) runShortcut(c, {event.key, event.modifiers});
    sizeKey_ = sizing_ = false;
    return;
  }
  takeTool(event.modifiers);
  const Shortcut shortcut{event.key, event.modifiers};
  const bool dialog = ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel);
  if (event.key == Key('F') && event.modifiers == 0 && !dialog) {
    // Alone it focuses; with a drag it sizes the tool. Which of them is known when it comes up.
    if (down && !event.repeat) {
      sizeKey_ = true;
      sizing_ = false;
      sizeFromMm_ = state_.tool().radiusMm;
      sizeFromX_ = mouse_.x;
    } else if (!down && sizeKey_) {
      const bool sized = sizing_;
      sizeKey_ = sizing_ = false;
      Context c = context();
      if (!sized) runShortcut(c, shortcut);
    }
    return;
  }
  if (!down || isModifier(event.key)) return;
  Context c = context();
  if (dialog && (event.key == Key::escape || event.key == Key::enter)) return;  // For what is on top: the panels have seen it.
  if (event.key == Key::escape) {
    if (state_.shown.firstStart && !widgets_.placing()) return;  // The start page closes.
    if (!state_.over.empty() && drag_ == Drag::none) return;  // They fold it.
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
    if (state_.deformBox && !dialog && drag_ == Drag::none && !widgets_.held() && !widgets_.placing()) {
      state_.deformBox->cancel = true;
      return;
    }
    if (sizing_) {
      state_.tool().radiusMm = sizeFromMm_;
      sizeKey_ = sizing_ = false;
      return;
    }
    if (widgets_.held() || widgets_.placing()) {
      widgets_.escape(c);
      if (drag_ == Drag::widget) drag_ = Drag::none;
      return;
    }
  }
  if (event.key == Key::enter && !state_.drawnCurve && widgets_.finish(c)) return;
  if (event.key == Key::enter && !state_.drawnCurve && state_.deformBox && !dialog) {
    state_.deformBox->apply = true;
    return;
  }
  if (event.key == Key::remove && widgets_.removePoint(c)) return;
  if (!dialog || panels_.letsThrough(c, shortcut)) runShortcut(c, shortcut);
}

// What the free cursor is over: once a picture, when something moved.
void SessionWindow::hover() {
  if (!hoverStale_ || drag_ == Drag::stroke || drag_ == Drag::line || drag_ == Drag::widget || drag_ == Drag::curve || sizing_) return;
  hoverStale_ = false;
  footprint_.reset();
  overWidget_ = false;
  if (!inWindow_ || ui_.wantsMouse() || drag_ != Drag::none || state_.drawnCurve) return;
  Context c = context();
  overWidget_ = widgets_.handle(c, grip(mouse_, false));
  const Camera::Ray r = ray(mouse_);
  double surface = std::numeric_limits<double>::quiet_NaN();
  if (const auto hit = pick(r)) {
    surface = hit->distanceMm;
    footprint_ = render::Cursor::Footprint{r.origin + surface * r.direction, hit->normal};
  }
  if (bench_.usesPointer()) hand_.hover(r, surface, mouse_);
}

}  // namespace argil::studio
