// Nearest points of mesh parts against every triangle, looked at by another program: soups, slivers, and meshes with
// all faults.

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <random>
#include <sstream>

#include "haptics/scene/part_mesh.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/tier.h"

namespace argil::haptics {
namespace {

constexpr uint32_t kSeed = 20261120;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int kShare = 20;  // Of the queries, one in so many.
#else
const int kShare = tests::byTier(4, 1);
#endif

double toSegment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d ab = b - a;
  const double t = ab.squaredNorm() > 0 ? std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) : 0.0;
  return (a + t * ab - p).norm();
}

// Foot in the plane if it lies within all three sides, else the nearest side.
double toTriangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d n = (b - a).cross(c - a);
  const auto within = [&](const Vec3d& from, const Vec3d& to) { return (to - from).cross(p - from).dot(n) >= 0; };
  if (n.squaredNorm() > 0 && within(a, b) && within(b, c) && within(c, a)) return std::abs((p - a).dot(n)) / n.norm();
  return std::min({toSegment(p, a, b), toSegment(p, b, c), toSegment(p, c, a)});
}

double bruteForce(const clay::TriangleMesh& mesh, const Vec3d& p) {
  double best = std::numeric_limits<double>::max();
  for (const auto& [a, b, c] : mesh.triangles)
    best = std::min(best, toTriangle(p, mesh.positions[a], mesh.positions[b], mesh.positions[c]));
  return best;
}

struct Compared {
  double worst = 0;     // Too far by, beyond what the header grants, mm.
  double offPoint = 0;  // Distance against the point given.
  int queries = 0, patient = 0;
};

// Queries at all scales: anywhere about the part, near its triangles, and along a walk where each answer is the next
// one's hint.
Compared compare(const clay::TriangleMesh& mesh, int queries, uint32_t seed) {
  const PartMesh part(mesh);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto direction = [&]() -> Vec3d { return Vec3d(uniform(random), uniform(random), uniform(random)); };
  Compared out;
  Vec3d walker = part.middleMm();
  uint32_t hint = PartMesh::kNone;
  for (int i = 0; i < queries; ++i) {
    Vec3d p;
    if (i % 3 == 0) {
      p = part.middleMm() + part.diagonalMm() * direction();
    } else if (i % 3 == 1) {
      const auto& t = mesh.triangles[random() % mesh.triangles.size()];
      p = mesh.positions[t[0]] + 0.7 * part.resolutionMm() * direction();
    } else {
      walker += 0.02 * part.diagonalMm() * direction();
      if ((walker - part.middleMm()).norm() > part.diagonalMm()) walker = part.middleMm();
      p = walker;
    }
    const double truth = bruteForce(mesh, p);
    const PartMesh::Hit hit = part.nearest(p, 1e12, hint);
    hint = i % 5 == 0 ? static_cast<uint32_t>(random()) : hit.triangle;  // Sometimes a wrong one.
    const double granted = std::min(0.01 * (hit.looked / 128), 0.1) * part.resolutionMm();
    out.worst = std::max({out.worst, hit.distance - truth - granted, truth - hit.distance});
    out.offPoint = std::max(out.offPoint, std::abs((hit.point - p).norm() - hit.distance));
    out.patient += granted == 0;
    ++out.queries;
    // A reach just short of it finds nothing, one just beyond finds it.
    if (i % 16 == 0 && granted == 0) {
      const double slack = 1e-6 * (part.diagonalMm() + truth);
      EXPECT_EQ(part.nearest(p, truth - slack, hint).triangle, PartMesh::kNone);
      EXPECT_NE(part.nearest(p, truth + slack, PartMesh::kNone).triangle, PartMesh::kNone);
    }
  }
  EXPECT_LT(out.worst, 3e-7 * part.diagonalMm());
  EXPECT_LT(out.offPoint, 1e-9 * part.diagonalMm() + 1e-9);
  EXPECT_GT(out.patient, out.queries / 2) << "nearly all answers should be exact";
  return out;
}

TEST(PartNearest, IsThatOfAllTrianglesOfRandomSoups) {
  std::printf("seed %u\n", kSeed);
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal;
  const auto vec = [&](double size) -> Vec3d { return size * Vec3d(normal(random), normal(random), normal(random)); };
  int queries = 0;
  for (int soup = 0; soup < 100; ++soup) {
    clay::TriangleMesh mesh;
    const size_t count = 1 + random() % 400;
    const double spread = std::pow(10.0, double(random() % 5) - 1),
                 size = spread * std::pow(10.0, -double(random() % 3));
    const Vec3d offset = soup % 4 ? Vec3d(Vec3d::Zero()) : Vec3d(vec(1e4));
    for (size_t t = 0; t < count; ++t) {
      const Vec3d at = offset + vec(spread);
      const auto first = static_cast<uint32_t>(mesh.positions.size());
      mesh.positions.push_back(at);
      mesh.positions.push_back(at + vec(size));
      switch (random() % 8) {
        case 0:
          mesh.positions.push_back(mesh.positions.back());
          break;  // A segment
        case 1:
          mesh.positions.push_back(0.3 * at + 0.7 * mesh.positions.back());
          break;  // or nearly one,
        case 2:
          mesh.positions.push_back(mesh.positions.back() + vec(1e-4 * size));
          break;  // a needle,
        case 3:
          mesh.positions.back() = at;
          mesh.positions.push_back(at);
          break;  // a point,
        default:
          mesh.positions.push_back(at + vec(size));
          break;
      }
      mesh.triangles.push_back({first, first + 1, first + 2});
      if (random() % 16 == 0) mesh.triangles.push_back(mesh.triangles.back());  // twice.
    }
    const Compared c = compare(mesh, 1000 / kShare, kSeed + static_cast<uint32_t>(soup));
    queries += c.queries;
    ASSERT_FALSE(::testing::Test::HasFailure()) << "soup " << soup << ": off by " << c.worst;
  }
  EXPECT_EQ(queries, 100000 / kShare);
}

// Enough of the two formats for the files below; polygons become fans.
clay::TriangleMesh load(const std::filesystem::path& path) {
  clay::TriangleMesh mesh;
  const auto polygon = [&](const std::vector<int64_t>& corners) {
    for (size_t i = 2; i < corners.size(); ++i)
      mesh.triangles.push_back({static_cast<uint32_t>(corners[0]), static_cast<uint32_t>(corners[i - 1]),
                                static_cast<uint32_t>(corners[i])});
  };
  std::ifstream file(path, std::ios::binary);
  std::string line;
  if (path.extension() == ".obj") {
    while (std::getline(file, line)) {
      std::istringstream words(line);
      std::string word;
      words >> word;
      if (word == "v") {
        Vec3d p = Vec3d::Zero();
        words >> p.x() >> p.y() >> p.z();
        mesh.positions.push_back(p);
      } else if (word == "f") {
        std::vector<int64_t> corners;
        while (words >> word) {
          if (word == "\\") {
            std::getline(file, line);
            words = std::istringstream(line);
            continue;
          }
          const int64_t index = std::stoll(word);
          corners.push_back(index < 0 ? index + static_cast<int64_t>(mesh.positions.size()) : index - 1);
        }
        polygon(corners);
      }
    }
    return mesh;
  }
  // PLY, little endian, floats first in a vertex, one list of ints in a face.
  size_t vertices = 0, faces = 0, stride = 0;
  bool inVertex = false;
  while (std::getline(file, line) && line.substr(0, 10) != "end_header") {
    std::istringstream words(line);
    std::string word, type;
    words >> word >> type;
    if (word == "element") {
      inVertex = type == "vertex";
      words >> (inVertex ? vertices : faces);
    } else if (word == "property" && inVertex) {
      stride += type == "uchar" ? 1 : type == "double" ? 8 : 4;
    }
  }
  std::vector<char> bytes(stride);
  for (size_t i = 0; i < vertices; ++i) {
    file.read(bytes.data(), static_cast<std::streamsize>(stride));
    std::array<float, 3> p{};
    std::memcpy(p.data(), bytes.data(), sizeof p);
    mesh.positions.emplace_back(p[0], p[1], p[2]);
  }
  for (size_t i = 0; i < faces && file; ++i) {
    const int count = file.get();
    std::vector<int64_t> corners;
    for (int k = 0; k < count; ++k) {
      int32_t index = 0;
      file.read(reinterpret_cast<char*>(&index), sizeof index);
      corners.push_back(index);
    }
    if (file) polygon(corners);
  }
  return mesh;
}

TEST(PartNearest, IsThatOfAllTrianglesOfMeshesWithFaults) {
  if (samples::meshData().empty()) GTEST_SKIP() << "ARGIL_DATA is not set";
  for (const char* name : {"non_manif_hole.ply", "many_small_holes.ply", "wallhole.obj", "teapot.obj",
                           "self_intersectA.obj", "stanford-bunny.obj"}) {
    const clay::TriangleMesh mesh = load(samples::meshData() / name);
    ASSERT_GT(mesh.triangles.size(), 10u) << name;
    const int queries = std::clamp(static_cast<int>(20'000'000 / mesh.triangles.size()), 1000, 5000) / kShare;
    const Compared c = compare(mesh, queries, kSeed);
    std::printf("%-22s %6zu triangles, %4d queries, %4d of them exact, off by at most %.2g mm\n", name,
                mesh.triangles.size(), c.queries, c.patient, c.worst);
    EXPECT_FALSE(::testing::Test::HasFailure()) << name;
  }
}

}  // namespace
}  // namespace argil::haptics
