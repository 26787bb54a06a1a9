#include "clay/cage/quad_patches.h"

#include <algorithm>
#include <set>
#include <utility>

namespace argil::clay {

namespace {

constexpr size_t kDisks = 400;  // around one vertex, at most
constexpr size_t kSides = 6;
constexpr int kLeast = 3;  // quads around a vertex

std::vector<uint32_t> sorted(std::vector<uint32_t> quads) {
  std::sort(quads.begin(), quads.end());
  return quads;
}

// The same for the same quads in any order. (splitmix64's mixing, Steele and others 2014)
uint64_t signOf(const std::vector<uint32_t>& quads) {
  uint64_t sum = 0;
  for (const uint32_t f : quads) {
    uint64_t x = (f + 1) * 0x9e3779b97f4a7c15;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
    x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
    sum += x ^ (x >> 31);
  }
  return sum;
}

}  // namespace

QuadPatches::AtVertex& QuadPatches::at(uint32_t vertex) {
  AtVertex& out = at_[vertex];
  if (std::exchange(out.stamp, now_) != now_) {
    out.sides = out.begins = 0;
    out.isCorner = false;
    vertices_.push_back(vertex);
  }
  return out;
}

void QuadPatches::put(Disk& disk, uint32_t quad) {
  if (std::exchange(stamp_[quad], inDisk_) != inDisk_) disk.quads.push_back(quad);
}

bool QuadPatches::straighten(Disk& disk, size_t most) {
  stamp_.resize(web_.quads(), 0);
  at_.resize(web_.vertices());
  ++inDisk_;
  for (const uint32_t f : std::exchange(disk.quads, {})) put(disk, f);
  size_t border = 0;
  for (bool grown = true; grown;) {
    grown = false;
    if (disk.quads.size() > most) return false;
    ++now_;
    vertices_.clear();
    for (const uint32_t f : disk.quads) {
      const auto& q = web_.quad(f);
      for (size_t s = 0; s < 4; ++s) {
        AtVertex& from = at(q[s]);
        if (from.sides == from.of.size()) return false;
        from.of[from.sides++] = {q[(s + 1) & 3], f, (web_.creases(f) >> s & 1) != 0};
      }
    }
    // The border: of each of its vertices the next one, and the quad between them.
    border = 0;
    for (const uint32_t v : vertices_) {
      AtVertex& here = at_[v];
      for (size_t k = 0; k < here.sides; ++k) {
        const Side& side = here.of[k];
        const AtVertex& there = at_[side.to];
        const auto end = there.of.begin() + there.sides;
        if (std::find_if(there.of.begin(), end, [&](const Side& each) { return each.to == v; }) != end) {
          if (side.isCrease) return false;
          continue;
        }
        here.next = side;
        ++here.begins;
        ++border;
      }
      // It meets itself at a vertex: all around that, too.
      if (here.begins < 2) continue;
      for (const uint32_t each : web_.around(v)) put(disk, each);
      grown = true;
    }
    if (grown) continue;
    disk.uneven = 0;
    for (const uint32_t v : vertices_) {
      AtVertex& here = at_[v];
      if (here.begins == 0) {
        const int off = int(here.sides) - 4;
        disk.uneven += off * off;
        continue;
      }
      const QuadWeb::Sector around = web_.sectorOf(v, here.next.quad, &sector_);
      int inside = 0;
      for (const uint32_t f : sector_) inside += isIn(f);
      const int outside = around.count - inside, others = int(web_.around(v).size()) - inside;
      const int asked = std::max({1, around.right - outside, kLeast - others});
      if (asked > 2) {
        // In a larger disk as well: so all such vertices grow at once.
        if (outside == 0) return false;
        for (const uint32_t f : sector_) put(disk, f);
        grown = true;
        continue;
      }
      here.isCorner = asked == 1;
      const QuadWeb::Sector after{outside + asked, around.right};
      disk.uneven += around.uneven(0, true) - after.uneven(0, true);
    }
  }
  const size_t edges = (4 * disk.quads.size() + border) / 2;
  if (vertices_.size() + disk.quads.size() != edges + 1) return false;
  uint32_t first = UINT32_MAX;
  for (const uint32_t v : vertices_)
    if (at_[v].isCorner) first = std::min(first, v);
  if (first == UINT32_MAX) return false;
  disk.sides.clear();
  size_t walked = 0;
  for (uint32_t v = first;;) {
    if (at_[v].isCorner) {
      if (!disk.sides.empty()) disk.sides.back().push_back(v);
      if (walked != 0 && v == first) break;
      disk.sides.push_back({v});
    } else {
      disk.sides.back().push_back(v);
    }
    v = at_[v].next.to;
    if (++walked > border) return false;
  }
  return walked == border && disk.sides.size() >= 2 && disk.sides.size() <= kSides;
}

std::optional<Refill> QuadPatches::notAlone(uint32_t quad, int corner, bool forward) const {
  const auto& q = web_.quad(quad);
  const auto s = static_cast<size_t>(corner);
  // Both quads as they lie beside the vertex, one way round or the other: v, beside, opposite, last; beside, far, next,
  // opposite.
  const uint32_t v = q[s], opposite = q[(s + 2) & 3], beside = q[(s + (forward ? 1 : 3)) & 3],
                 last = q[(s + (forward ? 3 : 1)) & 3];
  const QuadWeb::Sector at = web_.sectorOf(v, quad);
  if (at.count != 1 || at.right != 2 || (web_.creases(quad) >> ((s + (forward ? 1 : 2)) & 3) & 1) != 0)
    return std::nullopt;
  const uint32_t other = forward ? web_.across(opposite, beside) : web_.across(beside, opposite);
  const auto& o = web_.quad(other);
  const auto t = static_cast<size_t>(std::find(o.begin(), o.end(), beside) - o.begin());
  const uint32_t far = o[(t + (forward ? 1 : 3)) & 3], next = o[(t + 2) & 3];
  std::array six{v, beside, far, next, opposite, last};
  std::sort(six.begin(), six.end());
  if (std::adjacent_find(six.begin(), six.end()) != six.end()) return std::nullopt;
  Refill refill;
  refill.quads = sorted({quad, other});
  constexpr uint32_t kFirst = QuadFill::kAdded, kSecond = kFirst + 1;
  refill.fill.quads = {{last, v, kFirst, opposite},
                       {v, beside, kSecond, kFirst},
                       {beside, far, next, kSecond},
                       {next, opposite, kFirst, kSecond}};
  if (!forward)
    for (auto& each : refill.fill.quads) std::reverse(each.begin(), each.end());
  refill.fill.added = {0.4 * web_.at(v) + 0.2 * web_.at(beside) + 0.4 * web_.at(opposite),
                       0.5 * web_.at(beside) + 0.5 * web_.at(next)};
  refill.fill.irregular = 2;
  const QuadWeb::Sector atNext = web_.sectorOf(next, other);
  refill.gain = at.uneven(0, true) + atNext.uneven(0, true) - atNext.uneven(1, true) - refill.fill.irregular;
  if (refill.gain <= 0) return std::nullopt;
  return refill;
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
  // Of the same size, in the order in which they were found.
  const auto larger = [](const Disk& a, const Disk& b) {
    return a.quads.size() != b.quads.size() ? a.quads.size() > b.quads.size() : a.found > b.found;
  };
  std::vector<Disk> open;
  std::set<uint64_t> seen;
  const auto offer = [&](Disk disk) {
    if (seen.size() >= kDisks || !straighten(disk, most) || !seen.insert(signOf(disk.quads)).second) return;
    disk.found = seen.size();
    open.push_back(std::move(disk));
    std::push_heap(open.begin(), open.end(), larger);
  };
  offer({.quads = first});
  while (!open.empty()) {
    std::pop_heap(open.begin(), open.end(), larger);
    const Disk disk = std::move(open.back());
    open.pop_back();
    if (disk.uneven > leastIrregular(disk.sides)) {
      Refill refill{sorted(disk.quads), filled(disk.sides, disk.quads.size(), [&](uint32_t v) { return web_.at(v); }),
                    0};
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
          ++inDisk_;
          for (const uint32_t f : disk.quads) stamp_[f] = inDisk_;
          for (const uint32_t f : web_.around(from)) {
            const auto& q = web_.quad(f);
            const auto at = size_t(std::find(q.begin(), q.end(), from) - q.begin());
            if (!isIn(f) && (q[(at + 1) & 3] == to || q[(at + 3) & 3] == to)) clear = false;
          }
        }
      if (clear && refill.gain > 0 && take(refill)) return true;
    }
    for (const BorderSide& side : disk.sides) {
      Disk next{.quads = disk.quads};
      for (size_t k = 0; k + 1 < side.size(); ++k) next.quads.push_back(web_.across(side[k + 1], side[k]));
      offer(std::move(next));
    }
  }
  return false;
}

}  // namespace argil::clay
