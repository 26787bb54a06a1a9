#include "clay/import/mesh_to_clay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "clay/base/memory_guard.h"
#include "clay/mesh/winding_number.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/test_meshes.h"

namespace argil::clay {
namespace {

using testing::append;
using testing::bandFaults;
using testing::box;
using testing::clayVolume;
using ::testing::Contains;
using testing::dataFile;
using testing::expectProperBand;
using testing::flip;
using ::testing::HasSubstr;
using testing::icosphere;
using testing::meshVolume;
using ::testing::Not;
using testing::readMesh;

constexpr uint64_t kSeed = 42;
/// Steepest allowed where distances are of first order: beside closed holes and folds.
constexpr double kFirstOrder = 1.1;

/// With unit voxels and the origin at zero, so that mesh coordinates are voxel coordinates.
ImportOptions unitVoxels() {
  ImportOptions options;
  options.grid.voxelMm = 1;
  options.placeOrigin = false;
  return options;
}

Imported import(const TriangleMesh& mesh, const ImportOptions& options = unitVoxels()) {
  return meshToClay(Store::make(), mesh, options);
}

std::string messageOf(const TriangleMesh& mesh, const ImportOptions& options) {
  try {
    (void)import(mesh, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    return error.what();
  }
  return "no error";
}

/// Data scaled to 100 mm, so that sizes in files do not matter here.
TriangleMesh dataMesh(const std::string& name) {
  TriangleMesh mesh = readMesh(dataFile(name));
  Vec3d low = mesh.positions[0], high = low;
  for (const auto& p : mesh.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
  for (auto& p : mesh.positions) p = (p - low) * (100 / (high - low).maxCoeff());
  return mesh;
}

double volumeMm3(const Imported& imported) {
  return clayVolume(imported.version) * std::pow(imported.version.grid().voxelMm, 3);
}

Imported importData(const TriangleMesh& mesh, int voxels) {
  ImportOptions options;
  options.grid.voxelMm = suggestVoxelMm(mesh, voxels);
  return import(mesh, options);
}

#define SKIP_WITHOUT_DATA() \
  if (dataFile("").empty()) GTEST_SKIP() << "ARGIL_DATA is not set"

TEST(MeshToClay, PutsTheSurfaceOfASphereWhereTheMeshHasIt) {
  ImportOptions options;
  options.grid.voxelMm = 0.5;
  const Vec3d centre(3.21, -7.77, 11.1);
  const TriangleMesh mesh = icosphere(centre, 40, 6);
  const Imported imported = import(mesh, options);
  expectProperBand(imported.version);
  EXPECT_TRUE(imported.report.sound());
  EXPECT_FALSE(imported.report.windingUsed);
  EXPECT_EQ(imported.report.closingEdges, 0u);

  double sagitta = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    sagitta = std::max(sagitta, 40 - ((mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) / 3 - centre).norm());
  }
  const Grid& grid = imported.version.grid();
  Sampler sampler(imported.version);
  double squares = 0;
  size_t count = 0;
  imported.version.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < kBrickVoxels; ++i) {
      const Coord v = brick.coord * 8 + Coord{i >> 6, (i >> 3) & 7, i & 7};
      for (const Coord step : {Coord{1, 0, 0}, Coord{0, 1, 0}, Coord{0, 0, 1}}) {
        const double p = brick.phi(i), q = sampler.voxel(v + step);
        if ((p < 0) == (q < 0)) continue;
        const Vec3d at = v.toVec3d() + step.toVec3d() * (p / (p - q));
        const double error = (grid.toWorld(at) - centre).norm() - 40;
        squares += error * error;
        ++count;
      }
    }
  });
  ASSERT_GT(count, 100000u);
  const double rms = std::sqrt(squares / double(count));
  EXPECT_LE(rms, sagitta + 0.02 * grid.voxelMm);
  RecordProperty("rms_voxels", std::to_string(rms / grid.voxelMm));
  RecordProperty("sagitta_voxels", std::to_string(sagitta / grid.voxelMm));
}

TEST(MeshToClay, MeasuresExactDistances) {
  const Imported imported = import(box({10, 10, 10}, {41.3, 30.7, 25.2}));
  const Vec3d middle(25.65, 20.35, 17.6), half(15.65, 10.35, 7.6);
  imported.version.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < kBrickVoxels; ++i) {
      const Vec3d p = (brick.coord * 8 + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d();
      const Vec3d q = (p - middle).cwiseAbs() - half;
      const double exact = q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
      ASSERT_NEAR(brick.phi(i), std::clamp(exact, -3.0, 3.0), 1e-5) << p.transpose();
    }
  });
  EXPECT_NEAR(clayVolume(imported.version), 31.3 * 20.7 * 15.2, 5e-3 * 31.3 * 20.7 * 15.2);
  EXPECT_LT(imported.version.find({3, 2, 2}).phi(0, 3), -2.9f) << "the middle is solid";
}

TEST(MeshToClay, TakesFacesThatLieOnVoxels) {
  const Imported imported = import(box({10, 10, 10}, {42, 30, 26}));
  expectProperBand(imported.version);
  EXPECT_EQ(imported.report.droppedVoxels, 0u);
  Sampler sampler(imported.version);
  EXPECT_EQ(sampler.voxel({20, 20, 10}), 0);
  EXPECT_EQ(sampler.voxel({20, 20, 26}), 0);
  EXPECT_EQ(sampler.voxel({20, 20, 11}), -1);
  EXPECT_EQ(sampler.voxel({20, 20, 25}), -1);
  EXPECT_EQ(sampler.voxel({42, 30, 26}), 0);
}

TEST(MeshToClay, ClosesAHoleWhereTheWindingNumberIsAHalf) {
  // Of a box without its lid the level one half is the lid itself, exactly: from its plane the other faces fill half
  // the view.
  for (const double z : {30.0, 30.4}) {
    TriangleMesh open = box({10, 10, 10}, {50, 50, z});
    open.triangles.erase(open.triangles.begin() + 2, open.triangles.begin() + 4);
    const Imported imported = import(open);
    expectProperBand(imported.version, kFirstOrder);
    EXPECT_TRUE(imported.report.windingUsed);
    EXPECT_GT(imported.report.closingEdges, 1000u);
    EXPECT_NEAR(clayVolume(imported.version), 40 * 40 * (z - 10), 0.01 * 40 * 40 * (z - 10));
    double worst = 0;
    for (int x = 16; x < 45; ++x) {
      for (int y = 16; y < 45; ++y) {
        Sampler sampler(imported.version);
        for (int k = -2; k <= 3; ++k) worst = std::max(worst, std::abs(sampler.voxel({x, y, 30 + k}) - (30 + k - z)));
      }
    }
    EXPECT_LT(worst, 0.1) << "the field over the closed hole is a distance";
    EXPECT_THAT(imported.report.sentences().back(), HasSubstr("open along 4 edges"));
  }
}

TEST(MeshToClay, UnitesBodiesWhoseWallsLieInPlanesOfVoxels) {
  // A plate and two blocks that stand in it, all at whole voxels; a third beside it by a face.
  const std::array<std::pair<Vec3d, Vec3d>, 4> boxes{{{{10, 10, 10}, {50, 40, 18}},
                                                      {{20, 16, 12}, {30, 34, 34}},
                                                      {{36, 20, 14}, {44, 28, 30}},
                                                      {{50, 10, 10}, {60, 40, 18}}}};
  TriangleMesh mesh;
  for (const auto& [low, high] : boxes) append(mesh, box(low, high));
  const Imported imported = import(mesh);
  Sampler sampler(imported.version);
  double worst = 0;
  for (int x = 6; x < 64; ++x)
    for (int y = 6; y < 44; ++y)
      for (int z = 6; z < 38; ++z) {
        // Within the union by at least half a voxel around, or outside of it by that.
        int in = 0;
        for (int corner = 0; corner < 8; ++corner) {
          const Vec3d p = Vec3d(x, y, z) + 0.5 * Vec3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
          in += std::any_of(boxes.begin(), boxes.end(), [&](const auto& b) {
            return (p.array() > b.first.array()).all() && (p.array() < b.second.array()).all();
          });
        }
        const double phi = sampler.voxel({x, y, z});
        if (in == 8)
          ASSERT_LT(phi, -0.3) << x << " " << y << " " << z;
        else if (in == 0)
          ASSERT_GT(phi, 0.3) << x << " " << y << " " << z;
        else
          worst = std::max(worst, std::abs(phi));
      }
  EXPECT_LT(worst, 1.01);
  EXPECT_NEAR(clayVolume(imported.version), 40 * 30 * 8 + 10 * 18 * 16 + 8 * 8 * 12 + 10 * 30 * 8, 150);
}

TEST(MeshToClay, UnitesOverlappingBodies) {
  TriangleMesh mesh = icosphere({30, 30, 30}, 15, 5);
  append(mesh, icosphere({47, 30, 30}, 12, 5));
  append(mesh, icosphere({28, 30, 30}, 6, 4));  // inside of the first
  const Imported imported = import(mesh);
  expectProperBand(imported.version, kFirstOrder);
  EXPECT_EQ(imported.report.bodies, 3u);
  EXPECT_GT(imported.report.droppedVoxels, 1000u);
  // Two balls less their lens.
  const double d = 17, R = 15, r = 12, pi = std::numbers::pi;
  const double lens = pi * std::pow(R + r - d, 2) * (d * d + 2 * d * (R + r) - 3 * std::pow(R - r, 2)) / (12 * d);
  const double volume = 4.0 / 3 * pi * (R * R * R + r * r * r) - lens;
  EXPECT_NEAR(clayVolume(imported.version), volume, 0.01 * volume);

  // Outside the distance is exact; inside no wall is left.
  Sampler sampler(imported.version);
  double worstOutside = 0, worstInside = 0;
  for (int x = 10; x < 64; ++x) {
    for (int y = 10; y < 50; ++y) {
      for (int z = 10; z < 50; ++z) {
        const Vec3d p(x, y, z);
        const double exact = std::min((p - Vec3d(30, 30, 30)).norm() - R, (p - Vec3d(47, 30, 30)).norm() - r);
        const double phi = sampler.voxel({x, y, z});
        if (exact > 0) worstOutside = std::max(worstOutside, std::abs(phi - std::min(exact, 3.0)));
        // The union of two distances is a bound inside: the true depth is no less.
        if (exact < -0.1) worstInside = std::max(worstInside, phi - std::max(exact, -3.0));
      }
    }
  }
  EXPECT_LT(worstOutside, 0.1);  // and the facets of the mesh
  EXPECT_LT(worstInside, 0.35);
}

TEST(MeshToClay, KeepsCavitiesAndTurnsWhatIsInsideOut) {
  const auto inverted = [](TriangleMesh mesh) {
    for (auto& t : mesh.triangles) flip(t);
    return mesh;
  };
  TriangleMesh hollow = icosphere({30, 30, 30}, 20, 4);
  append(hollow, inverted(icosphere({30, 30, 30}, 10, 4)));
  const double volume = meshVolume(hollow);
  for (const TriangleMesh& mesh : {hollow, inverted(hollow)}) {
    const Imported imported = import(mesh);
    expectProperBand(imported.version);
    EXPECT_NEAR(clayVolume(imported.version), volume, 0.005 * volume);
    EXPECT_EQ(Sampler(imported.version).voxel({30, 30, 30}), 3);
  }
  EXPECT_TRUE(import(inverted(hollow)).report.flippedWhole);
}

TEST(MeshToClay, LosesWallsThinnerThanAVoxelWithoutATrace) {
  TriangleMesh mesh = icosphere({30, 30, 30}, 15, 4);
  append(mesh, box({60.3, 20, 20}, {60.6, 40, 40}));  // between two layers of voxels
  const Imported imported = import(mesh);
  expectProperBand(imported.version);
  EXPECT_EQ(imported.version.find(Coord{60, 30, 30} >> 3), Slot(Tile::outside));
  EXPECT_THAT(messageOf(box({60.3, 20, 20}, {60.6, 40, 40}), unitVoxels()), HasSubstr("use a smaller voxel"));
}

TEST(MeshToClay, SaysThatASheetHasNoInside) {
  TriangleMesh sheet{{{0, 0, 0}, {50, 0, 0}, {50, 50, 3}, {0, 50, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  EXPECT_THAT(messageOf(sheet, unitVoxels()), HasSubstr("open sheet"));
}

TEST(MeshToClay, RefusesWhatDoesNotFitAndNamesWhatWould) {
  const TriangleMesh mesh = box({0, 0, 0}, {1000, 10, 10});
  ImportOptions options;
  options.grid.voxelMm = 0.01;
  EXPECT_THAT(messageOf(mesh, options), HasSubstr("65536 is the most: use 0.0153 mm or more"));
  options.grid.voxelMm = 0.0153;
  EXPECT_THAT(messageOf(mesh, options), HasSubstr("268 million is the most: use 0.03 mm or more"));
  options.grid.voxelMm = 0.04;
  const PretendedMemory little([] { return MemoryRoom{uint64_t{8} << 30, uint64_t{2} << 30}; });
  EXPECT_THAT(messageOf(mesh, options), HasSubstr("about 12.1 GB of memory, and 1.88 GB are free: use a voxel larger"));
  options.grid.voxelMm = 0;
  EXPECT_THAT(messageOf(mesh, options), HasSubstr("voxel size"));
  options.grid.voxelMm = 1;
  EXPECT_THAT(messageOf(box({4e6, 0, 0}, {4.001e6, 10, 10}), options), HasSubstr("1e6 mm"));
  options.threads = 65;
  EXPECT_THAT(messageOf(mesh, options), HasSubstr("65 threads"));
  EXPECT_THAT(messageOf({}, unitVoxels()), HasSubstr("no triangle"));
  EXPECT_THAT(messageOf({{{1, 2, 3}}, {{0, 0, 0}}}, unitVoxels()), HasSubstr("no triangle"));
}

// What is said to help is possible: there are no voxels above 1000 mm and below 0.001 mm.
TEST(MeshToClay, SaysWhatHelpsWhereNoVoxelDoes) {
  const TriangleMesh huge = box({0, 0, 0}, {3e7, 2e7, 1e7}), tiny = box({0, 0, 0}, {3e-5, 2e-5, 1e-5});
  ImportOptions options;
  options.grid.voxelMm = suggestVoxelMm(huge);
  EXPECT_THAT(messageOf(huge, options), HasSubstr("give a smaller unit or scale it down"));
  options.grid.voxelMm = suggestVoxelMm(tiny);
  EXPECT_THAT(messageOf(tiny, options), HasSubstr("give a larger unit or scale it up"));
}

TEST(MeshToClay, ASheetBesideASolidIsNotSaidToBeClosed) {
  TriangleMesh mesh = box({20, 20, 20}, {40, 40, 40}), sheet = box({60, 20, 20}, {80, 40, 40});
  sheet.triangles.resize(2);
  append(mesh, sheet);
  const Imported made = import(mesh, unitVoxels());
  std::string said;
  for (const std::string& sentence : made.report.sentences()) said += sentence + " ";
  EXPECT_THAT(said, HasSubstr("open along 4 edges; nothing closes it"));
  EXPECT_THAT(said, HasSubstr("Walls thinner than"));
  EXPECT_THAT(said, ::testing::Not(HasSubstr("closed by themselves")));
}

TEST(MeshToClay, PlacesTheOrigin) {
  ImportOptions options;
  options.grid.voxelMm = 0.25;
  const Imported imported = import(icosphere({-123, 456, 789}, 5, 3), options);
  const Grid& grid = imported.version.grid();
  const Vec3d low = grid.toVoxel(Vec3d(-128, 451, 784));
  EXPECT_GE(low.minCoeff(), 16);
  EXPECT_LT(low.maxCoeff(), 18);
  EXPECT_LT(Sampler(imported.version).trilinear(grid.toVoxel({-123, 456, 789})), -2.9);
}

TEST(MeshToClay, SuggestsAVoxelSize) {
  EXPECT_DOUBLE_EQ(suggestVoxelMm(box({0, 0, 0}, {100, 10, 10})), 0.391);
  EXPECT_DOUBLE_EQ(suggestVoxelMm(box({0, 0, 0}, {100, 10, 10}), 1000), 0.1);
  EXPECT_DOUBLE_EQ(suggestVoxelMm(box({0, 0, 0}, {1e-3, 1e-3, 1e-3})), 1e-3);
  EXPECT_THROW((void)suggestVoxelMm({}), Error);
}

TEST(MeshToClay, DoesNotDependOnThreads) {
  TriangleMesh mesh = icosphere({30, 30, 30}, 20, 4);
  append(mesh, box({25, 25, 40}, {35, 35, 60}));
  mesh.triangles.pop_back();
  ImportOptions options = unitVoxels();
  options.threads = 1;
  const uint64_t hash = import(mesh, options).version.hash();
  options.threads = 3;
  EXPECT_EQ(import(mesh, options).version.hash(), hash);
}

TEST(MeshToClay, StopsWhenCancelled) {
  const TriangleMesh mesh = icosphere({300, 300, 300}, 200, 6);
  Job before;
  before.cancel();
  EXPECT_THROW((void)meshToClay(Store::make(), mesh, unitVoxels(), &before), Cancelled);
  // In the middle: once some progress is seen. The store must be as before.
  const auto store = Store::make();
  Job job;
  std::thread other([&] {
    while (job.fraction() < 0.06) std::this_thread::yield();
    job.cancel();
  });
  EXPECT_THROW((void)meshToClay(store, mesh, unitVoxels(), &job), Cancelled);
  other.join();
  while (store->collect()) {
  }
  EXPECT_EQ(store->usage().bricks, 0u);
}

TEST(MeshToClay, KeepsTheVolumeOfSoundMeshes) {
  SKIP_WITHOUT_DATA();
  for (const char* name : {"mesh/nefertiti_lowres.obj", "mesh/fandisk.obj", "mesh/armadillo_29k.obj"}) {
    SCOPED_TRACE(name);
    const TriangleMesh mesh = dataMesh(name);
    const Imported imported = importData(mesh, 160);
    expectProperBand(imported.version);
    EXPECT_NEAR(volumeMm3(imported) / meshVolume(mesh), 1, 0.005);
    RecordProperty(std::string(name).substr(5, 4), std::to_string(volumeMm3(imported) / meshVolume(mesh)));
  }
}

TEST(MeshToClay, ClosesTheBunny) {
  SKIP_WITHOUT_DATA();
  const TriangleMesh mesh = dataMesh("mesh/stanford-bunny.obj");
  const double volume = meshVolume(testing::withHolesFanned(mesh));
  const Imported imported = importData(mesh, 160);
  expectProperBand(imported.version, kFirstOrder);
  EXPECT_NEAR(volumeMm3(imported) / volume, 1, 0.01);
  RecordProperty("ratio", std::to_string(volumeMm3(imported) / volume));
}

TEST(MeshToClay, RepairsFlippedAndRepeatedFaces) {
  SKIP_WITHOUT_DATA();
  TriangleMesh mesh = dataMesh("mesh/armadillo_29k.obj");
  const double volume = volumeMm3(importData(mesh, 128));
  std::mt19937 random(kSeed);
  const size_t count = mesh.triangles.size();
  for (size_t i = 0; i < count; ++i) {
    if (random() % 20 == 0) flip(mesh.triangles[i]);
    if (random() % 10 == 0) mesh.triangles.push_back(mesh.triangles[i]);
  }
  const Imported imported = importData(mesh, 128);
  expectProperBand(imported.version);
  EXPECT_NEAR(volumeMm3(imported) / volume, 1, 1e-6) << "seed " << kSeed;
  EXPECT_GT(imported.report.flippedFaces, 1000u);
  EXPECT_GT(imported.report.duplicateFaces, 2000u);
}

TEST(MeshToClay, UnitesAHundredBodies) {
  SKIP_WITHOUT_DATA();
  const TriangleMesh mesh = dataMesh("mesh/cycloidal.ply");
  const Imported imported = importData(mesh, 160);
  expectProperBand(imported.version, kFirstOrder);
  EXPECT_EQ(imported.report.bodies, 100u);
  // One random place in each cell of a lattice, decided by the sum of solid angles of all triangles' tree.
  const WindingNumber winding(mesh);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(0, 1);
  Vec3d high = mesh.positions[0];
  for (const auto& p : mesh.positions) high = high.cwiseMax(p);
  constexpr int kN = 24;
  int inside = 0;
  for (int i = 0; i < kN * kN * kN; ++i) {
    const Vec3d p = (Vec3d(i % kN, i / kN % kN, i / kN / kN) + Vec3d(unit(random), unit(random), unit(random))) / kN;
    inside += winding.at(p.cwiseProduct(high)) > 0.5;
  }
  const double volume = high.prod() * inside / (kN * kN * kN);
  EXPECT_NEAR(volumeMm3(imported) / volume, 1, 0.02) << "seed " << kSeed;
  RecordProperty("ratio", std::to_string(volumeMm3(imported) / volume));
}

// An outline in the plane z = 0, extruded; `caps` are triangles of its corners.
TriangleMesh extruded(const std::vector<Eigen::Vector2d>& outline, const std::vector<std::array<uint32_t, 3>>& caps,
                      double low, double high) {
  TriangleMesh mesh;
  const auto n = static_cast<uint32_t>(outline.size());
  for (const double z : {low, high})
    for (const Eigen::Vector2d& p : outline) mesh.positions.emplace_back(p.x(), p.y(), z);
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t j = (i + 1) % n;
    mesh.triangles.push_back({i, j, i + n});
    mesh.triangles.push_back({j, j + n, i + n});
  }
  for (const auto& [a, b, c] : caps) {
    mesh.triangles.push_back({a, c, b});
    mesh.triangles.push_back({a + n, b + n, c + n});
  }
  return mesh;
}

// A slanting blade of 0.3 voxels on a block has a voxel here and there in it: they hang together with nothing.
TEST(MeshToClay, TakesSpecksOutAndCountsThem) {
  const TriangleMesh mesh = extruded({{0, 0}, {20, 0}, {20, 20}, {26, 60}, {25.7, 60}, {19.7, 20}, {0, 20}},
                                     {{2, 3, 4}, {2, 4, 5}, {0, 1, 2}, {0, 2, 5}, {0, 5, 6}}, 0.1, 2.9);
  const Imported made = meshToClay(Store::make(), mesh, unitVoxels());
  EXPECT_EQ(made.report.bodies, 1u);
  EXPECT_GT(made.report.losses.specks, 1u);
  EXPECT_EQ(made.report.losses.bodies, 1u);
  EXPECT_EQ(made.report.losses.cavities, 0u);
  EXPECT_NEAR(clayVolume(made.version), 20 * 20 * 2.8, 20);
  EXPECT_THAT(made.report.sentences(), ::testing::Contains(HasSubstr("taken out")));
}

// A rod of its own that is as thin is a body of the mesh: what there is of it stays.
TEST(MeshToClay, KeepsSmallBodiesThatTheMeshHas) {
  TriangleMesh mesh = extruded({{0, 0}, {20, 0}, {20, 20}, {0, 20}}, {{0, 1, 2}, {0, 2, 3}}, 0.1, 20.1);
  const TriangleMesh rod =
      extruded({{29.8, 9.8}, {30.2, 9.8}, {30.2, 10.2}, {29.8, 10.2}}, {{0, 1, 2}, {0, 2, 3}}, 0.1, 20.1);
  for (const auto& [a, b, c] : rod.triangles) mesh.triangles.push_back({a + 8, b + 8, c + 8});
  mesh.positions.insert(mesh.positions.end(), rod.positions.begin(), rod.positions.end());
  const Imported made = meshToClay(Store::make(), mesh, unitVoxels());
  EXPECT_EQ(made.report.losses.specks, 0u);
  EXPECT_EQ(made.report.losses.bodies, 2u);
}

// A prism of n sides around z, open at its top, turned and moved.
TriangleMesh cup(int sides, double radius, double height, const Eigen::Matrix3d& turn, const Vec3d& by) {
  std::vector<Eigen::Vector2d> outline;
  std::vector<std::array<uint32_t, 3>> fan;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5) / sides;
    outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    if (i > 1) fan.push_back({0, uint32_t(i) - 1, uint32_t(i)});
  }
  TriangleMesh mesh = extruded(outline, fan, 0, height);
  std::erase_if(mesh.triangles, [&](const std::array<uint32_t, 3>& t) {
    return std::all_of(t.begin(), t.end(), [&](uint32_t v) { return v >= uint32_t(sides); });
  });
  for (Vec3d& p : mesh.positions) p = turn * p + by;
  return mesh;
}

// A hole with a flat rim is closed by the plane of the rim: from there half of the view is the rest of the mesh.
TEST(MeshToClay, TellsTheAreaOfTheSurfaceThatClosesAHole) {
  const auto about = [](double degrees, const Vec3d& axis) {
    return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis.normalized()).toRotationMatrix();
  };
  const std::array<Eigen::Matrix3d, 4> turns{Eigen::Matrix3d::Identity(), about(45, Vec3d::UnitZ()),
                                             about(35, {1, 1, 0.2}), about(70, {0.3, -1, 0.4})};
  for (const int sides : {3, 4, 24})
    for (const double radius : {12.0, 23.3})
      for (const Eigen::Matrix3d& turn : turns)
        for (const Vec3d& by : {Vec3d(0, 0, 0), Vec3d(0.23, 0.41, 0.37)}) {
          const Imported imported = import(cup(sides, radius, 0.9 * radius, turn, by));
          const double hole = sides * radius * radius * std::sin(2 * std::numbers::pi / sides) / 2;
          EXPECT_NEAR(imported.report.closedMm2 / hole, 1, 0.05)
              << sides << " sides, radius " << radius << " at " << by.transpose();
        }
  // The lid of a box whose walls lie on voxels, between them, and anywhere.
  for (const double at : {0.0, 0.25, 0.5, 0.77}) {
    TriangleMesh open = box(Vec3d::Constant(10 + at), Vec3d::Constant(50 + at));
    open.triangles.erase(open.triangles.begin() + 2, open.triangles.begin() + 4);
    EXPECT_NEAR(import(open).report.closedMm2, 1600, 0.02 * 1600) << at;
  }
}

// The volume that is told is that within the surface, which follows flat faces exactly: sums over voxels have up to 5 %
// more for a cube of 8 voxels.
TEST(MeshToClay, TellsTheVolumeWithinItsSurface) {
  const auto about = [](double degrees, const Vec3d& axis) {
    return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis.normalized()).toRotationMatrix();
  };
  for (const double edge : {6.3, 8.0, 11.7, 20.0})
    for (const double at : {0.0, 0.21, 0.5}) {
      const Imported made = import(box(Vec3d::Constant(at), Vec3d::Constant(at + edge)));
      EXPECT_NEAR(made.report.losses.clayMm3 / (edge * edge * edge), 1, 0.005) << edge << " at " << at;
      for (const std::string& sentence : made.report.sentences())
        EXPECT_THAT(sentence, ::testing::Not(HasSubstr("volume"))) << edge << " at " << at;
    }
  // What is told is the difference between the mesh and the surface that files get, whatever it is.
  for (const double thick : {1.05, 1.25, 1.6, 2.3, 3.1})
    for (const Eigen::Matrix3d& turn : {about(0, Vec3d::UnitX()), about(8, {1, 0.2, 0}), about(29, {0.4, 1, 0.3})}) {
      TriangleMesh plate = box({0, 0, 0}, {40, 30, thick});
      for (Vec3d& p : plate.positions) p = turn * p + Vec3d(0.3, 0.1, 0.2);
      const Imported made = import(plate);
      Surface surface(false, Grade::fine);
      surface.update(made.version);
      const double less = 100 * (1 - meshVolume(surface.toMesh()) / (40 * 30 * thick));
      double told = 0;
      for (const std::string& sentence : made.report.sentences()) {
        double share = 0;
        char way[5] = "";
        if (std::sscanf(sentence.c_str(), "The clay has %lf %% %4s", &share, way) == 2)
          told = std::string(way) == "less" ? share : -share;
        if (const size_t from = sentence.find("mm: "); sentence.starts_with("Walls about") && from != std::string::npos)
          told = std::strtod(sentence.c_str() + from + 4, nullptr);
      }
      EXPECT_NEAR(told, std::abs(less) > 0.5 ? less : 0, 0.06) << thick;
    }
}

// A tray: walls of a third of a voxel are lost, and it is said how much, where, and what would keep them.
TEST(MeshToClay, TellsWhatThinWallsLose) {
  // A block of 20 with a wall of 0.3 × 40 × 40 that stands on it.
  const TriangleMesh mesh =
      extruded({{0.35, 0.1}, {20.65, 0.1}, {20.65, 60.3}, {20.35, 60.3}, {20.35, 20.3}, {0.35, 20.3}},
               {{0, 1, 4}, {0, 4, 5}, {1, 2, 4}, {2, 3, 4}}, 0.1, 40.1);
  const Imported made = meshToClay(Store::make(), mesh, unitVoxels());
  const MeshLosses& losses = made.report.losses;
  EXPECT_NEAR(losses.meshMm3, 20.3 * 20.2 * 40 + 0.3 * 40 * 40, 1);
  EXPECT_NEAR(losses.lostMm2, 2 * 40 * 40, 250);
  EXPECT_LT((losses.lostAtMm - Vec3d(20.5, 40.3, 20.1)).norm(), 1.5);
  std::string said;
  for (const std::string& sentence : made.report.sentences()) said += sentence + " ";
  EXPECT_THAT(said, HasSubstr("Walls about 0.3 mm thin are lost at a voxel of 1 mm"));
  EXPECT_THAT(said, HasSubstr("would keep them"));
  // With the voxels that it names the wall is there.
  ImportOptions fine = unitVoxels();
  fine.grid.voxelMm = 0.15;
  const Imported kept = meshToClay(Store::make(), mesh, fine);
  EXPECT_LT(kept.report.losses.lostMm2, 5);
  EXPECT_NEAR(kept.report.losses.clayMm3 / kept.report.losses.meshMm3, 1, 0.005);
}

// A plate of less than a voxel that lies on a layer of them: distances of about zero on that layer, and no clay. The
// volume by distances is right even so.
TEST(MeshToClay, APlateOfDistancesAboutZeroIsLost) {
  for (const double thick : {0.6, 0.75, 0.9, 1.5, 3.0}) {
    SCOPED_TRACE(thick);
    const Imported made = meshToClay(Store::make(), box({20.2, 20.3, 20}, {60.3, 60.1, 20 + thick}), unitVoxels());
    const MeshLosses& losses = made.report.losses;
    std::string said;
    for (const std::string& sentence : made.report.sentences()) said += sentence + " ";
    if (thick < 1) {
      EXPECT_NEAR(losses.clayMm3, 0, 1) << said;
      EXPECT_NEAR(losses.lostMm2, 2 * 40 * 40, 250);
      EXPECT_LT((losses.lostAtMm - Vec3d(40, 40, 20)).norm(), 1.5);
      EXPECT_THAT(said, HasSubstr("mm thin are lost at a voxel of 1 mm: 100.0 % of the volume"));
    } else {
      EXPECT_NEAR(losses.clayMm3 / losses.meshMm3, 1, 0.05) << said;
      EXPECT_EQ(losses.lostMm2, 0);
    }
  }
}

TEST(MeshToClay, TakesEveryTestMeshOrSaysWhyNot) {
  SKIP_WITHOUT_DATA();
  for (const char* name :
       {"dragon_vrip_res3.ply", "suzanne.obj", "teapot.obj", "featuretype.STL", "self_intersectA.obj",
        "thin_tray_1002_tray_bottom.STL", "goblet_vase.stl", "gebco7510_55cl_utm.stl"}) {
    SCOPED_TRACE(name);
    const Imported imported = importData(dataMesh(std::string("mesh/") + name), 96);
    expectProperBand(imported.version, kFirstOrder);
    EXPECT_GT(clayVolume(imported.version), 1000);
  }
  for (const char* name : {"many_small_holes.ply", "non_manif_hole.ply"}) {
    EXPECT_THAT(messageOf(dataMesh(std::string("mesh/") + name), {}), HasSubstr("open sheet")) << name;
  }
}

}  // namespace
}  // namespace argil::clay
