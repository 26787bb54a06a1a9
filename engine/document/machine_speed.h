#pragma once
// How fast this machine is at what a hand waits for.

#include <array>
#include <filesystem>
#include <optional>
#include <string>

namespace argil::engine {

/// Of a carving dab of a ball into the surface of clay, one thread, from the dab to its triangles, in a band of three
/// voxels: µs, by powers of the radius in voxels. `slant`: as ClayPlan has it.
struct MachineSpeed {
  std::array<double, 3> dabUs = {80, 4, 0.75};  ///< Of a machine that nobody has measured.

  /// Returns the time of a dab; above zero whatever `dabUs` is.
  [[nodiscard]] double dabMs(double radiusVoxels, double band, double slant) const;
  /// Whether some machine could be so: a busy one may have measured anything.
  [[nodiscard]] bool plausible() const;
};

/// Measures for about a second. Any thread.
[[nodiscard]] MachineSpeed measureMachine();

/// What was measured on this machine before; nothing where nothing was, on another processor or by another version.
/// `file`: machineFile().
[[nodiscard]] std::optional<MachineSpeed> readMachine(const std::filesystem::path& file);
/// Writes it whole or not at all; a folder that cannot be written is no error.
void keepMachine(const std::filesystem::path& file, const MachineSpeed& speed);
/// $XDG_CACHE_HOME/argil/machine.json, else ~/.cache/argil/machine.json; empty when there is no home.
[[nodiscard]] std::filesystem::path machineFile();

/// As it was measured before, else measured now and kept; as nobody measured it where the machine was too busy for
/// sense.
[[nodiscard]] MachineSpeed machineSpeed();

/// As the system calls it; empty where it does not say.
[[nodiscard]] std::string processorName();

}  // namespace argil::engine
