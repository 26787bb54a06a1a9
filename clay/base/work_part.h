#pragma once
// Progress of a part of some work, as part of the whole.

#include "clay/base/job.h"

namespace argil::clay {

/// Maps 0 to 1 of a part to what it is of the job. No job: nothing is reported. Any thread, as Job.
class WorkPart {
 public:
  explicit WorkPart(Job* job, double from = 0, double to = 1) : job_(job), from_(from), to_(to) {}
  /// Of work beside another part that tells how far it is: can be cancelled, and tells nothing.
  [[nodiscard]] WorkPart beside() const {
    WorkPart out = *this;
    out.tells_ = false;
    return out;
  }
  [[nodiscard]] WorkPart part(double from, double to) const {
    WorkPart out = *this;
    out.from_ = at(from);
    out.to_ = at(to);
    return out;
  }
  /// Throws Cancelled.
  void step(double fraction) const {
    if (!job_) return;
    if (tells_) return job_->step(at(fraction));
    if (job_->cancelled()) throw Cancelled();
  }

 private:
  [[nodiscard]] double at(double fraction) const { return from_ + (to_ - from_) * fraction; }

  Job* job_;
  double from_, to_;
  bool tells_ = true;
};

}  // namespace argil::clay
