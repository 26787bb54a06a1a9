// What files of others may cost: archives that unpack to a gigabyte, and a large glTF in and out.

#include <malloc.h>
#include <sys/resource.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "tests/e2e/support/command.h"
#include "tests/support/tier.h"

namespace argil::tests {
namespace {

constexpr uint64_t kMiB = uint64_t{1} << 20;

struct Measured {
  Outcome outcome;
  uint64_t peakBytes = 0;  ///< The most that was resident.
};

/// Like argil(), with its peak. `program` instead of argil itself, when named.
Measured measured(const std::vector<std::string>& arguments, const std::string& program = ARGIL_COMMAND) {
  const Scratch scratch;
  const fs::path out = scratch / "out", err = scratch / "err";
  std::vector<std::string> words = {program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 1, program == ARGIL_COMMAND ? out.c_str() : "/dev/null",
                                   O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_addopen(&actions, 2, err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  // A new process begins with the peak of the one that starts it.
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";
  pid_t pid = 0;
  const int failed = posix_spawn(&pid, program.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) throw std::runtime_error("cannot run " + program);
  int status = 0;
  rusage used{};
  wait4(pid, &status, 0, &used);
  Measured result;
  result.outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.outcome.out = slurp(out);
  result.outcome.err = slurp(err);
  result.peakBytes = uint64_t(used.ru_maxrss) * 1024;
  return result;
}

/// Under sanitizers memory is not what it is.
bool countsMemory() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return false;
#else
  return true;
#endif
}

/// Packs as one stream of deflate that ends on a byte and can be continued.
std::string deflated(const std::string& text, bool last) {
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, -15, 9, Z_DEFAULT_STRATEGY);
  std::string packed(deflateBound(&stream, text.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = uInt(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = uInt(packed.size());
  deflate(&stream, last ? Z_FINISH : Z_FULL_FLUSH);
  packed.resize(packed.size() - stream.avail_out);
  deflateEnd(&stream);
  return packed;
}

/// A text whose middle is repeated until it has a gibibyte, packed 190:1.
class Bomb {
 public:
  /// `item(random)`: one that may be repeated; most are the same.
  template <class Item>
  Bomb(const std::string& head, const std::string& foot, const Item& item) {
    constexpr double kRatio = 190;
    std::mt19937 random(7);
    const std::string same = item(random);
    std::string piece, packedPiece;
    for (double odd = 0.001; packedPiece.size() < double(piece.size()) / kRatio || piece.empty(); odd *= 1.1) {
      piece.clear();
      while (piece.size() < kMiB) piece += double(random()) < odd * 4294967296.0 ? item(random) : same;
      packedPiece = deflated(piece, false);
    }
    add(head, deflated(head, false));
    for (uint64_t bytes = 0; bytes < 1024 * kMiB; bytes += piece.size()) add(piece, packedPiece);
    add(foot, deflated(foot, true));
    piece_ = std::move(piece);
  }
  [[nodiscard]] std::string gzip() const {
    return std::string("\x1f\x8b\x08\0\0\0\0\0\0\x03", 10) + packed_ + little(crc_) + little(uint32_t(size_));
  }
  /// The same gibibyte as members of a mebibyte, of which the last one alone says how long it is.
  [[nodiscard]] std::string manyMembers() const {
    const uint32_t crc = uint32_t(::crc32(0, reinterpret_cast<const Bytef*>(piece_.data()), uInt(piece_.size())));
    const std::string member = std::string("\x1f\x8b\x08\0\0\0\0\0\0\x03", 10) + deflated(piece_, true) + little(crc) +
                               little(uint32_t(piece_.size()));
    std::string all;
    for (int i = 0; i < 1024; ++i) all += member;
    return all;
  }
  struct Part {
    std::string name, packed;
    uint32_t crc, size;
  };
  [[nodiscard]] Part part(const std::string& name) const { return {name, packed_, crc_, uint32_t(size_)}; }
  static Part part(const std::string& name, const std::string& text) {
    return {name, deflated(text, true),
            uint32_t(::crc32(0, reinterpret_cast<const Bytef*>(text.data()), uInt(text.size()))),
            uint32_t(text.size())};
  }
  static std::string zip(const std::vector<Part>& parts) {
    std::string bytes, table;
    for (const Part& part : parts) {
      const std::string sizes = little(part.crc) + little(uint32_t(part.packed.size())) + little(part.size) +
                                std::string({char(part.name.size()), 0, 0, 0});
      const std::string common = std::string("\x14\0\0\0\x08\0\0\0\x21\0", 10) + sizes;
      table += std::string("PK\x01\x02\x14\0", 6) + common + std::string(10, '\0') + little(uint32_t(bytes.size())) +
               part.name;
      bytes += "PK\x03\x04" + common + part.name + part.packed;
    }
    const auto count = std::string({char(parts.size()), 0});
    return bytes + table + std::string("PK\x05\x06\0\0\0\0", 8) + count + count + little(uint32_t(table.size())) +
           little(uint32_t(bytes.size())) + std::string(2, '\0');
  }

 private:
  static std::string little(uint32_t value) {
    return {char(value), char(value >> 8), char(value >> 16), char(value >> 24)};
  }
  void add(const std::string& text, const std::string& packed) {
    packed_ += packed;
    crc_ = uint32_t(::crc32(crc_, reinterpret_cast<const Bytef*>(text.data()), uInt(text.size())));
    size_ += text.size();
  }
  std::string packed_, piece_;
  uint32_t crc_ = 0;
  uint64_t size_ = 0;
};

std::string number(std::mt19937& random) {
  return std::to_string(double(random() % 100000) / 1000);
}

class Bombs : public testing::Test {
 protected:
  static const Bomb& stl() {
    static const Bomb bomb("solid a\n", "endsolid a\n", [](std::mt19937& random) {
      std::string facet = "facet normal 0 0 1\nouter loop\n";
      for (int i = 0; i < 3; ++i)
        facet += "vertex " + number(random) + " " + number(random) + " " + number(random) + "\n";
      return facet + "endloop\nendfacet\n";
    });
    return bomb;
  }
  void expectHarmless(const std::string& name, const std::string& bytes) {
    ASSERT_GT(bytes.size(), 4 * kMiB);
    ASSERT_LT(bytes.size(), 8 * kMiB);
    std::ofstream(scratch_ / name, std::ios::binary) << bytes;
    const Measured ran = measured({"inspect", (scratch_ / name).string()});
    EXPECT_EQ(ran.outcome.code, 2) << ran.outcome.err;
    EXPECT_NE(ran.outcome.err.find("50 times its size"), std::string::npos) << ran.outcome.err;
    EXPECT_EQ(std::count(ran.outcome.err.begin(), ran.outcome.err.end(), '\n'), 1) << ran.outcome.err;
    std::printf("%s of %.1f MiB: %.1f MiB at most\n", name.c_str(), double(bytes.size()) / double(kMiB),
                double(ran.peakBytes) / double(kMiB));
    if (countsMemory()) {
      EXPECT_LE(ran.peakBytes, 256 * kMiB) << name;
    }
  }
  Scratch scratch_;
};

TEST_F(Bombs, StlInGzip) {
  expectHarmless("a.stl.gz", stl().gzip());
}
TEST_F(Bombs, StlInManyMembersOfGzip) {
  expectHarmless("a.stl.gz", stl().manyMembers());
}
TEST_F(Bombs, StlInZip) {
  expectHarmless("a.zip", Bomb::zip({stl().part("a.stl")}));
}

TEST_F(Bombs, ThreeMf) {
  const Bomb model(
      "<?xml version=\"1.0\"?><model unit=\"millimeter\" "
      "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\"><resources><object "
      "id=\"1\"><mesh><vertices>",
      "</vertices><triangles><triangle v1=\"0\" v2=\"1\" "
      "v3=\"2\"/></triangles></mesh></object></resources><build><item "
      "objectid=\"1\"/></build></model>",
      [](std::mt19937& random) {
        return "<vertex x=\"" + number(random) + "\" y=\"" + number(random) + "\" z=\"" + number(random) + "\"/>\n";
      });
  expectHarmless(
      "a.3mf",
      Bomb::zip({Bomb::part("_rels/.rels",
                            "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"
                            "<Relationship Id=\"a\" Target=\"/3D/3dmodel.model\" "
                            "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>"),
                 model.part("3D/3dmodel.model")}));
}

/// A torus of 2 · around · across triangles as plain .glb, with normals.
void writeTorus(const fs::path& file, uint32_t around, uint32_t across) {
  const uint64_t vertices = uint64_t{around} * across, triangles = 2 * vertices;
  const auto text = [](uint64_t n) { return std::to_string(n); };
  std::string json =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1},"indices":2}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":)" +
      text(vertices) +
      R"(,"type":"VEC3","min":[-2,-2,-2],"max":[2,2,2]},{"bufferView":1,"componentType":5126,"count":)" +
      text(vertices) + R"(,"type":"VEC3"},{"bufferView":2,"componentType":5125,"count":)" + text(3 * triangles) +
      R"(,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":)" + text(12 * vertices) +
      R"(},{"buffer":0,"byteOffset":)" + text(12 * vertices) + R"(,"byteLength":)" + text(12 * vertices) +
      R"(},{"buffer":0,"byteOffset":)" + text(24 * vertices) + R"(,"byteLength":)" + text(12 * triangles) +
      R"(}],"buffers":[{"byteLength":)" + text(24 * vertices + 12 * triangles) + "}]}";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::ofstream out(file, std::ios::binary);
  const auto words = [&](const auto& values) {
    out.write(reinterpret_cast<const char*>(values.data()), std::streamsize(values.size() * sizeof values[0]));
  };
  const auto binary = uint32_t(24 * vertices + 12 * triangles), jsonBytes = uint32_t(json.size());
  words(std::array{uint32_t{0x46546c67}, uint32_t{2}, 28 + jsonBytes + binary, jsonBytes, uint32_t{0x4e4f534a}});
  out << json;
  words(std::array{binary, uint32_t{0x004e4942}});
  const auto turn = [](uint32_t i, uint32_t of) { return 2 * std::numbers::pi * i / of; };
  for (const bool normals : {false, true}) {
    for (uint32_t i = 0; i < around; ++i) {
      std::vector<std::array<float, 3>> ring;
      for (uint32_t j = 0; j < across; ++j) {
        const double a = turn(i, around), b = turn(j, across), out2 = normals ? std::cos(b) : 1 + 0.3 * std::cos(b);
        ring.push_back(
            {float(std::cos(a) * out2), float((normals ? 1 : 0.3) * std::sin(b)), float(-std::sin(a) * out2)});
      }
      words(ring);
    }
  }
  for (uint32_t i = 0; i < around; ++i) {
    std::vector<std::array<uint32_t, 3>> ring;
    for (uint32_t j = 0; j < across; ++j) {
      const uint32_t i1 = (i + 1) % around, j1 = (j + 1) % across;
      const uint32_t a = i * across + j, b = i1 * across + j, c = i1 * across + j1, d = i * across + j1;
      ring.push_back({a, b, c});
      ring.push_back({a, c, d});
    }
    words(ring);
  }
}

// The mesh: 24 bytes a vertex and 12 a triangle. Three million triangles, ten with ARGIL_LONG=1. What the programs take
// for a small file is their own.
TEST(MemoryOfModels, AGlbInAndOutCostsThreeTimesItsMeshAtMost) {
  if (!countsMemory()) GTEST_SKIP() << "memory is not counted under sanitizers";
  const Scratch scratch;
  const bool isLong = longTier();
  const uint32_t around = isLong ? 2500 : 1500, across = isLong ? 2000 : 1000;
  const uint64_t mesh = uint64_t{around} * across * (24 + 2 * 12);
  const fs::path small = scratch / "small.glb", large = scratch / "large.glb", written = scratch / "out.glb";
  writeTorus(small, 10, 10);
  writeTorus(large, around, across);
  const auto program = [&](const fs::path& file) {
    const Measured ran = measured({"convert", file.string(), written.string(), "--overwrite"});
    EXPECT_EQ(ran.outcome.code, 0) << ran.outcome.err;
    return ran.peakBytes;
  };
  const auto reader = [&](const fs::path& file) {
    const Measured ran =
        measured({"gltf", file.string()}, (fs::path(ARGIL_COMMAND).parent_path() / "argil-reader").string());
    EXPECT_EQ(ran.outcome.code, 0) << ran.outcome.err;
    return ran.peakBytes;
  };
  const double times = double(program(large) - program(small)) / double(mesh);
  const double readerTimes = double(reader(large) - reader(small)) / double(mesh);
  std::printf("%.1f MB of mesh: the program took %.2f times that, its reader %.2f times\n", double(mesh) / 1e6, times,
              readerTimes);
  EXPECT_LE(times, 3);
  EXPECT_LE(readerTimes, 3);
}

// What is said of memory adds up to what the system counts.
TEST(Memory, OfADocumentAddsUp) {
  const Scratch scratch;
  const fs::path script = scratch / "s.json", document = scratch / "d.argil";
  std::ofstream(script) << R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.1}, {"sphere": {"radius_mm": 30}}],
    "strokes": [{"tool": "carve", "radius_mm": 4, "path": [[0, 30, 0, 0], [1, 0, 30, 0]]},
                {"tool": "paint", "radius_mm": 6, "path": [[0, 0, 30, 0], [1, 0, 0, 30]]}]})";
  ASSERT_EQ(argil({"sculpt", script.string(), "-o", document.string()}).code, 0);
  const Outcome told = argil({"inspect", "--cost", "--json", document.string()});
  ASSERT_EQ(told.code, 0) << told.err;
  const auto memory = nlohmann::json::parse(told.out)["memory"];
  const double resident = memory["resident"], sum = memory["sum"];
  EXPECT_GT(memory["clay"].get<double>(), 80e6);
  EXPECT_NEAR(sum / resident, 1, 0.05) << memory.dump();
}

}  // namespace
}  // namespace argil::tests
