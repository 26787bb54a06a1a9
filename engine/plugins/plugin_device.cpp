#include "engine/plugins/plugin_device.h"

#include <glob.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptics/base/clock.h"
#include "plugins/runner/futex.h"

namespace argil::engine {

namespace {

std::vector<std::string> matching(const std::vector<std::string>& patterns) {
  constexpr size_t kMost = 64;
  std::vector<std::string> nodes;
  for (const std::string& pattern : patterns) {
    glob_t found{};
    if (::glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found) == 0)
      for (size_t i = 0; i < found.gl_pathc && nodes.size() < kMost; ++i) nodes.emplace_back(found.gl_pathv[i]);
    ::globfree(&found);
  }
  return nodes;
}

class PluginLink final : public haptics::DeviceLink {
 public:
  PluginLink(Plugin::Device device, PluginLibrary library) : device_(std::move(device)), library_(std::move(library)) {}
  ~PluginLink() override { end(); }

  Opened open(std::string& sentence) override {
    end();
    if (crashes_ >= PluginProcesses::kMostFaults) {
      sentence = ended_ + "; it is not used again until Argil is started again";
      return Opened::refused;
    }
    library_.nodes = matching(device_.nodes);
    if (!device_.nodes.empty() && library_.nodes.empty()) {
      sentence = device_.name + " is not plugged in";
      return Opened::absent;
    }
    try {
      process_ = std::make_unique<PluginProcess>(library_, 1);
      process_->name(plugin::ThingKind::device, device_.id);
      process_->call(plugin::Command::beginDevice);
    } catch (const PluginError& error) {
      process_.reset();
      sentence = error.what();
      // That nothing is there is no fault of it.
      if (error.fault() == PluginFault::failed) return Opened::absent;
      fault(error);
      return Opened::refused;
    }
    sentence = device_.name;
    return Opened::ready;
  }

  Exchanged exchange(const Vec3d& forceN, int64_t deadlineNs, haptics::DeviceState& state) noexcept override {
    if (!process_) return Exchanged::gone;
    plugin::Channel& shared = process_->channel();
    shared.force.store({forceN.x(), forceN.y(), forceN.z()});
    const uint32_t turn = shared.turn.fetch_add(1) + 1;
    plugin::wakeAll(shared.turn);
    for (;;) {
      const uint32_t turned = shared.turned.load();
      if (turned == turn) break;
      const int64_t left = deadlineNs - haptics::nowNs();
      if (left <= 0) return stillThere() ? Exchanged::nothing : Exchanged::gone;
      plugin::sleepWhile(shared.turned, turned, left);
    }
    plugin::Channel::DeviceSaid said;
    if (!shared.said.load(said, seen_) || said.turn != turn) return Exchanged::garbage;
    if (said.status != ARGIL_OK) return Exchanged::gone;
    return checkedState(said.state, device_.sheet, state) ? Exchanged::state : Exchanged::garbage;
  }

  void close() noexcept override { end(); }

 private:
  bool stillThere() noexcept {
    try {
      if (process_->alive()) return true;
      process_->call(plugin::Command::none);  // says how it ended
    } catch (const PluginError& error) {
      fault(error);
    } catch (const std::exception&) {
    }
    return false;
  }
  void fault(const PluginError& error) {
    ++crashes_;
    ended_ = error.what();
  }
  void end() noexcept {
    if (!process_) return;
    try {
      if (process_->alive()) process_->call(plugin::Command::endDevice);
    } catch (const std::exception&) {  // it is over
    }
    process_.reset();
    seen_ = 0;
  }

  Plugin::Device device_;
  PluginLibrary library_;
  std::unique_ptr<PluginProcess> process_;
  uint64_t seen_ = 0;
  int crashes_ = 0;
  std::string ended_;
};

}  // namespace

bool checkedState(const argil_device_state& said, const haptics::DeviceSheet& sheet,
                  haptics::DeviceState& state) noexcept {
  haptics::DeviceState checked;
  for (int k = 0; k < 3; ++k) {
    if (!(std::abs(said.position_mm[k]) <= sheet.workspaceMm[k])) return false;
    checked.pose.translation[k] = said.position_mm[k];
  }
  const Eigen::Quaterniond rotation(said.rotation[3], said.rotation[0], said.rotation[1], said.rotation[2]);
  const double length = rotation.norm();
  if (!(length <= 1e6)) return false;
  if (length > 1e-6) checked.pose.rotation = rotation.normalized();
  if (!(said.pressure >= 0 && said.pressure <= 1)) return false;
  checked.pressure = said.pressure;
  checked.buttons = said.buttons;
  state = checked;
  return true;
}

std::unique_ptr<haptics::Device> openPluginDevice(const Plugin::Device& device, const PluginLibrary& library) {
  return std::make_unique<haptics::ThreadedDevice>(device.sheet, std::make_unique<PluginLink>(device, library));
}

}  // namespace argil::engine
