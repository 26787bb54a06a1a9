#include "clay/unwrap/charts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <queue>
#include <set>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "clay/base/error.h"
#include "clay/base/joined_sets.h"
#include "clay/base/parallel.h"

namespace argil::clay {

namespace {

constexpr size_t kQuadsOfPart = 25, kLeastParts = 40, kMostParts = 160;  // of the first parts
constexpr int kMoves = 8, kSweeps = 10;                                  // of their middles, and over their seams
constexpr int kTryRounds = 12, kLastRounds = 60;                         // of laying flat

// What is asked of a chart, less and less until there are few: of the stretch that is allowed, and how much of its
// convex hull it fills and of the whole surface it may be, since charts that are compact and none too large lie close
// together.
constexpr double kPartFilled = 0.7;
constexpr double kLeastHeight = 1e-5;  // of a triangle's side
constexpr double kLeastSide = 1e-4;    // of a mean quad's
struct Step {
  double stretch, filled, share;
};
constexpr std::array kSteps = {Step{0.2, 0.85, 0.12}, Step{0.5, 0.8, 0.16}, Step{1, 0.75, 0.2}, Step{1, 0.6, 0.25},
                               Step{1, 0, 1}};

Vec3d areaOf(const std::array<Vec3d, 4>& c) {
  return 0.5 * (c[2] - c[0]).cross(c[3] - c[1]);
}

double turn(const Vec2d& a, const Vec2d& b, const Vec2d& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

// Two triangles beside each other keep all their lengths; what has no length or no height gets a little.
FlatDisk unfolded(const SurfaceDisk& disk, double least) {
  FlatDisk flat;
  flat.places.assign(disk.positions.size(), Vec2d::Zero());
  const auto lengthOf = [&](uint32_t a, uint32_t b) {
    return std::max(least, (disk.positions[b] - disk.positions[a]).norm());
  };
  // The third corner, to the left of the way from one to another.
  const auto third = [&](uint32_t a, uint32_t b, uint32_t c) -> Vec2d {
    const Vec3d way = disk.positions[b] - disk.positions[a], other = disk.positions[c] - disk.positions[a];
    const double length = lengthOf(a, b), along = other.dot(way) / length;
    const double up = std::max(way.cross(other).norm() / length, kLeastHeight * length);
    const Vec2d x = (flat.places[b] - flat.places[a]).normalized();
    return flat.places[a] + along * x + up * Vec2d(-x.y(), x.x());
  };
  const auto &one = disk.triangles[0], &other = disk.triangles[1];
  flat.places[one[1]] = {lengthOf(one[0], one[1]), 0};
  flat.places[one[2]] = third(one[0], one[1], one[2]);
  for (size_t s = 0; s < 3; ++s)
    if (std::find(one.begin(), one.end(), other[(s + 2) % 3]) == one.end())
      flat.places[other[(s + 2) % 3]] = third(other[s], other[(s + 1) % 3], other[(s + 2) % 3]);
  return flat;
}

// Of the convex hull (Andrew's chains).
double filledOf(const SurfaceDisk& disk, const FlatDisk& flat) {
  std::vector<Vec2d> points;
  double own = 0;
  for (size_t i = 0; i < disk.boundary.size(); ++i) {
    points.push_back(flat.places[disk.boundary[i]]);
    const Vec2d& next = flat.places[disk.boundary[(i + 1) % disk.boundary.size()]];
    own += 0.5 * (points.back().x() * next.y() - points.back().y() * next.x());
  }
  std::sort(points.begin(), points.end(),
            [](const Vec2d& a, const Vec2d& b) { return std::tie(a.x(), a.y()) < std::tie(b.x(), b.y()); });
  double hull = 0;
  for (int side = 0; side < 2; ++side) {
    std::vector<Vec2d> chain;
    for (const Vec2d& p : points) {
      while (chain.size() > 1 && turn(chain[chain.size() - 2], chain.back(), p) <= 0) chain.pop_back();
      chain.push_back(p);
    }
    for (size_t i = 0; i + 1 < chain.size(); ++i)
      hull += 0.5 * (chain[i].x() * chain[i + 1].y() - chain[i].y() * chain[i + 1].x());
    std::reverse(points.begin(), points.end());
  }
  return own / hull;
}

class Charts {
 public:
  Charts(const QuadMesh& mesh, double stretch, int threads)
      : mesh_(mesh), stretch_(stretch), threads_(threads), topology_(mesh.positions.size(), mesh.quads) {
    joined_.assign(topology_.edges().size(), false);
    for (uint32_t f = 0; f < mesh.quads.size(); ++f) {
      const Vec3d area = areaOf(cornersOf(f));
      size_.push_back(area.norm());
      normal_.push_back(size_.back() > 0 ? Vec3d(area / size_.back()) : Vec3d::UnitZ());
    }
    const double whole = std::accumulate(size_.begin(), size_.end(), 0.0);
    if (!(whole > 0)) throw Error("a mesh without an area cannot be laid flat");
    least_ = kLeastSide * std::sqrt(whole / double(size_.size()));
  }

  std::vector<Chart> make(size_t few, const WorkPart& part) {
    firstParts(part.part(0, 0.2));
    double from = 0.2;
    for (const Step& step : kSteps) {
      const double to = from + 0.7 / double(kSteps.size());
      joinUpTo({1 + step.stretch * (stretch_ - 1), step.filled, step.share}, few, part.part(from, to));
      from = to;
    }
    std::vector<Chart> out;
    for (auto& each : charts_)
      if (each) out.push_back(std::move(*each));
    for (Chart& each : out) {
      part.step(0.9);
      if (each.quads.size() == 1) continue;  // it has its lengths
      auto flat = laidFlat(each.disk, kLastRounds);
      if (flat && flat->stretch <= each.flat.stretch && !crossesItself(flat->places, each.disk.boundary))
        each.flat = std::move(*flat);
    }
    return out;
  }

 private:
  [[nodiscard]] std::array<Vec3d, 4> cornersOf(uint32_t quad) const {
    const auto& q = mesh_.quads[quad];
    return {mesh_.positions[q[0]], mesh_.positions[q[1]], mesh_.positions[q[2]], mesh_.positions[q[3]]};
  }
  [[nodiscard]] uint32_t across(uint32_t quad, int side) const {
    const QuadTopology::Edge& edge = topology_.edges()[topology_.edgeOf(quad, side)];
    return edge.quad[0] == quad ? edge.quad[1] : edge.quad[0];
  }
  [[nodiscard]] double lengthOf(uint32_t edge) const {
    const QuadTopology::Edge& e = topology_.edges()[edge];
    return (mesh_.positions[e.from] - mesh_.positions[e.to]).norm();
  }

  // --- The first parts: quads that face about the same way, each part connected.

  void firstParts(const WorkPart& part) {
    const size_t quads = mesh_.quads.size();
    const size_t wanted = std::clamp<size_t>(quads / kQuadsOfPart, std::min(quads, kLeastParts), kMostParts);
    std::vector<uint32_t> seeds = spread(wanted);
    std::vector<uint32_t> label;
    for (int move = 0; move < kMoves; ++move) {
      part.step(0.5 * move / kMoves);
      label = grown(seeds);
      moveTo(label, seeds);
    }
    label = grown(seeds);
    evenOut(label);
    const std::vector<std::vector<uint32_t>> parts = connected(label);
    chartOf_.assign(quads, UINT32_MAX);
    for (size_t i = 0; i < parts.size(); ++i) {
      part.step(0.5 + 0.5 * double(i) / double(parts.size()));
      addFlat(parts[i]);
    }
  }

  // Quads that are far from each other, one in each body at least.
  std::vector<uint32_t> spread(size_t wanted) const {
    std::vector<double> far(mesh_.quads.size(), INFINITY);
    std::vector<uint32_t> seeds;
    using Entry = std::pair<double, uint32_t>;
    uint32_t next = 0;
    while (seeds.size() < wanted || far[next] == INFINITY) {
      seeds.push_back(next);
      std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
      far[next] = 0;
      queue.push({0, next});
      while (!queue.empty()) {
        const auto [distance, quad] = queue.top();
        queue.pop();
        if (distance > far[quad]) continue;
        for (int s = 0; s < 4; ++s) {
          const uint32_t to = across(quad, s);
          const double more = distance + std::sqrt(size_[to]) * (1 + 4 * (normal_[quad] - normal_[to]).squaredNorm());
          if (more < far[to]) far[to] = more, queue.push({more, to});
        }
      }
      next = static_cast<uint32_t>(std::max_element(far.begin(), far.end()) - far.begin());
      if (far[next] == 0) break;
    }
    return seeds;
  }

  std::vector<uint32_t> grown(const std::vector<uint32_t>& seeds) const {
    std::vector<Vec3d> facing;
    for (const uint32_t seed : seeds) facing.push_back(normal_[seed]);
    return grown(seeds, facing_.size() == seeds.size() ? facing_ : facing);
  }
  // Each quad to the part that it is like, from the seeds outwards (Cohen-Steiner and others 2004).
  std::vector<uint32_t> grown(const std::vector<uint32_t>& seeds, const std::vector<Vec3d>& facing) const {
    using Entry = std::tuple<double, uint32_t, uint32_t>;  // cost, quad, part
    std::vector<uint32_t> label(mesh_.quads.size(), UINT32_MAX);
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    for (uint32_t i = 0; i < seeds.size(); ++i) queue.push({-1, seeds[i], i});
    while (!queue.empty()) {
      const auto [cost, quad, part] = queue.top();
      queue.pop();
      if (label[quad] != UINT32_MAX) continue;
      label[quad] = part;
      for (int s = 0; s < 4; ++s) {
        const uint32_t to = across(quad, s);
        if (label[to] == UINT32_MAX) queue.push({size_[to] * (normal_[to] - facing[part]).squaredNorm(), to, part});
      }
    }
    return label;
  }
  // Each seed to the quad that is most like its part.
  void moveTo(const std::vector<uint32_t>& label, std::vector<uint32_t>& seeds) {
    facing_.assign(seeds.size(), Vec3d::Zero());
    for (uint32_t f = 0; f < label.size(); ++f) facing_[label[f]] += size_[f] * normal_[f];
    for (Vec3d& each : facing_) each = each.norm() > 0 ? Vec3d(each.normalized()) : Vec3d::UnitX();
    std::vector<double> best(seeds.size(), INFINITY);
    for (uint32_t f = 0; f < label.size(); ++f) {
      const double off = (normal_[f] - facing_[label[f]]).squaredNorm();
      if (off < best[label[f]]) best[label[f]] = off, seeds[label[f]] = f;
    }
  }

  // Seams become shorter: a quad goes to the part that it shares more of its outline with than with its own.
  void evenOut(std::vector<uint32_t>& label) const {
    for (int sweep = 0, moved = 1; sweep < kSweeps && moved > 0; ++sweep) {
      moved = 0;
      for (uint32_t f = 0; f < label.size(); ++f) {
        std::map<uint32_t, double> shared;
        for (int s = 0; s < 4; ++s) shared[label[across(f, s)]] += lengthOf(topology_.edgeOf(f, s));
        const auto most = std::max_element(shared.begin(), shared.end(),
                                           [](const auto& a, const auto& b) { return a.second < b.second; });
        if (most->second > (1 + 1e-9) * shared[label[f]]) label[f] = most->first, ++moved;
      }
    }
  }
  std::vector<std::vector<uint32_t>> connected(const std::vector<uint32_t>& label) const {
    std::vector<std::vector<uint32_t>> parts;
    std::vector<bool> seen(label.size(), false);
    for (uint32_t first = 0; first < label.size(); ++first) {
      if (seen[first]) continue;
      std::vector<uint32_t> part = {first};
      seen[first] = true;
      for (size_t i = 0; i < part.size(); ++i)
        for (int s = 0; s < 4; ++s) {
          const uint32_t to = across(part[i], s);
          if (!seen[to] && label[to] == label[first]) seen[to] = true, part.push_back(to);
        }
      std::sort(part.begin(), part.end());
      parts.push_back(std::move(part));
    }
    return parts;
  }

  // A part as a chart; where it cannot be laid flat within the stretch, its halves.
  void addFlat(std::vector<uint32_t> quads) {
    joinAsDisk(quads);
    std::optional<Chart> chart = chartOf(quads);
    if (chart && quads.size() == 1) chart->flat = unfolded(chart->disk, least_);
    if (chart && (quads.size() == 1 || layFlat(*chart, {stretch_, quads.size() < 4 ? 0 : kPartFilled, 1}))) {
      for (const uint32_t f : quads) chartOf_[f] = static_cast<uint32_t>(charts_.size());
      charts_.push_back(std::move(chart));
      ++alive_;
      return;
    }
    for (const uint32_t f : quads)
      for (int s = 0; s < 4; ++s) joined_[topology_.edgeOf(f, s)] = false;
    for (auto& half : halves(quads)) addFlat(std::move(half));
  }

  // By steps from two ends; each connected.
  std::array<std::vector<uint32_t>, 2> halves(const std::vector<uint32_t>& quads) const {
    const auto farthest = [&](uint32_t from) {
      std::map<uint32_t, int> steps = {{from, 0}};
      std::vector<uint32_t> order = {from};
      for (size_t i = 0; i < order.size(); ++i)
        for (int s = 0; s < 4; ++s) {
          const uint32_t to = across(order[i], s);
          if (std::binary_search(quads.begin(), quads.end(), to) && steps.emplace(to, steps[order[i]] + 1).second)
            order.push_back(to);
        }
      return order.back();
    };
    const uint32_t one = farthest(quads.front()), other = farthest(one);
    std::map<uint32_t, int> side = {{one, 0}, {other, 1}};
    std::vector<uint32_t> order = {one, other};
    for (size_t i = 0; i < order.size(); ++i)
      for (int s = 0; s < 4; ++s) {
        const uint32_t to = across(order[i], s);
        if (std::binary_search(quads.begin(), quads.end(), to) && side.emplace(to, side[order[i]]).second)
          order.push_back(to);
      }
    std::array<std::vector<uint32_t>, 2> out;
    for (const auto& [quad, half] : side) out[size_t(half)].push_back(quad);
    return out;
  }

  // --- What is joined.

  // Joins all quads of a connected part, as far as it stays a disk: first as a tree, flattest edges first, then what is
  // beside a joined edge and would only be a slit.
  void joinAsDisk(const std::vector<uint32_t>& quads) {
    std::vector<std::tuple<double, uint32_t>> inner;
    for (const uint32_t f : quads)
      for (int s = 0; s < 4; ++s) {
        const uint32_t edge = topology_.edgeOf(f, s), to = across(f, s);
        if (to > f && std::binary_search(quads.begin(), quads.end(), to))
          inner.push_back({-normal_[f].dot(normal_[to]), edge});
      }
    std::sort(inner.begin(), inner.end());
    JoinedSets disk(quads.size());
    const auto place = [&](uint32_t f) {
      return static_cast<uint32_t>(std::lower_bound(quads.begin(), quads.end(), f) - quads.begin());
    };
    for (const auto& [cost, edge] : inner) {
      const auto& e = topology_.edges()[edge];
      if (disk.join(place(e.quad[0]), place(e.quad[1]))) joined_[edge] = true;
    }
    // A slit's end: a vertex around which all other edges are joined.
    std::set<uint32_t> vertices;
    for (const uint32_t f : quads) vertices.insert(mesh_.quads[f].begin(), mesh_.quads[f].end());
    std::vector<uint32_t> todo(vertices.begin(), vertices.end());
    while (!todo.empty()) {
      const uint32_t v = todo.back();
      todo.pop_back();
      uint32_t open = UINT32_MAX;
      int count = 0;
      for (size_t k = 0; k < topology_.valence(v); ++k) {
        const uint32_t edge = topology_.spokes(v)[k].edge;
        if (!joined_[edge]) open = edge, ++count;
      }
      if (count != 1) continue;
      const auto& e = topology_.edges()[open];
      const uint32_t other = e.from == v ? e.to : e.from;
      joined_[open] = true;
      todo.push_back(other);
    }
  }

  // Also along edges that are no more than tried; sorted.
  [[nodiscard]] bool isJoined(uint32_t edge, const std::vector<uint32_t>& tried) const {
    return joined_[edge] || std::binary_search(tried.begin(), tried.end(), edge);
  }

  // The quads as they are joined; none where that is no disk.
  std::optional<Chart> chartOf(std::vector<uint32_t> quads, const std::vector<uint32_t>& tried = {}) const {
    Chart chart;
    chart.quads = std::move(quads);
    std::unordered_map<uint32_t, uint32_t> placeOf;
    for (uint32_t i = 0; i < chart.quads.size(); ++i) placeOf[chart.quads[i]] = i;
    // Corners that are one vertex: those that meet across joined edges.
    JoinedSets corners(4 * chart.quads.size());
    for (uint32_t i = 0; i < chart.quads.size(); ++i)
      for (uint32_t s = 0; s < 4; ++s) {
        const uint32_t edge = topology_.edgeOf(chart.quads[i], int(s));
        const auto& e = topology_.edges()[edge];
        if (!isJoined(edge, tried) || e.quad[0] != chart.quads[i] || e.side[0] != s) continue;
        const uint32_t other = placeOf.at(e.quad[1]), side = e.side[1];
        corners.join(4 * i + s, 4 * other + ((side + 1) & 3));
        corners.join(4 * i + ((s + 1) & 3), 4 * other + side);
      }
    std::vector<uint32_t> vertexOf(4 * chart.quads.size(), UINT32_MAX);
    chart.vertices.resize(chart.quads.size());
    for (uint32_t c = 0; c < vertexOf.size(); ++c) {
      uint32_t& vertex = vertexOf[corners.find(c)];
      if (vertex == UINT32_MAX) {
        vertex = static_cast<uint32_t>(chart.disk.positions.size());
        chart.disk.positions.push_back(mesh_.positions[mesh_.quads[chart.quads[c / 4]][c % 4]]);
      }
      chart.vertices[c / 4][c % 4] = vertex;
    }
    // One boundary through all that are on one.
    std::vector<uint32_t> next(chart.disk.positions.size(), UINT32_MAX);
    size_t open = 0;
    for (uint32_t i = 0; i < chart.quads.size(); ++i)
      for (uint32_t s = 0; s < 4; ++s)
        if (!isJoined(topology_.edgeOf(chart.quads[i], int(s)), tried)) {
          next[chart.vertices[i][s]] = chart.vertices[i][(s + 1) & 3];
          ++open;
        }
    const auto first = std::find_if(next.begin(), next.end(), [](uint32_t v) { return v != UINT32_MAX; });
    if (first == next.end()) return std::nullopt;
    uint32_t at = static_cast<uint32_t>(first - next.begin());
    for (size_t i = 0; i < open; ++i, at = next[at]) {
      if (at == UINT32_MAX) return std::nullopt;
      chart.disk.boundary.push_back(at);
    }
    if (at != chart.disk.boundary.front()) return std::nullopt;
    for (uint32_t i = 0; i < chart.quads.size(); ++i)
      for (const auto& t : trianglesOf(cornersOf(chart.quads[i])))
        chart.disk.triangles.push_back({chart.vertices[i][t[0]], chart.vertices[i][t[1]], chart.vertices[i][t[2]]});
    return chart;
  }

  // Sides that are next to nothing are left to quads that stay alone: numbers do not suffice for them.
  bool layFlat(Chart& chart, const Step& asked) const {
    for (const auto& t : chart.disk.triangles)
      for (size_t s = 0; s < 3; ++s)
        if ((chart.disk.positions[t[s]] - chart.disk.positions[t[(s + 1) % 3]]).norm() < least_) return false;
    auto flat = laidFlat(chart.disk, kTryRounds);
    if (!flat || !(flat->stretch <= asked.stretch) || filledOf(chart.disk, *flat) < asked.filled ||
        crossesItself(flat->places, chart.disk.boundary))
      return false;
    chart.flat = std::move(*flat);
    return true;
  }

  // --- Charts become one.

  // The longest run of edges that two charts share, one behind the other on the boundaries of both.
  std::vector<uint32_t> sharedRun(uint32_t a, uint32_t b, double& length) const {
    const Chart &one = *charts_[a], &other = *charts_[b];
    // Boundary sides in order, as edges, and the chart across.
    std::unordered_map<uint32_t, uint32_t> follows;  // of edges to b: the edge before them on b's boundary
    const auto edges = [&](const Chart& chart) {
      std::unordered_map<uint32_t, uint32_t> leaving;  // vertex of the chart: edge of the mesh
      for (uint32_t i = 0; i < chart.quads.size(); ++i)
        for (uint32_t s = 0; s < 4; ++s) {
          const uint32_t edge = topology_.edgeOf(chart.quads[i], int(s));
          if (!joined_[edge]) leaving[chart.vertices[i][s]] = edge;
        }
      std::vector<uint32_t> list;
      for (const uint32_t v : chart.disk.boundary) list.push_back(leaving.at(v));
      return list;
    };
    const std::vector<uint32_t> ours = edges(one), theirs = edges(other);
    const auto between = [&](uint32_t edge) {
      const auto& e = topology_.edges()[edge];
      const uint32_t p = chartOf_[e.quad[0]], q = chartOf_[e.quad[1]];
      return (p == a && q == b) || (p == b && q == a);
    };
    for (size_t i = 0; i < theirs.size(); ++i) follows[theirs[i]] = theirs[(i + theirs.size() - 1) % theirs.size()];
    // Begin where a run begins.
    const size_t count = ours.size();
    const auto goesOn = [&](size_t i) {  // side i is of the run of the side before it
      const uint32_t before = ours[(i + count - 1) % count], edge = ours[i % count];
      return between(before) && between(edge) && follows.at(before) == edge;
    };
    size_t begin = 0;
    while (begin < count && goesOn(begin)) ++begin;
    std::vector<uint32_t> best, run;
    length = 0;
    double now = 0;
    for (size_t i = 0; i < count; ++i) {
      const uint32_t edge = ours[(begin + i) % count];
      if (i == 0 || !goesOn((begin + i) % count)) run.clear(), now = 0;
      if (!between(edge)) continue;
      run.push_back(edge);
      now += lengthOf(edge);
      if (now > length) length = now, best = run;
    }
    // All around: one stays open, or the two would have no boundary.
    if (best.size() == count && best.size() == theirs.size()) length -= lengthOf(best.back()), best.pop_back();
    return best;
  }

  void joinUpTo(const Step& asked, size_t few, const WorkPart& part) {
    std::set<std::pair<uint32_t, uint32_t>> refused;
    const size_t begun = alive_;
    // The smallest first, with the neighbour that it shares most of its boundary with.
    std::set<std::pair<double, uint32_t>> bySize;
    const auto sizeOf = [&](uint32_t chart) {
      double sum = 0;
      for (const uint32_t f : charts_[chart]->quads) sum += size_[f];
      return sum;
    };
    for (uint32_t c = 0; c < charts_.size(); ++c)
      if (charts_[c]) bySize.insert({sizeOf(c), c});
    const double whole = std::accumulate(size_.begin(), size_.end(), 0.0);
    while (!bySize.empty() && alive_ > few) {
      part.step(1 - double(alive_) / double(begun + 1));
      const uint32_t a = bySize.begin()->second;
      bySize.erase(bySize.begin());
      std::set<uint32_t> beside;
      for (const uint32_t f : charts_[a]->quads)
        for (int s = 0; s < 4; ++s) beside.insert(chartOf_[across(f, s)]);
      beside.erase(a);
      std::vector<std::tuple<double, uint32_t, std::vector<uint32_t>>> choices;
      for (const uint32_t b : beside) {
        if (refused.count(std::minmax(a, b))) continue;
        double length = 0;
        std::vector<uint32_t> run = sharedRun(a, b, length);
        double turn = 0;
        for (const uint32_t edge : run) {
          const auto& e = topology_.edges()[edge];
          turn += lengthOf(edge) * (1 - normal_[e.quad[0]].dot(normal_[e.quad[1]]));
        }
        if (!run.empty()) choices.push_back({turn - length, b, std::move(run)});
      }
      std::sort(choices.begin(), choices.end());
      std::erase_if(choices,
                    [&](const auto& choice) { return sizeOf(a) + sizeOf(std::get<1>(choice)) > asked.share * whole; });
      std::vector<std::optional<Chart>> tried(choices.size());
      parallelBlocks(
          choices.size(), threads_,
          [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i)
              tried[i] = joinedChart(a, std::get<1>(choices[i]), std::get<2>(choices[i]), asked);
          },
          1);
      // The one that gives the most compact chart.
      std::optional<Chart> best;
      double filled = -1;
      uint32_t with = 0;
      const std::vector<uint32_t>* along = nullptr;
      for (size_t i = 0; i < choices.size(); ++i) {
        const auto& [cost, b, run] = choices[i];
        std::optional<Chart>& both = tried[i];
        if (!both) refused.insert(std::minmax(a, b));
        if (!both || filledOf(both->disk, both->flat) <= filled) continue;
        filled = filledOf(both->disk, both->flat);
        best = std::move(both), with = b, along = &run;
      }
      if (!best) continue;
      for (const uint32_t edge : *along) joined_[edge] = true;
      // What was refused of either is open again.
      std::erase_if(refused, [&](const auto& pair) {
        return pair.first == a || pair.second == a || pair.first == with || pair.second == with;
      });
      bySize.erase({sizeOf(with), with});
      for (const uint32_t f : best->quads) chartOf_[f] = a;
      charts_[a] = std::move(best);
      charts_[with].reset();
      --alive_;
      bySize.insert({sizeOf(a), a});
    }
  }

  // Two charts joined along a run of edges, if that is what was asked. Any thread.
  std::optional<Chart> joinedChart(uint32_t a, uint32_t b, std::vector<uint32_t> run, const Step& asked) const {
    std::sort(run.begin(), run.end());
    std::vector<uint32_t> quads;
    std::merge(charts_[a]->quads.begin(), charts_[a]->quads.end(), charts_[b]->quads.begin(), charts_[b]->quads.end(),
               std::back_inserter(quads));
    std::optional<Chart> chart = chartOf(std::move(quads), run);
    if (chart && !layFlat(*chart, asked)) chart.reset();
    return chart;
  }

  const QuadMesh& mesh_;
  double stretch_, least_ = 0;
  int threads_;
  QuadTopology topology_;
  std::vector<bool> joined_;
  std::vector<Vec3d> normal_, facing_;
  std::vector<double> size_;
  std::vector<uint32_t> chartOf_;
  std::vector<std::optional<Chart>> charts_;
  size_t alive_ = 0;
};

}  // namespace

std::vector<Chart> chartsOf(const QuadMesh& mesh, double stretch, size_t few, int threads, const WorkPart& part) {
  return Charts(mesh, stretch, threads).make(few, part);
}

}  // namespace argil::clay
