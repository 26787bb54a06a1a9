#pragma once
// Ctrl-C ends work in good order.

#include "clay/base/job.h"

namespace argil {

/// The job that SIGINT and SIGTERM cancel; the first call installs their handler, which a second signal leaves by
/// _exit: files are then still whole or absent. For main.
Job& interruptibleJob();

}  // namespace argil
