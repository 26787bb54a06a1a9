#pragma once
// What is done at each quality, and what is known of its result.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/document/quality.h"

namespace argil::bench {

struct TradeoffError {
  double rms = 0, most = 0, bytes = 0;
};

/// A workload of one part. run() is what is timed; error() looks at what the last run() left.
class TradeoffWork {
 public:
  virtual ~TradeoffWork() = default;
  virtual void run(const engine::Quality& quality) = 0;
  [[nodiscard]] virtual TradeoffError error() = 0;

  std::string name, unit = "mm";
};

/// Of clay: shapes that are known in closed form, and scans of ARGIL_DATA where that is set. Of strokes: tools over a
/// ball, beside the same with every axis at its dearest. Of touch: paths over clay, beside the same. Of surface: how
/// far vertices are off known shapes.
[[nodiscard]] std::vector<std::unique_ptr<TradeoffWork>> tradeoffWork(engine::QualityPart part);

}  // namespace argil::bench
