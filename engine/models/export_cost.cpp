#include "engine/models/export_cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace argil::engine {
namespace {

// The time of a dab of 20 voxels on the machine where the seconds below were measured.
constexpr double kReferenceMs = 0.646;
// Measured on a ball and a sculpted head of 135 000 triangles: quads with pictures of 2048 pixels, smooth faces.
constexpr double kQuadsBeginS = 10, kQuadS = 0.004, kQuadsMost = 1.6;
constexpr double kFacesBeginS = 4, kFaceS = 0.032, kFacesMost = 6;
constexpr double kFirstFaces = 100, kMostFacesTried = 2000;  // Counts of faces where an error is asked for.

// 17 becomes 15, 23 becomes 25; minutes from 90 s on.
std::string rounded(double seconds) {
  if (seconds >= 90) return fmt::format("{:.0f} min", std::ceil(seconds / 60 - 0.5));
  const double step = seconds >= 50 ? 10 : seconds >= 10 ? 5 : 1;
  return fmt::format("{:.0f} s", std::max(1.0, step * std::round(seconds / step)));
}

}  // namespace

ExportTime exportTime(const ModelExport& what, size_t pieces, bool quads, bool cad, const MachineSpeed& machine) {
  ExportTime time;
  if (quads && what.quads) {
    const double seconds = kQuadsBeginS + kQuadS * double(*what.quads);
    time.leastS += seconds;
    time.mostS += kQuadsMost * seconds;
  }
  if (cad) {
    const double least = what.cadErrorMm ? kFirstFaces : double(what.cadQuads),
                 most = what.cadErrorMm ? kMostFacesTried : double(what.cadQuads);
    time.leastS += kFacesBeginS + kFaceS * least;
    time.mostS += kFacesMost * (kFacesBeginS + kFaceS * most);
  }
  const double by = double(pieces) * machine.dabMs(20, 3, 1.5) / kReferenceMs;
  time.leastS *= by;
  time.mostS *= by;
  return time;
}

std::string sentence(const ExportTime& time) {
  if (!(time.mostS >= 1)) return {};
  const std::string least = rounded(time.leastS), most = rounded(time.mostS);
  return least == most ? "about " + least : least + " to " + most + ", by the shape";
}

}  // namespace argil::engine
