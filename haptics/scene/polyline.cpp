#include "haptics/scene/polyline.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>

#include "clay/base/error.h"

namespace argil::haptics {
namespace {

constexpr double kFarthestMm = 1e6;
constexpr double kSameMm = 1e-9;  // Points closer than this are one.
// A piece turns by less than 26° between control legs: downhill from anywhere on it leads to its nearest place.
constexpr double kTurnCosine = 0.9;
constexpr int kMostHalvings = 8;  // Of a segment that turns more.
constexpr size_t kGroup = 4;      // Pieces in a box.
constexpr int kNewton = 24;
constexpr double kStillMm = 1e-12;  // A shorter step along the curve is none.

std::atomic<uint64_t> nextId{1};

std::vector<Vec3d> cleaned(std::vector<Vec3d> points, bool closed) {
  if (points.size() > Polyline::kMaxPoints) throw Error("guide curve: more than a million points; give fewer");
  std::vector<Vec3d> kept;
  kept.reserve(points.size());
  for (const Vec3d& p : points) {
    if (!p.allFinite() || p.cwiseAbs().maxCoeff() > kFarthestMm)
      throw Error("guide curve: a point is not finite or beyond 1e6 mm");
    if (kept.empty() || (p - kept.back()).norm() > kSameMm) kept.push_back(p);
  }
  while (closed && kept.size() > 1 && (kept.front() - kept.back()).norm() <= kSameMm) kept.pop_back();
  if (kept.size() < (closed ? 3u : 2u))
    throw Error(closed ? "guide curve: a closed curve needs three different points"
                       : "guide curve: two different points are needed");
  return kept;
}

// Unit tangent where chords a and b meet; where the curve turns back on itself, square to it.
Vec3d tangentBetween(const Vec3d& a, const Vec3d& b) {
  const double la = a.norm(), lb = b.norm();
  const Vec3d t = (a / la * lb + b / lb * la) / (la + lb);
  const double length = t.norm();
  return length > 1e-6 ? Vec3d(t / length) : Vec3d(a.unitOrthogonal());
}

}  // namespace

// Five-point Gauss–Legendre: pieces turn little, so their speed is smooth.
double Polyline::Piece::arc(double t) const noexcept {
  constexpr std::array<double, 5> kAt{-0.9061798459386640, -0.5384693101056831, 0, 0.5384693101056831,
                                      0.9061798459386640};
  constexpr std::array<double, 5> kWeight{0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                          0.4786286704993665, 0.2369268850561891};
  double sum = 0;
  for (size_t i = 0; i < 5; ++i) sum += kWeight[i] * first(0.5 * t * (1 + kAt[i])).norm();
  return 0.5 * t * sum;
}

Polyline::Polyline(std::vector<Vec3d> given, bool closed)
    : closed_(closed), id_(nextId.fetch_add(1, std::memory_order_relaxed)) {
  const std::vector<Vec3d> points = cleaned(std::move(given), closed);
  const size_t n = points.size(), segments = closed ? n : n - 1;
  const auto chord = [&](size_t i) { return Vec3d(points[(i + 1) % n] - points[i % n]); };
  std::vector<Vec3d> tangents(n);
  for (size_t i = 0; i < n; ++i) {
    const bool end = !closed && (i == 0 || i + 1 == n);
    if (!end) tangents[i] = tangentBetween(chord(i + n - 1), chord(i));
  }
  if (!closed) {
    // An end bends as its segment does: the inner tangent mirrored in the chord.
    const auto mirrored = [](const Vec3d& tangent, const Vec3d& c) {
      return Vec3d(2 * c * c.dot(tangent) / c.squaredNorm() - tangent);
    };
    tangents.front() = n == 2 ? chord(0).normalized() : mirrored(tangents[1], chord(0));
    tangents.back() = n == 2 ? tangents[0] : mirrored(tangents[n - 2], chord(n - 2));
  }
  pieces_.reserve(segments);
  for (size_t i = 0; i < segments; ++i) {
    const Vec3d &a = points[i], &b = points[(i + 1) % n];
    const double third = (b - a).norm() / 3;
    addPieces({a, a + third * tangents[i], b - third * tangents[(i + 1) % n], b}, 0);
  }
  starts_.reserve(pieces_.size() + 1);
  starts_.push_back(0);
  for (const Piece& piece : pieces_) starts_.push_back(starts_.back() + piece.arc(1));
  buildBoxes();
}

void Polyline::addPieces(const std::array<Vec3d, 4>& b, int depth) {
  const std::array<Vec3d, 3> leg{b[1] - b[0], b[2] - b[1], b[3] - b[2]};
  const auto straight = [](const Vec3d& a, const Vec3d& c) { return a.dot(c) >= kTurnCosine * a.norm() * c.norm(); };
  if (depth < kMostHalvings && !(straight(leg[0], leg[1]) && straight(leg[1], leg[2]) && straight(leg[0], leg[2]))) {
    const Vec3d ab = (b[0] + b[1]) / 2, bc = (b[1] + b[2]) / 2, cd = (b[2] + b[3]) / 2;
    const Vec3d abc = (ab + bc) / 2, bcd = (bc + cd) / 2, middle = (abc + bcd) / 2;
    addPieces({b[0], ab, abc, middle}, depth + 1);
    addPieces({middle, bcd, cd, b[3]}, depth + 1);
    return;
  }
  // The hull of the control points bounds the bulge; the outer two lie on the chord.
  const Vec3d chord = b[3] - b[0];
  const auto off = [&](const Vec3d& p) {
    return (p - b[0] - chord * std::clamp(chord.dot(p - b[0]) / chord.squaredNorm(), 0.0, 1.0)).norm();
  };
  pieces_.push_back(
      {{b[0], 3 * leg[0], 3 * (leg[1] - leg[0]), b[3] - b[0] - 3 * leg[1]}, std::max(off(b[1]), off(b[2]))});
}

void Polyline::buildBoxes() {
  const size_t groups = (pieces_.size() + kGroup - 1) / kGroup;
  while (leaves_ < groups) leaves_ *= 2;
  const Vec3d far = Vec3d::Constant(std::numeric_limits<double>::infinity());
  boxes_.assign(2 * leaves_, Box{far, -far});
  for (size_t i = 0; i < pieces_.size(); ++i) {
    Box& box = boxes_[leaves_ + i / kGroup];
    const auto& c = pieces_[i].c;
    // The curve lies within the hull of its control points.
    const Vec3d first = c[0] + c[1] / 3, second = c[0] + 2 * c[1] / 3 + c[2] / 3, last = pieces_[i].point(1);
    for (const Vec3d& p : {c[0], first, second, last}) {
      box.low = box.low.cwiseMin(p);
      box.high = box.high.cwiseMax(p);
    }
  }
  for (size_t i = leaves_ - 1; i > 0; --i)
    boxes_[i] = {boxes_[2 * i].low.cwiseMin(boxes_[2 * i + 1].low),
                 boxes_[2 * i].high.cwiseMax(boxes_[2 * i + 1].high)};
}

Polyline::Place Polyline::finish(uint32_t piece, double t, const Vec3d& p) const noexcept {
  const Piece& on = pieces_[piece];
  Place place;
  place.piece = piece;
  place.t = t;
  place.point = on.point(t);
  place.tangent = on.first(t).normalized();
  place.distance = (place.point - p).norm();
  return place;
}

// The local minimum of |point(t) − p| within the piece that is met going downhill from t.
double Polyline::descend(const Piece& piece, const Vec3d& p, double t) noexcept {
  Vec3d away = piece.point(t) - p;
  double best = away.squaredNorm();
  for (int i = 0; i < kNewton; ++i) {
    const Vec3d d = piece.first(t);
    const double slope = away.dot(d), speed2 = d.squaredNorm();
    // Newton where the distance curves upwards enough, else a step as if the curve were straight.
    const double bend = speed2 + away.dot(piece.second(t));
    double next = std::clamp(t - slope / std::max(bend, 0.2 * speed2), 0.0, 1.0);
    bool moved = false;
    for (int half = 0; half < 12 && !moved; ++half) {
      if (std::abs(next - t) * std::sqrt(speed2) < kStillMm) return t;
      const Vec3d there = piece.point(next) - p;
      // Near the end rounding hides the gain: the slope decides, the distance only stops a step that goes far uphill.
      if (there.squaredNorm() <= best * (1 + 1e-15)) {
        t = next;
        away = there;
        best = std::min(best, there.squaredNorm());
        moved = true;
      } else {
        next = 0.5 * (next + t);
      }
    }
    if (!moved) return t;
  }
  return t;
}

Polyline::Place Polyline::slide(const Vec3d& p, const Place& from) const ARGIL_REALTIME {
  const uint32_t count = static_cast<uint32_t>(pieces_.size());
  uint32_t piece = std::min(from.piece, count - 1);
  double t = std::clamp(from.t, 0.0, 1.0);
  int came = 0;
  for (int i = 0; i < kMostPieces; ++i) {
    const Piece& on = pieces_[piece];
    t = descend(on, p, t);
    const double slope = (on.point(t) - p).dot(on.first(t));
    int step = 0;
    if (t == 1 && slope < 0) step = 1;
    if (t == 0 && slope > 0) step = -1;
    // Turning back at a joint: the minimum is the joint itself, up to rounding.
    if (step == 0 || step == -came) break;
    if (step > 0 && piece + 1 == count && !closed_) break;
    if (step < 0 && piece == 0 && !closed_) break;
    piece = (piece + count + static_cast<uint32_t>(step)) % count;
    t = step > 0 ? 0.0 : 1.0;
    came = step;
  }
  return finish(piece, t, p);
}

Polyline::Place Polyline::nearest(const Vec3d& p, const Place* hint) const ARGIL_REALTIME {
  Place best;
  if (hint) {
    best = slide(p, *hint);
  } else {
    best = finish(0, 0, p);
  }
  double best2 = best.distance * best.distance;
  uint32_t bestPiece = best.piece;
  double bestT = best.t;
  std::array<std::pair<size_t, double>, 64> stack;
  size_t depth = 0;
  int looked = 0;
  stack[depth++] = {1, boxes_[1].distance2(p)};
  while (depth > 0 && looked < kMostLeaves) {
    const auto [node, far2] = stack[--depth];
    if (!(far2 < best2)) continue;
    if (node >= leaves_) {
      ++looked;
      const size_t first = (node - leaves_) * kGroup, end = std::min(first + kGroup, pieces_.size());
      for (size_t i = first; i < end; ++i) {
        const Piece& piece = pieces_[i];
        if (i == bestPiece && hint) continue;
        const Vec3d chord = piece.c[1] + piece.c[2] + piece.c[3], from = p - piece.c[0];
        const double foot = std::clamp(chord.dot(from) / chord.squaredNorm(), 0.0, 1.0);
        const double least = (from - foot * chord).norm() - piece.bulge;
        if (least > 0 && least * least >= best2) continue;
        const double t = descend(piece, p, foot);
        const double d2 = (piece.point(t) - p).squaredNorm();
        if (d2 < best2) {
          best2 = d2;
          bestPiece = static_cast<uint32_t>(i);
          bestT = t;
        }
      }
      continue;
    }
    const double a = boxes_[2 * node].distance2(p), b = boxes_[2 * node + 1].distance2(p);
    const std::pair<size_t, double> left{2 * node, a}, right{2 * node + 1, b};
    if (a < b) {
      if (b < best2) stack[depth++] = right;
      if (a < best2) stack[depth++] = left;
    } else {
      if (a < best2) stack[depth++] = left;
      if (b < best2) stack[depth++] = right;
    }
  }
  return finish(bestPiece, bestT, p);
}

double Polyline::arcLengthMm(const Place& place) const ARGIL_REALTIME {
  return starts_[place.piece] + pieces_[place.piece].arc(place.t);
}

Polyline::Place Polyline::at(double arcLengthMm) const ARGIL_REALTIME {
  const double wanted = std::clamp(arcLengthMm, 0.0, lengthMm());
  const auto after = std::upper_bound(starts_.begin() + 1, starts_.end() - 1, wanted);
  const size_t i = static_cast<size_t>(after - starts_.begin()) - 1;
  const double within = wanted - starts_[i], whole = starts_[i + 1] - starts_[i];
  double t = whole > 0 ? within / whole : 0;
  for (int k = 0; k < 8; ++k) {
    const double speed = pieces_[i].first(t).norm();
    if (speed > 0) t = std::clamp(t - (pieces_[i].arc(t) - within) / speed, 0.0, 1.0);
  }
  Place place = finish(static_cast<uint32_t>(i), t, pieces_[i].point(t));
  place.distance = 0;
  return place;
}

}  // namespace argil::haptics
