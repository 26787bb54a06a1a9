#include "ui3d/cli/progress.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>

namespace argil::cli {

ProgressLine::ProgressLine(std::string what, const Job* job) {
  if (!job || !isatty(STDERR_FILENO)) return;
  thread_ = std::jthread([what = std::move(what), job](const std::stop_token& stop) {
    int shown = 0;
    for (int tenths = 0; !stop.stop_requested(); ++tenths) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      if (tenths < 3) continue;
      shown = std::fprintf(stderr, "\r%s %3.0f %%", what.c_str(), 100 * job->fraction());
      std::fflush(stderr);
    }
    if (shown > 0) std::fprintf(stderr, "\r%*s\r", shown, "");
  });
}

ProgressLine::~ProgressLine() {
  if (thread_.joinable()) thread_.request_stop();
}

}  // namespace argil::cli
