#pragma once
// Plays a recording in place of a person.

#include <filesystem>
#include <optional>
#include <vector>

#include "ui3d/studio/view/event.h"

namespace argil::studio {

/// Events come at their times; a check stops the recording's clock until it holds, a screenshot until it was taken. One
/// thread.
class Player {
 public:
  static constexpr double kCheckSeconds = 60;

  /// `speed`: so many times as fast as it was recorded. Throws Error for a recording that is none.
  explicit Player(const std::filesystem::path& file, double speed = 1);

  /// Moves events that are due into `events`, their times made the studio's; stops at the next check or screenshot.
  void poll(double nowS, std::vector<Event>& events);
  /// The check or screenshot that is to be done now, or null.
  [[nodiscard]] const Event* waiting() const;
  /// It was done: the recording goes on from there.
  void passed(double nowS);
  /// A check that has waited too long.
  [[nodiscard]] bool stuck(double nowS) const;
  /// When the next event is due; infinity while waiting or at the end.
  [[nodiscard]] double nextS() const;
  [[nodiscard]] bool over() const { return next_ == events_.size(); }
  /// Of the next event, from 1.
  [[nodiscard]] size_t position() const { return next_ + 1; }

 private:
  std::vector<Event> events_;
  size_t next_ = 0;
  double offsetS_ = 0;           // Studio's clock less the recording's.
  std::optional<double> heldS_;  // Since when it waits.
};

}  // namespace argil::studio
