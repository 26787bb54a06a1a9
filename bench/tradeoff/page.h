#pragma once
// The trade-off for people: docs/tradeoff.md and its figure.

#include <filesystem>
#include <vector>

#include "bench/tradeoff/front.h"

namespace argil::bench {

/// Writes tradeoff.csv, tradeoff.svg and tradeoff.md into a folder, each whole or not at all.
void writeTradeoff(const std::vector<TradeoffRow>& measured, const std::filesystem::path& folder);

}  // namespace argil::bench
