#include "clay/cage/quad_patches.h"

#include <algorithm>
#include <set>
#include <utility>

namespace argil::clay {

namespace {

constexpr size_t kDisks = 400;  // around one vertex, at most
// Beyond a line of creases: disks that are looked at, how many more edges a line may get, disks in all, and how many of
// those beyond are gone on from.
constexpr size_t kDisksBeyond = 24, kMostDisks = 3, kFartherFrom = 1;
constexpr int kLooks = 3;   // disks along one line beyond which is looked
constexpr int kVertex = 8;  // an irregular vertex more is worse than sides of four that differ by so many edges
constexpr std::array<std::array<int, 2>, 2> kOtherCounts{{{1, 2}, {-1, -2}}};
constexpr size_t kSides = 6;
constexpr int kOpened = 2;  // irregular vertices between the four quads that two become
constexpr int kLeast = 3;   // quads around a vertex

std::vector<uint32_t> sorted(std::vector<uint32_t> quads) {
  std::sort(quads.begin(), quads.end());
  return quads;
}

bool isAlong(const BorderSide& side, const BorderSide& line) {
  return side == line || (side.size() == line.size() && std::equal(side.begin(), side.end(), line.rbegin()));
}

// By how many edges sides of four that are opposite differ.
int unequal(const std::vector<int>& sides) {
  return sides.size() == 4 ? std::abs(sides[0] - sides[2]) + std::abs(sides[1] - sides[3]) : 0;
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

void Refill::carryOver(const QuadWeb& web) {
  for (const auto& [was, is] : disks)
    for (const auto& [v, place] : placesOn(was, is, [&](uint32_t each) { return web.at(each); }))
      added[v - QuadFill::kAdded] = place;
}

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
  refill.made = {{last, v, kFirst, opposite},
                 {v, beside, kSecond, kFirst},
                 {beside, far, next, kSecond},
                 {next, opposite, kFirst, kSecond}};
  if (!forward)
    for (auto& each : refill.made) std::reverse(each.begin(), each.end());
  refill.added = {0.4 * web_.at(v) + 0.2 * web_.at(beside) + 0.4 * web_.at(opposite),
                  0.5 * web_.at(beside) + 0.5 * web_.at(next)};
  const QuadWeb::Sector atNext = web_.sectorOf(next, other);
  refill.gain = at.uneven(0, true) + atNext.uneven(0, true) - atNext.uneven(1, true) - kOpened;
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

template <class Look>
bool QuadPatches::grow(const std::vector<uint32_t>& first, size_t most, size_t count, const BorderSide& but,
                       const Look& look) {
  // Of the same size, in the order in which they were found.
  const auto larger = [](const Disk& a, const Disk& b) {
    return a.quads.size() != b.quads.size() ? a.quads.size() > b.quads.size() : a.found > b.found;
  };
  std::vector<Disk> open;
  std::set<uint64_t> seen;
  const auto offer = [&](Disk disk) {
    if (seen.size() >= count || !straighten(disk, most) || !seen.insert(signOf(disk.quads)).second) return;
    disk.found = seen.size();
    open.push_back(std::move(disk));
    std::push_heap(open.begin(), open.end(), larger);
  };
  offer({.quads = first});
  while (!open.empty()) {
    std::pop_heap(open.begin(), open.end(), larger);
    const Disk disk = std::move(open.back());
    open.pop_back();
    if (look(disk)) return true;
    for (const BorderSide& side : disk.sides) {
      // A row along a side beside it would make that one longer.
      if (!but.empty() && (side.front() == but.back() || side.back() == but.front() || side == but)) continue;
      Disk next{.quads = disk.quads};
      for (size_t k = 0; k + 1 < side.size(); ++k) next.quads.push_back(web_.across(side[k + 1], side[k]));
      offer(std::move(next));
    }
  }
  return false;
}

bool QuadPatches::isClear(const Refill& refill, const Disks& disks) {
  std::set<std::pair<uint32_t, uint32_t>> border, inside;
  for (const Disk* disk : disks)
    for (const BorderSide& side : disk->sides)
      for (size_t k = 0; k + 1 < side.size(); ++k) border.emplace(side[k], side[k + 1]);
  ++inDisk_;
  for (const uint32_t f : refill.quads) stamp_[f] = inDisk_;
  for (const auto& quad : refill.made)
    for (size_t s = 0; s < 4; ++s) {
      const uint32_t from = quad[s], to = quad[(s + 1) & 3];
      if (from >= QuadFill::kAdded || to >= QuadFill::kAdded || border.contains({from, to})) continue;
      if (!inside.emplace(from, to).second) return false;
      for (const uint32_t f : web_.around(from)) {
        const auto& q = web_.quad(f);
        const auto at = size_t(std::find(q.begin(), q.end(), from) - q.begin());
        if (!isIn(f) && (q[(at + 1) & 3] == to || q[(at + 3) & 3] == to)) return false;
      }
    }
  return true;
}

bool QuadPatches::isLine(const BorderSide& side) const {
  for (size_t k = 0; k + 1 < side.size(); ++k) {
    const uint32_t f = web_.across(side[k], side[k + 1]);
    const auto s = std::find(web_.quad(f).begin(), web_.quad(f).end(), side[k]) - web_.quad(f).begin();
    if ((web_.creases(f) >> s & 1) == 0 || (k > 0 && web_.isCorner(side[k]))) return false;
  }
  return true;
}

int QuadPatches::gainOf(const Disks& disks, const std::vector<OtherCount>& lines) {
  int gain = 0;
  for (const Disk* disk : disks) {
    std::vector<int> before, after;
    for (const BorderSide& side : disk->sides) {
      before.push_back(int(side.size()) - 1);
      after.push_back(before.back());
      for (const OtherCount& each : lines)
        if (isAlong(side, each.line)) after.back() = each.edges;
    }
    gain += kVertex * (disk->uneven - leastIrregular(after)) + unequal(before) - unequal(after);
  }
  return gain;
}

bool QuadPatches::fits(const Disks& disks, const BorderSide& line) const {
  const Disk& last = *disks.back();
  const auto isOn = [](const Disk& disk, uint32_t v) {
    return std::any_of(disk.sides.begin(), disk.sides.end(),
                       [v](const BorderSide& side) { return std::find(side.begin(), side.end(), v) != side.end(); });
  };
  const auto has = [](const Disk& disk, uint32_t f) {
    return std::find(disk.quads.begin(), disk.quads.end(), f) != disk.quads.end();
  };
  if (std::none_of(last.sides.begin(), last.sides.end(), [&](const BorderSide& side) { return isAlong(side, line); }))
    return false;
  for (const Disk* disk : disks) {
    if (disk == &last) continue;
    for (const uint32_t f : last.quads)
      if (has(*disk, f)) return false;
    for (const BorderSide& side : last.sides)
      for (const uint32_t v : side)
        if (std::find(line.begin(), line.end(), v) == line.end() && isOn(*disk, v)) return false;
  }
  return std::ranges::all_of(std::array{line.front(), line.back()}, [&](uint32_t v) {
    const auto& around = web_.around(v);
    int left = 0;
    for (const Disk* disk : disks) left += isOn(*disk, v);
    for (const uint32_t f : around)
      left += std::none_of(disks.begin(), disks.end(), [&](const Disk* disk) { return has(*disk, f); });
    return left >= kLeast;
  });
}

std::optional<Refill> QuadPatches::filledAnew(const Disks& disks, const std::vector<OtherCount>& lines) {
  Refill refill;
  // Vertices along the new lines have the next numbers of the web for now.
  const auto first = static_cast<uint32_t>(web_.vertices());
  for (const auto& [line, edges] : lines) {
    std::vector<double> until{0};
    for (size_t k = 0; k + 1 < line.size(); ++k)
      until.push_back(until.back() + (web_.at(line[k + 1]) - web_.at(line[k])).norm());
    BorderSide made{line.front()};
    for (int i = 1; i < edges; ++i) {
      const double length = until.back() * i / edges;
      const auto k = static_cast<size_t>(std::upper_bound(until.begin() + 1, until.end() - 1, length) - until.begin());
      const double share = (length - until[k - 1]) / std::max(until[k] - until[k - 1], 1e-300);
      made.push_back(first + static_cast<uint32_t>(refill.added.size()));
      refill.added.push_back((1 - share) * web_.at(line[k - 1]) + share * web_.at(line[k]));
    }
    made.push_back(line.back());
    refill.lines.push_back(line);
    refill.newLines.push_back(std::move(made));
  }
  const std::vector<Vec3d> onLines = refill.added;
  const auto at = [&](uint32_t v) { return v < first ? web_.at(v) : onLines[v - first]; };
  // To numbers from QuadFill::kAdded on; those within a disk begin `before` later.
  const auto number = [&](uint32_t& v, uint32_t before) {
    if (v >= QuadFill::kAdded)
      v += before;
    else if (v >= first)
      v += QuadFill::kAdded - first;
  };
  for (const Disk* disk : disks) {
    QuadDisk was{.quads = {}, .sides = disk->sides}, is{.quads = {}, .sides = disk->sides};
    for (const uint32_t f : disk->quads) was.quads.push_back(web_.quad(f));
    for (BorderSide& side : is.sides)
      for (size_t i = 0; i < lines.size(); ++i) {
        const BorderSide &line = refill.lines[i], &made = refill.newLines[i];
        if (!isAlong(side, line)) continue;
        if (side == line)
          side = made;
        else
          side.assign(made.rbegin(), made.rend());
        break;
      }
    QuadFill fill = filled(is.sides, disk->quads.size(), at);
    if (fill.quads.empty()) return std::nullopt;
    const auto before = static_cast<uint32_t>(refill.added.size());
    for (auto& quad : fill.quads)
      for (uint32_t& v : quad) number(v, before);
    for (BorderSide& side : is.sides)
      for (uint32_t& v : side) number(v, before);
    is.quads = fill.quads;
    refill.added.insert(refill.added.end(), fill.added.begin(), fill.added.end());
    refill.made.insert(refill.made.end(), is.quads.begin(), is.quads.end());
    refill.quads.insert(refill.quads.end(), disk->quads.begin(), disk->quads.end());
    refill.gain += disk->uneven - fill.irregular;
    refill.disks.emplace_back(std::move(was), std::move(is));
  }
  for (BorderSide& line : refill.newLines)
    for (uint32_t& v : line) number(v, 0);
  refill.quads = sorted(std::move(refill.quads));
  if (!isClear(refill, disks)) return std::nullopt;
  return refill;
}

bool QuadPatches::beyondLines(Disks& disks, std::vector<OtherCount>& lines, size_t most,
                              const std::function<bool(const Refill&)>& take) {
  // More edges first: where there are enough quads already the rest is looked at.
  return std::ranges::any_of(kOtherCounts, [&](const auto& more) {
    return std::ranges::any_of(
        disks.back()->sides, [&](const BorderSide& line) { return beyondLine(line, more, disks, lines, most, take); });
  });
}

bool QuadPatches::beyondLine(const BorderSide& line, const std::array<int, 2>& more, Disks& disks,
                             std::vector<OtherCount>& lines, size_t most,
                             const std::function<bool(const Refill&)>& take) {
  const auto isLast = [&](const OtherCount& each) { return isAlong(line, each.line); };
  if (std::any_of(lines.begin(), lines.end(), isLast)) return false;
  // The counts with which it would be better, whatever that is for the other.
  std::vector<int> counts;
  lines.push_back({line, 0});
  for (const int each : more) {
    lines.back().edges = int(line.size()) - 1 + each;
    if (lines.back().edges > 0 && gainOf(disks, lines) > 0) counts.push_back(lines.back().edges);
  }
  lines.pop_back();
  if (counts.empty() || !isLine(line)) return false;
  // Larger disks along the same line differ little.
  if (disks.size() == 1 && ++looks_[{line.front(), line.back(), uint32_t(more[0] > 0)}] > kLooks) return false;
  std::vector<uint32_t> beyond;
  for (size_t k = 0; k + 1 < line.size(); ++k) beyond.push_back(web_.across(line[k + 1], line[k]));
  size_t found = 0;
  return grow(beyond, most, kDisksBeyond, BorderSide(line.rbegin(), line.rend()), [&](const Disk& other) {
    disks.push_back(&other);
    bool taken = false;
    if (fits(disks, line)) {
      found += disks.size() < kMostDisks && std::ranges::any_of(other.sides, [&](const BorderSide& side) {
                 return !isAlong(side, line) && isLine(side);
               });
      for (size_t i = 0; i < counts.size() && !taken; ++i) {
        lines.push_back({line, counts[i]});
        if (gainOf(disks, lines) > 0)
          if (const std::optional<Refill> refill = filledAnew(disks, lines)) taken = take(*refill);
        if (!taken && disks.size() < kMostDisks && found <= kFartherFrom) taken = beyondLines(disks, lines, most, take);
        lines.pop_back();
      }
    }
    disks.pop_back();
    return taken;
  });
}

bool QuadPatches::from(const std::vector<uint32_t>& first, size_t most,
                       const std::function<bool(const Refill&)>& take) {
  looks_.clear();
  return grow(first, most, kDisks, {}, [&](const Disk& disk) {
    Disks disks{&disk};
    std::vector<OtherCount> lines;
    if (gainOf(disks, lines) > 0)
      if (const std::optional<Refill> refill = filledAnew(disks, lines); refill && take(*refill)) return true;
    return lines_ && beyondLines(disks, lines, most, take);
  });
}

}  // namespace argil::clay
