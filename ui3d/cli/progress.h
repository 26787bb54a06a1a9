#pragma once
// Progress on a terminal.

#include <string>
#include <thread>

#include "clay/base/job.h"

namespace argil::cli {

/// Shows `what` and the job's percentage on stderr while it lives, when that is a terminal and the work takes longer
/// than 0.3 s; clears the line at the end.
class ProgressLine {
 public:
  ProgressLine(std::string what, const Job* job);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

 private:
  std::jthread thread_;
};

}  // namespace argil::cli
