#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetRebuild.h>
#include <openvdb/tools/SignedFloodFill.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>

#include "clay/error.h"
#include "io/reader/reader.h"

namespace argil::io::reader {

namespace {

using Grid = openvdb::FloatGrid;

constexpr uint64_t kMostBricks = uint64_t{1} << 22;
constexpr double kLeastBand = 3;        // voxels on each side: what clay keeps
constexpr double kBandSlack = 1e-3;     // of a voxel: 32-bit numbers of other units
constexpr double kScaleSlack = 1e-6;    // relative: what a transform may differ from a uniform scale by
constexpr int kReach = 14000 * 8 - 64;  // voxels: clay's (clay/version.h), less a region

/// The voxel's edge where the transform is a uniform scale and a translation; else 0.
double uniformVoxel(const openvdb::math::Transform& transform) {
  if (!transform.isLinear()) return 0;
  const openvdb::Mat4d matrix = transform.baseMap()->getAffineMap()->getMat4();
  const double edge = matrix(0, 0);
  if (!(edge > 0)) return 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (std::abs(matrix(i, j) - (i == j ? edge : 0)) > kScaleSlack * edge) return 0;
    }
  }
  return edge;
}

/// Whether the values are distances: near the surface their slope is about one almost everywhere (creases apart).
bool isDistance(const Grid& grid, double voxel) {
  uint64_t looked = 0, odd = 0;
  const auto accessor = grid.getConstAccessor();
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    for (auto value = leaf->cbeginValueOn(); value; ++value) {
      if (std::abs(*value) > voxel) continue;
      const openvdb::Coord at = value.getCoord();
      double square = 0;
      for (int axis = 0; axis < 3; ++axis) {
        openvdb::Coord step(0);
        step[axis] = 1;
        const double slope =
            (double(accessor.getValue(at + step)) - double(accessor.getValue(at - step))) / (2 * voxel);
        square += slope * slope;
      }
      ++looked;
      odd += square < 0.5 * 0.5 || square > 1.5 * 1.5;
    }
  }
  return odd * 10 <= looked;
}

void requireFinite(const Grid& grid, const std::string& name) {
  for (auto value = grid.cbeginValueAll(); value; ++value) {
    if (!std::isfinite(*value)) throw Error("has values in " + name + " that are not finite; export it again");
  }
}

/// Whole bricks to be added so that the grid lies within clay's reach.
openvdb::Coord shiftOf(const Grid& grid, const std::string& name) {
  openvdb::CoordBBox box;
  if (!grid.tree().evalLeafBoundingBox(box)) throw Error("has no surface in " + name + "; check what was exported");
  openvdb::Coord shift(0);
  for (int axis = 0; axis < 3; ++axis) {
    const int64_t low = box.min()[axis], high = box.max()[axis];
    if (low >= -kReach && high <= kReach) continue;
    if (high - low > 2 * int64_t{kReach})
      throw Error("has " + std::to_string(high - low) + " voxels along an axis in " + name +
                  ", more than clay can; export it with larger voxels");
    shift[axis] = int(-((low + high) / 2 >> 3) * 8);
  }
  return shift;
}

void sendLevelSet(Grid::Ptr grid, const std::string& title, Sender& sender) {
  const std::string name = title.empty() ? "the grid without a name" : "grid " + title;
  requireFinite(*grid, name);
  double voxel = uniformVoxel(grid->transform());
  std::string why;
  if (voxel == 0) {
    const openvdb::Vec3d edges = grid->transform().voxelSize();
    voxel = std::min({edges.x(), edges.y(), edges.z()});
    why = "is turned, skewed or scaled by axis";
  } else if (!(double(grid->background()) >= (kLeastBand - kBandSlack) * voxel)) {
    why = "has a band of fewer than 3 voxels";
  } else if (!isDistance(*grid, voxel)) {
    why = "holds no distances";
  }
  if (!std::isfinite(voxel) || !(voxel > 0))
    throw Error("has a transform in " + name + " that is none; export it again");
  if (!why.empty()) {
    openvdb::math::Transform::Ptr uniform = openvdb::math::Transform::createLinearTransform(voxel);
    grid = openvdb::tools::levelSetRebuild(*grid, 0, float(kLeastBand), float(kLeastBand), uniform.get());
    sender.note(name + " " + why + ": its distances were made anew");
  }
  openvdb::tools::signedFloodFill(grid->tree());
  if (grid->tree().leafCount() > kMostBricks)
    throw Error("has more than " + std::to_string(kMostBricks) + " bricks in " + name +
                "; export it with larger voxels");

  const openvdb::Coord shift = shiftOf(*grid, name);
  const openvdb::Vec3d origin = grid->transform().indexToWorld(-shift);
  // Root tiles (edge 4096 voxels), and those of the nodes below (128 and 8).
  std::vector<wire::Tile> tiles;
  auto tile = grid->tree().cbeginValueAll();
  tile.setMaxDepth(Grid::TreeType::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    openvdb::CoordBBox box;
    if (tile.getValue() >= 0 || !tile.getBoundingBox(box)) continue;
    const openvdb::Coord first = box.min() + shift;
    tiles.push_back({first.x() >> 3, first.y() >> 3, first.z() >> 3, box.dim().x() >> 3});
  }
  wire::Grid head{.voxel = voxel,
                  .origin = {origin.x(), origin.y(), origin.z()},
                  .tiles = tiles.size(),
                  .bricks = grid->tree().leafCount()};
  sender.named(wire::Kind::grid, head, title);
  sender.array(wire::Kind::tiles, std::span<const wire::Tile>(tiles));
  std::vector<wire::Brick> bricks;
  const auto give = [&] {
    sender.array(wire::Kind::bricks, std::span<const wire::Brick>(bricks));
    bricks.clear();
  };
  for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) {
    const openvdb::Coord first = leaf->origin() + shift;
    wire::Brick& brick = bricks.emplace_back();
    brick.x = first.x() >> 3, brick.y = first.y() >> 3, brick.z = first.z() >> 3;
    for (openvdb::Index i = 0; i < 512; ++i) brick.phi[i] = float(double(leaf->getValue(i)) / voxel);
    if (bricks.size() == 256) give();
  }
  give();
}

std::string classOf(const openvdb::GridBase& grid) {
  switch (grid.getGridClass()) {
    case openvdb::GRID_FOG_VOLUME:
      return "a fog volume";
    case openvdb::GRID_STAGGERED:
      return "a staggered field";
    case openvdb::GRID_LEVEL_SET:
      return "a level set of " + grid.valueType();
    default:
      return "a field of " + grid.valueType() + " of no known class";
  }
}

}  // namespace

void readVdb(const std::filesystem::path& path, Sender& sender) {
  unsigned char magic[4] = {};
  if (!std::filesystem::is_regular_file(path)) throw Error("is not a regular file; copy its content to a file first");
  std::ifstream(path, std::ios::binary).read(reinterpret_cast<char*>(magic), sizeof magic);
  if (std::memcmp(magic, " BDV", sizeof magic) != 0) throw Error("is no OpenVDB file; export it again");
  openvdb::initialize();
  openvdb::io::File file(path.string());
  file.open(false);  // nothing is left to be loaded later
  sender.text(wire::Kind::format, "OpenVDB");
  std::vector<std::string> others;
  size_t sent = 0;
  const openvdb::GridPtrVecPtr grids = file.getGrids();
  for (openvdb::GridBase::Ptr& base : *grids) {
    if (!base) continue;
    const std::string title = base->getName();
    Grid::Ptr grid;
    if (base->getGridClass() == openvdb::GRID_LEVEL_SET) {
      if (base->isType<Grid>()) grid = openvdb::gridPtrCast<Grid>(base);
      if (base->isType<openvdb::DoubleGrid>())
        grid = std::make_shared<Grid>(*openvdb::gridPtrCast<openvdb::DoubleGrid>(base));
    }
    if (!grid) {
      others.push_back((title.empty() ? std::string("a grid without a name") : "grid " + title.substr(0, 60)) + " is " +
                       classOf(*base));
      continue;
    }
    base.reset();
    if (sent == wire::kMostGrids)
      throw Error("holds more than " + std::to_string(wire::kMostGrids) + " level sets; export them as several files");
    sendLevelSet(grid, title, sender);
    ++sent;
  }
  if (sent == 0) {
    throw Error("holds no level set" + (others.empty() ? std::string() : ": " + others.front()) +
                "; convert it to a level set (signed distances) in the program that wrote it");
  }
  for (const std::string& other : others) sender.note(other + ", which is not kept");
}

}  // namespace argil::io::reader
