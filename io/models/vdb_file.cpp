#include "io/models/vdb_file.h"

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/ValueTransformer.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <optional>
#include <ostream>
#include <set>
#include <span>
#include <streambuf>

#include "clay/kernels/channel.h"
#include "clay/store/editor.h"
#include "clay/store/openvdb_grids.h"
#include "clay/store/vdb_bridge.h"
#include "io/bytes/atomic_file.h"
#include "io/bytes/input.h"
#include "io/models/draco_mesh.h"
#include "io/models/reader_process.h"

namespace argil::io {

namespace {

using clay::kBrickEdge;
using clay::kBrickVoxels;

constexpr uint64_t kMostBricks = uint64_t{1} << 22;  // 9 GB of clay
/// Blocks of 8×8×8 bricks, and single ones, that may be filled inside: some thousand times what a sculpture needs, and
/// a minute at most.
constexpr uint64_t kMostFilled = uint64_t{1} << 24;
constexpr uint64_t kMostFaces = uint64_t{1} << 26;  // bricks looked at beside filled blocks
constexpr int kBlock = 8;
constexpr int kLookEvery = 4096;

/// One grid at a time, from messages that are not believed.
class ClayAssembler {
 public:
  ClayAssembler(double unitMm, Job* job) : unitMm_(unitMm), job_(job) {}
  void take(wire::Kind kind, std::span<const std::byte> payload);
  std::vector<VdbObject> objects;

 private:
  void begin(std::span<const std::byte> payload);
  void finishGrid();
  void addTile(const wire::Tile& tile);
  void addBrick(const wire::Brick& brick);
  void addColours(const wire::ColourBrick& brick);
  void requireNoJumps(const clay::Version& version) const;
  void look() const {
    if (job_ != nullptr && job_->cancelled()) throw Cancelled();
  }

  double unitMm_;
  Job* job_;
  std::optional<clay::Editor> editor_;
  VdbObject object_;  // being received
  std::vector<std::string> notes_;
  std::vector<wire::Tile> tiles_;
  uint64_t missingTiles_ = 0, missingBricks_ = 0, mostColours_ = 0, filled_ = 0, faces_ = 0;
};

bool inReach(int64_t first, int64_t edge) {
  return first >= -clay::kBrickReach && first + edge <= clay::kBrickReach;
}

void ClayAssembler::take(wire::Kind kind, std::span<const std::byte> payload) {
  switch (kind) {
    case wire::Kind::format:
      return;
    case wire::Kind::note:
      notes_.push_back(wireText(payload));
      return;
    case wire::Kind::grid:
      finishGrid();
      begin(payload);
      return;
    case wire::Kind::tiles:
      if (!editor_ || payload.size() / sizeof(wire::Tile) > missingTiles_) failWire();
      for (; !payload.empty(); payload = payload.subspan(sizeof(wire::Tile)), --missingTiles_)
        addTile(wireStruct<wire::Tile>(payload));
      return;
    case wire::Kind::bricks:
      if (!editor_ || payload.size() / sizeof(wire::Brick) > missingBricks_) failWire();
      for (; !payload.empty(); payload = payload.subspan(sizeof(wire::Brick)), --missingBricks_)
        addBrick(wireStruct<wire::Brick>(payload));
      return;
    case wire::Kind::colourBricks:
      if (!editor_ || missingBricks_ != 0 || payload.size() / sizeof(wire::ColourBrick) > mostColours_) failWire();
      for (; !payload.empty(); payload = payload.subspan(sizeof(wire::ColourBrick)), --mostColours_)
        addColours(wireStruct<wire::ColourBrick>(payload));
      return;
    case wire::Kind::end:
      finishGrid();
      if (objects.empty()) failWire();
      // What was left out of the file is said once.
      for (std::string& note : notes_) objects.front().notes.push_back(std::move(note));
      return;
    default:
      failWire();
  }
}

void ClayAssembler::begin(std::span<const std::byte> payload) {
  std::span<const std::byte> name;
  const auto head = wireStruct<wire::Grid>(payload, &name);
  object_ = {};
  object_.name = wireText(name);
  object_.rotation = Eigen::Quaterniond(head.rotation[0], head.rotation[1], head.rotation[2], head.rotation[3]);
  if (!(std::abs(object_.rotation.norm() - 1) < 1e-6)) failWire();
  if (head.hasColour != 0) object_.colour = Colour{head.colour[0], head.colour[1], head.colour[2], 255};
  missingTiles_ = head.tiles;
  missingBricks_ = mostColours_ = head.bricks;
  if (head.bricks == 0 || head.bricks > kMostBricks || head.tiles > kMostFilled) failWire();
  clay::Grid grid;
  grid.voxelMm = head.voxel * unitMm_;
  grid.originMm = Vec3d(head.origin[0], head.origin[1], head.origin[2]) * unitMm_;
  try {
    grid.check();
  } catch (const Error& error) {
    throw Error("grid " + shown(object_.name) + " cannot be clay (" + error.what() +
                "); choose another unit, or scale it in the program that wrote it");
  }
  editor_.emplace(clay::Version::empty(clay::Store::make(), grid));
}

void ClayAssembler::addTile(const wire::Tile& tile) {
  const bool known = tile.edge == 1 || tile.edge == 16 || tile.edge == 512;
  if (!known || !inReach(tile.x, tile.edge) || !inReach(tile.y, tile.edge) || !inReach(tile.z, tile.edge)) failWire();
  if (tile.edge > 1 && ((tile.x | tile.y | tile.z) & (kBlock - 1)) != 0) failWire();
  const int step = std::min(tile.edge, kBlock), count = tile.edge / step;
  filled_ += uint64_t(count) * uint64_t(count) * uint64_t(count);
  faces_ += 6 * uint64_t(tile.edge) * uint64_t(tile.edge);
  if (filled_ > kMostFilled || faces_ > kMostFaces)
    throw Error("grid " + shown(object_.name) +
                " is solid over too large a space for clay; export it with larger voxels");
  for (int x = 0; x < tile.edge; x += step) {
    look();
    for (int y = 0; y < tile.edge; y += step) {
      for (int z = 0; z < tile.edge; z += step)
        editor_->setBlock({tile.x + x, tile.y + y, tile.z + z}, step == kBlock ? 1 : 0, clay::Tile::inside);
    }
  }
  tiles_.push_back(tile);
}

void ClayAssembler::addBrick(const wire::Brick& brick) {
  if (missingBricks_ % kLookEvery == 0) look();
  if (!inReach(brick.x, 1) || !inReach(brick.y, 1) || !inReach(brick.z, 1)) failWire();
  for (const float phi : brick.phi) {
    if (!std::isfinite(phi)) failWire();
  }
  editor_->setVoxels({brick.x, brick.y, brick.z}, std::span<const float, kBrickVoxels>(brick.phi, kBrickVoxels));
}

/// Bytes count in the band alone.
void ClayAssembler::addColours(const wire::ColourBrick& brick) {
  if (mostColours_ % kLookEvery == 0) look();
  const Coord coord{brick.x, brick.y, brick.z};
  if (!inReach(brick.x, 1) || !inReach(brick.y, 1) || !inReach(brick.z, 1)) failWire();
  const clay::Slot distances = editor_->find(coord);
  const float band = editor_->grid().band;
  std::array<uint8_t, kBrickVoxels> values;
  for (size_t k = 0; k < clay::kColourChannels.size(); ++k) {
    for (int i = 0; i < kBrickVoxels; ++i)
      values[size_t(i)] = std::abs(distances.phi(i, band)) < band ? brick.channel[k][i] : uint8_t{0};
    editor_->setChannel(clay::kColourChannels[k], coord, values);
  }
}

/// A distance cannot jump from inside to outside: where a tile lies beside a brick, the brick's voxels there have its
/// sign, and tiles side by side have the same.
void ClayAssembler::requireNoJumps(const clay::Version& version) const {
  constexpr std::array<Coord, 6> kSides = {Coord{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  const auto jumps = [&]() {
    throw Error("grid " + shown(object_.name) +
                " changes from inside to outside where it has no surface; make it a closed level set in the program "
                "that wrote it");
  };
  uint64_t done = 0;
  version.forEachBrick([&](const clay::Brick& brick) {
    if (++done % kLookEvery == 0) look();
    for (const Coord& side : kSides) {
      const clay::Slot beside = version.find(brick.coord + side);
      if (!beside.isTile()) continue;
      const bool inside = beside.tile() == clay::Tile::inside;
      const auto edge = [](int direction, int i) { return direction > 0 ? kBrickEdge - 1 : direction < 0 ? 0 : i; };
      for (int i = 0; i < kBrickEdge; ++i) {
        for (int j = 0; j < kBrickEdge; ++j) {
          const int x = edge(side.x, i), y = edge(side.y, side.x != 0 ? i : j), z = edge(side.z, j);
          if ((brick.phi(clay::Brick::offset(x, y, z)) < 0) != inside) jumps();
        }
      }
    }
  });
  for (const wire::Tile& tile : tiles_) {
    look();
    for (const Coord& side : kSides) {
      for (int i = 0; i < tile.edge; ++i) {
        for (int j = 0; j < tile.edge; ++j) {
          const auto at = [&](int direction, int along) {
            return direction > 0 ? tile.edge : direction < 0 ? -1 : along;
          };
          const clay::Slot beside =
              version.find({tile.x + at(side.x, i), tile.y + at(side.y, side.x != 0 ? i : j), tile.z + at(side.z, j)});
          if (beside == clay::Slot(clay::Tile::outside)) jumps();
        }
      }
    }
  }
}

void ClayAssembler::finishGrid() {
  if (!editor_) return;
  if (missingTiles_ != 0 || missingBricks_ != 0) failWire();
  object_.version = editor_->commit();
  editor_.reset();
  if (object_.version.stats().bricks == 0)
    throw Error("grid " + shown(object_.name) + " has no surface; check what was exported");
  requireNoJumps(object_.version);
  object_.notes = std::move(notes_);
  notes_.clear();
  tiles_.clear();
  filled_ = faces_ = 0;
  objects.push_back(std::move(object_));
}

// Red, green and blue as linear light.
openvdb::Vec3f linearLight(uint8_t red, uint8_t green, uint8_t blue) {
  const auto part = [](uint8_t srgb) { return float(linearOf(srgb)) / 65535; };
  return {part(red), part(green), part(blue)};
}

// What is seen of the clay where that is not the piece's own colour; null where that is nowhere.
openvdb::Vec3SGrid::Ptr coloursOf(const VdbView& view, Job* job) {
  const Colour own = view.colour.value_or(Colour{});
  auto grid = openvdb::Vec3SGrid::create(linearLight(own.red, own.green, own.blue));
  const clay::Version& version = view.version;
  const auto groundOf = [&](uint8_t material) -> std::optional<std::array<uint8_t, 3>> {
    return material > 0 && material <= view.materials.size() ? view.materials[material - 1u] : std::nullopt;
  };
  const bool materials =
      version.has(clay::Channel::material) &&
      std::any_of(view.materials.begin(), view.materials.end(), [](const auto& each) { return each.has_value(); });
  if (!version.has(clay::Channel::cover) && !materials) return nullptr;
  auto accessor = grid->getAccessor();
  const clay::ChannelSlot none;
  uint64_t done = 0;
  version.forEachBrick([&](const clay::Brick& brick) {
    if (++done % kLookEvery == 0 && job != nullptr && job->cancelled()) throw Cancelled();
    const auto slotOf = [&](clay::Channel channel) { return version.find(channel, brick.coord); };
    const clay::ChannelSlot cover = slotOf(clay::Channel::cover), material = slotOf(clay::Channel::material);
    if (cover == none && (!materials || material == none)) return;
    const clay::ChannelSlot parts[3] = {slotOf(clay::Channel::red), slotOf(clay::Channel::green),
                                        slotOf(clay::Channel::blue)};
    for (int i = 0; i < kBrickVoxels; ++i) {
      const auto ground = groundOf(material.value(i));
      const unsigned covers = cover.value(i);
      if ((covers == 0 && !ground) || !(std::abs(brick.phi(i)) < version.grid().band)) continue;
      const std::array<uint8_t, 3> under = ground.value_or(std::array{own.red, own.green, own.blue});
      const auto over = [&](size_t k) {
        return uint8_t((parts[k].value(i) * covers + under[k] * (255 - covers) + 127) / 255);
      };
      const Coord at = brick.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
      accessor.setValueOn({at.x, at.y, at.z}, linearLight(over(0), over(1), over(2)));
    }
  });
  return grid->empty() ? nullptr : grid;
}

// Where a view's samples lie in the world.
openvdb::math::Transform::Ptr transformOf(const VdbView& view) {
  const clay::Grid& place = view.version.grid();
  if (view.rotation.isApprox(Eigen::Quaterniond::Identity(), 0)) {
    const Vec3d origin = place.originMm + view.positionMm;
    auto transform = openvdb::math::Transform::createLinearTransform(place.voxelMm);
    transform->postTranslate({origin.x(), origin.y(), origin.z()});
    return transform;
  }
  // Their matrices multiply rows.
  const Eigen::Matrix3d turn = view.rotation.normalized().toRotationMatrix() * place.voxelMm;
  const Vec3d origin = view.rotation * place.originMm + view.positionMm;
  openvdb::Mat4d matrix = openvdb::Mat4d::identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) matrix(row, column) = turn(column, row);
    matrix(3, row) = origin[row];
  }
  return openvdb::math::Transform::createLinearTransform(matrix);
}

/// A stream into a file that appears whole or not at all; its errors pass through the library.
class FileBuffer : public std::streambuf {
 public:
  FileBuffer(AtomicFile& file, Job* job) : file_(file), job_(job) {}

 protected:
  std::streamsize xsputn(const char* bytes, std::streamsize count) override {
    if (job_ != nullptr && job_->cancelled()) throw Cancelled();
    file_.write(std::as_bytes(std::span(bytes, size_t(count))));
    return count;
  }
  int_type overflow(int_type c) override {
    if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
    const char one = traits_type::to_char_type(c);
    return xsputn(&one, 1) == 1 ? c : traits_type::eof();
  }
  // The library asks where it is, though it never goes back.
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    return offset == 0 && from == std::ios_base::cur ? pos_type(off_type(file_.bytes())) : pos_type(off_type(-1));
  }

 private:
  AtomicFile& file_;
  Job* job_;
};

}  // namespace

std::vector<VdbObject> readVdb(const std::filesystem::path& path, double unitMm, Job* job) {
  if (!std::isfinite(unitMm) || !(unitMm > 0))
    throw Error("the unit of " + displayName(path) + " must be a positive number of mm");
  ClayAssembler clays(unitMm, job);
  try {
    runReader(
        "vdb", path, [&](wire::Kind kind, std::span<const std::byte> payload) { clays.take(kind, payload); }, job);
  } catch (const std::bad_alloc&) {
    fail(displayName(path), "does not fit into memory; export it with larger voxels");
  }
  return std::move(clays.objects);
}

WriteReport writeVdb(const std::filesystem::path& path, const std::vector<VdbView>& clays, Job* job) {
  const std::string name = displayName(path);
  if (clays.empty()) throw Error(name + ": there is no clay to write; add some first", Error::Kind::work);
  clay::initializeVdb();
  AtomicFile file(path);
  openvdb::GridCPtrVec grids;
  std::set<std::string> titles;
  for (const VdbView& each : clays) {
    if (job != nullptr) job->step(0.5 * double(&each - clays.data()) / double(clays.size()));
    if (!each.version || each.version.stats().bricks == 0)
      throw Error(name + ": " + shown(each.name) + " has no surface to write", Error::Kind::work);
    const clay::Grid& place = each.version.grid();
    auto grid = std::static_pointer_cast<openvdb::FloatGrid>(clay::toVdb(each.version).grid);
    const double voxel = place.voxelMm;
    const auto inMm = [voxel](float phi) { return float(double(phi) * voxel); };
    openvdb::tools::foreach (grid->beginValueAll(),
                             [&](const openvdb::FloatGrid::ValueAllIter& value) { value.setValue(inMm(*value)); });
    grid->tree().root().setBackground(inMm(place.band), false);
    const auto transform = transformOf(each);
    grid->setTransform(transform);
    grid->setName(each.name);
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    grid->setCreator("Argil");
    grid->insertMeta("unit", openvdb::StringMetadata("mm"));
    if (each.colour)
      grid->insertMeta(wire::kColourMeta,
                       openvdb::Vec3SMetadata(linearLight(each.colour->red, each.colour->green, each.colour->blue)));
    grids.push_back(grid);
    if (const auto colours = coloursOf(each, job)) {
      std::string title = clays.size() == 1 ? "Cd" : each.name + ".Cd";
      for (int n = 2; !titles.insert(title).second; ++n) title = each.name + " " + std::to_string(n) + ".Cd";
      grid->insertMeta(wire::kColoursMeta, openvdb::StringMetadata(title));
      colours->setName(title);
      colours->setTransform(transform->copy());
      colours->setSaveFloatAsHalf(true);  // keeps every byte of sRGB
      colours->setCreator("Argil");
      grids.push_back(colours);
    }
  }
  FileBuffer buffer(file, job);
  std::ostream out(&buffer);
  out.exceptions(std::ios_base::badbit);  // so that what the file throws is thrown on
  openvdb::MetaMap facts;
  facts.insertMeta("creator", openvdb::StringMetadata("Argil"));
  openvdb::io::Stream(out).write(grids, facts);
  if (job != nullptr) job->step(0.95);
  file.commit();
  if (job != nullptr) job->step(1);
  WriteReport report;
  report.format = "OpenVDB";
  report.bytes = file.bytes();
  return report;
}

}  // namespace argil::io
