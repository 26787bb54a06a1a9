#pragma once
// What argil inspect says of moulds.

#include <nlohmann/json.hpp>
#include <optional>

#include "engine/print/pull_check.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {

/// Whether a pull was asked for. Throws Error for one that is no direction, and a draft without a pull.
[[nodiscard]] bool pullAsked(const InspectOptions& options);
/// Of a surface in the world; `unevenMm` as checkPull() takes it.
[[nodiscard]] engine::PullReport pullOf(const InspectOptions& options, const clay::TriangleMesh& mesh, double unevenMm);
void sayPull(const InspectOptions& options, const engine::PullReport& report);
[[nodiscard]] nlohmann::ordered_json pullJson(const engine::PullReport& report);

}  // namespace argil::cli
