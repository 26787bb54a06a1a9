#include "clay/unwrap/compact.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <utility>

#include "clay/base/parallel.h"

namespace argil::clay {

namespace {

constexpr int kFieldCells = 128;                        // along a shape's longer side
constexpr double kMostReach = 16;                       // cells around a shape
constexpr double kFirstStep = 0.02, kLastStep = 0.002;  // of sides, one after the other
constexpr int kFirstTries = 1;
constexpr int kTries = 8;           // before a side counts as too small
constexpr double kShake = 0.1;      // of a shape's radius, radians
constexpr size_t kManyShapes = 30;  // of more, fewer rounds
constexpr int kRounds = 600;        // of pushing, in a try
constexpr int kPatience = 20;       // rounds without less in the way, until a shape is moved elsewhere
constexpr int kElsewhere = 100;     // places tried for it
constexpr double kSlack = 0.15;     // of a cell: what distances between cells are off by
constexpr double kLongest = 4;      // cells between two samples of an outline

using Segment = std::array<Vec2d, 2>;

double cross(const Vec2d& a, const Vec2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double distanceTo(const Segment& s, const Vec2d& p) {
  const Vec2d along = s[1] - s[0];
  const double length = along.squaredNorm();
  const double t = length > 0 ? std::clamp((p - s[0]).dot(along) / length, 0.0, 1.0) : 0;
  return (s[0] + t * along - p).norm();
}

double distanceBetween(const Segment& a, const Segment& b) {
  const Vec2d u = a[1] - a[0], v = b[1] - b[0];
  const bool crossed =
      cross(u, b[0] - a[0]) * cross(u, b[1] - a[0]) < 0 && cross(v, a[0] - b[0]) * cross(v, a[1] - b[0]) < 0;
  if (crossed) return 0;
  return std::min({distanceTo(a, b[0]), distanceTo(a, b[1]), distanceTo(b, a[0]), distanceTo(b, a[1])});
}

Eigen::Matrix2d turnBy(double angle) {
  return Eigen::Rotation2Dd(angle).toRotationMatrix();
}

// Edges that one triangle alone has.
std::vector<Segment> outlineOf(const FlatShape& shape) {
  std::map<std::pair<uint32_t, uint32_t>, int> sides;
  for (const auto& t : *shape.triangles)
    for (size_t k = 0; k < 3; ++k) ++sides[std::minmax(t[k], t[(k + 1) % 3])];
  std::vector<Segment> outline;
  for (const auto& [side, count] : sides)
    if (count == 1) outline.push_back({(*shape.places)[side.first], (*shape.places)[side.second]});
  return outline;
}

// A shape around its middle, with distances to its outline, negative inside.
class Piece {
 public:
  Piece(const FlatShape& shape, double reach) : outline_(outlineOf(shape)) {
    Vec2d low = Vec2d::Constant(INFINITY), high = -low;
    for (const Segment& s : outline_)
      for (const Vec2d& p : s) low = low.cwiseMin(p), high = high.cwiseMax(p);
    middle_ = 0.5 * (low + high);
    const Vec2d half = 0.5 * (high - low);
    for (Segment& s : outline_)
      for (Vec2d& p : s) p -= middle_;
    // The margin around a speck may be far wider than it is.
    cell_ = std::max(2 * half.maxCoeff() / kFieldCells, reach / kMostReach);
    perCell_ = 1 / cell_;
    const double pad = reach + 2 * cell_;
    low_ = -half - Vec2d::Constant(pad);
    width_ = static_cast<int>(std::ceil(2 * (half.x() + pad) / cell_)) + 1;
    height_ = static_cast<int>(std::ceil(2 * (half.y() + pad) / cell_)) + 1;
    field_.resize(size_t(width_) * size_t(height_));
    std::vector<double> crossings;
    for (int y = 0; y < height_; ++y) {
      const double at = low_.y() + y * cell_;
      crossings.clear();
      for (const Segment& s : outline_) {
        if ((s[0].y() <= at) == (s[1].y() <= at)) continue;
        crossings.push_back(s[0].x() + (at - s[0].y()) / (s[1].y() - s[0].y()) * (s[1].x() - s[0].x()));
      }
      std::sort(crossings.begin(), crossings.end());
      for (int x = 0; x < width_; ++x) {
        const Vec2d p(low_.x() + x * cell_, at);
        double least = INFINITY;
        for (const Segment& s : outline_) least = std::min(least, distanceTo(s, p));
        const auto before = std::lower_bound(crossings.begin(), crossings.end(), p.x()) - crossings.begin();
        field_[size_t(y) * size_t(width_) + size_t(x)] = static_cast<float>(before % 2 == 1 ? -least : least);
      }
    }
    for (const Segment& s : outline_) {
      const int parts = std::max(1, static_cast<int>(std::ceil((s[1] - s[0]).norm() / (kLongest * cell_))));
      for (int i = 0; i < parts; ++i) samples_.push_back(s[0] + (s[1] - s[0]) * i / parts);
      for (const Vec2d& p : s) radius_ = std::max(radius_, p.norm());
    }
    for (const Segment& s : outline_) samples_.push_back(s[1]);
  }
  [[nodiscard]] const std::vector<Segment>& outline() const { return outline_; }
  [[nodiscard]] const std::vector<Vec2d>& samples() const { return samples_; }
  [[nodiscard]] const Vec2d& middle() const { return middle_; }
  [[nodiscard]] double radius() const { return radius_; }
  [[nodiscard]] double cell() const { return cell_; }

  // How far `p` is outside, and the way out; infinite where that is farther than what was asked for.
  [[nodiscard]] double outside(const Vec2d& p, Vec2d& way) const {
    const Vec2d q = (p - low_) * perCell_;
    if (!(q.x() >= 0 && q.y() >= 0 && q.x() < width_ - 1 && q.y() < height_ - 1)) return INFINITY;
    const int x = static_cast<int>(q.x()), y = static_cast<int>(q.y());
    const float* const f = &field_[size_t(y) * size_t(width_) + size_t(x)];
    const double u = q.x() - x, v = q.y() - y, a = f[0], b = f[1], c = f[width_], d = f[width_ + 1];
    way = {(1 - v) * (b - a) + v * (d - c), (1 - u) * (c - a) + u * (d - b)};
    return (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d);
  }

 private:
  std::vector<Segment> outline_;
  std::vector<Vec2d> samples_;
  Vec2d middle_ = Vec2d::Zero(), low_ = Vec2d::Zero();
  double radius_ = 0, cell_ = 1, perCell_ = 1;
  int width_ = 0, height_ = 0;
  std::vector<float> field_;
};

struct Place {
  Vec2d at = Vec2d::Zero();  // of the middle
  double turn = 0;
};

// What pushes a shape: moves and turns that would take it out of the way of all that is in its way, by least squares.
struct Push {
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sums = Eigen::Vector3d::Zero();
  void add(const Vec2d& way, double turning, double by) {
    const Eigen::Vector3d row(way.x(), way.y(), turning);
    squares += row * row.transpose();
    sums += by * row;
  }
};

class Table {
 public:
  Table(const std::vector<Piece>& pieces, double side, double margin)
      : pieces_(pieces), side_(side), gap_(margin * side) {}

  // Until nothing is in the way of anything. `goesOn` is asked in each round.
  template <class GoesOn>
  bool separate(std::vector<Place>& places, std::mt19937& random, const GoesOn& goesOn) {
    double least = INFINITY;
    const auto rounds = static_cast<int>(kRounds * kManyShapes / std::max(kManyShapes, pieces_.size()));
    for (int round = 0, since = 0; round < rounds; ++round) {
      if (!goesOn()) return false;
      const double left = look(places);
      if (left == 0) return isClear(places);
      since = left < 0.99 * least ? 0 : since + 1;
      least = std::min(least, left);
      if (since >= kPatience) {
        moveElsewhere(places, random);
        since = 0;
        least = INFINITY;
      } else {
        move(places);
      }
    }
    return false;
  }

 private:
  // Sum of what is in the way, in mm, and what is to be done about it.
  double look(const std::vector<Place>& places) {
    const size_t count = pieces_.size();
    pushes_.assign(count, {});
    turns_.clear();
    for (const Place& each : places) turns_.push_back(turnBy(each.turn));
    points_.resize(count);
    double sum = 0;
    for (size_t i = 0; i < count; ++i) {
      const double slack = kSlack * pieces_[i].cell(), rim = 0.5 * gap_ + slack;
      points_[i].clear();
      for (const Vec2d& p : pieces_[i].samples()) {
        const Vec2d arm = turns_[i] * p, at = places[i].at + arm;
        points_[i].push_back(at);
        for (int k = 0; k < 2; ++k) {
          const double by = std::max(rim - at[k], 0.0) - std::max(at[k] - (side_ - rim), 0.0);
          if (std::abs(by) <= 0.5 * slack) continue;
          sum += std::abs(by);
          // A rim does not give way: twice as far as where both do.
          const Vec2d way = Vec2d::Unit(k);
          pushes_[i].add(way, cross(arm, way) / pieces_[i].radius(), 2 * by);
        }
      }
    }
    for (size_t i = 0; i < count; ++i)
      for (size_t j = 0; j < count; ++j)
        if (i != j && (places[i].at - places[j].at).norm() < pieces_[i].radius() + pieces_[j].radius() + gap_)
          sum += look(places, i, j);
    return sum;
  }
  // Of samples of i that are in the way of j.
  double look(const std::vector<Place>& places, size_t i, size_t j) {
    const Piece& other = pieces_[j];
    const double wanted = gap_ + kSlack * other.cell(), near = other.radius() + wanted;
    const Eigen::Matrix2d& turn = turns_[j];
    double sum = 0;
    for (const Vec2d& p : points_[i]) {
      const Vec2d from = p - places[j].at;
      if (from.squaredNorm() > near * near) continue;
      Vec2d way;
      const double by = wanted - other.outside(turn.transpose() * from, way);
      if (!(by > 0.5 * kSlack * other.cell()) || way.squaredNorm() < 1e-12) continue;
      sum += by;
      way = (turn * way).normalized();
      const Vec2d arm = p - places[i].at;
      pushes_[i].add(way, cross(arm, way) / pieces_[i].radius(), by);
      pushes_[j].add(-way, -cross(from, way) / other.radius(), by);
    }
    return sum;
  }
  void move(std::vector<Place>& places) const {
    for (size_t i = 0; i < places.size(); ++i) {
      const double trace = pushes_[i].squares.trace();
      if (!(trace > 0)) continue;
      const double radius = pieces_[i].radius();
      Eigen::Vector3d by =
          (pushes_[i].squares + 1e-2 * trace * Eigen::Matrix3d::Identity()).ldlt().solve(pushes_[i].sums);
      by *= 0.5 * std::min(1.0, 0.2 * radius / std::max(by.norm(), 1e-300));
      places[i].at += by.head<2>();
      places[i].turn += by.z() / radius;
    }
  }
  // One of those that are in the way goes where it is least so.
  void moveElsewhere(std::vector<Place>& places, std::mt19937& random) {
    const size_t count = pieces_.size();
    std::vector<size_t> inTheWay;
    for (size_t i = 0; i < count; ++i)
      if (pushes_[i].squares.trace() > 0) inTheWay.push_back(i);
    const size_t i = inTheWay[random() % inTheWay.size()];
    const auto share = [&] { return double(random() % 65536) / 65536; };
    Place best = places[i];
    double least = costOf(places, i, INFINITY);
    for (int k = 0; k < kElsewhere; ++k) {
      const double inset = 0.5 * pieces_[i].radius();
      places[i].at = Vec2d::Constant(inset) + (side_ - 2 * inset) * Vec2d(share(), share());
      places[i].turn = 2 * std::numbers::pi * share();
      const double cost = costOf(places, i, least);
      if (cost < least) least = cost, best = places[i];
    }
    places[i] = best;
  }
  // Sum of what is in the way of i and of what it is in the way of; not more than `enough` is of interest.
  double costOf(const std::vector<Place>& places, size_t i, double enough) {
    const size_t count = pieces_.size();
    turns_[i] = turnBy(places[i].turn);
    points_[i].clear();
    double sum = 0;
    const double rim = 0.5 * gap_;
    for (const Vec2d& p : pieces_[i].samples()) {
      const Vec2d at = places[i].at + turns_[i] * p;
      points_[i].push_back(at);
      for (int k = 0; k < 2; ++k) sum += 2 * (std::max(rim - at[k], 0.0) + std::max(at[k] - (side_ - rim), 0.0));
    }
    for (size_t j = 0; j < count && sum < enough; ++j) {
      if (i == j || (places[i].at - places[j].at).norm() >= pieces_[i].radius() + pieces_[j].radius() + gap_) continue;
      sum += inTheWay(places, i, j) + inTheWay(places, j, i);
    }
    return sum;
  }
  [[nodiscard]] double inTheWay(const std::vector<Place>& places, size_t i, size_t j) const {
    const Piece& other = pieces_[j];
    const double near = other.radius() + gap_;
    const Eigen::Matrix2d back = turns_[j].transpose();
    double sum = 0;
    Vec2d way;
    for (const Vec2d& p : points_[i]) {
      const Vec2d from = p - places[j].at;
      if (from.squaredNorm() < near * near) sum += std::max(0.0, gap_ - other.outside(back * from, way));
    }
    return sum;
  }
  // By the outlines themselves.
  [[nodiscard]] bool isClear(const std::vector<Place>& places) const {
    std::vector<std::vector<Segment>> outlines(pieces_.size());
    for (size_t i = 0; i < pieces_.size(); ++i)
      for (const Segment& s : pieces_[i].outline()) {
        outlines[i].push_back({places[i].at + turns_[i] * s[0], places[i].at + turns_[i] * s[1]});
        for (const Vec2d& p : outlines[i].back())
          if (std::min(p.minCoeff(), side_ - p.maxCoeff()) < 0.5 * gap_ * (1 - 1e-9)) return false;
      }
    for (size_t i = 0; i < pieces_.size(); ++i)
      for (size_t j = 0; j < i; ++j) {
        if ((places[i].at - places[j].at).norm() > pieces_[i].radius() + pieces_[j].radius() + gap_) continue;
        for (const Segment& a : outlines[i]) {
          const Vec2d low = a[0].cwiseMin(a[1]) - Vec2d::Constant(gap_),
                      high = a[0].cwiseMax(a[1]) + Vec2d::Constant(gap_);
          for (const Segment& b : outlines[j])
            if ((b[0].cwiseMin(b[1]).array() <= high.array()).all() &&
                (b[0].cwiseMax(b[1]).array() >= low.array()).all() && distanceBetween(a, b) < gap_)
              return false;
        }
      }
    return true;
  }

  const std::vector<Piece>& pieces_;
  double side_, gap_;
  std::vector<Push> pushes_;
  std::vector<Eigen::Matrix2d> turns_;
  std::vector<std::vector<Vec2d>> points_;
};

// Small moves and turns of all.
void shake(const std::vector<Piece>& pieces, std::vector<Place>& places, std::mt19937& random) {
  const auto share = [&] { return double(random() % 65536) / 32768 - 1; };
  for (size_t i = 0; i < places.size(); ++i) {
    places[i].at += kShake * pieces[i].radius() * Vec2d(share(), share());
    places[i].turn += kShake * share();
  }
}

struct Arrangement {
  std::vector<Place> places;
  double side = 0;
};

// As near together as it comes, with so many tries of each side.
void shrink(const std::vector<Piece>& pieces, double margin, int tries, int threads, const WorkPart& part,
            Arrangement& best) {
  unsigned seed = 0;
  for (double step = kFirstStep; step > kLastStep;) {
    part.step(1 - step / kFirstStep);
    const double side = (1 - step) * best.side;
    const auto count = static_cast<size_t>(tries);
    std::vector<std::vector<Place>> tried(count);
    std::atomic<size_t> first = count;
    parallelBlocks(
        count, threads,
        [&](size_t begin, size_t end) {
          for (size_t k = begin; k < end && k < first; ++k) {
            std::vector<Place> places = best.places;
            for (Place& each : places) each.at *= 1 - step;
            std::mt19937 random(seed + static_cast<unsigned>(k));
            if (k > 0) shake(pieces, places, random);
            if (!Table(pieces, side, margin).separate(places, random, [&] { return k < first; })) continue;
            tried[k] = std::move(places);
            size_t now = first;
            while (k < now && !first.compare_exchange_weak(now, k)) continue;
          }
        },
        1);
    seed += static_cast<unsigned>(tries);
    if (first < count)
      best = {std::move(tried[first]), side};
    else
      step /= 2;
  }
}

}  // namespace

Packing compacted(const std::vector<FlatShape>& shapes, std::vector<Packing> starts, double margin, int threads,
                  const WorkPart& part) {
  std::vector<std::optional<Piece>> made(shapes.size());
  double reach = 0;
  for (const Packing& each : starts) reach = std::max(reach, margin * each.sideMm);
  parallelBlocks(
      shapes.size(), threads,
      [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) made[i].emplace(shapes[i], reach);
      },
      1);
  std::vector<Piece> pieces;
  for (std::optional<Piece>& each : made) pieces.push_back(std::move(*each));
  std::vector<Arrangement> found(starts.size());
  parallelBlocks(
      starts.size(), threads,
      [&](size_t begin, size_t end) {
        for (size_t s = begin; s < end; ++s) {
          found[s].side = starts[s].sideMm;
          for (size_t i = 0; i < shapes.size(); ++i) {
            const Packing::Placed& placed = starts[s].placed[i];
            found[s].places.push_back(
                {Eigen::Rotation2Dd(placed.turn) * pieces[i].middle() + placed.moveMm, placed.turn});
          }
          shrink(pieces, margin, kFirstTries, 1, part.part(0, 0.5), found[s]);
        }
      },
      1);
  const auto side = [](const Arrangement& each) { return each.side; };
  Arrangement best = *std::ranges::min_element(found, {}, side);
  shrink(pieces, margin, kTries, threads, part.part(0.5, 1), best);
  Packing out = starts.front();
  out.covered *= out.sideMm * out.sideMm / (best.side * best.side);
  out.sideMm = best.side;
  for (size_t i = 0; i < shapes.size(); ++i) {
    const Place& place = best.places[i];
    out.placed[i] = {place.turn, place.at - Eigen::Rotation2Dd(place.turn) * pieces[i].middle()};
  }
  return out;
}

}  // namespace argil::clay
