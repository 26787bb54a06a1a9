#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetRebuild.h>
#include <openvdb/tools/SignedFloodFill.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <new>
#include <stdexcept>
#include <string>

#include "clay/base/error.h"
#include "clay/store/openvdb_grids.h"
#include "io/reader/memory_bound.h"
#include "io/reader/mesh_data.h"
#include "io/reader/reader.h"

namespace argil::io::reader {

namespace {

using Grid = openvdb::FloatGrid;

constexpr size_t kLargestNode = size_t{4} << 20;  // bytes that reading may take at once whatever the file's size
constexpr uint64_t kMostBricks = uint64_t{1} << 22;
constexpr double kMostRebuilt = 67e6;   // voxels of a level set whose distances are made anew
constexpr double kLeastBand = 3;        // voxels on each side: what clay keeps
constexpr double kBandSlack = 1e-3;     // of a voxel: 32-bit numbers of other units
constexpr double kScaleSlack = 1e-6;    // relative: what a transform may differ from a uniform scale by
constexpr int kReach = 14000 * 8 - 64;  // voxels: clay's (clay/store/version.h), less a region

/// How voxels lie: their edge, 0 where the transform is more than a uniform scale, a rotation and a translation.
struct Voxels {
  double edge = 0;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
};

Voxels voxelsOf(const openvdb::math::Transform& transform) {
  if (!transform.isLinear()) return {};
  const openvdb::Mat4d matrix = transform.baseMap()->getAffineMap()->getMat4();
  Eigen::Matrix3d axes;  // their matrices multiply rows
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) axes(i, j) = matrix(j, i);
  }
  if (!axes.allFinite() || !(axes.determinant() > 0)) return {};
  if (axes.isApprox(axes(0, 0) * Eigen::Matrix3d::Identity(), kScaleSlack)) return {axes(0, 0)};
  const double edge = std::cbrt(axes.determinant());
  const Eigen::Matrix3d turn = axes / edge;
  if (!(turn * turn.transpose()).isIdentity(kScaleSlack)) return {};
  return {edge, Eigen::Quaterniond(turn).normalized()};
}

using Colours = openvdb::Vec3SGrid;
struct ColourGrid {
  Colours::Ptr grid;
  bool used = false;
};
/// By the names of the grids.
using ColourGrids = std::map<std::string, ColourGrid>;

constexpr const char* kColourNames[] = {"Cd", "color", "Color", "colour", "Colour", "rgb", "albedo"};

Colours::Ptr coloursOf(const Grid& grid, ColourGrids& all) {
  const auto named = [&](const std::string& name) -> Colours::Ptr {
    const auto found = all.find(name);
    if (found == all.end()) return nullptr;
    found->second.used = true;
    return found->second.grid;
  };
  if (const auto meta = grid.getMetadata<openvdb::StringMetadata>(wire::kColoursMeta)) return named(meta->value());
  for (const char* name : kColourNames) {
    if (Colours::Ptr found = named(grid.getName() + "." + name)) return found;
  }
  for (const char* name : kColourNames) {
    if (Colours::Ptr found = named(name)) return found;
  }
  return nullptr;
}

/// The colours at a leaf's voxels in the band, each at the nearest sample there is; false where there is none.
bool coloursAt(const Grid::TreeType::LeafNodeType& leaf, double most, const openvdb::math::Transform& place,
               const openvdb::math::Transform& colourPlace, Colours::ConstAccessor& colours, wire::ColourBrick& brick) {
  bool any = false;
  for (openvdb::Index i = 0; i < Grid::TreeType::LeafNodeType::SIZE; ++i) {
    for (auto& channel : brick.channel) channel[i] = 0;
    if (!(std::abs(double(leaf.getValue(i))) < most)) continue;
    const openvdb::Vec3d world = place.indexToWorld(leaf.offsetToGlobalCoord(i));
    openvdb::Vec3f colour;
    if (!colours.probeValue(colourPlace.worldToIndexCellCentered(world), colour)) continue;
    for (int k = 0; k < 3; ++k) brick.channel[k][i] = srgbByte(double(colour[k]));
    brick.channel[3][i] = 255;
    any = true;
  }
  return any;
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

/// Refuses what would become far more voxels than it has when its distances are made anew: a damaged transform may make
/// one voxel a million.
void requireRebuildable(const Grid& grid, double voxel, const std::string& name) {
  openvdb::Vec3d edges = grid.transform().voxelSize() / voxel;
  std::sort(&edges[0], &edges[0] + 3);
  const double voxels = double(grid.activeVoxelCount()) * edges[1] * edges[2] * (2 * kLeastBand + 1) / 3;
  if (voxels <= kMostRebuilt) return;
  throw Error("would have more than " + std::to_string(int(kMostRebuilt / 1e6)) + " million voxels in " + name +
              " if its distances were made anew for cubes; resample it in the program that wrote it");
}

void sendLevelSet(Grid::Ptr grid, const std::string& title, ColourGrids& allColours, Sender& sender) {
  const std::string name = title.empty() ? "the grid without a name" : "grid " + title;
  requireFinite(*grid, name);
  const Colours::Ptr colours = coloursOf(*grid, allColours);
  const auto colour = grid->getMetadata<openvdb::Vec3SMetadata>(wire::kColourMeta);
  auto [voxel, rotation] = voxelsOf(grid->transform());
  std::string why;
  if (voxel == 0) {
    const openvdb::Vec3d edges = grid->transform().voxelSize();
    voxel = std::min({edges.x(), edges.y(), edges.z()});
    why = "is skewed, mirrored or scaled by axis";
  } else if (!(double(grid->background()) >= (kLeastBand - kBandSlack) * voxel)) {
    why = "has a band of fewer than 3 voxels";
  } else if (!isDistance(*grid, voxel)) {
    why = "holds no distances";
  }
  if (!std::isfinite(voxel) || !(voxel > 0))
    throw Error("has a transform in " + name + " that is none; export it again");
  if (!why.empty()) {
    requireRebuildable(*grid, voxel, name);
    openvdb::math::Transform::Ptr uniform = openvdb::math::Transform::createLinearTransform(voxel);
    rotation.setIdentity();
    grid = openvdb::tools::levelSetRebuild(*grid, 0, float(kLeastBand), float(kLeastBand), uniform.get());
    sender.note(name + " " + why + ": its distances were made anew");
  }
  openvdb::tools::signedFloodFill(grid->tree());
  if (grid->tree().leafCount() > kMostBricks)
    throw Error("has more than " + std::to_string(kMostBricks) + " bricks in " + name +
                "; export it with larger voxels");

  const openvdb::Coord shift = shiftOf(*grid, name);
  const openvdb::Vec3d first = grid->transform().indexToWorld(-shift);
  const Eigen::Vector3d origin = rotation.conjugate() * Eigen::Vector3d(first.x(), first.y(), first.z());
  // Root tiles (edge 4096 voxels), and those of the nodes below (128 and 8).
  std::vector<wire::Tile> tiles;
  auto tile = grid->tree().cbeginValueAll();
  tile.setMaxDepth(Grid::TreeType::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    openvdb::CoordBBox box;
    if (tile.getValue() >= 0 || !tile.getBoundingBox(box)) continue;
    const openvdb::Coord low = box.min() + shift;
    tiles.push_back({low.x() >> 3, low.y() >> 3, low.z() >> 3, box.dim().x() >> 3});
  }
  wire::Grid head{.voxel = voxel,
                  .origin = {origin.x(), origin.y(), origin.z()},
                  .rotation = {rotation.w(), rotation.x(), rotation.y(), rotation.z()},
                  .tiles = tiles.size(),
                  .bricks = grid->tree().leafCount(),
                  .colour = {},
                  .hasColour = colour != nullptr};
  for (int k = 0; k < 3 && colour; ++k) head.colour[k] = srgbByte(double(colour->value()[k]));
  sender.named(wire::Kind::grid, head, title);
  sender.array(wire::Kind::tiles, std::span<const wire::Tile>(tiles));
  std::vector<wire::Brick> bricks;
  const auto give = [&] {
    sender.array(wire::Kind::bricks, std::span<const wire::Brick>(bricks));
    bricks.clear();
  };
  for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) {
    const openvdb::Coord at = leaf->origin() + shift;
    wire::Brick& brick = bricks.emplace_back();
    brick.x = at.x() >> 3, brick.y = at.y() >> 3, brick.z = at.z() >> 3;
    for (openvdb::Index i = 0; i < 512; ++i) brick.phi[i] = float(double(leaf->getValue(i)) / voxel);
    if (bricks.size() == 256) give();
  }
  give();
  if (!colours) return;
  auto accessor = colours->getConstAccessor();
  std::vector<wire::ColourBrick> painted;
  const double most = double(grid->background());
  for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) {
    const openvdb::Coord at = leaf->origin() + shift;
    wire::ColourBrick& brick = painted.emplace_back();
    brick.x = at.x() >> 3, brick.y = at.y() >> 3, brick.z = at.z() >> 3;
    if (!coloursAt(*leaf, most, grid->transform(), colours->transform(), accessor, brick)) painted.pop_back();
    if (painted.size() == 256) {
      sender.array(wire::Kind::colourBricks, std::span<const wire::ColourBrick>(painted));
      painted.clear();
    }
  }
  sender.array(wire::Kind::colourBricks, std::span<const wire::ColourBrick>(painted));
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

// By what other programs call them: a field of three numbers that is named otherwise may be a velocity.
bool isColours(const openvdb::GridBase& grid) {
  if (!grid.isType<Colours>()) return false;
  const std::string name = grid.getName();
  const std::string last = name.substr(name.rfind('.') == std::string::npos ? 0 : name.rfind('.') + 1);
  return std::find(std::begin(kColourNames), std::end(kColourNames), last) != std::end(kColourNames);
}

/// All grids. The library believes each length and count that a file has, and reads zeros behind its end: here reading
/// ends where the file does, and no piece of memory is larger than the file, so that trees, whose smallest node has 64
/// bytes in it, stay within a small multiple.
openvdb::GridPtrVecPtr gridsOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error("cannot be opened; check the name and the permissions");
  file.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
  const MemoryBound bound(std::max<size_t>(kLargestNode, std::filesystem::file_size(path)));
  try {
    return openvdb::io::Stream(file, false).getGrids();
  } catch (const std::ios_base::failure&) {
    throw Error("is cut off or damaged: its data ends too early; export it again");
  } catch (const std::bad_alloc&) {
    throw Error("is cut off or damaged: it claims more data than it has; export it again");
  } catch (const std::length_error&) {
    throw Error("is cut off or damaged: it claims more data than it has; export it again");
  }
}

}  // namespace

void readVdb(const std::filesystem::path& path, Sender& sender) {
  unsigned char magic[4] = {};
  if (!std::filesystem::is_regular_file(path)) throw Error("is not a regular file; copy its content to a file first");
  std::ifstream(path, std::ios::binary).read(reinterpret_cast<char*>(magic), sizeof magic);
  if (std::memcmp(magic, " BDV", sizeof magic) != 0) throw Error("is no OpenVDB file; export it again");
  openvdb::initialize();
  const openvdb::GridPtrVecPtr grids = gridsOf(path);
  sender.text(wire::Kind::format, "OpenVDB");
  std::vector<std::string> others;
  size_t sent = 0;
  ColourGrids colours;
  for (openvdb::GridBase::Ptr& base : *grids) {
    if (!base || !isColours(*base)) continue;
    colours[base->getName()].grid = openvdb::gridPtrCast<Colours>(base);
    base.reset();
  }
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
    sendLevelSet(grid, title, colours, sender);
    ++sent;
  }
  if (sent == 0) {
    throw Error("holds no level set" + (others.empty() ? std::string() : ": " + others.front()) +
                "; convert it to a level set (signed distances) in the program that wrote it");
  }
  for (const std::string& other : others) sender.note(other + ", which is not kept");
  for (const auto& [name, each] : colours) {
    if (!each.used) sender.note("grid " + name.substr(0, 60) + " has colours of no level set here: it is not kept");
  }
}

}  // namespace argil::io::reader
