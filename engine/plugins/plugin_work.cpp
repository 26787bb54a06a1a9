#include "engine/plugins/plugin_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "clay/base/work_part.h"
#include "clay/field/settle.h"
#include "clay/store/editor.h"
#include "clay/store/tree.h"

namespace argil::engine {

using plugin::Channel;
using plugin::Command;
using plugin::Upcall;

namespace {

/// A process for the time of some work.
class Taken {
 public:
  explicit Taken(PluginProcesses& from) : from_(from), process_(from.take(1)) {}
  ~Taken() { from_.giveBack(std::move(process_)); }
  Taken(const Taken&) = delete;
  Taken& operator=(const Taken&) = delete;
  PluginProcess& operator*() const { return *process_; }
  PluginProcess* operator->() const { return process_.get(); }

 private:
  PluginProcesses& from_;
  std::unique_ptr<PluginProcess> process_;
};

constexpr size_t kPhiAt = plugin::kMostBricks * sizeof(int32_t[3]);  // behind coordinates

[[noreturn]] void failGarbage(PluginProcess& process, const char* what) {
  process.end(PluginFault::failed, fmt::format("{} and was stopped", what));
}

}  // namespace

void exportByPlugin(PluginProcesses& processes, const std::string& exporter, io::AtomicFile& file,
                    const io::ModelView& model, const PluginFrame& frame, Job* job) {
  const Taken process(processes);
  Channel& shared = process->channel();
  const auto serve = [&](Upcall what) -> uint64_t {
    const uint64_t count = shared.count;
    if (what != Upcall::write || count > plugin::kMostBytesAtOnce)
      failGarbage(*process, "asked for something that a file has not");
    file.write({process->window(), count});
    return 1;
  };
  uint64_t all = 0, done = 0;
  for (const io::ModelObject& object : model.objects)
    all += object.mesh.positions.size() + object.mesh.triangles.size();
  // Progress is what has gone by; the plugin's own says nothing of that.
  const auto run = [&](Command command) {
    if (job) job->step(static_cast<double>(done) / static_cast<double>(std::max<uint64_t>(all, 1)));
    process->run(command, serve, nullptr);
  };
  const auto blocks = [&](Command command, const auto& items, const std::vector<io::Colour>& colours) {
    using Item = std::remove_cvref_t<decltype(items[0])>;
    static_assert(sizeof(Item) == sizeof(double[3]) || sizeof(Item) == sizeof(uint32_t[3]));
    for (size_t from = 0; from < items.size(); from += plugin::kMostElements) {
      const size_t count = std::min<size_t>(items.size() - from, plugin::kMostElements);
      std::memcpy(process->window(), items.data() + from, count * sizeof(Item));
      if (!colours.empty()) std::memcpy(process->window() + count * sizeof(Item), colours.data() + from, count * 4);
      shared.count = count;
      shared.first = colours.empty() ? 0 : 1;
      run(command);
      done += count;
    }
  };
  static_assert(sizeof(io::Colour) == 4);
  process->name(plugin::ThingKind::exporter, exporter);
  shared.objectCount = static_cast<uint32_t>(model.objects.size());
  shared.frame = frame.number;
  shared.frameCount = frame.count;
  const auto finish = [&](bool complete) {
    shared.count = complete;
    run(Command::endExport);
  };
  run(Command::beginExport);
  try {
    for (const io::ModelObject& object : model.objects) {
      std::vector<io::Colour> colours = object.vertexColours;
      if (colours.empty() && object.colour) colours.assign(object.mesh.positions.size(), *object.colour);
      shared.object = {object.mesh.positions.size(), object.mesh.triangles.size(), !colours.empty(), {}};
      std::memcpy(shared.object.name, object.name.data(), std::min(object.name.size(), sizeof shared.object.name - 1));
      run(Command::exportObject);
      blocks(Command::exportVertices, object.mesh.positions, colours);
      blocks(Command::exportTriangles, object.mesh.triangles, {});
    }
  } catch (...) {
    // It frees what it holds, unless it is gone.
    if (process->alive()) try {
        job = nullptr;
        finish(false);
      } catch (const Error&) {
      }
    throw;
  }
  finish(true);
}

io::ModelFile importByPlugin(PluginProcesses& processes, const std::string& importer, std::span<const std::byte> bytes,
                             Job* job, uint64_t most) {
  const Taken process(processes);
  Channel& shared = process->channel();
  io::ModelFile model;
  uint64_t vertices = 0, triangles = 0, taken = 0;  // announced of the object in work; bytes in all
  bool colours = false;
  const auto bad = [&](const char* what) { failGarbage(*process, what); };
  const auto take = [&](uint64_t more) {
    taken += more;
    if (taken > most) bad("gave more than memory has room for");
  };
  const auto requireWhole = [&] {
    if (model.objects.empty()) return;
    const io::ModelObject& object = model.objects.back();
    if (object.mesh.positions.size() != vertices || object.mesh.triangles.size() != triangles)
      bad("gave an object of another size than it said");
  };
  const auto serve = [&](Upcall what) -> uint64_t {
    const uint64_t count = shared.count, first = shared.first;
    switch (what) {
      case Upcall::read: {
        if (count > plugin::kMostBytesAtOnce || first > bytes.size()) return 0;
        const uint64_t some = std::min<uint64_t>(count, bytes.size() - first);
        std::memcpy(process->window(), bytes.data() + first, some);
        return some;
      }
      case Upcall::object: {
        requireWhole();
        vertices = shared.object.vertices;
        triangles = shared.object.triangles;
        colours = shared.object.colours != 0;
        if (vertices > UINT32_MAX || triangles > UINT32_MAX || vertices == 0 || triangles == 0)
          bad("gave an object without triangles, or with too many");
        take(sizeof(io::ModelObject));
        model.objects.emplace_back().name = PluginProcess::textOf(shared.object.name);
        return 1;
      }
      case Upcall::vertices: {
        if (model.objects.empty() || count > plugin::kMostElements || (first != 0) != colours)
          bad("gave vertices of no object");
        io::ModelObject& object = model.objects.back();
        if (object.mesh.positions.size() + count > vertices) bad("gave more vertices than it said");
        take(count * (sizeof(Vec3d) + 4));
        const size_t before = object.mesh.positions.size();
        object.mesh.positions.resize(before + count);
        std::memcpy(object.mesh.positions[before].data(), process->window(), count * sizeof(Vec3d));
        for (size_t i = before; i < object.mesh.positions.size(); ++i)
          if (!object.mesh.positions[i].allFinite()) bad("gave a position that is not finite");
        if (!colours) return 1;
        object.vertexColours.resize(before + count);
        std::memcpy(object.vertexColours.data() + before, process->window() + count * sizeof(Vec3d), count * 4);
        return 1;
      }
      case Upcall::triangles: {
        if (model.objects.empty() || count > plugin::kMostElements) bad("gave triangles of no object");
        auto& all = model.objects.back().mesh.triangles;
        if (all.size() + count > triangles) bad("gave more triangles than it said");
        take(count * sizeof(uint32_t[3]));
        const size_t before = all.size();
        all.resize(before + count);
        std::memcpy(all.data() + before, process->window(), count * sizeof(uint32_t[3]));
        for (size_t i = before; i < all.size(); ++i)
          for (const uint32_t corner : all[i])
            if (corner >= vertices) bad("gave a triangle whose corner is not there");
        return 1;
      }
      default:
        bad("asked for something that a file has not");
    }
    return 0;
  };
  process->name(plugin::ThingKind::importer, importer);
  shared.fileBytes = bytes.size();
  process->run(Command::import, serve, job);
  requireWhole();
  if (model.objects.empty()) throw Error("holds no triangles");
  for (const io::ModelObject& object : model.objects) model.faces += object.mesh.triangles.size();
  return model;
}

std::shared_ptr<const clay::HeightImage> imageByPlugin(PluginProcesses& processes, const std::string& texture,
                                                       const std::vector<std::string>& numbers,
                                                       std::span<const float> values) {
  constexpr int kEdge = 256;  // pixels: as many places as go by at once
  constexpr size_t kPlaces = size_t{kEdge} * kEdge;
  static_assert(kPlaces <= plugin::kMostElements);
  const Taken process(processes);
  process->name(plugin::ThingKind::texture, texture);
  process->call(Command::describe);
  requireNumbers(*process, texture, numbers);
  Channel& shared = process->channel();
  std::copy(values.begin(), values.end(), shared.parameters);
  shared.count = kPlaces;
  // Middles of pixels, rows from the top.
  const auto at = [](int pixel) { return (2.0f * static_cast<float>(pixel) + 1) / kEdge - 1; };
  std::vector<float> places(2 * kPlaces);
  for (int y = 0; y < kEdge; ++y)
    for (int x = 0; x < kEdge; ++x) {
      places[static_cast<size_t>(y) * kEdge + static_cast<size_t>(x)] = at(x);
      places[kPlaces + static_cast<size_t>(y) * kEdge + static_cast<size_t>(x)] = -at(y);
    }
  std::memcpy(process->window(), places.data(), places.size() * sizeof(float));
  process->call(Command::texture);
  std::vector<float> heights(kPlaces);
  std::memcpy(heights.data(), process->window() + 2 * kPlaces * sizeof(float), kPlaces * sizeof(float));
  std::vector<uint16_t> grey(kPlaces);
  for (size_t i = 0; i < kPlaces; ++i) {
    if (!std::isfinite(heights[i]))
      process->end(PluginFault::notFinite, "gave a height that is not finite and was stopped");
    grey[i] = static_cast<uint16_t>(std::lround(std::clamp(heights[i], 0.0f, 1.0f) * 65535));
  }
  return std::make_shared<const clay::HeightImage>(kEdge, kEdge, grey);
}

clay::Version operateByPlugin(PluginProcesses& processes, const std::string& operation,
                              const std::vector<std::string>& numbers, std::span<const float> values,
                              const clay::Version& version, Job* job) {
  constexpr double kItsPart = 0.8;  // of the time, about: redistancing follows
  const Taken process(processes);
  Channel& shared = process->channel();
  process->name(plugin::ThingKind::operation, operation);
  process->call(Command::describe);
  requireNumbers(*process, operation, numbers);
  const float band = version.grid().band;
  std::vector<const clay::Brick*> bricks;
  version.forEachBrick([&](const clay::Brick& brick) { bricks.push_back(&brick); });
  const auto put = [](std::byte* to, const float* phi) { std::memcpy(to, phi, sizeof(clay::BrickValues)); };
  clay::Editor editor(version);
  std::vector<Coord> changed;
  const auto serve = [&](Upcall what) -> uint64_t {
    const uint64_t count = shared.count, first = shared.first;
    clay::BrickValues scratch;
    switch (what) {
      case Upcall::bricks: {
        if (first >= bricks.size()) return 0;
        const uint64_t some = std::min<uint64_t>({count, plugin::kMostBricks, bricks.size() - first});
        for (uint64_t i = 0; i < some; ++i) {
          const clay::Brick& brick = *bricks[first + i];
          const std::array<int32_t, 3> coord{brick.coord.x, brick.coord.y, brick.coord.z};
          std::memcpy(process->window() + i * sizeof coord, coord.data(), sizeof coord);
          put(process->window() + kPhiAt + i * sizeof scratch, brick.values(scratch));
        }
        return some;
      }
      case Upcall::brick: {
        const Coord coord{shared.coord[0], shared.coord[1], shared.coord[2]};
        put(process->window(), version.find(coord).values(scratch, band));
        return 1;
      }
      case Upcall::put: {
        if (count > plugin::kMostBricks) failGarbage(*process, "put more bricks than there is room for");
        for (uint64_t i = 0; i < count; ++i) {
          std::array<int32_t, 3> at;
          std::memcpy(at.data(), process->window() + i * sizeof at, sizeof at);
          std::memcpy(scratch, process->window() + kPhiAt + i * sizeof scratch, sizeof scratch);
          if (!std::all_of(std::begin(scratch), std::end(scratch), [](float v) { return std::isfinite(v); }))
            process->end(PluginFault::notFinite, "gave a distance that is not finite and was stopped");
          const Coord coord{at[0], at[1], at[2]};
          if (!clay::inReach(coord)) failGarbage(*process, "put clay where there is no room for it");
          editor.setVoxels(coord, scratch);
          changed.push_back(coord);
        }
        return 1;
      }
      default:
        failGarbage(*process, "asked for something that an operation has not");
    }
  };
  shared.stroke = {};
  shared.stroke.size = sizeof shared.stroke;
  shared.stroke.band = band;
  shared.stroke.voxel_mm = version.grid().voxelMm;
  std::copy_n(version.grid().originMm.data(), 3, shared.stroke.origin_mm);
  shared.stroke.parameter_count = static_cast<uint32_t>(values.size());
  std::copy(values.begin(), values.end(), shared.parameters);
  shared.count = bricks.size();
  process->run(Command::operate, serve, job, kItsPart);
  if (changed.empty()) return version;
  std::sort(changed.begin(), changed.end());
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  clay::redistanceAll(editor, clay::bricksAround(editor, changed), clay::WorkPart(job).part(kItsPart, 1));
  clay::keepChannels(editor, version);
  return editor.commit();
}

}  // namespace argil::engine
