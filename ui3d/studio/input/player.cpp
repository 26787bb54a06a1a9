#include "ui3d/studio/input/player.h"

#include <limits>

#include "ui3d/studio/input/event_log.h"

namespace argil::studio {
namespace {

bool holds(const Event& event) {
  return event.kind == Event::Kind::check || event.kind == Event::Kind::screenshot;
}

}  // namespace

Player::Player(const std::filesystem::path& file, double speed) : events_(readEvents(file)) {
  for (Event& event : events_) event.timeS /= speed;
}

void Player::poll(double nowS, std::vector<Event>& events) {
  while (next_ < events_.size() && events_[next_].timeS + offsetS_ <= nowS) {
    if (holds(events_[next_])) {
      if (!heldS_) heldS_ = nowS;
      return;
    }
    events.push_back(events_[next_++]);
    events.back().timeS += offsetS_;
  }
}

const Event* Player::waiting() const {
  return heldS_ ? &events_[next_] : nullptr;
}

void Player::passed(double nowS) {
  offsetS_ = nowS - events_[next_].timeS;
  ++next_;
  heldS_.reset();
}

bool Player::stuck(double nowS) const {
  return heldS_ && nowS - *heldS_ > kCheckSeconds;
}

double Player::nextS() const {
  return heldS_ || over() ? std::numeric_limits<double>::infinity() : events_[next_].timeS + offsetS_;
}

}  // namespace argil::studio
