// Linked into the test programs of the tsan preset only.

#include <tbb/global_control.h>

namespace {
const tbb::global_control oneThread(tbb::global_control::max_allowed_parallelism, 1);
}
