#pragma once
// What argil inspect says of printing.

#include <nlohmann/json.hpp>
#include <optional>

#include "engine/print/print_check.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {

/// The way to print that was asked for, with its limits. Throws Error: an unknown one, limits that are none.
[[nodiscard]] std::optional<engine::PrintProcess> printOf(const InspectOptions& options);
void sayPrint(const engine::PrintProcess& process, const engine::PrintReport& report);
[[nodiscard]] nlohmann::ordered_json printJson(const engine::PrintProcess& process, const engine::PrintReport& report);

}  // namespace argil::cli
