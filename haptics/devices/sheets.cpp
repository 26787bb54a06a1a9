#include "haptics/devices/sheets.h"

#include <array>

#include "clay/base/error.h"

namespace argil::haptics {
namespace {

// Peak, continuous force, step, top stiffness, moving mass and friction are published figures where they exist. Where
// they do not (damping everywhere; mass and friction of the delta robots; a continuous force of the Falcon and the
// omega.3) the row holds an estimate of the usual size for a mechanism of that kind: NOTES.md, "Simulated device".
DeviceSheet row(const char* name, const char* like, Vec3d workspaceMm, double peakN, double continuousN, double stepMm,
                double topNmm, double topDampingNsmm, double massKg, double frictionN, double dampingNsmm, int dofIn,
                int buttons) {
  DeviceSheet s;
  s.name = name;
  s.like = like;
  s.dofIn = dofIn;
  s.workspaceMm = workspaceMm;
  s.peakForceN = peakN;
  s.continuousForceN = continuousN;
  s.resolutionMm = stepMm;
  s.topStiffnessNmm = topNmm;
  s.topDampingNsmm = topDampingNsmm;
  s.massKg = massKg;
  s.frictionN = frictionN;
  s.dampingNsmm = dampingNsmm;
  s.buttons = buttons;
  return s;
}

const std::array<DeviceSheet, 6>& rows() {
  static const std::array<DeviceSheet, 6> sheets = {
      //  name        like                        workspace mm      peak  cont  step   N/mm  N·s/mm  kg     N     N·s/mm
      //  dof buttons
      row("touch", "Touch (Omni)", {160, 120, 70}, 3.3, 0.88, 0.055, 1.26, 0.002, 0.045, 0.26, 0.0008, 6, 2),
      row("touchx", "Touch X (Desktop)", {160, 120, 120}, 7.9, 1.75, 0.023, 1.86, 0.003, 0.045, 0.06, 0.0008, 6, 2),
      row("premium15", "PHANToM Premium 1.5", {195, 270, 375}, 8.5, 1.4, 0.03, 3.5, 0.004, 0.075, 0.04, 0.001, 3, 1),
      row("falcon", "Novint Falcon", {100, 100, 100}, 8.9, 2.5, 0.06, 3.0, 0.02, 0.2, 0.5, 0.004, 3, 4),
      row("omega3", "omega.3", {160, 160, 110}, 12.0, 12.0, 0.01, 14.5, 0.02, 0.2, 0.1, 0.01, 3, 1),
      // Continuous force from a published driver's limit; the rest estimates: NOTES.md, "Haply Inverse3".
      row("haply", "Haply Inverse3", {240, 160, 200}, 8.0, 3.3, 0.02, 2.0, 0.003, 0.15, 0.1, 0.0015, 6, 2),
  };
  return sheets;
}

}  // namespace

std::span<const DeviceSheet> deviceSheets() {
  return rows();
}

const DeviceSheet& deviceSheet(std::string_view name) {
  std::string names;
  for (const DeviceSheet& sheet : rows()) {
    if (sheet.name == name) return sheet;
    names += (names.empty() ? "" : ", ") + sheet.name;
  }
  throw Error("no device is called '" + std::string(name) + "': choose one of " + names);
}

}  // namespace argil::haptics
