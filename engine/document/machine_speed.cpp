#include "engine/document/machine_speed.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "clay/base/error.h"
#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "engine/document/random.h"
#include "io/bytes/atomic_file.h"

namespace argil::engine {

namespace {

using nlohmann::json;

constexpr int kFormat = 1;
// Of the ball, and of the dabs that a parabola is laid through, voxels.
constexpr double kBall = 150;
constexpr std::array<double, 3> kRadii{4, 16, 48};
constexpr int kDabs = 25;
// Of a dab's cost so much does not follow the band: as much as a band of so many voxels.
constexpr double kBeside = 15;
// No dab is done sooner, whatever was measured; 100 voxels are the largest tip that is predicted.
constexpr double kLeastDabUs = 1, kLeastRadius = 0.5, kMostRadius = 100;
// And so much does not follow how the surface lies to the axes.
constexpr double kNoSlant = 0.4;

double microseconds() {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Median of dabs all over a ball, each taken back before the next.
double dab(const clay::Version& ball, clay::Surface& surface, double radius) {
  static const auto brush = clay::Brush::of(clay::Method::carve);
  Random random(3);
  std::vector<double> us;
  for (int i = 0; i < kDabs; ++i) {
    const Vec3d at = kBall * random.inBall().normalized();
    const double from = microseconds();
    clay::BrushStroke stroke(ball, brush);
    stroke.apply({at, at, radius});
    surface.update(stroke.publish());
    us.push_back(microseconds() - from);
    surface.update(ball);
  }
  std::nth_element(us.begin(), us.begin() + kDabs / 2, us.end());
  return us[kDabs / 2];
}

}  // namespace

double MachineSpeed::dabMs(double radiusVoxels, double band, double slant) const {
  const double us = std::max(kLeastDabUs, dabUs[0] + radiusVoxels * (dabUs[1] + radiusVoxels * dabUs[2]));
  return 1e-3 * us * (band + kBeside) / (3 + kBeside) * (slant + kNoSlant) / (1.5 + kNoSlant);
}

bool MachineSpeed::plausible() const {
  const auto sensible = [&](double radius) {
    const double us = dabUs[0] + radius * (dabUs[1] + radius * dabUs[2]);
    return us > kLeastDabUs && us < 1e7;
  };
  constexpr std::array kTried{kLeastRadius, 4.0, 30.0, kMostRadius};
  if (!std::all_of(kTried.begin(), kTried.end(), sensible)) return false;
  // A parabola through times that a busy machine spoilt may be below zero between them.
  const double lowest = dabUs[2] > 0 ? -dabUs[1] / (2 * dabUs[2]) : kLeastRadius;
  return lowest < kLeastRadius || lowest > kMostRadius || sensible(lowest);
}

std::string processorName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name"))
      if (const size_t at = line.find(": "); at != std::string::npos) return line.substr(at + 2);
  return {};
}

MachineSpeed measureMachine() {
  clay::Grid grid;
  grid.voxelMm = 1;
  const clay::Version ball = clay::makeSphere(clay::Store::make(), grid, Vec3d(0.3, 0.2, 0.4), kBall);
  clay::Surface surface(true, clay::Grade::crisp);
  surface.update(ball);
  // The parabola through the three.
  std::array<double, 3> us{};
  for (size_t i = 0; i < us.size(); ++i) us[i] = dab(ball, surface, kRadii[i]);
  const auto [x0, x1, x2] = kRadii;
  const double first = (us[1] - us[0]) / (x1 - x0), second = ((us[2] - us[1]) / (x2 - x1) - first) / (x2 - x0);
  return {{us[0] - first * x0 + second * x0 * x1, first - second * (x0 + x1), second}};
}

std::optional<MachineSpeed> readMachine(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) return std::nullopt;
  const json kept = json::parse(in, nullptr, false);
  if (!kept.is_object() || !kept.contains("format") || kept["format"] != kFormat || !kept.contains("processor") ||
      kept["processor"] != processorName())
    return std::nullopt;
  const json* dab = kept.contains("dab_us") ? &kept["dab_us"] : nullptr;
  MachineSpeed speed;
  if (!dab || !dab->is_array() || dab->size() != speed.dabUs.size()) return std::nullopt;
  for (size_t i = 0; i < speed.dabUs.size(); ++i) {
    if (!(*dab)[i].is_number()) return std::nullopt;
    speed.dabUs[i] = (*dab)[i].get<double>();
  }
  return speed.plausible() ? std::optional(speed) : std::nullopt;
}

void keepMachine(const std::filesystem::path& file, const MachineSpeed& speed) {
  const std::string text =
      json{{"format", kFormat}, {"processor", processorName()}, {"dab_us", speed.dabUs}}.dump(2) + "\n";
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  try {
    io::AtomicFile out(file);
    out.write(std::as_bytes(std::span(text)));
    out.commit();
  } catch (const Error&) {
    // It is measured again the next time.
  }
}

std::filesystem::path machineFile() {
  const auto folder = [](const char* name) {
    const char* value = std::getenv(name);
    return std::filesystem::path(value ? value : "");
  };
  if (folder("XDG_CACHE_HOME").is_absolute()) return folder("XDG_CACHE_HOME") / "argil" / "machine.json";
  if (folder("HOME").is_absolute()) return folder("HOME") / ".cache" / "argil" / "machine.json";
  return {};
}

MachineSpeed machineSpeed() {
  const std::filesystem::path file = machineFile();
  if (const auto known = readMachine(file)) return *known;
  const MachineSpeed speed = measureMachine();
  if (!speed.plausible()) return {};
  if (!file.empty()) keepMachine(file, speed);
  return speed;
}

}  // namespace argil::engine
