#pragma once
// Progress of a part of some work, as part of the whole.

#include "clay/base/job.h"

namespace argil::clay {

/// Maps 0 to 1 of a part to what it is of the job. No job: nothing is reported. Any thread, as Job.
class WorkPart {
 public:
  explicit WorkPart(Job* job, double from = 0, double to = 1) : job_(job), from_(from), to_(to) {}
  [[nodiscard]] WorkPart part(double from, double to) const { return WorkPart(job_, at(from), at(to)); }
  /// Throws Cancelled.
  void step(double fraction) const {
    if (job_) job_->step(at(fraction));
  }

 private:
  [[nodiscard]] double at(double fraction) const { return from_ + (to_ - from_) * fraction; }

  Job* job_;
  double from_, to_;
};

}  // namespace argil::clay
