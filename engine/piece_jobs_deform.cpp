#include "engine/piece_jobs.h"

namespace argil::engine {

std::span<const PieceJob> deformJobs() { return {}; }

}  // namespace argil::engine
