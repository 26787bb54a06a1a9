#pragma once
// 3Dconnexion SpaceMouse: a puck that is pushed and turned, six degrees of freedom in, none out.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "haptics/devices/device_thread.h"

namespace argil::haptics {

/// Where HID reports come from: hidraw nodes, or an emulator. One physical device may have several nodes: a receiver
/// has one for each puck that could be paired with it. The device's thread only.
class HidSource {
 public:
  struct Node {
    std::vector<uint8_t> descriptor;
    int fd = -1;  ///< Readable without waiting, one whole report a read; -1: gone.
  };
  virtual ~HidSource() = default;
  [[nodiscard]] virtual DeviceLink::Opened open(std::string& sentence) = 0;
  [[nodiscard]] virtual std::span<const Node> nodes() const noexcept = 0;  ///< While open; their order stays.
  virtual void drop(size_t node) noexcept = 0;                             ///< Closes one that is gone.
  virtual void close() noexcept = 0;
};

struct SpaceMouseOptions {
  /// Such as /dev/hidraw3, which stands for all nodes of its device; empty: the first device there is.
  std::string node = {};
  double topSpeedMms = 120;       ///< At full deflection, mm/s: 1 to 1000.
  double topTurnRads = 1.5;       ///< At full deflection, rad/s: 0 to 20.
  double deadZone = 0.03;         ///< Part of full deflection that counts as rest: 0 to 0.5.
  Vec3d boxMm = {200, 200, 200};  ///< The stylus stays in this box around its origin.
};

/// The puck's deflection is a velocity: its place is what that adds up to. x to the right, y away from the person, z
/// up. Throws Error for options out of range; a device that is not there yet is used as soon as it is.
[[nodiscard]] std::unique_ptr<Device> openSpaceMouse(const SpaceMouseOptions& options);
/// The same from elsewhere than a hidraw node.
[[nodiscard]] std::unique_ptr<Device> openSpaceMouse(const SpaceMouseOptions& options,
                                                     std::unique_ptr<HidSource> source);

[[nodiscard]] const DeviceSheet& spaceMouseSheet();
/// Whether these ids may be those of a SpaceMouse or one of its kin: all of 3Dconnexion's (its ordinary mice too: their
/// descriptors tell), and those that were sold under Logitech's.
[[nodiscard]] bool isSpaceMouse(uint16_t vendor, uint16_t product) noexcept;

/// A HID node of the system.
struct HidNode {
  std::string node;    ///< /dev/hidrawN.
  std::string name;    ///< As the device calls itself.
  std::string device;  ///< The same for all nodes of one physical device.
  uint16_t vendor = 0, product = 0;
  bool sixAxes = true;  ///< False: it says that it is none.
};
/// All of them, by sysfs; needs no rights. Empty where there are none.
[[nodiscard]] std::vector<HidNode> hidNodes(const std::string& sys = "/sys", const std::string& dev = "/dev");
/// Those of `all` that are SpaceMice, one for each physical device: the first that has six axes.
[[nodiscard]] std::vector<HidNode> spaceMice(const std::vector<HidNode>& all);

}  // namespace argil::haptics
