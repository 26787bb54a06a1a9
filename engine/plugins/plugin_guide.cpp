#include "engine/plugins/plugin_guide.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace argil::engine {

namespace {

constexpr double kFarthestMm = 1e6, kStiffestNmm = 1e4;

bool taken(const double (&from)[3], Vec3d& to) ARGIL_REALTIME {
  to = Vec3d(from[0], from[1], from[2]);
  return std::abs(to.x()) <= kFarthestMm && std::abs(to.y()) <= kFarthestMm && std::abs(to.z()) <= kFarthestMm;
}

}  // namespace

bool checkedModel(const argil_local_model& said, haptics::LocalModel& model) ARGIL_REALTIME {
  haptics::LocalModel checked;
  if (said.count > haptics::LocalModel::kMost || !taken(said.middle_mm, checked.middle) ||
      !(said.radius_mm >= 0 && said.radius_mm <= kFarthestMm))
    return false;
  checked.radiusMm = said.radius_mm;
  checked.count = static_cast<int>(said.count);
  for (uint32_t i = 0; i < said.count; ++i) {
    const argil_element& from = said.elements[i];
    haptics::LocalModel::Element& to = checked.elements[i];
    if (from.kind > ARGIL_ELEMENT_SPRING || !taken(from.place_mm, to.place) ||
        !(from.stiffness_n_mm >= 0 && static_cast<double>(from.stiffness_n_mm) <= kStiffestNmm))
      return false;
    to.stiffnessNmm = static_cast<double>(from.stiffness_n_mm);
    if (from.kind == ARGIL_ELEMENT_PLANE) {
      to.kind = haptics::LocalModel::Element::Kind::plane;
      if (!taken(from.normal, to.normal)) return false;
      const double length = to.normal.norm();
      if (!(length > 1e-6)) return false;
      to.normal /= length;
    } else {
      to.kind = haptics::LocalModel::Element::Kind::spring;
      if (!(from.range_mm > 1e-3 && from.range_mm <= kFarthestMm)) return false;
      to.rangeMm = from.range_mm;
    }
  }
  model = checked;
  return true;
}

PluginGuide::PluginGuide(std::shared_ptr<PluginProcesses> processes, const std::string& guide,
                         const std::vector<std::string>& numbers, std::span<const float> values)
    : processes_(std::move(processes)), process_(processes_->take(1)), channel_(&process_->channel()) {
  try {
    process_->name(plugin::ThingKind::guide, guide);
    process_->call(plugin::Command::describe);
    requireNumbers(*process_, guide, numbers);
    std::copy(values.begin(), values.end(), channel_->parameters);
    process_->call(plugin::Command::beginGuide);
  } catch (...) {
    processes_->giveBack(std::move(process_));
    throw;
  }
  // What one before it said is not for this one; and the servo meets no page for the first time.
  argil_local_model before;
  (void)channel_->model.load(before, seen_);
  channel_->hand.store({});
}

PluginGuide::~PluginGuide() {
  try {
    if (process_->alive()) process_->call(plugin::Command::endGuide);
  } catch (const PluginError&) {  // it is over
  }
  processes_->giveBack(std::move(process_));
}

bool PluginGuide::newest(haptics::LocalModel& model) ARGIL_REALTIME {
  argil_local_model now;
  return said(now) && checkedModel(now, model);
}

bool PluginGuide::said(argil_local_model& model) ARGIL_REALTIME {
  return channel_->model.load(model, seen_);
}

void PluginGuide::tell(const Vec3d& hand, const Vec3d& velocity, uint32_t buttons) ARGIL_REALTIME {
  argil_hand now{};
  now.size = sizeof now;
  now.buttons = buttons;
  for (int k = 0; k < 3; ++k) {
    now.position_mm[k] = hand[k];
    now.velocity_mm_s[k] = velocity[k];
  }
  channel_->hand.store(now);
}

void PluginGuide::look() {
  if (process_->alive()) return;
  process_->call(plugin::Command::none);  // which says how it ended
}

}  // namespace argil::engine
