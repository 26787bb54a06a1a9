#include "ui3d/studio/input/hand.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace argil::studio {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
// The tip glides to where a cursor jumped (PointerOptions::smoothSeconds); the clay is pressed once it is there, for
// which the pointer waits if that takes longer.
constexpr double kSettleS = 0.016;
constexpr double kLastS = 0.012;  // From the last motion to the release: the tip has arrived.
// The pointer adds this much depth at full pressure; the studio's own depth goes with the tool's size and replaces it.
const double kPenDepthMm = haptics::PointerOptions().penDepthMm;
constexpr double kPlaceUnits = 2;  // Of the window, between the places of a straight line.
constexpr int kMostPlaces = 2000;

std::optional<double> surfaceUnder(const Hand::Stroke& stroke, const Camera::Ray& ray) {
  double from = 0;
  if (stroke.section) {  // What is cut away is not met.
    const double above = stroke.section->normal.dot(ray.origin - stroke.section->pointMm),
                 along = stroke.section->normal.dot(ray.direction);
    if (above > 0 && along < 0) from = -above / along;
  }
  return stroke.clay.distance(ray.origin, ray.direction, from);
}

}  // namespace

std::vector<Vec3d> Hand::placesUnder(const Stroke& stroke, const Event& from, const Event& to, bool deep) {
  const float dx = to.x - from.x, dy = to.y - from.y;
  const int count = std::clamp(static_cast<int>(std::hypot(dx, dy) / kPlaceUnits), 1, kMostPlaces);
  std::vector<Vec3d> places;
  for (int i = 0; i <= count; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(count);
    const Camera::Ray ray = stroke.camera.ray(from.x + t * dx, from.y + t * dy, stroke.width, stroke.height);
    const auto surface = surfaceUnder(stroke, ray);
    if (surface)
      places.push_back(ray.origin + (*surface + (deep ? stroke.depthPart * stroke.radiusMm : 0)) * ray.direction);
    else if (!places.empty())
      break;
  }
  return places;
}

void Hand::feed(const haptics::PointerSample& sample) {
  bench_.feedPointer(sample);
  if (std::isfinite(sample.surfaceMm)) place_ = sample.origin + sample.surfaceMm * sample.direction;
}

void Hand::hover(const Camera::Ray& ray, double surfaceMm, const Event& event) {
  if (active()) return;
  haptics::PointerSample sample;
  sample.origin = ray.origin;
  sample.direction = ray.direction;
  if (std::isfinite(surfaceMm)) lastSurfaceMm_ = surfaceMm;
  sample.surfaceMm = lastSurfaceMm_;
  sample.tiltX = event.tiltX;
  sample.tiltY = event.tiltY;
  feed(sample);
}

haptics::PointerSample Hand::sampleOf(const Event& event, bool down) {
  const Camera::Ray ray = stroke_->camera.ray(event.x, event.y, stroke_->width, stroke_->height);
  if (const auto hit = surfaceUnder(*stroke_, ray)) lastSurfaceMm_ = *hit;
  haptics::PointerSample sample;
  sample.origin = ray.origin;
  sample.direction = ray.direction;
  sample.buttons = down ? 1 : 0;
  sample.tiltX = event.tiltX;
  sample.tiltY = event.tiltY;
  sample.pressure = event.pressure;
  // A pen that hardly touches puts the tip on the clay, its centre a radius above; all its pressure takes it as deep as
  // a mouse goes.
  const double lifted = stroke_->cuts && event.pressure >= 0 ? -1 : 0;
  const double pressed = event.pressure >= 0 ? event.pressure : 1;
  const double depth = (lifted + (down ? pressed * (stroke_->depthPart - lifted) : 0)) * stroke_->radiusMm;
  sample.surfaceMm = lastSurfaceMm_ + depth - (event.pressure > 0 ? kPenDepthMm * event.pressure : 0);
  return sample;
}

void Hand::push(double timeS, const haptics::PointerSample& sample, bool last) {
  lastDueS_ = std::max(timeS, lastDueS_);
  due_.push_back({lastDueS_, sample, last});
}

void Hand::begin(Stroke stroke, const Event& event, double nowS) {
  while (!due_.empty()) {  // The stroke before ends now.
    feed(due_.front().sample);
    due_.pop_front();
  }
  stroke_ = std::move(stroke);
  released_ = false;
  lastDueS_ = nowS;
  haptics::PointerSample above = sampleOf(event, false), down = sampleOf(event, true);
  feed(above);
  lagS_ = nowS - event.timeS + kSettleS;
  push(nowS + kSettleS, down);
}

void Hand::move(const Event& event) {
  if (!pressed()) return;
  push(event.timeS + lagS_, sampleOf(event, true));
}

void Hand::end(const Event& event) {
  if (!pressed()) return;
  haptics::PointerSample down = sampleOf(event, true), up = sampleOf(event, false);
  push(event.timeS + lagS_, down);
  push(lastDueS_ + kLastS, up, true);
  released_ = true;
}

void Hand::leave() {
  if (!active()) bench_.pointerLeft();
}

double Hand::pump(double nowS) {
  while (!due_.empty() && due_.front().timeS <= nowS) {
    const Due due = due_.front();
    due_.pop_front();
    feed(due.sample);
    if (due.last) {
      stroke_.reset();
      released_ = false;
    }
  }
  return due_.empty() ? kNever : due_.front().timeS;
}

}  // namespace argil::studio
