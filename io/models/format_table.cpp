#include "io/models/format_table.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <deque>
#include <mutex>

#include "clay/base/error.h"
#include "io/models/added_formats.h"
#include "io/models/three_mf_read.h"
#include "io/models/three_mf_write.h"

namespace argil::io {
namespace {

const std::array kFormats = {
    Format{.name = "STL",
           .extension = ".stl",
           .recognizes = recognizesStl,
           .parseModel = parseStl,
           .encoder = makeStlEncoder,
           .singlePrecision = true},
    Format{.name = "OBJ",
           .extension = ".obj",
           .recognizes = recognizesObj,
           .parseModel = parseObj,
           .encoder = makeObjEncoder,
           .objects = true,
           .colours = true},
    Format{.name = "PLY",
           .extension = ".ply",
           .recognizes = recognizesPly,
           .parseMesh = parsePly,
           .encoder = makePlyEncoder,
           .singlePrecision = true,
           .colours = true,
           .triangleColours = true},
    Format{.name = "OFF", .extension = ".off", .recognizes = recognizesOff, .parseMesh = parseOff},
    Format{.name = "3MF",
           .extension = ".3mf",
           .recognizes = recognizesThreeMf,
           .parseModel = parseThreeMf,
           .write = writeThreeMf,
           .singlePrecision = true,
           .objects = true,
           .colours = true,
           .triangleColours = true},
    Format{.name = "glTF (binary)",
           .extension = ".glb",
           .recognizes = recognizesGlb,
           .readInProcess = readGltf,
           .write = writeGlb,
           .objects = true,
           .colours = true,
           .triangleColours = true},
    Format{.name = "glTF",
           .extension = ".gltf",
           .recognizes = recognizesGltf,
           .readInProcess = readGltf,
           .write = writeGltf,
           .objects = true,
           .colours = true,
           .triangleColours = true},
    Format{.name = "Draco",
           .extension = ".drc",
           .recognizes = recognizesDraco,
           .readInProcess = readDraco,
           .write = writeDraco,
           .colours = true,
           .triangleColours = true},
    Format{.name = "STEP", .extension = ".step", .recognizes = recognizesStep, .readInProcess = readCad},
    Format{.name = "STEP", .extension = ".stp", .recognizes = recognizesStep, .readInProcess = readCad},
    Format{.name = "IGES", .extension = ".iges", .recognizes = recognizesIges, .readInProcess = readCad},
    Format{.name = "IGES", .extension = ".igs", .recognizes = recognizesIges, .readInProcess = readCad},
};

// Rows are never moved: those who read them do not wait for those who add.
class Formats {
 public:
  Formats() : count_(kFormats.size()) { std::copy(kFormats.begin(), kFormats.end(), rows_.begin()); }
  [[nodiscard]] std::span<const Format> all() const { return {rows_.data(), count_.load(std::memory_order_acquire)}; }

  void add(AddedFormat format) {
    const std::lock_guard lock(mutex_);
    for (const Format& each : all())
      if (each.extension == format.extension)
        throw Error("there is another format with the ending " + format.extension);
    const size_t at = count_.load(std::memory_order_relaxed);
    if (at == kMost) throw Error("more than " + std::to_string(kMost) + " formats");
    const AddedFormat& kept = added_.emplace_back(std::move(format));
    Format& row = rows_[at];
    row.name = kept.name;
    row.extension = kept.extension;
    row.recognizes = [](const Input&) { return false; };
    row.readInProcess = kept.read;
    if (kept.write)
      row.write = [&kept](AtomicFile& file, const ModelView& model, const WriteOptions&, WriteReport& report,
                          Job* job) {
        report.format = kept.name;
        kept.write(file, model, job);
      };
    row.byEnding = true;
    row.frameEnding = kept.frameEnding;
    row.objects = row.colours = true;
    count_.store(at + 1, std::memory_order_release);
  }

 private:
  static constexpr size_t kMost = 64;
  std::mutex mutex_;
  std::array<Format, kMost> rows_{};
  std::deque<AddedFormat> added_;
  std::atomic<size_t> count_;
};

Formats& table() {
  static Formats formats;
  return formats;
}

}  // namespace

std::span<const Format> formats() {
  return table().all();
}

void addFormat(AddedFormat format) {
  table().add(std::move(format));
}

std::string frameEndingOf(std::string_view extension) {
  for (const Format& each : formats())
    if (each.extension == extension) return std::string(each.frameEnding);
  return {};
}

std::vector<AddedFormatFacts> addedFormats() {
  std::vector<AddedFormatFacts> facts;
  for (const Format& each : formats().subspan(kFormats.size()))
    facts.push_back(
        {each.name, each.extension, each.readInProcess != nullptr, each.write != nullptr, !each.frameEnding.empty()});
  return facts;
}

bool hasFormat(std::string_view extension) {
  const auto all = formats();
  return std::any_of(all.begin(), all.end(), [&](const Format& each) { return each.extension == extension; });
}

}  // namespace argil::io
