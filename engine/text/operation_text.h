#pragma once
// Operations on whole pieces as scripts hold them: made from the rows of engine/tools/piece_jobs.h.

#include <nlohmann/json.hpp>

#include "engine/text/script.h"
#include "engine/text/script_place.h"

namespace argil::engine {

/// Throws Error for an operation that there is none of, for what is missing, unknown or out of range. `before` stays 0.
[[nodiscard]] ScriptOperation readOperation(const Place& place);
/// Throws Error for numbers that are not finite.
[[nodiscard]] nlohmann::ordered_json operationJson(const ScriptOperation& operation);

/// Keys of what the row takes beside its parameters, in the order in which operationJson() writes them.
[[nodiscard]] std::vector<std::string_view> keysOf(const PieceJob& row);

}  // namespace argil::engine
