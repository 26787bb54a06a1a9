#pragma once
// What argil inspect says of printing.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/document/document.h"
#include "engine/print/pieces_meet.h"
#include "engine/print/print_check.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {

/// The way to print that was asked for, with its limits. Throws Error: an unknown one, limits that are none.
[[nodiscard]] std::optional<engine::PrintProcess> printOf(const InspectOptions& options);
void sayPrint(const engine::PrintProcess& process, const engine::PrintReport& report);
/// Of the pieces that are seen: which of them a printer would make one.
struct Meetings {
  std::vector<std::string> names;
  std::vector<engine::PiecesMeet> found;
};
[[nodiscard]] Meetings meetings(const engine::Document& document, double gapMm, Job* job);
/// Says nothing where there is one piece.
void sayMeetings(const Meetings& meetings, double gapMm);
[[nodiscard]] nlohmann::ordered_json meetingsJson(const Meetings& meetings);
[[nodiscard]] nlohmann::ordered_json printJson(const engine::PrintProcess& process, const engine::PrintReport& report);

}  // namespace argil::cli
