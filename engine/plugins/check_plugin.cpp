#include "engine/plugins/check_plugin.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <thread>

#include "clay/base/error.h"
#include "clay/brush/formula.h"
#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "engine/document/random.h"
#include "engine/plugins/plugin.h"
#include "engine/plugins/plugin_device.h"
#include "engine/plugins/plugin_guide.h"
#include "engine/plugins/plugin_work.h"
#include "haptics/base/clock.h"
#include "io/bytes/input.h"

namespace argil::engine {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kRadius = 9, kBall = 30;  // voxels
constexpr int kRandom = 6;                 // sets of numbers
constexpr double kLoadMs = 100, kSlowest = 20;
constexpr int kTurns = 5, kMostTurns = 25;
constexpr int kManyStrokes = 40;
constexpr double kGrowthMb = 4;

/// The same brush, given no more than some bricks at a time.
class InBatches : public clay::ExternalBrush {
 public:
  InBatches(std::shared_ptr<const clay::ExternalBrush> brush, size_t most) : brush_(std::move(brush)), most_(most) {}
  [[nodiscard]] int margin() const override { return brush_->margin(); }
  [[nodiscard]] clay::Renew leaves() const override { return brush_->leaves(); }
  [[nodiscard]] std::unique_ptr<clay::BrickWorker> begin(const clay::WorkerStroke& stroke) const override {
    return std::make_unique<Worker>(brush_->begin(stroke), most_);
  }

 private:
  class Worker : public clay::BrickWorker {
   public:
    Worker(std::unique_ptr<clay::BrickWorker> worker, size_t most) : worker_(std::move(worker)), most_(most) {}
    [[nodiscard]] size_t most() const override { return most_; }
    [[nodiscard]] Place place(size_t brick) override { return worker_->place(brick); }
    void begin(std::span<const clay::Stamp> images, size_t count) override { worker_->begin(images, count); }
    void written(size_t count) noexcept override { worker_->written(count); }
    void finish() override { worker_->finish(); }
    [[nodiscard]] const float* result(size_t brick) const override { return worker_->result(brick); }
    [[noreturn]] void failResult() override {
      worker_->failResult();
      std::abort();  // g++ 12 does not see that the other one returns not
    }

   private:
    std::unique_ptr<clay::BrickWorker> worker_;
    size_t most_;
  };
  std::shared_ptr<const clay::ExternalBrush> brush_;
  size_t most_;
};

class BrushTrial {
 public:
  explicit BrushTrial(const AddedTool& tool) : tool_(tool) {
    std::vector<std::string> names;
    names.reserve(tool.numbers.size());
    for (const auto& number : tool.numbers) names.push_back(number.id);
    if (!tool.external) formula_ = std::make_shared<const clay::Formula>(tool.formula, names);
    clay::Grid grid;
    grid.originMm = Vec3d::Constant(grid.voxelMm / 2);  // a plane between bricks through the middle
    ball_ = clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), kBall * grid.voxelMm);
  }

  // Sets of numbers: as it begins, all low, all high, at random.
  [[nodiscard]] std::vector<std::vector<float>> numbers() const {
    std::vector<std::vector<float>> sets(3 + kRandom);
    Random random(1);
    for (const auto& number : tool_.numbers)
      for (size_t i = 0; i < sets.size(); ++i)
        sets[i].push_back(static_cast<float>(i == 0   ? number.standard
                                             : i == 1 ? number.low
                                             : i == 2 ? number.high
                                             : number.logarithmic
                                                 ? number.low * std::pow(number.high / number.low, random.unit())
                                                 : random.between(number.low, number.high)));
    return sets;
  }

  struct How {
    float strength = 1, amount = 1;
    bool mirrored = false;
    int publishEvery = 100, threads = 1;
    size_t batch = 0;  // bricks; 0: as many as there is room for
  };
  [[nodiscard]] clay::Version stroked(const std::vector<float>& numbers, const How& how) const {
    auto brush = std::make_shared<clay::Brush>();
    const auto method = tool_.external ? clay::Method::external : clay::Method::formula;
    brush->operations.push_back({clay::Property::distance, method, tool_.falloff, how.amount});
    brush->formula = formula_;
    brush->external = how.batch > 0 ? std::make_shared<const InBatches>(tool_.external, how.batch) : tool_.external;
    brush->adds = tool_.adds;
    brush->values = numbers;
    clay::BrushStroke stroke(ball_, brush, {}, how.threads);
    for (size_t i = 0; i < stamps().size(); ++i) {
      clay::Stamp stamp = stamps()[i];
      stamp.strength = how.strength;
      clay::Stamp image = stamp;
      image.a.x() = -1 - stamp.a.x();
      image.b.x() = -1 - stamp.b.x();
      image.axes.row(0) *= -1;
      if (how.mirrored)
        stroke.apply(std::array{stamp, image});
      else
        stroke.apply(stamp);
      if (static_cast<int>(i + 1) % how.publishEvery == 0) (void)stroke.publish();
    }
    return stroke.finish();
  }

  [[nodiscard]] const clay::Version& ball() const { return ball_; }

  // Empty, or what is wrong with clay that it made.
  [[nodiscard]] std::string problemOf(const clay::Version& made) const {
    const double reach = kRadius + 3 + 2 * clay::kBrickEdge;
    std::string problem;
    made.forEachBrick([&](const clay::Brick& brick) {
      const Vec3d middle = (brick.coord * clay::kBrickEdge).toVec3d() + Vec3d::Constant(3.5);
      double away = 1e9;
      for (const clay::Stamp& each : stamps()) away = std::min(away, (middle - each.a).norm());
      const clay::Slot was = ball_.find(brick.coord);
      for (int i = 0; i < clay::kBrickVoxels; ++i) {
        if (!(std::abs(brick.phi(i)) <= 3)) problem = "a distance that is not finite or beyond the band";
        if (away > reach && brick.phi(i) != was.phi(i, 3)) problem = "clay changed beyond the tip";
      }
    });
    clay::Surface surface(false);
    surface.update(made);
    if (!clay::checkTopology(surface.toMesh()).closed()) problem = "the surface is not closed";
    return problem;
  }

  // Whether the half below x = −1/2 is the mirror image of the other, to the bit.
  [[nodiscard]] static bool symmetric(const clay::Version& made) {
    bool same = true;
    made.forEachBrick([&](const clay::Brick& brick) {
      const clay::Slot slot = made.find({-1 - brick.coord.x, brick.coord.y, brick.coord.z});
      for (int i = 0; i < clay::kBrickVoxels; ++i)
        same = same && brick.phi(i) == slot.phi(clay::Brick::offset(7 - (i >> 6), (i >> 3) & 7, i & 7), 3);
    });
    return same;
  }

 private:
  static const std::vector<clay::Stamp>& stamps() {
    static const std::vector<clay::Stamp> all = [] {
      std::vector<clay::Stamp> made;
      Vec3d at(4, 3, kBall);
      for (int i = 0; i < 12; ++i) {
        const Vec3d to = at + Vec3d(0.9, 0.4, -0.2);
        made.push_back({at, to, kRadius});
        at = to;
      }
      return made;
    }();
    return all;
  }

  AddedTool tool_;
  std::shared_ptr<const clay::Formula> formula_;
  clay::Version ball_;
};

using Say = std::function<void(const char* what, const std::function<std::string()>& problem)>;

// What all brushes promise.
void checkBrush(const AddedTool& tool, const Say& say) {
  const BrushTrial trial(tool);
  const auto sets = trial.numbers();
  const clay::Version& ball = trial.ball();
  uint64_t usual = 0;
  say("changes the clay", [&] {
    usual = trial.stroked(sets[0], {}).hash();
    return usual != ball.hash() ? "" : "it does nothing at full strength, with its numbers as they begin";
  });
  if (usual == 0) return;  // what it does at its best is not known
  say("leaves closed clay, changed under the tip alone, whatever its numbers", [&] {
    for (const auto& numbers : sets)
      for (const float amount : {1.0f, -1.0f}) {
        if (amount < 0 && !tool.inverts) continue;
        std::string problem = trial.problemOf(trial.stroked(numbers, {.amount = amount}));
        if (problem.empty()) continue;
        for (size_t i = 0; i < numbers.size(); ++i)
          problem += fmt::format("{}{} = {:g}", i == 0 ? ", with " : ", ", tool.numbers[i].id, numbers[i]);
        return problem;
      }
    return std::string();
  });
  say("does nothing at strength 0",
      [&] { return trial.stroked(sets[0], {.strength = 0}).hash() == ball.hash() ? "" : "it changes the clay"; });
  const auto sameAs = [&](const BrushTrial::How& how) {
    return [&, how] { return trial.stroked(sets[0], how).hash() == usual ? "" : "it does not"; };
  };
  say("does the same however it is published", sameAs({.publishEvery = 1}));
  say("mirrors to the bit",
      [&] { return BrushTrial::symmetric(trial.stroked(sets[0], {.mirrored = true})) ? "" : "it does not"; });
  if (!tool.external) return;
  say("does the same once more", sameAs({}));
  say("does the same on four threads", sameAs({.threads = 4}));
  say("does the same one brick at a time", sameAs({.batch = 1}));
  say("does the same in batches of seven bricks", sameAs({.batch = 7}));
}

double residentMb(pid_t pid) {
  std::ifstream in(fmt::format("/proc/{}/statm", pid));
  double all = 0, resident = 0;
  in >> all >> resident;
  return resident * 4096 / 1e6;
}

// What a library promises beside that.
void checkLibrary(const PluginLibrary& library, const Plugin::Brush& brush, const Say& say,
                  std::vector<PluginCheck>& checks) {
  const auto trialOf = [&](const PluginLimits& limits) {
    AddedTool tool = brush.tool;
    tool.external =
        std::make_shared<const PluginBrush>(*brush.facts, std::make_shared<PluginProcesses>(library, limits));
    return BrushTrial(tool);
  };
  say("writes its results and nothing else", [&] {
    const BrushTrial trial = trialOf({.comparesWindow = true});
    (void)trial.stroked(trial.numbers()[0], {});
    return "";
  });
  say("asks for nothing that it may not have", [&]() -> std::string {
    const auto processes = std::make_shared<PluginProcesses>(library);
    AddedTool tool = brush.tool;
    tool.external = std::make_shared<const PluginBrush>(*brush.facts, processes);
    const BrushTrial trial(tool);
    (void)trial.stroked(trial.numbers()[0], {});
    const auto process = processes->take(1);
    const std::string refused = process->refusedCall();
    return refused.empty() ? "" : "forbidden: it tried to " + refused;
  });
  say("takes no more memory from stroke to stroke", [&]() -> std::string {
    const auto processes = std::make_shared<PluginProcesses>(library);
    AddedTool tool = brush.tool;
    tool.external = std::make_shared<const PluginBrush>(*brush.facts, processes);
    const BrushTrial trial(tool);
    const auto resident = [&] {
      auto process = processes->take(1);
      const double mb = residentMb(process->pid());
      processes->giveBack(std::move(process));
      return mb;
    };
    (void)trial.stroked(trial.numbers()[0], {});
    const double before = resident();
    for (int i = 0; i < kManyStrokes; ++i) (void)trial.stroked(trial.numbers()[0], {});
    const double grown = resident() - before;
    return grown < kGrowthMb ? "" : fmt::format("{:.0f} MB more after {} strokes", grown, kManyStrokes);
  });
  say("takes a time that a hand can wait for", [&]() -> std::string {
    const BrushTrial trial = trialOf({});
    AddedTool plain = brush.tool;
    plain.numbers.clear();
    plain.formula = "phi + weight * (mean - phi)";
    const BrushTrial peer(plain);
    const auto seconds = [](const BrushTrial& of, const std::vector<float>& numbers) {
      const auto began = Clock::now();
      (void)of.stroked(numbers, {});
      return std::chrono::duration<double>(Clock::now() - began).count();
    };
    // By turns, the least of each: on a busy machine a slow one is tried for longer before it is called slow.
    double least = 1e9, leastOfPeer = 1e9, ratio = kSlowest;
    for (int i = 0; i < kTurns || (i < kMostTurns && ratio >= kSlowest); ++i) {
      least = std::min(least, seconds(trial, trial.numbers()[0]));
      leastOfPeer = std::min(leastOfPeer, seconds(peer, {}));
      ratio = least / leastOfPeer;
    }
    checks.back().measured = fmt::format("{:.2g} times as long as smoothing", ratio);
    return ratio < kSlowest ? "" : fmt::format("{:.3g} times as long as smoothing", ratio);
  });
}

using Check = std::function<bool(std::string name, const std::function<std::string()>& problem)>;

clay::Version trialBall() {
  return clay::makeSphere(clay::Store::make(), clay::Grid{}, Vec3d::Zero(), kBall * clay::Grid{}.voxelMm);
}

// A ball goes out, and comes back where it can.
void checkFormat(const PluginLibrary& library, const Plugin::Format& format, const Check& check) {
  const auto name = [&](const char* what) { return fmt::format("{}: {}", format.id, what); };
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / fmt::format("argil-check-{}-{}{}", ::getpid(), format.id, format.ending);
  io::ModelObject ball;
  ball.name = "Ball";
  clay::Surface surface(false);
  surface.update(trialBall());
  ball.mesh = surface.toMesh();
  bool written = false;
  if (format.writes)
    written = check(name("writes a ball"), [&]() -> std::string {
      PluginProcesses processes(library);
      io::AtomicFile atomic(file);
      exportByPlugin(processes, format.id, atomic, {std::span(&ball, 1)}, {}, nullptr);
      atomic.commit();
      return std::filesystem::file_size(file) > 0 ? "" : "the file is empty";
    });
  if (format.reads && written)
    check(name("reads it again"), [&]() -> std::string {
      PluginProcesses processes(library);
      const io::FileBytes content = io::readFile(file);
      const io::ModelFile back = importByPlugin(processes, format.id, content.bytes(), nullptr);
      return back.objects.size() == 1 && back.objects[0].mesh.triangles.size() == ball.mesh.triangles.size()
                 ? ""
                 : "it is another model";
    });
  if (format.reads)
    check(name("survives files of other kinds"), [&]() -> std::string {
      Random random(1);
      for (int i = 0; i < 20; ++i) {
        std::vector<std::byte> bytes(static_cast<size_t>(1) << (i % 15));
        for (std::byte& each : bytes) each = static_cast<std::byte>(random.below(256));
        PluginProcesses processes(library);
        try {
          (void)importByPlugin(processes, format.id, bytes, nullptr);
        } catch (const PluginError& error) {
          if (error.fault() != PluginFault::failed) throw;
        } catch (const Error&) {
        }
      }
      return "";
    });
  std::error_code none;
  std::filesystem::remove(file, none);
}

void checkOperation(const PluginLibrary& library, const Plugin::Operation& operation, const Check& check) {
  const auto name = [&](const char* what) { return fmt::format("{}: {}", operation.id, what); };
  std::vector<std::string> names;
  for (const AddedTool::Number& number : operation.numbers) names.push_back(number.id);
  const auto made = [&](double AddedTool::Number::*value) {
    PluginProcesses processes(library);
    std::vector<float> values;
    for (const AddedTool::Number& number : operation.numbers) values.push_back(static_cast<float>(number.*value));
    return operateByPlugin(processes, operation.id, names, values, trialBall(), nullptr);
  };
  uint64_t usual = 0;
  check(name("changes a ball"), [&]() -> std::string {
    usual = made(&AddedTool::Number::standard).hash();
    return usual != trialBall().hash() ? "" : "it does nothing, with its numbers as they begin";
  });
  check(name("does the same once more"),
        [&]() -> std::string { return made(&AddedTool::Number::standard).hash() == usual ? "" : "it does not"; });
  check(name("leaves closed clay with its numbers at either end"), [&]() -> std::string {
    for (const auto value : {&AddedTool::Number::low, &AddedTool::Number::high}) {
      clay::Surface surface(false);
      surface.update(made(value));
      if (surface.quadCount() > 0 && !clay::checkTopology(surface.toMesh()).closed())
        return "the surface is not closed";
    }
    return "";
  });
}

std::vector<std::string> idsOf(const std::vector<AddedTool::Number>& numbers) {
  std::vector<std::string> ids;
  for (const AddedTool::Number& number : numbers) ids.push_back(number.id);
  return ids;
}
std::vector<float> valuesOf(const std::vector<AddedTool::Number>& numbers, double AddedTool::Number::*value) {
  std::vector<float> values;
  for (const AddedTool::Number& number : numbers) values.push_back(static_cast<float>(number.*value));
  return values;
}

// A hand goes to and fro through 100 mm: what the guide says is a model each time, or none.
void checkGuide(const PluginLibrary& library, const Plugin::Guide& guide, const Check& check) {
  for (const auto& [value, with] : {std::pair(&AddedTool::Number::standard, "as they begin"),
                                    {&AddedTool::Number::low, "at their low ends"},
                                    {&AddedTool::Number::high, "at their high ends"}})
    // By name: clang 14 captures no structured bindings.
    check(fmt::format("{}: says what is felt, with its numbers {}", guide.id, with),
          [&, value = value]() -> std::string {
            constexpr int kPlaces = 200;
            PluginGuide trial(std::make_shared<PluginProcesses>(library), guide.id, idsOf(guide.numbers),
                              valuesOf(guide.numbers, value));
            int said = 0, good = 0;
            for (int i = 0; i < kPlaces; ++i) {
              trial.tell(Vec3d(50 * std::sin(0.1 * i), 50 * std::cos(0.07 * i), 30 * std::sin(0.05 * i)), Vec3d::Zero(),
                         0);
              std::this_thread::sleep_for(std::chrono::milliseconds(2));
              argil_local_model model;
              haptics::LocalModel felt;
              if (trial.said(model)) ++said, good += checkedModel(model, felt);
              trial.look();
            }
            if (good < said) return fmt::format("{} of {} models are not finite or out of range", said - good, said);
            return said > 0 ? "" : "it says nothing";
          });
}

void checkTexture(const PluginLibrary& library, const Plugin::Texture& texture, const Check& check) {
  const auto image = [&](double AddedTool::Number::*value) {
    PluginProcesses processes(library);
    return imageByPlugin(processes, texture.tool.id, idsOf(texture.tool.numbers),
                         valuesOf(texture.tool.numbers, value));
  };
  for (const auto& [value, with] : {std::pair(&AddedTool::Number::standard, "as they begin"),
                                    {&AddedTool::Number::low, "at their low ends"},
                                    {&AddedTool::Number::high, "at their high ends"}})
    check(fmt::format("{}: gives heights, with its numbers {}", texture.tool.id, with),
          [&, value = value]() -> std::string { return image(value) ? "" : "it gives none"; });
}

// At its own rate, with no force and with its largest. A busy machine makes answers late: of three tries one that is
// good is enough, since what is wrong with a plugin is so in each.
void checkDevice(const PluginLibrary& library, const Plugin::Device& device, const Check& check) {
  check(fmt::format("{}: answers, or says that it is not there", device.id), [&]() -> std::string {
    constexpr int kTries = 3, kMs = 500;
    std::string problem;
    for (int attempt = 0; attempt < kTries; ++attempt) {
      const auto opened = openPluginDevice(device, library);
      haptics::DeviceState state;
      int there = 0, since = 0;
      for (int i = 0; i < kMs; ++i) {
        const double timeS = 1e-9 * static_cast<double>(haptics::nowNs());
        there += opened->read(timeS, state);
        since += there > 0;
        opened->write(timeS, Vec3d(0, 0, i % 2 == 0 && device.sheet.dofOut > 0 ? device.sheet.peakForceN : 0));
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      // Once there it stays.
      if (4 * there > 3 * since || (there == 0 && !device.nodes.empty())) return "";
      problem = fmt::format("{} (a state in {} of {} ms)", opened->status(), there, since);
    }
    return problem;
  });
}

}  // namespace

std::vector<PluginCheck> checkPlugin(const std::filesystem::path& folder) {
  std::vector<PluginCheck> checks;
  const auto check = [&](std::string name, const std::function<std::string()>& problem) {
    checks.push_back({std::move(name), ""});
    try {
      const std::string found = problem();
      checks.back().problem = found;
    } catch (const PluginError& error) {
      checks.back().problem = fmt::format("{}: {}", nameOf(error.fault()), error.what());
    } catch (const Error& error) {
      checks.back().problem = error.what();
    }
    return checks.back().problem.empty();
  };
  Plugin plugin;
  if (!check(fmt::format("{} can be read", kPluginFile), [&] {
        plugin = readPlugin(folder);
        return "";
      }))
    return checks;
  const PluginLibrary library = libraryOf(plugin, folder, {});
  if (!plugin.library.empty() && !check(fmt::format("{} is loaded", plugin.library), [&]() -> std::string {
        const auto began = Clock::now();
        PluginProcess process(library, 1);
        const double ms = std::chrono::duration<double, std::milli>(Clock::now() - began).count();
        checks.back().measured = fmt::format("{:.0f} ms", ms);
        for (const Plugin::Brush& brush : plugin.brushes)
          if (brush.facts) requireAsSaid(process, *brush.facts);
        return ms < 10 * kLoadMs ? "" : fmt::format("that took {:.0f} ms: {:.0f} are meant", ms, kLoadMs);
      }))
    return checks;
  for (const Plugin::Brush& brush : plugin.brushes) {
    const Say say = [&](const char* what, const std::function<std::string()>& problem) {
      check(fmt::format("{}: {}", brush.tool.id, what), problem);
    };
    AddedTool tool = brush.tool;
    if (brush.facts)
      tool.external = std::make_shared<const PluginBrush>(*brush.facts, std::make_shared<PluginProcesses>(library));
    checkBrush(tool, say);
    if (brush.facts) checkLibrary(library, brush, say, checks);
  }
  for (const Plugin::Format& format : plugin.formats) checkFormat(library, format, check);
  for (const Plugin::Operation& operation : plugin.operations) checkOperation(library, operation, check);
  for (const Plugin::Guide& guide : plugin.guides) checkGuide(library, guide, check);
  for (const Plugin::Texture& texture : plugin.textures) checkTexture(library, texture, check);
  for (const Plugin::Device& device : plugin.devices) checkDevice(library, device, check);
  return checks;
}

}  // namespace argil::engine
