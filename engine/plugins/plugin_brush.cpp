#include "engine/plugins/plugin_brush.h"

#include <sha256.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "plugins/runner/futex.h"

namespace argil::engine {

namespace {

class PluginWorker : public clay::BrickWorker {
 public:
  PluginWorker(const PluginBrushFacts& facts, std::shared_ptr<PluginProcesses> processes,
               const clay::WorkerStroke& stroke)
      : processes_(std::move(processes)), process_(processes_->take(stroke.threads)), margin_(facts.margin) {
    // What throws here gives the process back like all else.
    const Back back{*this};
    requireAsSaid(*process_, facts);
    plugin::Channel& shared = process_->channel();
    argil_stroke& to = shared.stroke;
    to = {};
    to.size = sizeof to;
    to.band = stroke.grid.band;
    to.voxel_mm = stroke.grid.voxelMm;
    std::copy_n(stroke.grid.originMm.data(), 3, to.origin_mm);
    to.amount = stroke.amount;
    to.per_stamp = stroke.perStamp;
    to.parameter_count = static_cast<uint32_t>(stroke.values.size());
    std::copy(stroke.values.begin(), stroke.values.end(), shared.parameters);
    process_->call(plugin::Command::beginStroke);
    layOut();
    back.keep = true;
  }
  ~PluginWorker() override {
    if (!process_) return;
    try {
      // Of a batch that was not finished nothing is wanted.
      if (begun_ && process_->alive()) {
        written(count_);
        process_->finish();
      }
      if (process_->alive()) process_->call(plugin::Command::endStroke);
    } catch (const PluginError&) {  // the stroke is over
    }
    processes_->giveBack(std::move(process_));
  }

  [[nodiscard]] size_t most() const override { return most_; }
  [[nodiscard]] Place place(size_t brick) override {
    return {reinterpret_cast<int32_t*>(process_->window()) + 3 * brick, phi_ + brick * floats_,
            weight_ + brick * clay::kBrickVoxels};
  }
  void begin(std::span<const clay::Stamp> images, size_t count) override {
    plugin::Channel& shared = process_->channel();
    count_ = count;
    shared.imageCount = static_cast<uint32_t>(images.size());
    for (size_t i = 0; i < images.size(); ++i) shared.images[i] = imageOf(images[i]);
    const clay::BrickLayout layout = clay::brickLayout(margin_);
    const auto at = [&](const float* floats) {
      return static_cast<uint64_t>(reinterpret_cast<const std::byte*>(floats) - process_->window());
    };
    plugin::BatchPlace place;
    place.count = static_cast<uint32_t>(count);
    place.margin = static_cast<uint32_t>(margin_);
    place.brick = static_cast<uint32_t>(floats_);
    place.plane = static_cast<uint32_t>(layout.plane);
    place.row = static_cast<uint32_t>(layout.row);
    // The first voxel of the margin.
    place.phi =
        at(phi_) + sizeof(float) * static_cast<uint64_t>(layout.first - margin_ * (layout.plane + layout.row + 1));
    place.weight = at(weight_);
    place.out = at(out_);
    shared.batch = place;
    shared.filled.store(0);
    if (process_->limits().comparesWindow) return;  // it is asked once all is there
    guarded([&] { process_->begin(plugin::Command::bricks); });
    begun_ = true;
  }
  void written(size_t count) noexcept override {
    plugin::Channel& shared = process_->channel();
    shared.filled.store(static_cast<uint32_t>(count));
    if (shared.sleepers.load() != 0 && count == count_) plugin::wakeAll(shared.filled);
  }
  void finish() override {
    begun_ = false;
    if (!process_->limits().comparesWindow) return guarded([&] { process_->finish(); });
    const auto at = [&](const float* floats) {
      return static_cast<size_t>(reinterpret_cast<const std::byte*>(floats) - process_->window());
    };
    const size_t before = at(out_), behind = at(out_ + count_ * clay::kBrickVoxels);
    const std::vector<std::byte> window(process_->window(), process_->window() + plugin::kWindowBytes);
    guarded([&] { process_->call(plugin::Command::bricks); });
    if (std::memcmp(window.data(), process_->window(), before) != 0 ||
        std::memcmp(window.data() + behind, process_->window() + behind, window.size() - behind) != 0)
      failAt(PluginFault::outside, "wrote outside of its batch and was stopped");
  }
  [[nodiscard]] const float* result(size_t brick) const override { return out_ + brick * clay::kBrickVoxels; }
  [[noreturn]] void failResult() override {
    failAt(PluginFault::notFinite, "gave a distance that is not finite and was stopped");
  }

 private:
  static constexpr const char* kEnds = "; the stroke ends as it was before";
  template <class Work>
  static void guarded(const Work& work) {
    try {
      work();
    } catch (const PluginError& error) {
      throw PluginError(error.fault(), error.what() + std::string(kEnds));
    }
  }
  [[noreturn]] void failAt(PluginFault fault, const char* what) { process_->end(fault, what + std::string(kEnds)); }

  struct Back {
    PluginWorker& of;
    mutable bool keep = false;
    ~Back() {
      if (!keep) of.processes_->giveBack(std::move(of.process_));
    }
  };

  static argil_image imageOf(const clay::Stamp& stamp) {
    argil_image image{};
    image.size = sizeof image;
    image.strength = stamp.strength;
    std::copy_n(stamp.a.data(), 3, image.a);
    std::copy_n(stamp.b.data(), 3, image.b);
    image.radius = stamp.radius;
    image.end_radius = stamp.radiusAtEnd();
    for (int axis = 0; axis < 3; ++axis)
      for (int k = 0; k < 3; ++k) image.axes[axis][k] = stamp.axes(k, axis);
    return image;
  }

  // Coordinates, distances, weights and results one behind the other, each on a page of its own.
  void layOut() {
    constexpr size_t kMostBricks = 1024, kPage = 4096;
    floats_ = (static_cast<size_t>(clay::brickLayout(margin_).floats) + 15) / 16 * 16;
    const size_t each = 3 * sizeof(int32_t) + sizeof(float) * (floats_ + 2 * size_t{clay::kBrickVoxels});
    most_ = std::min(kMostBricks, (plugin::kWindowBytes - 4 * kPage) / each);
    size_t at = 0;
    const auto room = [&](size_t bytes) {
      at = (at + kPage - 1) / kPage * kPage;
      return reinterpret_cast<float*>(process_->window() + std::exchange(at, at + bytes));
    };
    (void)room(most_ * 3 * sizeof(int32_t));
    phi_ = room(most_ * floats_ * sizeof(float));
    weight_ = room(most_ * clay::kBrickVoxels * sizeof(float));
    out_ = room(most_ * clay::kBrickVoxels * sizeof(float));
  }

  std::shared_ptr<PluginProcesses> processes_;
  std::unique_ptr<PluginProcess> process_;
  int margin_;
  size_t most_ = 0, floats_ = 0, count_ = 0;  // count_: bricks of the batch
  bool begun_ = false;                        // a batch that is not finished
  float *phi_ = nullptr, *weight_ = nullptr, *out_ = nullptr;
};

}  // namespace

std::string fileChecksum(const std::filesystem::path& file) {
  char digits[SHA256_DIGEST_STRING_LENGTH];
  const char* made = SHA256File(file.c_str(), digits);
  return made ? made : "";
}

PluginProcesses::PluginProcesses(PluginLibrary library, const PluginLimits& limits)
    : library_(std::move(library)), limits_(limits) {}

std::unique_ptr<PluginProcess> PluginProcesses::take(int threads) {
  for (;;) {
    std::unique_ptr<PluginProcess> process;
    {
      const std::lock_guard lock(mutex_);
      if (faults_ >= kMostFaults)
        throw Error(fmt::format("{} failed {} times and is not used again until Argil is started again", library_.name,
                                kMostFaults),
                    Error::Kind::work);
      if (waiting_.empty()) {
        ++started_;
        break;
      }
      process = std::move(waiting_.back());
      waiting_.pop_back();
    }
    // One that ended while it had nothing to do harmed nobody.
    try {
      process->call(plugin::Command::none);
      return process;
    } catch (const PluginError&) {
    }
  }
  if (!library_.checksum.empty() && fileChecksum(library_.file) != library_.checksum)
    throw PluginError(
        PluginFault::notThere,
        fmt::format("{} is not as it was when it was enabled: argil plugins enable {}", library_.name, library_.id));
  try {
    auto process = std::make_unique<PluginProcess>(library_, threads, limits_);
    const std::lock_guard lock(mutex_);
    newest_ = process->pid();
    return process;
  } catch (const PluginError& error) {
    const std::lock_guard lock(mutex_);
    if (error.fault() != PluginFault::notThere) ++faults_;
    throw;
  }
}

void PluginProcesses::giveBack(std::unique_ptr<PluginProcess> process) {
  if (!process) return;
  const std::lock_guard lock(mutex_);
  if (process->alive())
    waiting_.push_back(std::move(process));
  else
    ++faults_;
}

uint64_t PluginProcesses::started() const {
  const std::lock_guard lock(mutex_);
  return started_;
}

pid_t PluginProcesses::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

void requireNumbers(PluginProcess& process, const std::string& thing, const std::vector<std::string>& numbers) {
  plugin::Channel& shared = process.channel();
  const auto differs = [&](const std::string& what) {
    throw PluginError(PluginFault::notAsSaid,
                      fmt::format("{}: {} {}, and plugin.json says otherwise", process.library().name, thing, what));
  };
  const uint32_t count = shared.parameterCount;
  if (count != numbers.size()) differs(fmt::format("has {} numbers", count));
  for (size_t i = 0; i < numbers.size(); ++i)
    if (const std::string number = PluginProcess::textOf(shared.parameterIds[i]); number != numbers[i])
      differs(fmt::format("has the number \"{}\"", number));
}

void requireAsSaid(PluginProcess& process, const PluginBrushFacts& facts) {
  plugin::Channel& shared = process.channel();
  process.name(plugin::ThingKind::brush, facts.id);
  process.call(plugin::Command::describe);
  const auto differs = [&](const std::string& what) {
    throw PluginError(PluginFault::notAsSaid,
                      fmt::format("{}: {}, and plugin.json says otherwise", process.library().name, what));
  };
  if (shared.margin != static_cast<uint32_t>(facts.margin))
    differs(fmt::format("{} reads {} voxels around", facts.id, shared.margin));
  constexpr std::array kLeaves{clay::Renew::none, clay::Renew::slopes, clay::Renew::all};
  const uint32_t leaves = shared.flags & ARGIL_BRUSH_LEAVES;
  if (leaves >= kLeaves.size() || kLeaves[leaves] != facts.leaves)
    differs(fmt::format("{} leaves something else", facts.id));
  requireNumbers(process, facts.id, facts.numbers);
}

PluginBrush::PluginBrush(PluginBrushFacts facts, std::shared_ptr<PluginProcesses> processes)
    : facts_(std::move(facts)), processes_(std::move(processes)) {}

std::unique_ptr<clay::BrickWorker> PluginBrush::begin(const clay::WorkerStroke& stroke) const {
  return std::make_unique<PluginWorker>(facts_, processes_, stroke);
}

}  // namespace argil::engine
