// Islands that `inspect --print` tells of, beside those in the pictures of the layers that PrusaSlicer would cure: the
// clay is sliced by another program, and they are counted there without a word of ours. Skipped with a word where it
// is not installed.

#include <gtest/gtest.h>
#include <stb_image.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "io/bytes/input.h"
#include "io/bytes/zip_reader.h"
#include "tests/e2e/support/referees.h"

namespace argil::tests {
namespace {

using Json = nlohmann::json;

constexpr double kVoxelMm = 0.25, kPixelMm = 0.2;
constexpr double kVoxelsAPixel = kPixelMm * kPixelMm / (kVoxelMm * kVoxelMm);
constexpr size_t kPixels = 1024;  // along an edge of the bed

// Clay that begins in the air, in pictures: the layer and the pixels that it begins with, and what it is before it
// meets other clay.
struct Begun {
  size_t layer = 0, layersAlone = 0;
  std::vector<std::pair<int, int>> pixels;
  double voxels = 0;
};

// A picture at a time, from below upwards.
class LayerTree {
 public:
  void add(const std::vector<bool>& clay) {
    std::vector<int> part(clay.size(), -1);
    for (size_t i = 0; i < clay.size(); ++i)
      if (clay[i] && part[i] < 0) fill(clay, i, part);
    for (int& each : part)
      if (each >= 0) begun_[size_t(each = find(each))].voxels += kVoxelsAPixel;
    below_ = std::move(part);
    ++layer_;
  }
  // All but what stands on the bed. What never meets other clay is alone up to the end.
  std::vector<Begun> end() {
    std::vector<Begun> all;
    for (size_t i = 0; i < begun_.size(); ++i) {
      if (begun_[i].layer == 0 || begun_[i].pixels.empty()) continue;
      if (find(int(i)) == int(i)) begun_[i].layersAlone = layer_;
      all.push_back(std::move(begun_[i]));
    }
    return all;
  }

 private:
  int find(int i) const {
    while (parent_[size_t(i)] != i) i = parent_[size_t(i)];
    return i;
  }
  void fill(const std::vector<bool>& clay, size_t from, std::vector<int>& part) {
    std::vector<size_t> pixels{from};
    const int label = int(begun_.size());
    part[from] = label;
    std::vector<int> under;
    for (size_t next = 0; next < pixels.size(); ++next) {
      const size_t i = pixels[next];
      if (!below_.empty() && below_[i] >= 0) under.push_back(find(below_[i]));
      const size_t x = i % kPixels, y = i / kPixels;
      const auto go = [&](bool there, size_t to) {
        if (there && clay[to] && part[to] < 0) part[to] = label, pixels.push_back(to);
      };
      go(x > 0, i - 1), go(x + 1 < kPixels, i + 1), go(y > 0, i - kPixels), go(y + 1 < kPixels, i + kPixels);
    }
    std::sort(under.begin(), under.end());
    under.erase(std::unique(under.begin(), under.end()), under.end());
    parent_.push_back(under.empty() ? label : under.front());
    begun_.emplace_back().layer = layer_;
    if (under.empty())
      for (const size_t i : pixels) begun_.back().pixels.push_back({int(i % kPixels), int(i / kPixels)});
    // Of those that meet the one that began first stays.
    for (size_t k = 1; k < under.size(); ++k) {
      Begun& gone = begun_[size_t(under[k])];
      gone.layersAlone = layer_ - gone.layer;
      Begun& stays = begun_[size_t(under.front())];
      stays.voxels += gone.voxels;
      // Of two that begin together and meet at once either may be told of.
      if (gone.layersAlone <= 2 && gone.layer - stays.layer <= 1)
        stays.pixels.insert(stays.pixels.end(), gone.pixels.begin(), gone.pixels.end());
      parent_[size_t(under[k])] = under.front();
    }
  }

  std::vector<Begun> begun_;  // what goes on from below has no pixels
  std::vector<int> parent_, below_;
  size_t layer_ = 0;
};

// Random pins and rings around a ball, joined; some of them in the air.
std::string heap(unsigned seed) {
  constexpr int kBodies = 14;
  std::mt19937 random(seed);
  const auto in = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  std::string steps;
  for (int i = 0; i < kBodies; ++i) {
    const bool ring = i % 3 == 0;
    steps += fmt::format(
        R"({{"operation": "{}", "name": "P{}", "voxel_mm": 0.25, "centre_mm": [{:.3f}, {:.3f}, {:.3f}], )"
        R"("axis": [{:.3f}, {:.3f}, {:.3f}], )",
        ring ? "ring" : "cylinder", i, in(-18, 18), in(-18, 18), in(-14, 16), in(-1, 1), in(-1, 1), in(-1, 1));
    steps +=
        ring ? fmt::format(R"("radius_mm": {:.3f}, "tube_mm": {:.3f}}}, )", in(4, 8), in(1, 2))
             : fmt::format(R"("radius_mm": {:.3f}, "height_mm": {:.3f}, "round_mm": 0.2}}, )", in(0.5, 2.5), in(6, 24));
    steps += fmt::format(R"({{"operation": "join", "pieces": ["Clay", "P{}"]}}{})", i, i + 1 < kBodies ? ", " : "");
  }
  return R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.25}, {"sphere": {"radius_mm": 12}}], "strokes": [)" +
         steps + "]}";
}

class IslandReferee : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!installed("prusa-slicer")) GTEST_SKIP() << "prusa-slicer is not installed";
    Outcome made;
    if (const std::string name = GetParam(); name.find('.') != std::string::npos) {
      const char* data = std::getenv("ARGIL_DATA");
      if (data == nullptr) GTEST_SKIP() << "ARGIL_DATA is not set: no model of another program";
      made = argil({"convert", (fs::path(data) / "mesh" / name).string(), clay, "--voxel", "0.25", "--height", "60"});
    } else {
      std::ofstream(scratch / "script.json") << heap(unsigned(std::stoi(name)));
      made = argil({"sculpt", (scratch / "script.json").string(), "-o", clay});
    }
    ASSERT_EQ(made.code, 0) << made.err;
    made = argil({"convert", clay, (scratch / "clay.stl").string()});
    ASSERT_EQ(made.code, 0) << made.err;
  }
  void readLow();
  std::vector<Begun> askPrusaSlicer();

  Scratch scratch;
  const std::string clay = (scratch / "clay.argil").string();
  double low[3] = {};          // mm, of the triangles
  int column = 0, bottom = 0;  // where they begin in the pictures
};

void IslandReferee::readLow() {
  const std::string stl = slurp(scratch / "clay.stl");
  std::fill(low, low + 3, INFINITY);
  for (size_t at = 84; at + 50 <= stl.size(); at += 50)
    for (size_t k = 0; k < 9; ++k) {
      float value = 0;
      std::memcpy(&value, stl.data() + at + 12 + 4 * k, 4);
      low[k % 3] = std::min(low[k % 3], double(value));
    }
}

std::vector<Begun> IslandReferee::askPrusaSlicer() {
  std::ofstream(scratch / "sla.ini") << "printer_technology = SLA\nlayer_height = 0.25\ninitial_layer_height = 0.25\n"
                                        "supports_enable = 0\npad_enable = 0\nsupport_object_elevation = 0\n"
                                        "display_width = 204.8\ndisplay_height = 204.8\ndisplay_pixels_x = 1024\n"
                                        "display_pixels_y = 1024\ndisplay_orientation = landscape\n"
                                        "display_mirror_x = 0\ndisplay_mirror_y = 0\nelefant_foot_compensation = 0\n"
                                        "gamma_correction = 1\nslice_closing_radius = 0.001\nmax_print_height = 400\n"
                                        "bed_shape = 0x0,204.8x0,204.8x204.8,0x204.8\nfaded_layers = 3\n";
  static_cast<void>(outputOf("prusa-slicer --export-sla --load sla.ini clay.stl --output clay.sl1", scratch.path()));
  const io::FileBytes file = io::readFile(scratch / "clay.sl1");
  const io::Input input{file.bytes(), "clay.sl1"};
  io::ZipReader zip(input);
  std::vector<io::ZipReader::Part> pictures;
  for (const io::ZipReader::Part& part : zip.parts())
    if (part.name.ends_with(".png") && part.name.starts_with("clay")) pictures.push_back(part);
  std::sort(pictures.begin(), pictures.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  EXPECT_GT(pictures.size(), 50u);
  LayerTree tree;
  column = int(kPixels), bottom = 0;
  for (const io::ZipReader::Part& part : pictures) {
    const io::FileBytes png = zip.read(part);
    int width = 0, height = 0, channels = 0;
    const std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> grey(
        stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(png.data.get()), int(png.size), &width, &height,
                              &channels, 1),
        &stbi_image_free);
    if (!grey || width != int(kPixels) || height != int(kPixels)) {
      ADD_FAILURE() << part.name << " is no picture of a layer";
      return {};
    }
    std::vector<bool> white(kPixels * kPixels);
    for (size_t i = 0; i < white.size(); ++i)
      if ((white[i] = grey.get()[i] >= 128))
        column = std::min(column, int(i % kPixels)), bottom = std::max(bottom, int(i / kPixels));
    tree.add(white);
  }
  return tree.end();
}

TEST_P(IslandReferee, CountsTheSame) {
  const Outcome said = argil({"inspect", clay, "--print", "sla", "--json"});
  ASSERT_EQ(said.code, 0) << said.err;
  const Json ours = Json::parse(said.out)["pieces"][0]["print"]["islands"];
  readLow();
  const std::vector<Begun> theirs = askPrusaSlicer();
  // One of ours is one of theirs that begins near there: layers lie half a voxel apart at most, and what is hardly
  // inclined begins by some millimetres elsewhere.
  constexpr double kNearMm = 5;
  std::vector<std::tuple<double, size_t, size_t>> pairs;
  for (size_t i = 0; i < ours.size(); ++i)
    for (size_t k = 0; k < theirs.size(); ++k) {
      const auto mm = [&](size_t axis) { return ours[i]["at_mm"][axis].get<double>(); };
      if (std::abs(low[2] + (double(theirs[k].layer) + 0.5) * kVoxelMm - mm(2)) > 1.5 * kVoxelMm) continue;
      double far = kNearMm;
      for (const auto& [x, y] : theirs[k].pixels)
        far = std::min(far, std::hypot(low[0] + (x - column + 0.5) * kPixelMm - mm(0),
                                       low[1] + (bottom - y + 0.5) * kPixelMm - mm(1)));
      if (far < kNearMm) pairs.emplace_back(far, i, k);
    }
  std::sort(pairs.begin(), pairs.end());
  std::vector<bool> found(ours.size()), told(theirs.size());
  for (const auto& [far, i, k] : pairs)
    if (!found[i] && !told[k]) found[i] = told[k] = true;
  // What is alone for fewer layers may begin in one and not in the other, by how they lie.
  constexpr size_t kLayers = 5;
  size_t clear = 0;
  for (size_t i = 0; i < ours.size(); ++i) {
    const double alone = ours[i]["alone_mm"];
    EXPECT_TRUE(found[i] || (alone > 0 && alone < kLayers * kVoxelMm))
        << "PrusaSlicer has no island at " << ours[i].dump();
  }
  for (size_t k = 0; k < theirs.size(); ++k) {
    if (theirs[k].voxels < 16 || theirs[k].layersAlone < kLayers) continue;
    ++clear;
    EXPECT_TRUE(told[k]) << "not told: from layer " << theirs[k].layer << ", alone for " << theirs[k].layersAlone
                         << ", " << theirs[k].voxels << " voxels";
  }
  std::printf("%s: %zu islands, %td of them in PrusaSlicer's layers, which have %zu of %zu layers and more\n",
              GetParam().c_str(), ours.size(), std::count(found.begin(), found.end(), true), clear, kLayers);
  EXPECT_FALSE(theirs.empty());
}

INSTANTIATE_TEST_SUITE_P(LongClay, IslandReferee,
                         testing::Values("1", "2", "3", "4", "5", "6", "7", "8", "koala_100k.obj", "armadillo_29k.obj",
                                         "rocker-arm.obj", "dragon_vrip_871k.ply.gz"));

}  // namespace
}  // namespace argil::tests
