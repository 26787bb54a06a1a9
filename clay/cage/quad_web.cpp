#include "clay/cage/quad_web.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "clay/base/error.h"

namespace argil::clay {

QuadWeb::QuadWeb(QuadMesh mesh)
    : positions_(std::move(mesh.positions)),
      quads_(std::move(mesh.quads)),
      creases_(std::move(mesh.creases)),
      marked_(positions_.size(), false),
      around_(positions_.size()) {
  (void)QuadTopology(positions_.size(), quads_, creases_);  // throws
  creases_.resize(quads_.size(), 0);
  for (const uint32_t each : mesh.corners) marked_[each] = true;
  for (uint32_t f = 0; f < quads_.size(); ++f)
    for (const uint32_t v : quads_[f]) around_[v].push_back(f);
  alive_ = quads_.size();
}

void QuadWeb::beside(uint32_t vertex, std::vector<uint32_t>& out) const {
  out.clear();
  for (const uint32_t f : around_[vertex]) {
    const auto& q = quads_[f];
    const auto s = size_t(std::find(q.begin(), q.end(), vertex) - q.begin());
    out.push_back(q[(s + 1) & 3]);  // each edge leaves the vertex in one quad
  }
}

std::array<std::array<uint32_t, 2>, 2> QuadWeb::linesThrough(uint32_t vertex) const {
  const std::vector<uint32_t>& quads = around_[vertex];
  // Of a quad here: the next vertex after this one, and the one before.
  const auto next = [&](uint32_t f, size_t step) {
    const auto& q = quads_[f];
    return q[(static_cast<size_t>(std::find(q.begin(), q.end(), vertex) - q.begin()) + step) % 4];
  };
  const auto after = [&](uint32_t v) {
    return next(*std::find_if(quads.begin(), quads.end(), [&](uint32_t f) { return next(f, 1) == v; }), 3);
  };
  const uint32_t first = next(quads.front(), 1), second = after(first), third = after(second);
  return {{{first, third}, {second, after(third)}}};
}

void QuadWeb::alongCreases(uint32_t vertex, std::vector<uint32_t>& out) const {
  out.clear();
  for (const uint32_t f : around_[vertex]) {
    const auto& q = quads_[f];
    const int s = int(std::find(q.begin(), q.end(), vertex) - q.begin());
    if (isCrease(f, s)) out.push_back(q[size_t(s + 1) & 3]);
  }
}

size_t QuadWeb::creasesAt(uint32_t vertex) const {
  size_t count = 0;
  for (const uint32_t f : around_[vertex]) {
    if (creases_[f] == 0) continue;
    const auto& q = quads_[f];
    count += isCrease(f, int(std::find(q.begin(), q.end(), vertex) - q.begin()));
  }
  return count;
}

bool QuadWeb::isCorner(uint32_t vertex) const {
  const size_t count = creasesAt(vertex);
  return count != 0 && (count != 2 || marked_[vertex]);
}

void QuadWeb::setCrease(uint32_t from, uint32_t to, bool crease) {
  for (const auto& [a, b] : {std::pair{from, to}, std::pair{to, from}}) {
    const uint32_t f = across(a, b);
    const auto s = std::find(quads_[f].begin(), quads_[f].end(), a) - quads_[f].begin();
    creases_[f] = static_cast<uint8_t>((creases_[f] & ~(1 << s)) | (int{crease} << s));
  }
}

bool QuadWeb::joinFace(uint32_t quad, int corner) {
  if (creases_[quad] != 15) return false;
  const auto at = [&](int s) { return quads_[quad][static_cast<size_t>(corner + s) & 3]; };
  const auto normal = [&](uint32_t f) {
    const auto& o = quads_[f];
    return (positions_[o[2]] - positions_[o[0]]).cross(positions_[o[3]] - positions_[o[1]]).normalized();
  };
  // How little the two sides at a corner turn: the cosines with what lies across. A line must end nowhere.
  const Vec3d own = normal(quad);
  const auto flat = [&](int s) {
    if (creasesAt(at(s)) != 2) return -HUGE_VAL;
    return own.dot(normal(across(at(s + 1), at(s)))) + own.dot(normal(across(at(s), at(s + 3))));
  };
  const double here = flat(0), opposite = flat(2);
  const size_t first = creasesAt(at(1)), second = creasesAt(at(3));
  const bool all = first == 2 && second == 2 && std::min(here, opposite) > -HUGE_VAL;
  if (!all && (std::min(first, second) < 3 || std::max(here, opposite) == -HUGE_VAL)) return false;
  for (int s = 0; s < 4; ++s)
    if (all || (here >= opposite) == (s == 0 || s == 3)) setCrease(at(s), at(s + 1), false);
  return true;
}

QuadWeb::Sector QuadWeb::sectorOf(uint32_t vertex, uint32_t quad, std::vector<uint32_t>* quads) const {
  const size_t creases = creasesAt(vertex);
  if (quads) *quads = creases == 0 ? around_[vertex] : std::vector{quad};
  if (creases == 0) return {int(around_[vertex].size()), 4};
  Sector sector{1, 2};
  const bool straight = creases == 2 && !marked_[vertex];
  double angle = 0;
  const auto add = [&](uint32_t f, int s) {
    if (straight) return;
    const auto& q = quads_[f];
    const Vec3d a = positions_[q[size_t(s + 1) & 3]] - positions_[vertex],
                b = positions_[q[size_t(s + 3) & 3]] - positions_[vertex];
    angle += std::atan2(a.cross(b).norm(), a.dot(b));
  };
  const auto cornerOf = [&](uint32_t f) {
    return int(std::find(quads_[f].begin(), quads_[f].end(), vertex) - quads_[f].begin());
  };
  const int first = cornerOf(quad);
  add(quad, first);
  int s = first;
  for (uint32_t f = quad; !isCrease(f, s + 3) && sector.count <= int(around_[vertex].size());) {
    f = across(vertex, quads_[f][size_t(s + 3) & 3]);
    if (f == quad) return sector;  // one crease alone: it ends here
    s = cornerOf(f);
    add(f, s);
    if (quads) quads->push_back(f);
    ++sector.count;
  }
  s = first;
  for (uint32_t f = quad; !isCrease(f, s) && sector.count <= int(around_[vertex].size());) {
    f = across(quads_[f][size_t(s + 1) & 3], vertex);
    s = cornerOf(f);
    add(f, s);
    if (quads) quads->push_back(f);
    ++sector.count;
  }
  if (!straight) sector.right = std::max(1, int(std::lround(angle / (std::numbers::pi / 2))));
  return sector;
}

bool QuadWeb::areBeside(uint32_t a, uint32_t b) const {
  return std::any_of(around_[a].begin(), around_[a].end(), [&](uint32_t f) {
    const auto& q = quads_[f];
    const auto s = size_t(std::find(q.begin(), q.end(), a) - q.begin());
    return q[(s + 1) & 3] == b;
  });
}

uint32_t QuadWeb::across(uint32_t from, uint32_t to) const {
  for (const uint32_t f : around_[from]) {
    const auto& q = quads_[f];
    const auto s = size_t(std::find(q.begin(), q.end(), from) - q.begin());
    if (q[(s + 1) & 3] == to) return f;
  }
  throw Error("a mesh of quads that is not closed", Error::Kind::work);
}

void QuadWeb::removeFrom(uint32_t vertex, uint32_t quad) {
  auto& list = around_[vertex];
  list.erase(std::find(list.begin(), list.end(), quad));
}

std::optional<int> QuadWeb::gainOfCollapse(uint32_t quad, int corner, bool last) const {
  const auto& q = quads_[quad];
  const uint32_t a = q[size_t(corner) & 3], b = q[size_t(corner + 1) & 3], c = q[size_t(corner + 2) & 3],
                 d = q[size_t(corner + 3) & 3];
  const size_t va = around_[a].size(), vb = around_[b].size(), vc = around_[c].size(), vd = around_[d].size();
  const size_t merged = va + vc - 2;
  const bool creased = isOnCrease(a) || isOnCrease(c);
  if (merged < 3 || merged > (creased ? kMostOnCrease : kMostAround)) return std::nullopt;
  const bool onB = isOnCrease(b), onD = isOnCrease(d);
  // Where a line bends around the quad's corner b or d it may leave it out: two edges less, and the corner is free.
  const bool cutsB = isCrease(quad, corner) && isCrease(quad, corner + 1),
             cutsD = isCrease(quad, corner + 2) && isCrease(quad, corner + 3);
  if (isOnCrease(a) && isOnCrease(c)) {
    if (cutsB == cutsD || isCorner(cutsB ? b : d) || (isCorner(a) && isCorner(c))) return std::nullopt;
  } else if (cutsB || cutsD) {
    return std::nullopt;
  }
  // Of a vertex that keeps two quads these two become one.
  const bool bGoes = vb == 3, dGoes = vd == 3;
  if (bGoes && dGoes) return std::nullopt;
  if ((bGoes && onB && !cutsB) || (dGoes && onD && !cutsD)) return std::nullopt;
  // Nothing else may join a and c: no quad, no path of two edges.
  for (const uint32_t f : around_[a])
    if (f != quad && std::find(quads_[f].begin(), quads_[f].end(), c) != quads_[f].end()) return std::nullopt;
  std::vector<uint32_t> ofA, ofC;
  beside(a, ofA);
  beside(c, ofC);
  for (const uint32_t v : ofA)
    if (v == c || (v != b && v != d && std::find(ofC.begin(), ofC.end(), v) != ofC.end())) return std::nullopt;
  const Sector atA = sectorOf(a, quad), atB = sectorOf(b, quad), atC = sectorOf(c, quad), atD = sectorOf(d, quad);
  // What becomes of b and d where they stay.
  const auto left = [&](const Sector& sector, size_t valence, bool cut) {
    const int free = int(valence) - 1 - 4;
    return cut ? free * free : sector.uneven(-1, last);
  };
  const int afterB = left(atB, vb, cutsB), afterD = left(atD, vd, cutsD);
  Sector joined{atA.count + atC.count - 2, isOnCrease(c) ? atC.right : atA.right};
  if (!isOnCrease(a) && !isOnCrease(c)) joined = {int(merged), 4};
  if (joined.count < 1 || (creased && joined.count > joined.right + 2)) return std::nullopt;
  int gain = -joined.uneven(0, last);
  for (const Sector& each : {atA, atB, atC, atD}) gain += each.uneven(0, last);
  if (!bGoes && !dGoes) return gain - afterB - afterD;
  const uint32_t goes = bGoes ? b : d, stays = bGoes ? d : b;
  // Around it are the quad and two more, which share the edge to its third neighbour.
  std::vector<uint32_t> ofGoing;
  beside(goes, ofGoing);
  uint32_t third = kGone;
  for (const uint32_t v : ofGoing)
    if (v != a && v != c) third = v;
  if (third == kGone || third == stays) return std::nullopt;
  std::array<uint32_t, 2> ends{};  // opposite to it in the two quads: sides of one quad afterwards
  std::array<uint32_t, 2> halves{};
  size_t found = 0;
  for (const uint32_t f : around_[goes]) {
    if (f == quad) continue;
    const auto& o = quads_[f];
    const auto s = size_t(std::find(o.begin(), o.end(), goes) - o.begin());
    if (found < 2) halves[found] = f, ends[found++] = o[(s + 2) & 3];
  }
  if (found != 2 || ends[0] == ends[1] || ends[0] == stays || ends[1] == stays) return std::nullopt;
  const size_t vt = around_[third].size();
  if (merged < 4 || vt < 4) return std::nullopt;
  // Two quads of one sector become one: those are beside an edge that is no crease.
  const Sector atThird = sectorOf(third, halves[0]);
  return gain + joined.uneven(0, last) - joined.uneven(-1, last) + atThird.uneven(0, last) - atThird.uneven(-1, last) -
         (bGoes ? afterD : afterB);
}

uint32_t QuadWeb::collapse(uint32_t quad, int corner) {
  const auto q = quads_[quad];
  const uint32_t a = q[size_t(corner) & 3], b = q[size_t(corner + 1) & 3], c = q[size_t(corner + 2) & 3],
                 d = q[size_t(corner + 3) & 3];
  // Of two sides that become one edge: a crease if one of them is; a line that went along both leaves it out.
  const bool toB = isCrease(quad, corner) != isCrease(quad, corner + 1),
             toD = isCrease(quad, corner + 2) != isCrease(quad, corner + 3);
  if (isCorner(c)) marked_[a] = true;
  if (!isOnCrease(a)) marked_[a] = marked_[c];
  for (const uint32_t v : q) removeFrom(v, quad);
  for (const uint32_t f : around_[c]) {
    std::replace(quads_[f].begin(), quads_[f].end(), c, a);
    around_[a].push_back(f);
  }
  around_[c].clear();
  quads_[quad][0] = kGone;
  --alive_;
  setCrease(a, b, toB);
  setCrease(a, d, toD);
  for (const uint32_t goes : {b, d}) {
    if (around_[goes].size() != 2) continue;
    const uint32_t f = around_[goes][0], other = around_[goes][1];
    const auto& o = quads_[other];
    const auto s = size_t(std::find(o.begin(), o.end(), goes) - o.begin());
    const uint32_t end = o[(s + 2) & 3];
    const auto t = int(std::find(quads_[f].begin(), quads_[f].end(), goes) - quads_[f].begin());
    const auto set = [&](int side, bool crease) {
      creases_[f] = static_cast<uint8_t>((creases_[f] & ~(1 << (side & 3))) | (int{crease} << (side & 3)));
    };
    set(t, isCrease(other, int(s) + 2));
    set(t + 3, isCrease(other, int(s) + 1));
    quads_[f][size_t(t)] = end;
    around_[end].push_back(f);
    for (const uint32_t v : std::array(quads_[other]))
      if (v != goes) removeFrom(v, other);
    around_[goes].clear();
    quads_[other][0] = kGone;
    --alive_;
  }
  return a;
}

bool QuadWeb::removeInset(uint32_t quad) {
  const auto q = quads_[quad];
  std::array<uint32_t, 4> outer{}, ring{};
  uint8_t bits = 0;
  for (size_t s = 0; s < 4; ++s) {
    if (around_[q[s]].size() != 3 || isOnCrease(q[s])) return false;
    // The quad across side s has it as its own side from the next corner to this one, and the outer side opposite.
    ring[s] = across(q[(s + 1) & 3], q[s]);
    const auto& o = quads_[ring[s]];
    const auto t = size_t(std::find(o.begin(), o.end(), q[s]) - o.begin());
    outer[s] = o[(t + 1) & 3];
    if (isCrease(ring[s], int(t) + 1)) bits = static_cast<uint8_t>(bits | 1 << s);
  }
  for (size_t s = 0; s < 4; ++s)
    for (size_t k = 0; k < s; ++k)
      if (outer[s] == outer[k] || ring[s] == ring[k]) return false;
  for (const uint32_t v : outer)
    if (around_[v].size() < 4) return false;
  for (const uint32_t f : ring) {
    for (const uint32_t v : std::array(quads_[f])) removeFrom(v, f);
    quads_[f][0] = kGone;
  }
  for (const uint32_t v : q) around_[v].clear();
  alive_ -= 4;
  quads_[quad] = outer;
  creases_[quad] = bits;
  for (const uint32_t v : outer) around_[v].push_back(quad);
  return true;
}

QuadWeb::Six QuadWeb::sixAround(uint32_t quad, int corner) const {
  const auto& q = quads_[quad];
  const uint32_t a = q[size_t(corner) & 3], b = q[size_t(corner + 1) & 3];
  Six six;
  six.other = across(b, a);
  const auto& o = quads_[six.other];
  const auto s = size_t(std::find(o.begin(), o.end(), b) - o.begin());
  // Counter-clockwise from b: the rest of this quad, a, the rest of the other.
  six.vertices = {b, q[size_t(corner + 2) & 3], q[size_t(corner + 3) & 3], a, o[(s + 2) & 3], o[(s + 3) & 3]};
  return six;
}

std::optional<int> QuadWeb::gainOfTurn(uint32_t quad, int corner, int step, bool last) const {
  const Six six = sixAround(quad, corner);
  if (six.other == quad || isCrease(quad, corner)) return std::nullopt;
  const uint32_t a = six.vertices[0], b = six.vertices[3], c = six.vertices[size_t(step + 6) % 6],
                 d = six.vertices[size_t(step + 3) % 6];
  const size_t va = around_[a].size(), vb = around_[b].size(), vc = around_[c].size(), vd = around_[d].size();
  if (va < 4 || vb < 4 || vc >= (isOnCrease(c) ? kMostOnCrease : kMostAround) ||
      vd >= (isOnCrease(d) ? kMostOnCrease : kMostAround) || c == d || areBeside(c, d))
    return std::nullopt;
  for (size_t i = 0; i < 6; ++i)
    for (size_t j = 0; j < i; ++j)
      if (six.vertices[i] == six.vertices[j]) return std::nullopt;
  const Sector atA = sectorOf(a, quad), atB = sectorOf(b, quad);
  if (atA.count < 2 || atB.count < 2) return std::nullopt;
  const auto has = [&](uint32_t f, uint32_t v) {
    return std::find(quads_[f].begin(), quads_[f].end(), v) != quads_[f].end();
  };
  const Sector atC = sectorOf(c, has(quad, c) ? quad : six.other), atD = sectorOf(d, has(quad, d) ? quad : six.other);
  const auto gain = [last](const Sector& sector, int more) {
    return sector.uneven(0, last) - sector.uneven(more, last);
  };
  return gain(atA, -1) + gain(atB, -1) + gain(atC, 1) + gain(atD, 1);
}

std::array<uint32_t, 2> QuadWeb::endsOfTurn(uint32_t quad, int corner, int step) const {
  const Six six = sixAround(quad, corner);
  return {six.vertices[size_t(step + 6) % 6], six.vertices[size_t(step + 3) % 6]};
}

void QuadWeb::turn(uint32_t quad, int corner, int step) {
  const Six six = sixAround(quad, corner);
  const auto at = [&](int i) { return six.vertices[size_t(i + 6) % 6]; };
  // Creases among the six sides around both, the first from vertex 0 to 1.
  const auto& o = quads_[six.other];
  const int s = int(std::find(o.begin(), o.end(), six.vertices[0]) - o.begin());
  const std::array<bool, 6> around{isCrease(quad, corner + 1), isCrease(quad, corner + 2), isCrease(quad, corner + 3),
                                   isCrease(six.other, s + 1), isCrease(six.other, s + 2), isCrease(six.other, s + 3)};
  const auto three = [&](int from) {
    int bits = 0;
    for (int i = 0; i < 3; ++i) bits |= int{around[size_t(from + i + 6) % 6]} << i;
    return static_cast<uint8_t>(bits);
  };
  for (const uint32_t f : {quad, six.other})
    for (const uint32_t v : std::array(quads_[f])) removeFrom(v, f);
  // The first quad was b, 1, 2, a, the other a, 4, 5, b: all of it goes on by a step.
  quads_[quad] = {at(step), at(step + 1), at(step + 2), at(step + 3)};
  quads_[six.other] = {at(step + 3), at(step + 4), at(step + 5), at(step)};
  creases_[quad] = three(step);
  creases_[six.other] = three(step + 3);
  for (const uint32_t f : {quad, six.other})
    for (const uint32_t v : quads_[f]) around_[v].push_back(f);
}

uint32_t QuadWeb::add(const Vec3d& at) {
  positions_.push_back(at);
  marked_.push_back(false);
  around_.emplace_back();
  return static_cast<uint32_t>(positions_.size() - 1);
}

void QuadWeb::takeBack(uint32_t first) {
  positions_.resize(first);
  marked_.resize(first);
  around_.resize(first);
}

std::vector<uint32_t> QuadWeb::replace(const std::vector<uint32_t>& going,
                                       const std::vector<std::array<uint32_t, 4>>& quads,
                                       const std::vector<uint32_t>& free,
                                       const std::vector<std::vector<uint32_t>>& lines) {
  std::vector<std::array<uint32_t, 2>> creased;
  for (const auto& line : lines)
    for (size_t k = 0; k + 1 < line.size(); ++k)
      creased.insert(creased.end(), {{line[k], line[k + 1]}, {line[k + 1], line[k]}});
  for (const uint32_t f : going) {
    for (size_t s = 0; s < 4; ++s) {
      if (isCrease(f, int(s))) creased.push_back({quads_[f][s], quads_[f][(s + 1) & 3]});
      removeFrom(quads_[f][s], f);
    }
    quads_[f][0] = kGone;
  }
  std::vector<uint32_t> made;
  for (const auto& quad : quads) {
    const auto f = static_cast<uint32_t>(made.size() < free.size() ? free[made.size()] : quads_.size());
    if (f == quads_.size()) quads_.emplace_back(), creases_.push_back(0);
    quads_[f] = quad;
    creases_[f] = 0;
    for (size_t s = 0; s < 4; ++s) {
      around_[quad[s]].push_back(f);
      if (std::find(creased.begin(), creased.end(), std::array{quad[s], quad[(s + 1) & 3]}) != creased.end())
        creases_[f] = static_cast<uint8_t>(creases_[f] | 1 << s);
    }
    made.push_back(f);
  }
  alive_ = alive_ + quads.size() - going.size();
  return made;
}

QuadMesh QuadWeb::mesh() const {
  QuadMesh out;
  std::vector<uint32_t> index(positions_.size(), kGone);
  for (uint32_t v = 0; v < positions_.size(); ++v) {
    if (around_[v].empty()) continue;
    index[v] = static_cast<uint32_t>(out.positions.size());
    if (isCorner(v)) out.corners.push_back(index[v]);
    out.positions.push_back(positions_[v]);
  }
  for (size_t f = 0; f < quads_.size(); ++f) {
    const auto& q = quads_[f];
    if (q[0] == kGone) continue;
    out.quads.push_back({index[q[0]], index[q[1]], index[q[2]], index[q[3]]});
    out.creases.push_back(creases_[f]);
  }
  return out;
}

QuadWeb::Kept QuadWeb::forgetGone() {
  Kept kept;
  std::vector<uint32_t> vertex(positions_.size(), kGone), quad(quads_.size(), kGone);
  for (uint32_t v = 0; v < positions_.size(); ++v) {
    if (around_[v].empty()) continue;
    vertex[v] = static_cast<uint32_t>(kept.vertices.size());
    kept.vertices.push_back(v);
  }
  for (uint32_t f = 0; f < quads_.size(); ++f) {
    if (!isThere(f)) continue;
    quad[f] = static_cast<uint32_t>(kept.quads.size());
    kept.quads.push_back(f);
  }
  keepOnly(positions_, kept.vertices);
  keepOnly(marked_, kept.vertices);
  keepOnly(around_, kept.vertices);
  keepOnly(quads_, kept.quads);
  keepOnly(creases_, kept.quads);
  for (auto& each : around_)
    for (uint32_t& f : each) f = quad[f];
  for (auto& each : quads_)
    for (uint32_t& v : each) v = vertex[v];
  return kept;
}

}  // namespace argil::clay
