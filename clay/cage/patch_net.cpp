#include "clay/cage/patch_net.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace argil::clay {

namespace {

constexpr double kLeastBend = 0.5;  // radians: creases at a vertex that turn by less go straight on

// Sums of weights, one vertex once.
Weights tidy(Weights all) {
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  Weights out;
  for (const auto& each : all) {
    if (!out.empty() && out.back().first == each.first)
      out.back().second += each.second;
    else
      out.push_back(each);
  }
  return out;
}
class Sum {
 public:
  Sum& add(const Weights& weights, double share) {
    for (const auto& [vertex, weight] : weights) all_.emplace_back(vertex, share * weight);
    return *this;
  }
  [[nodiscard]] Weights done() const { return tidy(all_); }

 private:
  Weights all_;
};

// Of the control points along one side at a place: the first of four, and their weights.
struct Basis {
  int first;
  std::array<double, 5> weight;  // of first … first + 4; Bézier points between spans are means
};
Basis basisOf(double t, bool slope) {
  const int span = std::clamp(static_cast<int>(t), 0, kPatchSpans - 1);
  const double s = t - span, r = 1 - s;
  const std::array<double, 4> b =
      slope ? std::array<double, 4>{-3 * r * r, 3 * r * r - 6 * r * s, 6 * r * s - 3 * s * s, 3 * s * s}
            : std::array<double, 4>{r * r * r, 3 * r * r * s, 3 * r * s * s, s * s * s};
  Basis out{2 * span, {}};
  out.weight[1] = b[1];
  out.weight[2] = b[2];
  if (span == 0)
    out.weight[0] += b[0];
  else
    out.weight[0] += b[0] / 2, out.weight[1] += b[0] / 2;
  if (span == kPatchSpans - 1)
    out.weight[3] += b[3];
  else
    out.weight[2] += b[3] / 2, out.weight[3] += b[3] / 2;
  return out;
}

Vec3d evaluate(const PatchSurface& surface, uint32_t patch, const Basis& u, const Basis& v) {
  Vec3d sum = Vec3d::Zero();
  for (size_t a = 0; a < 4; ++a)
    for (size_t b = 0; b < 4; ++b)
      sum +=
          u.weight[a] * v.weight[b] * surface.points[surface.patches[patch][size_t(u.first) + a][size_t(v.first) + b]];
  return sum;
}

}  // namespace

Vec3d PatchSurface::at(uint32_t patch, double u, double v) const {
  return evaluate(*this, patch, basisOf(u, false), basisOf(v, false));
}
PatchSurface::Tangents PatchSurface::tangentsAt(uint32_t patch, double u, double v) const {
  return {evaluate(*this, patch, basisOf(u, true), basisOf(v, false)),
          evaluate(*this, patch, basisOf(u, false), basisOf(v, true))};
}

PatchNet::PatchNet(const QuadTopology& topology, const QuadMesh& cage) {
  const auto quads = static_cast<uint32_t>(topology.quads().size());
  const auto corners = static_cast<uint32_t>(topology.vertexCount());
  const auto edges = static_cast<uint32_t>(topology.edges().size());
  constexpr int kInner = 2 * kPatchSpans, kBetween = kPatchSpans - 1;  // control points, vertices of the net
  vertices_ = corners + kBetween * size_t{edges} + kBetween * kBetween * size_t{quads};
  firstEdge_ = corners;
  grid_.resize(quads);
  patches_.resize(quads);
  const uint32_t firstInner = corners + kInner * edges;
  for (uint32_t f = 0; f < quads; ++f) {
    for (int i = 0; i < kInner; ++i)
      for (int j = 0; j < kInner; ++j) inner(f, i, j) = firstInner + f * (kInner * kInner) + uint32_t(i * kInner + j);
    for (int i = 1; i < kPatchSpans; ++i)
      for (int j = 1; j < kPatchSpans; ++j)
        grid_[f][size_t(i)][size_t(j)] =
            corners + kBetween * edges + kBetween * kBetween * f + uint32_t((i - 1) * kBetween + j - 1);
    for (int s = 0; s < 4; ++s) {
      const uint32_t edge = topology.edgeOf(f, s);
      const bool forward = topology.edges()[edge].quad[0] == f && topology.edges()[edge].side[0] == s;
      const auto [i, j] = fromCorner(s, 0, 0, kPatchSpans + 1);
      grid_[f][size_t(i)][size_t(j)] = topology.quads()[f][size_t(s)];
      for (int p = 1; p < kPatchSpans; ++p) {
        const auto [x, y] = fromCorner(s, p, 0, kPatchSpans + 1);
        grid_[f][size_t(x)][size_t(y)] = corners + kBetween * edge + uint32_t(forward ? p - 1 : kBetween - p);
      }
      const auto [a, b] = fromCorner(s, 0, 0, kPatchPoints);
      patches_[f][size_t(a)][size_t(b)] = topology.quads()[f][size_t(s)];
      for (int p = 0; p < kInner; ++p) {
        const auto [x, y] = fromCorner(s, p + 1, 0, kPatchPoints);
        patches_[f][size_t(x)][size_t(y)] = edgePoint(edge, forward ? p : kInner - 1 - p);
      }
    }
  }

  points_.resize(firstInner + kInner * kInner * size_t{quads});
  for (uint32_t f = 0; f < quads; ++f)
    for (int i = 0; i < kInner; ++i)
      for (int j = 0; j < kInner; ++j) {
        const int x = i / 2 + (i & 1), y = j / 2 + (j & 1), ox = i / 2 + 1 - (i & 1), oy = j / 2 + 1 - (j & 1);
        const uint32_t own = vertex(f, x, y);
        const double n = own < corners && topology.creasesAt(own) == 0 ? double(topology.valence(own)) : 4;
        const double all = n + 5;
        points_[inner(f, i, j)] = tidy(
            {{own, n / all}, {vertex(f, ox, y), 2 / all}, {vertex(f, x, oy), 2 / all}, {vertex(f, ox, oy), 1 / all}});
      }
  for (uint32_t e = 0; e < edges; ++e) {
    const QuadTopology::Edge& edge = topology.edges()[e];
    for (int k = 0; k < kInner; ++k) {
      const auto [i, j] = fromCorner(edge.side[0], k, 0, kInner);
      const auto [x, y] = fromCorner(edge.side[1], kInner - 1 - k, 0, kInner);
      points_[edgePoint(e, k)] =
          Sum().add(points_[inner(edge.quad[0], i, j)], 0.5).add(points_[inner(edge.quad[1], x, y)], 0.5).done();
    }
  }
  for (uint32_t v = 0; v < corners; ++v) {
    Sum sum;
    const size_t n = topology.valence(v);
    for (size_t k = 0; k < n; ++k) {
      const QuadTopology::Spoke& spoke = topology.spokes(v)[k];
      const auto [i, j] = fromCorner(spoke.corner, 0, 0, kInner);
      sum.add(points_[inner(spoke.quad, i, j)], 1.0 / double(n));
    }
    points_[v] = sum.done();
  }
  placeCreases(topology, cage);
  for (uint32_t v = 0; v < corners; ++v) {
    const size_t n = topology.valence(v);
    if (topology.creasesAt(v) != 0)
      correctBeside(topology, cage, v);
    else if (n != 4)
      correctFan(topology, {v, 0, n, true, 2 * std::numbers::pi});
  }
}

// Creases are splines of their own vertices. One that goes through a vertex has it within, as a spline has its knots;
// else it ends there.
void PatchNet::placeCreases(const QuadTopology& topology, const QuadMesh& cage) {
  for (uint32_t e = 0; e < topology.edges().size(); ++e) {
    const QuadTopology::Edge& edge = topology.edges()[e];
    if (!edge.crease) continue;
    for (int k = 0; k < 2 * kPatchSpans; ++k) {
      const auto at = [&](int i) {
        const auto [x, y] = fromCorner(edge.side[0], i, 0, kPatchSpans + 1);
        return vertex(edge.quad[0], x, y);
      };
      const double second = k % 2 == 0 ? 1.0 / 3 : 2.0 / 3;
      points_[edgePoint(e, k)] = tidy({{at(k / 2), 1 - second}, {at(k / 2 + 1), second}});
    }
  }
  std::vector<bool> isEnd(topology.vertexCount());
  for (const uint32_t v : cage.corners) isEnd[v] = true;
  for (uint32_t v = 0; v < topology.vertexCount(); ++v) {
    const size_t creases = topology.creasesAt(v);
    if (creases == 0) continue;
    points_[v] = {{v, 1.0}};
    if (creases != 2 || isEnd[v]) continue;
    Sum sum;
    for (size_t k = 0; k < topology.valence(v); ++k) {
      const QuadTopology::Spoke& spoke = topology.spokes(v)[k];
      if (topology.edges()[spoke.edge].crease)
        sum.add(points_[edgePoint(spoke.edge, spoke.outward ? 0 : 2 * kPatchSpans - 1)], 0.5);
    }
    points_[v] = sum.done();
  }
}

void PatchNet::correctBeside(const QuadTopology& topology, const QuadMesh& cage, uint32_t vertex) {
  const size_t n = topology.valence(vertex);
  const QuadTopology::Spoke* spokes = topology.spokes(vertex);
  const bool isEnd = std::find(cage.corners.begin(), cage.corners.end(), vertex) != cage.corners.end();
  const bool isLine = topology.creasesAt(vertex) == 2 && !isEnd;
  const auto isCrease = [&](size_t k) { return topology.edges()[spokes[k % n].edge].crease; };
  std::vector<Fan> fans;
  std::vector<bool> straight(n);
  for (size_t first = 0; first < n; ++first) {
    if (!isCrease(first)) continue;
    Fan fan{vertex, first, 1, false, std::numbers::pi};
    while (!isCrease(first + fan.quads)) ++fan.quads;
    // Of one quad nothing is asked; two beside a line are as two in a row anywhere.
    if (fan.quads < 2 || (isLine && fan.quads == 2)) continue;
    if (!isLine) fan.angle = std::clamp(angleOf(topology, cage, fan), kLeastBend, 2 * std::numbers::pi - kLeastBend);
    // Where one crease goes straight on into the other there is no plane of both; they become one line, unless one of
    // them is part of another already.
    const size_t ends[2] = {first, (first + fan.quads) % n};
    const double off = fan.angle - std::numbers::pi;
    const bool isStraight = !isLine && std::abs(off) < kLeastBend;
    if (isStraight && (straight[ends[0]] || straight[ends[1]])) {
      fan.angle = std::numbers::pi + (off < 0 ? -kLeastBend : kLeastBend);
    } else if (isStraight) {
      fan.angle = std::numbers::pi;
      straight[ends[0]] = straight[ends[1]] = true;
      const auto end = [&](size_t k) {
        const QuadTopology::Spoke& spoke = spokes[k];
        return edgePoint(spoke.edge, spoke.outward ? 0 : 2 * kPatchSpans - 1);
      };
      const uint32_t a = end(ends[0]), b = end(ends[1]);
      const Weights half = Sum().add(points_[a], 0.5).add(points_[b], -0.5).done();
      points_[a] = Sum().add(points_[vertex], 1).add(half, 1).done();
      points_[b] = Sum().add(points_[vertex], 1).add(half, -1).done();
    }
    fans.push_back(fan);
  }
  for (Fan& fan : fans) {
    // Of two creases that were made straight the other side is half a turn as well.
    if (straight[fan.first] && straight[(fan.first + fan.quads) % n] && topology.creasesAt(vertex) == 2)
      fan.angle = std::numbers::pi;
    correctFan(topology, fan);
  }
}

double PatchNet::angleOf(const QuadTopology& topology, const QuadMesh& cage, const Fan& fan) {
  double angle = 0;
  for (size_t k = 0; k < fan.quads; ++k) {
    const QuadTopology::Spoke& spoke = topology.spokes(fan.vertex)[(fan.first + k) % topology.valence(fan.vertex)];
    const auto& q = topology.quads()[spoke.quad];
    const Vec3d at = cage.positions[fan.vertex], a = cage.positions[q[size_t(spoke.corner + 1) & 3]] - at,
                b = cage.positions[q[size_t(spoke.corner + 3) & 3]] - at;
    angle += std::atan2(a.cross(b).norm(), a.dot(b));
  }
  return angle;
}

// c0 … c3: the side's Bézier points in the span beside the vertex; a, b the rows of control points on either side of
// it. One tangent plane: a_i + b_i − 2 c_i = (2/3) λ0 e0, (2/9) λ0 e1, 0, 0, where e0, e1 are the differences of the
// quadratic's control points. Between two creases the outer edges are given, and nothing is asked across them.
void PatchNet::correctFan(const QuadTopology& topology, const Fan& fan) {
  constexpr int kInner = 2 * kPatchSpans;
  const size_t n = fan.quads, all = topology.valence(fan.vertex);
  const QuadTopology::Spoke* around = topology.spokes(fan.vertex);
  const auto spoke = [&](size_t k) -> const QuadTopology::Spoke& { return around[(fan.first + k) % all]; };
  const Weights c0 = points_[fan.vertex];
  const size_t begin = fan.closed ? 0 : 1;  // edges with a quad of the fan on either side: begin … n − 1
  // Control point k of a side, counted from the vertex; and those beside it, in the quads behind and before the edge.
  const auto side = [&](size_t k, int i) { return edgePoint(spoke(k).edge, spoke(k).outward ? i : kInner - 1 - i); };
  const auto after = [&](size_t k, int i) {
    const auto [x, y] = fromCorner(spoke(k).corner, i, 0, kInner);
    return inner(spoke(k).quad, x, y);
  };
  const auto before = [&](size_t k, int i) {
    const QuadTopology::Spoke& last = spoke((k + n - 1) % n);
    const auto [x, y] = fromCorner(last.corner, 0, i, kInner);
    return inner(last.quad, x, y);
  };
  const double step = fan.angle / double(n);
  std::vector<Weights> c1(n);
  if (fan.closed) {
    // Ends of side curves in one plane, as an affine regular polygon.
    for (size_t k = 0; k < n; ++k) {
      Sum sum;
      double rest = 1;
      for (size_t j = 0; j < n; ++j) {
        const double share = 2.0 / double(n) * std::cos(2 * std::numbers::pi * (double(k) - double(j)) / double(n));
        sum.add(points_[side(j, 0)], share);
        rest -= share;
      }
      c1[k] = sum.add(c0, rest).done();
    }
  } else if (fan.angle == std::numbers::pi) {
    // On half of one, whose other axis is the one nearest to where they end now.
    const auto sine = [&](size_t k) { return std::sin(double(k) * step); };
    const auto cosine = [&](size_t k) { return std::cos(double(k) * step); };
    const Weights along = Sum().add(points_[side(0, 0)], 1).add(c0, -1).done();
    Sum across;
    double squares = 0;
    for (size_t k = 1; k < n; ++k) {
      across.add(points_[side(k, 0)], sine(k)).add(c0, -sine(k)).add(along, -sine(k) * cosine(k));
      squares += sine(k) * sine(k);
    }
    const Weights other = across.done();
    for (size_t k = 1; k < n; ++k) c1[k] = Sum().add(c0, 1).add(along, cosine(k)).add(other, sine(k) / squares).done();
  } else {
    // In the plane of the two creases.
    for (size_t k = 1; k < n; ++k) {
      const double from = std::sin((double(n) - double(k)) * step) / std::sin(fan.angle),
                   to = std::sin(double(k) * step) / std::sin(fan.angle);
      c1[k] = Sum().add(c0, 1 - from - to).add(points_[side(0, 0)], from).add(points_[side(n, 0)], to).done();
    }
  }
  for (size_t k = begin; k < n; ++k) points_[side(k, 0)] = c1[k];
  // Of an even valence alternating sums of the curves' third points must vanish; they move with the third control point
  // by 0.6 of it.
  if (fan.closed && n % 2 == 0) {
    Weights alternating;
    {
      Sum sum;
      for (size_t k = 0; k < n; ++k) {
        const double sign = k % 2 == 0 ? 1 : -1;
        sum.add(points_[side(k, 2)], 0.6 * sign).add(c1[k], 0.6 * sign);
      }
      alternating = sum.done();
    }
    for (size_t k = 0; k < n; ++k) {
      const double share = (k % 2 == 0 ? -1.0 : 1.0) / (0.6 * double(n));
      for (const uint32_t point : {side(k, 2), after(k, 2), before(k, 2)})
        points_[point] = Sum().add(points_[point], 1).add(alternating, share).done();
    }
  }
  const double lambda = 2 * std::cos(step);
  std::vector<Weights> twists(n);  // what the two control points beside c1 must add up to
  for (size_t k = begin; k < n; ++k) {
    // The third difference vanishes: c3 − 3 c2 + 3 c1 − c0 = 0, and c3 is the mean of c2 and the point behind it.
    const Weights third = points_[side(k, 2)];
    const Weights c2 = Sum().add(third, 0.2).add(c1[k], 1.2).add(c0, -0.4).done();
    const uint32_t a = after(k, 1), b = before(k, 1);
    const Weights move = Sum().add(c2, 1).add(points_[a], -0.5).add(points_[b], -0.5).done();
    points_[a] = Sum().add(points_[a], 1).add(move, 1).done();
    points_[b] = Sum().add(points_[b], 1).add(move, 1).done();
    points_[side(k, 1)] = c2;
    const Weights c3 = Sum().add(c2, 0.5).add(third, 0.5).done();
    const Weights e1 = Sum().add(c3, 1).add(c1[k], -1.5).add(c0, 0.5).done();
    twists[k] = Sum().add(c1[k], 2).add(e1, 2.0 / 9 * lambda).done();
  }
  // Corner points x_k of the quads: x_{k−1} + x_k = twist k, as near to what they were as can be. What is missing at
  // each edge is d_k; the corrections y with y_{k−1} + y_k = d_k.
  std::vector<Weights> missing(n);
  for (size_t k = begin; k < n; ++k)
    missing[k] = Sum().add(twists[k], 1).add(points_[after(k, 0)], -1).add(points_[before(k, 0)], -1).done();
  // Between creases there is one edge less than quads, and the least corrections are those of the pseudoinverse.
  Eigen::MatrixXd least;
  if (!fan.closed) {
    const auto count = Eigen::Index(n);
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(count - 1, count);
    for (Eigen::Index k = 0; k + 1 < count; ++k) sums(k, k) = sums(k, k + 1) = 1;
    least = sums.transpose() * (sums * sums.transpose()).inverse();
  }
  for (size_t k = 0; k < n; ++k) {
    Sum y;
    if (!fan.closed) {
      for (size_t m = 1; m < n; ++m) y.add(missing[m], least(Eigen::Index(k), Eigen::Index(m) - 1));
    } else if (n % 2 == 1) {
      // y_k = ½ Σ_m (−1)^m d_{k+1+m}, m from 0 to n − 1, backwards around: the only one there is.
      for (size_t m = 0; m < n; ++m) y.add(missing[(k + 1 + m) % n], m % 2 == 0 ? 0.5 : -0.5);
    } else {
      // The least of them: y_k = Σ_m (−1)^m (n − 1 − 2 m) / (2 n) · d_{k+1+m}.
      for (size_t m = 0; m < n; ++m)
        y.add(missing[(k + 1 + m) % n], (m % 2 == 0 ? 1.0 : -1.0) * (double(n) - 1 - 2 * double(m)) / (2 * double(n)));
    }
    twists[k] = y.done();
  }
  for (size_t k = 0; k < n; ++k) {
    const uint32_t x = after(k, 0);
    points_[x] = Sum().add(points_[x], 1).add(twists[k], 1).done();
  }
}

Weights PatchNet::at(uint32_t patch, double u, double v) const {
  const Basis a = basisOf(u, false), b = basisOf(v, false);
  Sum sum;
  for (size_t i = 0; i < 4; ++i)
    for (size_t j = 0; j < 4; ++j)
      sum.add(points_[patches_[patch][size_t(a.first) + i][size_t(b.first) + j]], a.weight[i] * b.weight[j]);
  return sum.done();
}

}  // namespace argil::clay
