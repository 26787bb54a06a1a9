#include "engine/piece_jobs.h"

namespace argil::engine {

std::span<const PieceJob> combineJobs() { return {}; }

}  // namespace argil::engine
