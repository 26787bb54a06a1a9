#include "haptics/devices/registry.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "clay/base/error.h"
#include "haptics/devices/added_devices.h"
#include "haptics/devices/falcon.h"
#include "haptics/devices/falcon_protocol.h"
#include "haptics/devices/haply.h"
#include "haptics/devices/recorded.h"
#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/devices/spacemouse.h"

namespace argil::haptics {
namespace {

namespace fs = std::filesystem;

constexpr double kForeverS = 1e9;  // A hand that holds still for thirty years.

std::string firstLine(const fs::path& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  return line;
}

std::string refusal(const std::string& node) {
  if (access(node.c_str(), R_OK | W_OK) == 0) return "";
  return "it may not be opened: install installer/99-argil.rules";
}

// A serial line of a USB device, with what its device says of itself.
struct SerialNode {
  std::string node, product, vendorId, productId;
};

std::vector<SerialNode> serialNodes(const std::string& sys, const std::string& dev) {
  std::vector<SerialNode> nodes;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(fs::path(sys) / "class" / "tty", none)) {
    // The node's "device" is the USB interface; the device itself is the folder around it.
    std::error_code bad;
    const fs::path usb = fs::canonical(entry.path() / "device", bad).parent_path();
    if (bad || !fs::exists(usb / "idVendor", bad)) continue;
    nodes.push_back({(fs::path(dev) / entry.path().filename()).string(), firstLine(usb / "product"),
                     firstLine(usb / "idVendor"), firstLine(usb / "idProduct")});
  }
  std::sort(nodes.begin(), nodes.end(), [](const SerialNode& a, const SerialNode& b) {
    return a.node.size() != b.node.size() ? a.node.size() < b.node.size() : a.node < b.node;
  });
  return nodes;
}

bool isGrip(const SerialNode& n) {
  return n.product.find("Haply") != std::string::npos &&
         (n.product.find("Transceiver") != std::string::npos || n.product.find("VerseGrip") != std::string::npos);
}
bool isArm(const SerialNode& n) {
  // The arm is built on a Teensy and may still carry that board's general name.
  return !isGrip(n) &&
         (n.product.find("Haply") != std::string::npos || n.product.find("Inverse3") != std::string::npos ||
          (n.vendorId == "16c0" && n.productId == "0483"));
}

void findFalcons(const std::string& sys, const std::string& dev, std::vector<FoundDevice>& found) {
  std::vector<fs::path> usb;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(fs::path(sys) / "bus" / "usb" / "devices", none))
    usb.push_back(entry.path());
  std::sort(usb.begin(), usb.end());
  for (const fs::path& path : usb) {
    if (firstLine(path / "idVendor") != fmt::format("{:04x}", kFalconVendor) ||
        firstLine(path / "idProduct") != fmt::format("{:04x}", kFalconProduct))
      continue;
    const int bus = std::atoi(firstLine(path / "busnum").c_str()),
              address = std::atoi(firstLine(path / "devnum").c_str());
    const std::string node =
        (fs::path(dev) / "bus" / "usb" / fmt::format("{:03}", bus) / fmt::format("{:03}", address)).string();
    // The folder's name is the bus and its ports, as FalconOptions::where.
    found.push_back({"falcon:" + path.filename().string(), "Novint Falcon", node, refusal(node)});
  }
}

void findHaply(const std::string& sys, const std::string& dev, std::vector<FoundDevice>& found) {
  const auto nodes = serialNodes(sys, dev);
  const auto grip = std::find_if(nodes.begin(), nodes.end(), isGrip);
  for (const SerialNode& n : nodes) {
    if (!isArm(n)) continue;
    const bool named = n.vendorId != "16c0";
    found.push_back({"haply:" + n.node + (grip != nodes.end() ? "," + grip->node : ""),
                     (named ? "Haply Inverse3" : "Haply Inverse3, or another thing built on a Teensy") +
                         std::string(grip != nodes.end() ? " with its grip" : ""),
                     n.node, refusal(n.node)});
  }
}

void findSpaceMice(const std::string& sys, const std::string& dev, std::vector<FoundDevice>& found) {
  for (const HidNode& n : spaceMice(hidNodes(sys, dev)))
    found.push_back(
        {"spacemouse:" + n.node, n.name.empty() ? "3Dconnexion" : n.name, n.node,
         access(n.node.c_str(), R_OK) == 0 ? "" : "it may not be opened: install installer/99-argil.rules"});
}

std::string readFile(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in || path.empty())
    throw Error("recorded: " + (path.empty() ? "name a file of a hand path, as recorded:FILE"
                                             : path + " cannot be read; check the name"));
  return text.str();
}

// What a name stands for, before anything is opened.
struct Kind {
  const char* name;
  bool hardware;
  DeviceSheet (*sheet)(const std::string& rest, const OpenDeviceOptions&);
  std::unique_ptr<Device> (*open)(const std::string& rest, const OpenDeviceOptions&);
};

std::unique_ptr<Device> recorded(const std::string& file, const OpenDeviceOptions& options) {
  const std::string text = readFile(file);
  HandPath path =
      options.layout.units.empty() ? HandPath::fromCsv(text, file) : HandPath::fromCsv(text, file, options.layout);
  return std::make_unique<RecordedDevice>(std::move(path), RecordedDevice::Options{"recorded", options.loop});
}

std::unique_ptr<Device> falcon(const std::string& where, const OpenDeviceOptions& options) {
  FalconOptions falcon;
  falcon.where = where;
  falcon.firmware = options.falconFirmware;
  return openFalcon(falcon);
}

std::unique_ptr<Device> haply(const std::string& rest, const OpenDeviceOptions&) {
  HaplyOptions options;
  std::string lines = rest;
  if (lines.empty()) {
    std::vector<FoundDevice> found;
    findHaply("/sys", "/dev", found);
    if (!found.empty()) lines = found.front().name.substr(found.front().name.find(':') + 1);
  }
  const size_t comma = lines.find(',');
  if (!lines.empty()) options.port = lines.substr(0, comma);
  if (comma != std::string::npos) options.grip = lines.substr(comma + 1);
  return openHaply(options);
}

std::unique_ptr<Device> spaceMouse(const std::string& node, const OpenDeviceOptions&) {
  SpaceMouseOptions options;
  options.node = node;
  return openSpaceMouse(options);
}

std::unique_ptr<Device> simulated(const std::string& sheet, const OpenDeviceOptions&) {
  return std::make_unique<SimulatedDevice>(deviceSheet(sheet), HandPath::hold(Vec3d::Zero(), kForeverS));
}

const Kind kKinds[] = {
    {"falcon", true, [](const std::string&, const OpenDeviceOptions&) { return deviceSheet("falcon"); }, falcon},
    {"haply", true, [](const std::string&, const OpenDeviceOptions&) { return haplySheet(); }, haply},
    {"spacemouse", true, [](const std::string&, const OpenDeviceOptions&) { return spaceMouseSheet(); }, spaceMouse},
    {"recorded", false, [](const std::string& file, const OpenDeviceOptions& o) { return recorded(file, o)->sheet(); },
     recorded},
    {"simulated", false, [](const std::string& sheet, const OpenDeviceOptions&) { return deviceSheet(sheet); },
     simulated},
};

// The kind of a name, and what follows its colon.
std::pair<const Kind*, std::string> kindOf(const std::string& name) {
  const size_t colon = name.find(':');
  const std::string head = name.substr(0, colon);
  for (const Kind& kind : kKinds)
    if (head == kind.name) return {&kind, colon == std::string::npos ? "" : name.substr(colon + 1)};
  std::string names;
  for (const DeviceSheet& sheet : deviceSheets()) {
    if (sheet.name == name) return {&kKinds[std::size(kKinds) - 1], name};
    names += ", simulated:" + sheet.name;
  }
  throw Error("no device is called '" + name + "': choose one of falcon, haply, haply:PORT, spacemouse, recorded:FILE" +
              names);
}

// One that a plugin brought; null: none has that name.
std::unique_ptr<AddedDevice> added(const std::string& name) {
  std::vector<AddedDevice> all = addedDevices();
  for (AddedDevice& device : all)
    if (device.name == name) return std::make_unique<AddedDevice>(std::move(device));
  return nullptr;
}

}  // namespace

std::vector<FoundDevice> findDevices(const std::string& sys, const std::string& dev) {
  std::vector<FoundDevice> found;
  findFalcons(sys, dev, found);
  findHaply(sys, dev, found);
  findSpaceMice(sys, dev, found);
  for (const AddedDevice& device : addedDevices()) found.push_back({device.name, device.what, "", ""});
  return found;
}

std::unique_ptr<Device> openDevice(const std::string& name, const OpenDeviceOptions& options) {
  if (const auto device = added(name)) return device->open();
  const auto [kind, rest] = kindOf(name);
  return kind->open(rest, options);
}

DeviceSheet sheetOfDevice(const std::string& name, const OpenDeviceOptions& options) {
  if (const auto device = added(name)) return device->sheet;
  const auto [kind, rest] = kindOf(name);
  return kind->sheet(rest, options);
}

bool isHardware(const std::string& name) {
  return added(name) || kindOf(name).first->hardware;
}

}  // namespace argil::haptics
