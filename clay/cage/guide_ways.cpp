#include "clay/cage/guide_ways.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <queue>
#include <unordered_map>
#include <utility>

namespace argil::clay {

namespace {

constexpr double kStep = 0.5;     // of the mean side
constexpr int kMostSkipped = 12;  // such steps beside a line; a curve that stays there goes along it
constexpr double kAlongLine = 8;  // times as long is a side of a line, to a way that crosses it
constexpr size_t kMostWay = 400;  // vertices that are looked at between two places

}  // namespace

GuideWays::GuideWays(const TriangleMesh& mesh, const SurfaceCells& cells, const std::vector<bool>& creases,
                     double meanSide)
    : mesh_(mesh),
      tree_(mesh),
      creases_(creases),
      lines_(creases),
      meanSide_(meanSide),
      onLine_(mesh.positions.size()),
      first_(mesh.positions.size() + 1, 0) {
  for (size_t side = 0; side < creases.size(); ++side)
    if (creases[side]) onLine_[cells.corners[side]] = true;
  for (const uint32_t v : cells.corners) ++first_[v + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  sides_.resize(cells.corners.size());
  std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
  for (uint32_t side = 0; side < sides_.size(); ++side) sides_[next[cells.corners[side]]++] = side;
  to_.reserve(sides_.size());
  for (const uint32_t side : sides_) to_.push_back(cells.corners[side - side % 3 + (side + 1) % 3]);
}

std::optional<GuideWay> GuideWays::along(const GuideLoop& loop, double off) const {
  GuideWay way;
  uint32_t hint = UINT32_MAX;
  int skipped = 0;
  const auto pass = [&](uint32_t v, const Vec3d& place) {
    // Not there and back again.
    if (const size_t n = way.vertices.size(); n > 1 && way.vertices[n - 2] == v)
      way.vertices.pop_back(), way.places.pop_back();
    else
      way.vertices.push_back(v), way.places.push_back(place);
  };
  const auto go = [&](uint32_t to, const Vec3d& place) {
    if (way.vertices.empty()) return pass(to, place), true;
    if (way.vertices.back() == to) return true;
    const std::vector<uint32_t> between = shortest(way.vertices.back(), to);
    const Vec3d from = way.places.back();
    for (size_t i = 0; i < between.size(); ++i)
      pass(between[i], from + (place - from) * (double(i + 1) / double(between.size())));
    return !between.empty();
  };
  for (size_t i = 0; i < loop.size(); ++i) {
    const Vec3d &a = loop[i], &b = loop[(i + 1) % loop.size()];
    const auto steps = static_cast<int>(std::ceil((b - a).norm() / (kStep * meanSide_)));
    for (int k = 0; k < steps; ++k) {
      const Vec3d p = a + (b - a) * (double(k) / steps);
      const NearestTriangle::Hit hit = tree_.nearest(p, hint);
      hint = hit.triangle;
      if (hit.squared > off * off) return std::nullopt;
      const auto& t = tree_.corners(hit.triangle);
      const Vec3d on = nearestOnTriangle(p, mesh_.positions[t[0]], mesh_.positions[t[1]], mesh_.positions[t[2]]);
      const uint32_t nearest =
          *std::ranges::min_element(t, {}, [&](uint32_t v) { return (mesh_.positions[v] - on).squaredNorm(); });
      // It crosses a line at one vertex, the nearest between what lies on either side.
      if (onLine_[nearest] && ++skipped < kMostSkipped) continue;
      skipped = 0;
      if (!go(nearest, on)) return std::nullopt;
    }
  }
  if (way.vertices.size() < 3 || !go(way.vertices.front(), way.places.front())) return std::nullopt;
  // It ends where it began, if it did not go back there.
  if (way.vertices.size() > 1 && way.vertices.front() == way.vertices.back())
    way.vertices.pop_back(), way.places.pop_back();
  if (way.vertices.size() < 3) return std::nullopt;
  for (size_t i = 0; i < way.vertices.size(); ++i)
    if (onLine_[way.vertices[i]]) way.places[i] = onCrease(way.vertices[i], way.places[i]);
  return way;
}

uint32_t GuideWays::side(uint32_t from, uint32_t to) const {
  for (uint32_t i = first_[from]; i < first_[from + 1]; ++i)
    if (to_[i] == to) return sides_[i];
  return UINT32_MAX;
}

void GuideWays::add(const GuideWay& way) {
  for (size_t i = 0; i < way.vertices.size(); ++i) {
    const uint32_t a = way.vertices[i], b = way.vertices[(i + 1) % way.vertices.size()];
    onLine_[a] = lines_[side(a, b)] = lines_[side(b, a)] = true;
  }
}

// The nearest place on the creases at a vertex, or the place itself where there are none.
Vec3d GuideWays::onCrease(uint32_t v, const Vec3d& place) const {
  Vec3d best = place;
  double least = HUGE_VAL;
  for (uint32_t i = first_[v]; i < first_[v + 1]; ++i) {
    if (!creases_[sides_[i]]) continue;
    const Vec3d &to = mesh_.positions[to_[i]], on = nearestOnTriangle(place, mesh_.positions[v], to, to);
    if (const double off = (on - place).squaredNorm(); off < least) least = off, best = on;
  }
  return best;
}

// Vertices after `from`, with `to` at the end; none where that is far.
std::vector<uint32_t> GuideWays::shortest(uint32_t from, uint32_t to) const {
  using Open = std::pair<double, uint32_t>;
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  std::unordered_map<uint32_t, std::pair<double, uint32_t>> known{{from, {0, from}}};
  open.emplace(0, from);
  for (size_t settled = 0; !open.empty() && settled < kMostWay; ++settled) {
    const auto [length, at] = open.top();
    open.pop();
    if (at == to) break;
    if (length > known.at(at).first) continue;
    for (uint32_t i = first_[at]; i < first_[at + 1]; ++i) {
      const double side = (mesh_.positions[to_[i]] - mesh_.positions[at]).norm();
      const double longer = length + (lines_[sides_[i]] ? kAlongLine * side : side);
      const auto [found, fresh] = known.try_emplace(to_[i], longer, at);
      if (!fresh && !(longer < found->second.first)) continue;
      found->second = {longer, at};
      open.emplace(longer, to_[i]);
    }
  }
  std::vector<uint32_t> way;
  if (!known.contains(to)) return way;
  for (uint32_t at = to; at != from; at = known.at(at).second) way.push_back(at);
  std::ranges::reverse(way);
  return way;
}

}  // namespace argil::clay
