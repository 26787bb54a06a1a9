#include "clay/cage/quad_patches.h"

#include <algorithm>
#include <map>
#include <queue>
#include <set>
#include <utility>

namespace argil::clay {

namespace {

constexpr size_t kDisks = 200;  // around one vertex, at most
constexpr size_t kSides = 6;
constexpr int kLeast = 3;  // quads around a vertex

}  // namespace

void QuadPatches::put(Disk& disk, uint32_t quad) {
  if (stamp_.size() < web_.quads()) stamp_.resize(web_.quads(), 0);
  if (std::exchange(stamp_[quad], now_) != now_) disk.quads.push_back(quad);
}

bool QuadPatches::straighten(Disk& disk, size_t most) {
  ++now_;
  for (const uint32_t f : std::exchange(disk.quads, {})) put(disk, f);
  // The border: of each of its vertices the next one, and the quad between them.
  std::map<uint32_t, std::pair<uint32_t, uint32_t>> next;
  std::vector<uint32_t> sector;
  std::map<uint32_t, bool> corner;
  for (bool grown = true; grown;) {
    grown = false;
    if (disk.quads.size() > most) return false;
    next.clear();
    corner.clear();
    disk.uneven = 0;
    size_t sides = 0;
    for (const uint32_t f : disk.quads)
      for (size_t s = 0; s < 4; ++s) {
        const uint32_t from = web_.quad(f)[s], to = web_.quad(f)[(s + 1) & 3];
        if (isIn(web_.across(to, from))) {
          if ((web_.creases(f) >> s & 1) != 0) return false;
          continue;
        }
        ++sides;
        next[from] = {to, f};
      }
    if (next.size() != sides) {
      // It meets itself at a vertex: all around that, too.
      std::map<uint32_t, int> begins;
      for (const uint32_t f : std::vector(disk.quads))
        for (size_t s = 0; s < 4; ++s)
          if (const uint32_t from = web_.quad(f)[s]; !isIn(web_.across(web_.quad(f)[(s + 1) & 3], from)))
            if (++begins[from] == 2)
              for (const uint32_t each : web_.around(from)) put(disk, each), grown = true;
      continue;
    }
    for (const auto& [v, beside] : next) {
      const QuadWeb::Sector around = web_.sectorOf(v, beside.second, &sector);
      int inside = 0;
      for (const uint32_t f : sector) inside += isIn(f);
      const int outside = around.count - inside, others = int(web_.around(v).size()) - inside;
      const int asked = std::max({1, around.right - outside, kLeast - others});
      if (asked > 2) {
        if (outside == 0) return false;
        for (const uint32_t f : sector) put(disk, f);
        grown = true;
        break;
      }
      corner[v] = asked == 1;
      const QuadWeb::Sector after{outside + asked, around.right};
      disk.uneven += around.uneven(0, true) - after.uneven(0, true);
    }
  }
  std::set<uint32_t> vertices;
  for (const uint32_t f : disk.quads) vertices.insert(web_.quad(f).begin(), web_.quad(f).end());
  const size_t edges = (4 * disk.quads.size() + next.size()) / 2;
  if (vertices.size() + disk.quads.size() != edges + 1) return false;
  for (const uint32_t v : vertices)
    if (!next.contains(v)) {
      const int off = int(web_.around(v).size()) - 4;
      disk.uneven += off * off;
    }
  const auto first = std::find_if(corner.begin(), corner.end(), [](const auto& each) { return each.second; });
  if (first == corner.end()) return false;
  disk.sides.clear();
  size_t walked = 0;
  for (uint32_t v = first->first;;) {
    if (corner[v]) {
      if (!disk.sides.empty()) disk.sides.back().push_back(v);
      if (walked != 0 && v == first->first) break;
      disk.sides.push_back({v});
    } else {
      disk.sides.back().push_back(v);
    }
    v = next[v].first;
    if (++walked > next.size()) return false;
  }
  std::sort(disk.quads.begin(), disk.quads.end());
  return walked == next.size() && disk.sides.size() >= 2 && disk.sides.size() <= kSides;
}

bool QuadPatches::around(uint32_t vertex, size_t most, const std::function<bool(const Refill&)>& take) {
  std::vector<uint32_t> sector;
  for (const uint32_t f : std::vector(web_.around(vertex))) {
    const QuadWeb::Sector of = web_.sectorOf(vertex, f, &sector);
    if (of.count != of.right && f == *std::min_element(sector.begin(), sector.end()) && from(sector, most, take))
      return true;
  }
  return false;
}

bool QuadPatches::from(const std::vector<uint32_t>& first, size_t most,
                       const std::function<bool(const Refill&)>& take) {
  const auto larger = [](const Disk& a, const Disk& b) {
    return a.quads.size() != b.quads.size() ? a.quads.size() > b.quads.size() : a.quads > b.quads;
  };
  std::priority_queue<Disk, std::vector<Disk>, decltype(larger)> open(larger);
  std::set<std::vector<uint32_t>> seen;
  const auto offer = [&](Disk disk) {
    if (seen.size() >= kDisks || !straighten(disk, most) || !seen.insert(disk.quads).second) return;
    open.push(std::move(disk));
  };
  offer({first, {}, 0});
  while (!open.empty()) {
    const Disk disk = open.top();
    open.pop();
    if (disk.uneven > leastIrregular(disk.sides)) {
      Refill refill{disk.quads, filled(disk.sides, disk.quads.size(), [&](uint32_t v) { return web_.at(v); }), 0};
      refill.gain = disk.uneven - refill.fill.irregular;
      // An edge that leads from border to border must be none outside.
      bool clear = !refill.fill.quads.empty();
      std::set<std::pair<uint32_t, uint32_t>> border;
      for (const BorderSide& side : disk.sides)
        for (size_t k = 0; k + 1 < side.size(); ++k) border.emplace(side[k], side[k + 1]);
      for (const auto& quad : refill.fill.quads)
        for (size_t s = 0; s < 4 && clear; ++s) {
          const uint32_t from = quad[s], to = quad[(s + 1) & 3];
          if (from >= QuadFill::kAdded || to >= QuadFill::kAdded || border.contains({from, to})) continue;
          ++now_;
          for (const uint32_t f : disk.quads) stamp_[f] = now_;
          for (const uint32_t f : web_.around(from)) {
            const auto& q = web_.quad(f);
            const auto at = size_t(std::find(q.begin(), q.end(), from) - q.begin());
            if (!isIn(f) && (q[(at + 1) & 3] == to || q[(at + 3) & 3] == to)) clear = false;
          }
        }
      if (clear && refill.gain > 0 && take(refill)) return true;
    }
    for (const BorderSide& side : disk.sides) {
      Disk next{disk.quads, {}, 0};
      for (size_t k = 0; k + 1 < side.size(); ++k) next.quads.push_back(web_.across(side[k + 1], side[k]));
      offer(std::move(next));
    }
  }
  return false;
}

}  // namespace argil::clay
