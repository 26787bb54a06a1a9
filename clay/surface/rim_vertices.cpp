#include "clay/surface/rim_vertices.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <optional>

#include "clay/kernels/cell_cases.h"
#include "clay/kernels/crisp_kernels.h"
#include "clay/kernels/surface_kernels.h"
#include "clay/surface/rim_model.h"

namespace argil::clay {

namespace {

// The block of voxels that a brick's fits look at: from kMargin below its lowest voxel.
constexpr int kMargin = 4, kVoxels = kBrickEdge + 1 + 2 * kMargin, kCells = kVoxels - 1;
constexpr int kStepY = 20, kStepX = kVoxels * kStepY;

// How far from a group's middle are cells whose planes a fit may start from.
constexpr int kPlaneReach = 4;
// Reaches as far from any cell of a large group, counted from the group's middle.
constexpr int kFarthestPlane = kPlaneReach + 2;
// Planes of cells that bend by less than this (RMS, voxels), with a slope nearer to 1 than this, may start a fit.
constexpr float kStartBend = 0.06f, kStartBlur = 0.12f;
// Normals within 41° of a face's are its own.
constexpr float kOwn = 0.75f;
// A voxel that is off by more belongs to another face, and so many of them make one.
constexpr float kForeign = 0.12f;
constexpr int kLeastForeign = 3;
// What another group's fit may leave of a cell's own voxels, voxels.
constexpr float kBorrowed = 0.05f;
// Limits what a fit for a cell alone may leave, voxels: nothing else explains it, and the draft is off by more.
constexpr float kAloneWorst = 0.1f;
// The cosine between the normals of faces that meet at 87°.
constexpr float kAcuteCosine = -0.05f;
// The cosine between the planes that a fit starts from, at 81°.
constexpr float kAcuteStart = -0.15f;
// The cosine between faces at 65°: no right angle whatever the fit makes of it.
constexpr float kSurelyAcuteCosine = -0.42f;
// Voxels from the middle of a group to its rim, at most.
constexpr float kRimFarthest = 6;
// Voxels from a face's vertex to the face that it meets in a rim.
constexpr float kRimReach = 2.5f;
// The cosine between planes that may turn out to be of acute faces, at 100°.
constexpr float kBluntCosine = 0.17f;
// Cells so far from a hard one, along each axis, are fitted too.
constexpr int kBesideHard = 2;
// How far a vertex may go from its edge crossings to the face that they are on, voxels.
constexpr float kFaceReach = 1;
// A corner that lies so far beside a cell is in it, voxels: on a plane of the grid it is in either cell.
constexpr float kBeside = 0.07f;
// A point of a rim is one of the solid if the solid's distance there is less, voxels.
constexpr float kOnSolid = 0.05f;

struct FieldBlock {
  std::array<float, kVoxels * kStepX> phi;
  std::array<uint32_t, kVoxels * kVoxels> inside, exact;  // bit z; exact: beside a voxel of the other sign

  [[nodiscard]] const float* at(int x, int y, int z) const {
    return &phi[static_cast<size_t>(x * kStepX + y * kStepY + z)];
  }
  [[nodiscard]] uint32_t& row(std::array<uint32_t, kVoxels * kVoxels>& rows, int x, int y) {
    return rows[static_cast<size_t>(x * kVoxels + y)];
  }
  [[nodiscard]] uint32_t row(const std::array<uint32_t, kVoxels * kVoxels>& rows, int x, int y) const {
    return rows[static_cast<size_t>(x * kVoxels + y)];
  }

  void read(Sampler& field, Coord brick) {
    const float band = field.band(), step = field.step();
    Slot slots[3][3][3];
    for (int x = 0; x < 3; ++x)
      for (int y = 0; y < 3; ++y)
        for (int z = 0; z < 3; ++z) slots[x][y][z] = field.slot(brick + Coord{x - 1, y - 1, z - 1});
    for (int x = 0; x < kVoxels; ++x)
      for (int y = 0; y < kVoxels; ++y) {
        const int vx = x - kMargin + kBrickEdge, vy = y - kMargin + kBrickEdge;
        const Slot(&pair)[3] = slots[vx / kBrickEdge][vy / kBrickEdge];
        const int offset = Brick::offset(vx % kBrickEdge, vy % kBrickEdge, 0);
        float* out = &phi[static_cast<size_t>(x * kStepX + y * kStepY)];
        const auto piece = [&](const Slot& slot, int from, int count, int to) {
          if (const Brick* b = slot.brick())
            b->read(offset + from, count, out + to, step);
          else
            std::fill_n(out + to, count, slot.phi(0, band));
        };
        piece(pair[0], kBrickEdge - kMargin, kMargin, 0);
        piece(pair[1], 0, kBrickEdge, kMargin);
        piece(pair[2], 0, kMargin + 1, kMargin + kBrickEdge);
        uint32_t bits = 0;
        for (int z = 0; z < kVoxels; ++z) bits |= uint32_t{out[z] < 0} << z;
        row(inside, x, y) = bits;
      }
    constexpr uint32_t kInner = ((1u << kVoxels) - 1) & ~1u & ~(1u << (kVoxels - 1));
    exact.fill(0);
    for (int x = 1; x < kVoxels - 1; ++x)
      for (int y = 1; y < kVoxels - 1; ++y) {
        const uint32_t own = row(inside, x, y);
        row(exact, x, y) =
            ((own ^ own << 1) | (own ^ own >> 1) | (own ^ row(inside, x - 1, y)) | (own ^ row(inside, x + 1, y)) |
             (own ^ row(inside, x, y - 1)) | (own ^ row(inside, x, y + 1))) &
            kInner;
      }
  }
};

// The planes of the crossed cells of the block.
struct StartPlanes {
  struct Row {
    uint16_t cells;  // bit z: the plane may start a fit
    uint16_t first;  // index of its first one in `number`
  };
  std::array<Row, kCells * kCells> rows;
  std::array<uint16_t, BlockPlanes::kMost> number;
  std::array<uint16_t, kCells * kCells> kinked;  // bit z: crossed cells that a rim may pass
  BlockPlanes planes;

  // Cells of the block along each axis.
  struct Range {
    std::array<int, 3> low{kCells, kCells, kCells}, high{0, 0, 0};
  };

  // Finds those of the cells in `range`, the only ones that may be asked for; false where there are too many.
  bool find(const FieldBlock& block, const Range& range) {
    std::array<BlockCell, BlockPlanes::kMost + BlockPlanes::kPadding> cells;
    size_t count = 0;
    std::array<uint16_t, kCells * kCells> crossed;
    const unsigned asked = ((1u << range.high[2]) - 1) & ~((1u << range.low[2]) - 1);
    for (int x = range.low[0]; x < range.high[0]; ++x)
      for (int y = range.low[1]; y < range.high[1]; ++y) {
        const uint32_t a = block.row(block.inside, x, y), b = block.row(block.inside, x, y + 1),
                       c = block.row(block.inside, x + 1, y), d = block.row(block.inside, x + 1, y + 1);
        const uint32_t any = a | b | c | d, all = a & b & c & d;
        const auto bits = static_cast<uint16_t>((any | any >> 1) & ~(all & all >> 1) & asked);
        crossed[static_cast<size_t>(x * kCells + y)] = bits;
        if (count + static_cast<size_t>(std::popcount(bits)) > BlockPlanes::kMost) return false;
        for (unsigned left = bits; left != 0; left &= left - 1)
          cells[count++] = static_cast<BlockCell>(x << 8 | y << 4 | std::countr_zero(left));
      }
    if (count == 0) return false;
    std::fill_n(cells.data() + count, BlockPlanes::kPadding, cells[0]);
    cellPlanes(block.phi.data(), kStepX, kStepY, kMargin, cells.data(), static_cast<int>(count), planes);
    size_t plane = 0, kept = 0;
    for (int x = range.low[0]; x < range.high[0]; ++x)
      for (int y = range.low[1]; y < range.high[1]; ++y) {
        const auto i = static_cast<size_t>(x * kCells + y);
        rows[i].first = static_cast<uint16_t>(kept);
        unsigned some = 0;
        kinked[i] = 0;
        for (unsigned left = crossed[i]; left != 0; left &= left - 1, ++plane) {
          if (planes.foot[plane][BlockPlanes::bend] > kKinkedBend * kKinkedBend ||
              planes.normal[plane][BlockPlanes::blur] > 1 - kKinkedSlope)
            kinked[i] = static_cast<uint16_t>(kinked[i] | (left & (0 - left)));
          if (!(quality(plane) > 0)) continue;
          number[kept++] = static_cast<uint16_t>(plane);
          some |= left & (0 - left);
        }
        rows[i].cells = static_cast<uint16_t>(some);
      }
    return true;
  }
  // Whether such a cell is at most a step away along each axis, cells counted in the brick.
  [[nodiscard]] bool kinkedAround(int x, int y, int z) const {
    unsigned bits = 0;
    for (int i = x - 1; i <= x + 1; ++i)
      for (int j = y - 1; j <= y + 1; ++j) bits |= kinked[static_cast<size_t>((i + kMargin) * kCells + j + kMargin)];
    return (bits >> (z + kMargin - 1) & 7) != 0;
  }
  [[nodiscard]] float quality(size_t plane) const {
    return 1 - planes.foot[plane][BlockPlanes::bend] * (1 / (kStartBend * kStartBend)) -
           planes.normal[plane][BlockPlanes::blur] * (1 / kStartBlur);
  }
  [[nodiscard]] Vec3f foot(size_t plane) const {
    return Vec3f(planes.foot[plane][0], planes.foot[plane][1], planes.foot[plane][2]);
  }
  [[nodiscard]] Vec3f normal(size_t plane) const {
    return Vec3f(planes.normal[plane][0], planes.normal[plane][1], planes.normal[plane][2]);
  }
};

struct Start {
  std::array<Vec3f, kMostRimFaces> normal, foot;
  int faces = 0;
};

// Planes near a group's middle.
struct NearPlanes {
  static constexpr size_t kMost = 8 * 8 * 8;
  std::array<Vec3f, kMost> normal, foot;  // feet from the middle
  std::array<float, kMost> weight;
  size_t count = 0;

  NearPlanes(const StartPlanes& planes, const std::array<int, 3>& middle) {
    const Vec3f at =
        Vec3f(static_cast<float>(middle[0]), static_cast<float>(middle[1]), static_cast<float>(middle[2])) -
        Vec3f::Constant(static_cast<float>(kMargin));
    constexpr unsigned kBits = (1u << (2 * kPlaneReach)) - 1;
    for (int x = middle[0] - kPlaneReach; x < middle[0] + kPlaneReach; ++x)
      for (int y = middle[1] - kPlaneReach; y < middle[1] + kPlaneReach; ++y) {
        const StartPlanes::Row& row = planes.rows[static_cast<size_t>(x * kCells + y)];
        const unsigned wanted = kBits << (middle[2] - kPlaneReach);
        for (unsigned left = row.cells & wanted; left != 0; left &= left - 1) {
          const unsigned below = row.cells & ((left & (0 - left)) - 1);
          const size_t i = planes.number[row.first + static_cast<size_t>(std::popcount(below))];
          const Vec3f from = planes.foot(i) - at;
          normal[count] = planes.normal(i);
          foot[count] = from;
          weight[count++] = planes.quality(i) / (0.5f + from.squaredNorm());
        }
      }
  }

  // The two faces that most of them lie on; false where they all face one way.
  bool twoFaces(Start& start) const {
    if (count < 2) return false;
    const size_t first = static_cast<size_t>(
        std::max_element(weight.begin(), weight.begin() + static_cast<std::ptrdiff_t>(count)) - weight.begin());
    size_t second = count;
    float best = 0;
    for (size_t i = 0; i < count; ++i)
      if (const float t = 1 - normal[i].dot(normal[first]); t > kLeastTurn && weight[i] * t > best)
        best = weight[i] * t, second = i;
    if (second == count) return false;
    start.faces = 2;
    start.normal = {normal[first], normal[second], Vec3f::UnitZ()};
    for (int round = 0; round < 2; ++round) {
      std::array<Vec3f, 2> n{Vec3f::Zero(), Vec3f::Zero()}, f{Vec3f::Zero(), Vec3f::Zero()};
      std::array<float, 2> w{};
      for (size_t i = 0; i < count; ++i) {
        const float a = normal[i].dot(start.normal[0]), b = normal[i].dot(start.normal[1]);
        if (std::max(a, b) < kOwn) continue;
        const size_t k = b > a;
        n[k] += weight[i] * normal[i];
        f[k] += weight[i] * foot[i];
        w[k] += weight[i];
      }
      for (size_t k = 0; k < 2; ++k) {
        if (!(w[k] > 0)) return false;
        start.normal[k] = n[k] * (1 / std::sqrt(n[k].squaredNorm()));
        start.foot[k] = f[k] * (1 / w[k]);
      }
    }
    return true;
  }

  // A third one beside those of a fit, where planes lie on neither; false where none do.
  bool thirdFace(const RimModel& two, Start& start) const {
    const auto isForeign = [&](size_t i) {
      bool foreign = true;
      for (size_t k = 0; k < 2; ++k) {
        Vec3f gradient;
        const float d = two.distance(static_cast<int>(k), foot[i], gradient);
        foreign = foreign && (std::abs(d) > kForeign || gradient.dot(normal[i]) < kOwn);
      }
      return foreign;
    };
    std::array<uint16_t, kMost> foreign;
    size_t some = 0;
    for (size_t i = 0; i < count; ++i)
      if (isForeign(i)) foreign[some++] = static_cast<uint16_t>(i);
    if (some == 0) return false;
    size_t heaviest = foreign[0];
    for (size_t j = 1; j < some; ++j)
      if (weight[foreign[j]] > weight[heaviest]) heaviest = foreign[j];
    Vec3f n = Vec3f::Zero(), f = Vec3f::Zero();
    float w = 0;
    for (size_t j = 0; j < some; ++j) {
      const size_t i = foreign[j];
      if (normal[i].dot(normal[heaviest]) < kOwn || std::abs(normal[heaviest].dot(foot[i] - foot[heaviest])) > 1)
        continue;
      n += weight[i] * normal[i], f += weight[i] * foot[i], w += weight[i];
    }
    start.faces = 3;
    for (size_t k = 0; k < 2; ++k) {
      const RimFace& face = two.fit().face[k];
      start.normal[k] = Vec3f(face.normal[0], face.normal[1], face.normal[2]);
      start.foot[k] = Vec3f(face.origin[0], face.origin[1], face.origin[2]);
    }
    start.normal[2] = n * (1 / std::sqrt(n.squaredNorm()));
    start.foot[2] = f * (1 / w);
    return true;
  }
};

// Cells that share a fit: first four along each axis, two where that does not explain them, and a cell alone where that
// does not either. Number 0 to 7 are the large groups of a brick; the last is that of the cell that was asked for.
struct Group {
  static constexpr int kLarge = 8, kOwn = kLarge + 64, kCount = kOwn + 1;
  static int largeOf(int cell) { return cell >> 8 << 2 | (cell >> 5 & 1) << 1 | (cell >> 2 & 1); }
  static int smallOf(int cell) { return kLarge + ((cell >> 7) * 16 + (cell >> 4 & 3) * 4 + (cell >> 1 & 3)); }
  static bool isLarge(int group) { return group < kLarge; }
  // In voxels from the block's lowest; not for kOwn.
  static std::array<int, 3> middleOf(int group) {
    if (isLarge(group))
      return {kMargin + 2 + 4 * (group >> 2), kMargin + 2 + 4 * (group >> 1 & 1), kMargin + 2 + 4 * (group & 1)};
    const int small = group - kLarge;
    return {kMargin + 1 + 2 * (small >> 4), kMargin + 1 + 2 * (small >> 2 & 3), kMargin + 1 + 2 * (small & 3)};
  }
};
using Groups = std::bitset<Group::kCount>;

// How a group is fitted.
struct FitSize {
  float reach;       // voxels up to here count
  float near;        // and up to here must be explained
  float fading;      // RimInput::fading
  float mostWorst;   // what may be left of those, voxels
  float mostMisfit;  // and of all, in the mean
};
constexpr FitSize kLargeFit{.reach = 4.3f, .near = 3.3f, .fading = 0.25f, .mostWorst = 0.03f, .mostMisfit = 0.15f},
    kSmallFit{.reach = 3.7f, .near = 2, .fading = 0.5f, .mostWorst = 0.04f, .mostMisfit = 0.3f},
    kOwnFit{.reach = 3.7f, .near = 2, .fading = 0.5f, .mostWorst = kAloneWorst, .mostMisfit = 0.3f};
const FitSize& sizeOf(int group) {
  return Group::isLarge(group) ? kLargeFit : group == Group::kOwn ? kOwnFit : kSmallFit;
}

// The fits of a brick's groups.
class RimFits {
 public:
  // Begins with another brick, for these large groups; false where too many cells are crossed to tell planes apart.
  bool begin(Sampler& field, Coord brick, const Groups& large) {
    block_.read(field, brick);
    models_.fill(std::nullopt);
    blunt_.reset();
    StartPlanes::Range range;
    for (int group = 0; group < Group::kLarge; ++group) {
      if (!large[static_cast<size_t>(group)]) continue;
      const std::array<int, 3> middle = Group::middleOf(group);
      for (size_t axis = 0; axis < 3; ++axis) {
        range.low[axis] = std::min(range.low[axis], middle[axis] - kFarthestPlane);
        range.high[axis] = std::max(range.high[axis], middle[axis] + kFarthestPlane);
      }
    }
    return planes_.find(block_, range);
  }

  [[nodiscard]] const FieldBlock& block() const { return block_; }
  [[nodiscard]] bool kinkedAround(int cell) const { return planes_.kinkedAround(cell >> 6, cell >> 3 & 7, cell & 7); }

  // In voxels from the block's lowest.
  [[nodiscard]] std::array<int, 3> middleOf(int group) const {
    return group == Group::kOwn ? own_ : Group::middleOf(group);
  }
  // Makes the faces around a voxel those of Group::kOwn.
  void fitAround(const std::array<int, 3>& middle) {
    own_ = middle;
    models_[Group::kOwn].reset();
    fit(Group::kOwn);
  }

  // Finds the faces of a group: two, or three where voxels are left that lie on neither.
  void fit(int group) {
    const NearPlanes near(planes_, middleOf(group));
    Start start;
    if (!near.twoFaces(start) || start.normal[0].dot(start.normal[1]) > kBluntCosine) return;
    gather(group);
    std::optional<RimModel>& model = models_[static_cast<size_t>(group)];
    run(group, start, model);
    if (model && !isWithin(*model, group == Group::kOwn ? kSmallFit : sizeOf(group))) {
      const bool more = foreignVoxels(*model) >= kLeastForeign && near.thirdFace(*model, start);
      if (group != Group::kOwn) model.reset();
      std::optional<RimModel> three;
      if (more) run(group, start, three);
      if (three && (!model || three->fit().worst < model->fit().worst)) model = three;
    }
    if (!model) return;
    const bool good = isGood(*model, group);
    // A looser fit tells less of the angle.
    if (good && isAcute(*model, start, group != Group::kOwn)) return;
    blunt_[static_cast<size_t>(group)] = good;
    model.reset();
  }
  // Tells whether a group was explained without a rim for this: smaller groups in it need no fit.
  [[nodiscard]] bool isBlunt(int group) const { return blunt_[static_cast<size_t>(group)]; }

  [[nodiscard]] bool any() const {
    return std::any_of(models_.begin(), models_.end(), [](const auto& model) { return model.has_value(); });
  }
  [[nodiscard]] const RimModel* of(int group) const {
    const std::optional<RimModel>& model = models_[static_cast<size_t>(group)];
    return model ? &*model : nullptr;
  }

 private:
  static bool isWithin(const RimModel& model, const FitSize& size) {
    return model.fit().worst < size.mostWorst && model.fit().misfit < size.mostMisfit;
  }
  static bool isGood(const RimModel& model, int group) { return isWithin(model, sizeOf(group)); }

  // Tells whether two of the faces meet near the group at less than a right angle. Planes tell blunter ones as well,
  // and a rounded edge is not taken for a rim. Voxels beside an edge tell a face's slope from its bend badly: the
  // planes that the fit started from must be acute as well, or the faces very much so.
  static bool isAcute(const RimModel& model, const Start& start, bool byStart) {
    for (size_t i = 1; i < static_cast<size_t>(model.fit().faces); ++i)
      for (size_t j = 0; j < i; ++j) {
        Vec3f rim = Vec3f::Zero();
        std::array<Vec3f, kMostRimFaces> g;
        if (!model.meet(1u << i | 1u << j, kRimFarthest, rim, g)) continue;
        const bool acute = byStart && start.normal[i].dot(start.normal[j]) < kAcuteStart;
        const float most = acute ? kAcuteCosine : kSurelyAcuteCosine;
        if (g[0].dot(g[1]) < most) return true;
      }
    return false;
  }

  // The exact voxels around a group's middle.
  void gather(int group) {
    const std::array<int, 3> middle = middleOf(group);
    const float reach = sizeOf(group).reach;
    const int steps = static_cast<int>(reach);
    const unsigned bits = ((1u << (2 * steps + 1)) - 1) << (middle[2] - steps);
    int n = 0;
    for (int x = -steps; x <= steps; ++x)
      for (int y = -steps; y <= steps; ++y)
        for (unsigned left = block_.row(block_.exact, middle[0] + x, middle[1] + y) & bits; left != 0;
             left &= left - 1) {
          const int z = std::countr_zero(left) - middle[2];
          if (static_cast<float>(x * x + y * y + z * z) > reach * reach || n == kMostRimVoxels) continue;
          voxels_.x[n] = static_cast<float>(x), voxels_.y[n] = static_cast<float>(y);
          voxels_.z[n] = static_cast<float>(z);
          voxels_.phi[n++] = *block_.at(middle[0] + x, middle[1] + y, middle[2] + z);
        }
    voxels_.count = n;
  }

  [[nodiscard]] int foreignVoxels(const RimModel& model) const {
    int count = 0;
    for (int i = 0; i < voxels_.count; ++i)
      count += std::abs(model.distance(Vec3f(voxels_.x[i], voxels_.y[i], voxels_.z[i])) - voxels_.phi[i]) > kForeign;
    return count;
  }

  void run(int group, const Start& start, std::optional<RimModel>& model) {
    RimFit fit;
    fit.faces = start.faces;
    for (size_t k = 0; k < static_cast<size_t>(start.faces); ++k)
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        fit.face[k].normal[axis] = start.normal[k][axis];
        fit.face[k].origin[axis] = start.foot[k][axis];
      }
    const FitSize& size = sizeOf(group);
    if (fitRim(voxels_, {size.near, size.fading}, fit)) model.emplace(fit);
  }

  FieldBlock block_;
  StartPlanes planes_;
  RimVoxels voxels_;
  std::array<std::optional<RimModel>, Group::kCount> models_;
  Groups blunt_;
  std::array<int, 3> own_{};
};

Vec3f vec(const std::array<int, 3>& a) {
  return {static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(a[2])};
}
Vec3f cornerAt(int c) {
  return {static_cast<float>(c >> 2), static_cast<float>((c >> 1) & 1), static_cast<float>(c & 1)};
}

// A cell's faces.
struct CellModel {
  const RimModel* model = nullptr;
  Vec3f low;  // the cell's lowest corner, from the model's middle
  RimModel::Corners corners;
};

// The model of a group, if it explains the exact voxels among a cell's corners.
bool explains(const RimFits& fits, int group, int cell, CellModel& out) {
  const RimModel* model = fits.of(group);
  if (!model) return false;
  const FieldBlock& block = fits.block();
  const std::array<int, 3> low{(cell >> 6) + kMargin, (cell >> 3 & 7) + kMargin, (cell & 7) + kMargin};
  const std::array<int, 3> middle = fits.middleOf(group);
  out.model = model;
  out.low = vec({low[0] - middle[0], low[1] - middle[1], low[2] - middle[2]});
  out.corners = model->corners(out.low);
  const float most = group == Group::kOwn ? kAloneWorst : kBorrowed;
  for (int c = 0; c < 8; ++c) {
    const int x = low[0] + (c >> 2), y = low[1] + (c >> 1 & 1), z = low[2] + (c & 1);
    if (!(block.row(block.exact, x, y) >> z & 1)) continue;
    if (!(std::abs(model->joined(out.corners.at(c)) - *block.at(x, y, z)) < most)) return false;
  }
  return true;
}

// The faces around a cell: by its own groups, or by the best one beside it.
bool findModel(const RimFits& fits, int cell, CellModel& out) {
  if (explains(fits, Group::largeOf(cell), cell, out) || explains(fits, Group::smallOf(cell), cell, out)) return true;
  int best = -1;
  float least = INFINITY;
  CellModel found;
  for (int x = -2; x <= 2; x += 2)
    for (int y = -2; y <= 2; y += 2)
      for (int z = -2; z <= 2; z += 2) {
        const int at[3] = {(cell >> 6) + x, (cell >> 3 & 7) + y, (cell & 7) + z};
        if (std::min({at[0], at[1], at[2]}) < 0 || std::max({at[0], at[1], at[2]}) > 7) continue;
        const int other = at[0] << 6 | at[1] << 3 | at[2];
        for (const int group : {Group::largeOf(other), Group::smallOf(other)})
          if (group != best && fits.of(group) && fits.of(group)->fit().misfit < least &&
              explains(fits, group, cell, found))
            best = group, least = found.model->fit().misfit, out = found;
      }
  return best >= 0;
}

// By a fit for the cell alone, around either end of its diagonal: what shares a group's fit may lie on other faces, and
// a group ends with its brick.
bool fitAlone(RimFits& fits, int cell, CellModel& out) {
  for (const int end : {0, 1}) {
    fits.fitAround({(cell >> 6) + kMargin + end, (cell >> 3 & 7) + kMargin + end, (cell & 7) + kMargin + end});
    if (explains(fits, Group::kOwn, cell, out)) return true;
  }
  return false;
}

// Tells whether one of the cells is at most a step away along each axis.
bool isBeside(const RimCells& cells, int cell) {
  for (int x = std::max((cell >> 6) - 1, 0); x <= std::min((cell >> 6) + 1, 7); ++x)
    for (int y = std::max((cell >> 3 & 7) - 1, 0); y <= std::min((cell >> 3 & 7) + 1, 7); ++y)
      for (int z = std::max((cell & 7) - 1, 0); z <= std::min((cell & 7) + 1, 7); ++z)
        if (cells[static_cast<size_t>(x << 6 | y << 3 | z)]) return true;
  return false;
}

struct PlacedVertex {
  Vec3f at, normal;  // `at` from the cell's lowest corner
  bool sharp = false;
};

// Tells whether a face meets another one at less than a right angle beside a place on it.
bool hasRimBeside(const RimModel& model, int face, const Vec3f& p, const Vec3f& gradient) {
  bool beside = false;
  for (int k = 0; k < model.fit().faces; ++k) {
    Vec3f other;
    if (k == face || std::abs(model.distance(k, p, other)) > kRimReach) continue;
    beside = beside || other.dot(gradient) < kAcuteCosine;
  }
  return beside;
}

std::optional<PlacedVertex> place(const FieldBlock& block, const CellModel& cell, const RimSuspect& s) {
  const RimModel& model = *cell.model;
  const std::array<int, 3> low{(s.cell >> 6) + kMargin, (s.cell >> 3 & 7) + kMargin, (s.cell & 7) + kMargin};
  unsigned faces = 0;
  Vec3f mean = Vec3f::Zero();
  for (unsigned left = s.edges; left != 0; left &= left - 1) {
    const CellEdge edge = kCellEdges[static_cast<size_t>(std::countr_zero(left))];
    const bool upwards = (block.row(block.inside, low[0] + (edge.from >> 2), low[1] + (edge.from >> 1 & 1)) >>
                              (low[2] + (edge.from & 1)) &
                          1) != 0;
    const RimModel::Crossing crossing =
        model.crossing(cell.corners, upwards ? edge.from : edge.to, upwards ? edge.to : edge.from);
    faces |= 1u << crossing.face;
    mean += cornerAt(edge.from);
    mean[edge.axis] += upwards ? crossing.along : 1 - crossing.along;
  }
  mean = mean * (1 / static_cast<float>(std::popcount(s.edges))) + cell.low;
  Vec3f p = mean;
  std::array<Vec3f, kMostRimFaces> gradients;
  if (!model.meet(faces, std::popcount(faces) == 1 ? kFaceReach : kVertexReach, p, gradients)) return std::nullopt;
  if (std::popcount(faces) == 2 && model.fit().faces == 3) {
    // The third face ends the rim before, or in this cell.
    const bool ended = std::abs(model.distance(p)) > kOnSolid;
    Vec3f corner = mean;
    std::array<Vec3f, kMostRimFaces> there;
    const bool known = model.meet(7, kVertexReach, corner, there);
    const Vec3f within = corner - cell.low;
    if (known && (ended || (within.minCoeff() >= -kBeside && within.maxCoeff() <= 1 + kBeside))) {
      p = corner;
      faces = 7;
      gradients = there;
    } else if (ended) {
      return std::nullopt;
    }
  }
  PlacedVertex placed;
  placed.at = p - cell.low;
  placed.normal = Vec3f::Zero();
  const auto n = static_cast<size_t>(std::popcount(faces));
  bool acute = n == 1 && hasRimBeside(model, std::countr_zero(faces), p, gradients[0]);
  for (size_t i = 0; i < n; ++i) {
    placed.normal += gradients[i];
    for (size_t j = 0; j < i; ++j) {
      const float cosine = gradients[i].dot(gradients[j]);
      placed.sharp = placed.sharp || 1 - cosine > kLeastTurn;
      acute = acute || cosine < kAcuteCosine;
    }
  }
  if (!acute) return std::nullopt;
  if (!(placed.normal.squaredNorm() > 1e-4f)) placed.normal = gradients[0];
  return placed;
}

}  // namespace

void placeOnRims(Sampler& field, Coord brick, std::span<const RimSuspect> suspects, const RimCells& hard, bool all,
                 bool wantNormals, ExtractionBuffer& out, PlacedVertices& placed, PlacedVertices& sharp) {
  // Kept: it is a quarter of a megabyte, and fresh memory costs more than the fits of a brick.
  thread_local const std::unique_ptr<RimFits> room = std::make_unique_for_overwrite<RimFits>();
  RimFits& fits = *room;
  std::array<uint16_t, ExtractionBuffer::kMostVertices> wanted;
  size_t count = 0;
  Groups large, small;
  // A rim goes on for some cells beside those that are known to be hard.
  for (const RimSuspect& s : suspects) {
    if (!all && !hard[s.cell]) continue;
    for (int corner = 0; corner < 8; ++corner) {
      const auto at = [&](int shift, int bit) {
        return std::clamp((s.cell >> shift & 7) + ((corner >> bit & 1) != 0 ? kBesideHard : -kBesideHard), 0, 7);
      };
      large.set(static_cast<size_t>(Group::largeOf(at(6, 2) << 6 | at(3, 1) << 3 | at(0, 0))));
    }
  }
  if (!fits.begin(field, brick, large)) return;
  for (size_t i = 0; i < suspects.size(); ++i)
    if (large[static_cast<size_t>(Group::largeOf(suspects[i].cell))] &&
        (suspects[i].kinked || fits.kinkedAround(suspects[i].cell)))
      wanted[count++] = static_cast<uint16_t>(i);
  for (int group = 0; group < Group::kLarge; ++group)
    if (large[static_cast<size_t>(group)]) fits.fit(group);
  CellModel model;
  for (size_t i = 0; i < count; ++i) {
    const int cell = suspects[wanted[i]].cell;
    if (fits.isBlunt(Group::largeOf(cell)) && !all) continue;
    if (!explains(fits, Group::largeOf(cell), cell, model)) small.set(static_cast<size_t>(Group::smallOf(cell)));
  }
  for (int group = Group::kLarge; group < Group::kCount && small.any(); ++group)
    if (small[static_cast<size_t>(group)]) fits.fit(group);
  const bool acute = fits.any();
  int last = -1;
  bool found = false, alone = false;
  for (size_t i = 0; i < count; ++i) {
    const RimSuspect& s = suspects[wanted[i]];
    if (s.cell != last) found = findModel(fits, s.cell, model), alone = false;
    last = s.cell;
    std::optional<PlacedVertex> vertex;
    if (found) vertex = place(fits.block(), model, s);
    if (acute && !vertex && !alone && (hard[s.cell] || (s.kinked && isBeside(hard, s.cell)))) {
      alone = true;
      found = fitAlone(fits, s.cell, model);
      if (found) vertex = place(fits.block(), model, s);
    }
    if (!vertex || (!s.kinked && !vertex->sharp)) continue;
    placed.set(s.vertex);
    sharp.set(s.vertex, vertex->sharp);
    out.positions[s.vertex] = vec({s.cell >> 6, s.cell >> 3 & 7, s.cell & 7}) + vertex->at;
    if (!wantNormals) continue;
    PackedNormal packed = PackedNormal::pack(vertex->normal);
    if (vertex->sharp) packed.v = static_cast<int16_t>(packed.v | 1);
    out.normals[s.vertex] = packed;
  }
}

}  // namespace argil::clay
