#include "clay/base/interrupt.h"

#include <unistd.h>

#include <csignal>

namespace argil {

Job& interruptibleJob() {
  static Job job;
  static const bool installed = [] {
    struct sigaction action {};
    action.sa_handler = [](int) {
      // The second Ctrl-C ends the program the hard way: files are still whole or absent.
      if (job.cancelled()) _exit(1);
      job.cancel();
    };
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    return true;
  }();
  static_cast<void>(installed);
  return job;
}

}  // namespace argil
