#include "clay/cage/quad_web.h"

#include <algorithm>
#include <utility>

#include "clay/base/error.h"

namespace argil::clay {

namespace {

int uneven(size_t valence) {
  const int from4 = static_cast<int>(valence) - 4;
  return from4 * from4;
}

}  // namespace

QuadWeb::QuadWeb(QuadMesh mesh)
    : positions_(std::move(mesh.positions)), quads_(std::move(mesh.quads)), around_(positions_.size()) {
  (void)QuadTopology(positions_.size(), quads_);  // throws
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

bool QuadWeb::areBeside(uint32_t a, uint32_t b) const {
  return std::any_of(around_[a].begin(), around_[a].end(), [&](uint32_t f) {
    const auto& q = quads_[f];
    const auto s = size_t(std::find(q.begin(), q.end(), a) - q.begin());
    return q[(s + 1) & 3] == b;
  });
}

// The quad that has the side from `from` to `to`.
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

std::optional<int> QuadWeb::gainOfCollapse(uint32_t quad, int corner) const {
  const auto& q = quads_[quad];
  const uint32_t a = q[size_t(corner) & 3], b = q[size_t(corner + 1) & 3], c = q[size_t(corner + 2) & 3],
                 d = q[size_t(corner + 3) & 3];
  const size_t va = around_[a].size(), vb = around_[b].size(), vc = around_[c].size(), vd = around_[d].size();
  const size_t merged = va + vc - 2;
  if (merged < 3 || merged > kMostAround) return std::nullopt;
  // Of a vertex that keeps two quads these two become one.
  const bool bGoes = vb == 3, dGoes = vd == 3;
  if (bGoes && dGoes) return std::nullopt;
  // Nothing else may join a and c: no quad, no path of two edges.
  for (const uint32_t f : around_[a])
    if (f != quad && std::find(quads_[f].begin(), quads_[f].end(), c) != quads_[f].end()) return std::nullopt;
  std::vector<uint32_t> ofA, ofC;
  beside(a, ofA);
  beside(c, ofC);
  for (const uint32_t v : ofA)
    if (v == c || (v != b && v != d && std::find(ofC.begin(), ofC.end(), v) != ofC.end())) return std::nullopt;
  int gain = uneven(va) + uneven(vb) + uneven(vc) + uneven(vd) - uneven(merged);
  if (!bGoes && !dGoes) return gain - uneven(vb - 1) - uneven(vd - 1);
  const uint32_t goes = bGoes ? b : d, stays = bGoes ? d : b;
  // Around it are the quad and two more, which share the edge to its third neighbour.
  std::vector<uint32_t> ofGoing;
  beside(goes, ofGoing);
  uint32_t third = kGone;
  for (const uint32_t v : ofGoing)
    if (v != a && v != c) third = v;
  if (third == kGone || third == stays) return std::nullopt;
  std::array<uint32_t, 2> ends{};  // opposite to it in the two quads: sides of one quad afterwards
  size_t found = 0;
  for (const uint32_t f : around_[goes]) {
    if (f == quad) continue;
    const auto& o = quads_[f];
    const auto s = size_t(std::find(o.begin(), o.end(), goes) - o.begin());
    if (found < 2) ends[found++] = o[(s + 2) & 3];
  }
  if (found != 2 || ends[0] == ends[1] || ends[0] == stays || ends[1] == stays) return std::nullopt;
  const size_t vt = around_[third].size();
  if (merged < 4 || vt < 4) return std::nullopt;
  gain += uneven(merged) - uneven(merged - 1) + uneven(vt) - uneven(vt - 1) - uneven(around_[stays].size() - 1);
  return gain;
}

uint32_t QuadWeb::collapse(uint32_t quad, int corner) {
  const auto q = quads_[quad];
  const uint32_t a = q[size_t(corner) & 3], b = q[size_t(corner + 1) & 3], c = q[size_t(corner + 2) & 3],
                 d = q[size_t(corner + 3) & 3];
  for (const uint32_t v : q) removeFrom(v, quad);
  for (const uint32_t f : around_[c]) {
    std::replace(quads_[f].begin(), quads_[f].end(), c, a);
    around_[a].push_back(f);
  }
  around_[c].clear();
  quads_[quad][0] = kGone;
  --alive_;
  for (const uint32_t goes : {b, d}) {
    if (around_[goes].size() != 2) continue;
    const uint32_t f = around_[goes][0], other = around_[goes][1];
    const auto& o = quads_[other];
    const auto s = size_t(std::find(o.begin(), o.end(), goes) - o.begin());
    const uint32_t end = o[(s + 2) & 3];
    std::replace(quads_[f].begin(), quads_[f].end(), goes, end);
    around_[end].push_back(f);
    for (const uint32_t v : std::array(quads_[other]))
      if (v != goes) removeFrom(v, other);
    around_[goes].clear();
    quads_[other][0] = kGone;
    --alive_;
  }
  return a;
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

std::optional<int> QuadWeb::gainOfTurn(uint32_t quad, int corner, int step) const {
  const Six six = sixAround(quad, corner);
  if (six.other == quad) return std::nullopt;
  const uint32_t a = six.vertices[0], b = six.vertices[3], c = six.vertices[size_t(step + 6) % 6],
                 d = six.vertices[size_t(step + 3) % 6];
  const size_t va = around_[a].size(), vb = around_[b].size(), vc = around_[c].size(), vd = around_[d].size();
  if (va < 4 || vb < 4 || vc >= kMostAround || vd >= kMostAround || c == d || areBeside(c, d)) return std::nullopt;
  for (size_t i = 0; i < 6; ++i)
    for (size_t j = 0; j < i; ++j)
      if (six.vertices[i] == six.vertices[j]) return std::nullopt;
  return uneven(va) + uneven(vb) + uneven(vc) + uneven(vd) - uneven(va - 1) - uneven(vb - 1) - uneven(vc + 1) -
         uneven(vd + 1);
}

std::array<uint32_t, 2> QuadWeb::endsOfTurn(uint32_t quad, int corner, int step) const {
  const Six six = sixAround(quad, corner);
  return {six.vertices[size_t(step + 6) % 6], six.vertices[size_t(step + 3) % 6]};
}

void QuadWeb::turn(uint32_t quad, int corner, int step) {
  const Six six = sixAround(quad, corner);
  const auto at = [&](int i) { return six.vertices[size_t(i + 6) % 6]; };
  for (const uint32_t f : {quad, six.other})
    for (const uint32_t v : std::array(quads_[f])) removeFrom(v, f);
  // The first quad was b, 1, 2, a, the other a, 4, 5, b: all of it goes on by a step.
  quads_[quad] = {at(step), at(step + 1), at(step + 2), at(step + 3)};
  quads_[six.other] = {at(step + 3), at(step + 4), at(step + 5), at(step)};
  for (const uint32_t f : {quad, six.other})
    for (const uint32_t v : quads_[f]) around_[v].push_back(f);
}

QuadMesh QuadWeb::mesh() const {
  QuadMesh out;
  std::vector<uint32_t> index(positions_.size(), kGone);
  for (uint32_t v = 0; v < positions_.size(); ++v) {
    if (around_[v].empty()) continue;
    index[v] = static_cast<uint32_t>(out.positions.size());
    out.positions.push_back(positions_[v]);
  }
  for (const auto& q : quads_)
    if (q[0] != kGone) out.quads.push_back({index[q[0]], index[q[1]], index[q[2]], index[q[3]]});
  return out;
}

}  // namespace argil::clay
