#include "haptics/contact/proxy.h"

#include <algorithm>
#include <cmath>

namespace argil::haptics {
namespace {

// Lengths in voxels of the finest piece.
constexpr double kOnSurface = 1e-6;  // Voxels: nearer than that a direction is rounding.
constexpr double kLookOut = 1.5;     // Voxels, to see where outside is.
constexpr double kOverlap = 0.02;    // Of ball and clay that counts as touching: below what a search resolves.
constexpr double kGiveBack = 0.005;  // Of that overlap, a tick.
// How far smooth normals may lead away from the goal in the steps of a tick.
constexpr double kAway[] = {0.0035, 0.0015, 0};
constexpr double kStill = 1e-3;     // A shorter step is no step; in each further step of a tick it grows:
constexpr double kStillGrowth = 3;  // the next tick does what is left, a hundredth of a voxel.
// After a step that was searched so little more needs no search: what curvature left over.
constexpr double kTrust = 0.015;
constexpr double kKeep = 0.35;  // Contacts farther off than the radius and this are forgotten,
// or than this part of the radius: a small ball would drag along all that it touched.
constexpr double kKeepRadii = 0.08;
constexpr double kLookAhead = 4;   // How far beyond the ball free space is measured: later ticks need no search.
constexpr double kEscapeStep = 4;  // Between two looks along a ray out of deep clay.
constexpr int kEscapeRings = 256;  // So many looks along each ray.

constexpr int kAttempts = 3;  // To bring one step onto the surface before it is halved.
constexpr int kHalvings = 4;
// After a tick in which none of them brought anything (a ball in a socket of its own size).
constexpr int kAttemptsStuck = 2;
// Longest part of the way of what moves, beyond free space, in radii: as seen from it the centre cannot pass.
constexpr double kCarryRadii = 0.4;
constexpr int kMostCarries = 64;         // Parts of a tick's motion at most,
constexpr double kCarrySearches = 0.6;   // and of the searches of a tick.
constexpr int kSettleAttempts = 4;       // To bring the ball out of what came, in each of them.
constexpr double kStepRadii = 0.8;       // Longest step beyond free space, in radii: the centre cannot pass a surface.
constexpr double kMergeCosine = 0.995;   // Contacts at rest whose normals are within 6° are one,
constexpr double kSameCosine = 0.99998;  // and within 0.4° while a step is tried: dropping one would let it in again.

// A smooth normal stands for the true one up to 10°, fades out until 20°: beyond that it is an edge, and edges are
// felt.
constexpr double kSmoothCosine = 0.9848, kEdgeCosine = 0.9397;

// nearestAllowed, the most frequent case first: a single plane and no lock.
ActiveSet solve(const Vec3d& goal, const HalfSpace* planes, int count, const Subspace& within, int hard) noexcept {
  if (within.dimension < 3 || hard > 0) return nearestAllowed(goal, planes, count, within, hard);
  if (count != 1) return nearestAllowed(goal, planes, count);
  ActiveSet result;
  const double wanted = planes[0].offset - planes[0].normal.dot(goal);
  result.count = wanted > 0;
  result.multiplier[0] = wanted;
  result.x = wanted > 0 ? Vec3d(goal + wanted * planes[0].normal) : goal;
  return result;
}

// Directions to look for a way out of deep clay: faces, edges and corners of a cube.
struct EscapeRays {
  std::array<Vec3d, 26> direction;
  EscapeRays() {
    size_t n = 0;
    for (int size = 1; size <= 3; ++size)
      for (int i = 0; i < 27; ++i) {
        const Vec3d d(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1);
        if (static_cast<int>(d.squaredNorm()) == size) direction[n++] = d.normalized();
      }
  }
};
const EscapeRays kEscape;

}  // namespace

void Proxy::reset(const Vec3d& at) noexcept {
  proxy_ = at;
  contactCount_ = 0;
  clearance_ = 0;
  escapeRing_ = 0;
  escapeRay_ = -1;
  stuck_ = false;
}

void Proxy::begin(Surroundings& around, const Guides& guides, const Quality& quality, double radiusMm) ARGIL_REALTIME {
  around_ = &around;
  voxel_ = around.empty() ? radiusMm : around.resolutionMm();
  radius_ = radiusMm;
  keep_ = std::min(kKeep * voxel_, kKeepRadii * radiusMm + kOverlap * voxel_);
  part_ = 0;
  steps_ = quality.contactSteps;
  mostSearches_ = quality.contactSearches;
  smoothNormals_ = quality.smoothNormals;
  searches_ = 0;
  guides_ = &guides;
  locked_ = guides.locked();
  if (locked_) {
    const Vec3d before = proxy_;
    proxy_ = guides.snap(proxy_);
    clearance_ -= (proxy_ - before).norm();
  }
  prune();
}

Vec3d Proxy::snapped(const Vec3d& p) const ARGIL_REALTIME {
  return locked_ ? guides_->snap(p) : p;
}

bool Proxy::caught() const noexcept {
  return radius_ - clearance_ > 1.2 * kOverlap * voxel_;
}

// The nearest surface of all things within the radius and kLookAhead.
Around Proxy::search(const Vec3d& p) ARGIL_REALTIME {
  ++searches_;
  return around_->nearest(p, radius_ + kLookAhead * voxel_);
}

void Proxy::refresh() ARGIL_REALTIME {
  stuck_ = false;
  // What was known of the surface is old: begin from the nearest point of the new one.
  const Around here = search(proxy_);
  place(proxy_, here.distance);
  int kept = 0;
  for (int i = 0; i < contactCount_; ++i) {
    const ContactPoint c = contacts_[size_t(i)];
    if (!around_->holds(c.thing, c.point)) continue;
    contacts_[size_t(kept)] = c;
    contacts_[size_t(kept++)].smoothKnown = false;
  }
  contactCount_ = kept;
  if (here.distance < radius_ + keep_) note(here, kMergeCosine);
}

// A point that holds the ball, in place of those that say the same: their normals differ by less than the angle.
void Proxy::note(const Around& found, double mergeCosine) ARGIL_REALTIME {
  if (!found.found) return;
  const Vec3d normal = (proxy_ - found.point).normalized();
  int kept = 0, farthest = 0;
  for (int i = 0; i < contactCount_; ++i) {
    const ContactPoint old = contacts_[size_t(i)];
    if ((proxy_ - old.point).normalized().dot(normal) > mergeCosine) continue;
    contacts_[size_t(kept)] = old;
    if ((proxy_ - old.point).squaredNorm() > (proxy_ - contacts_[size_t(farthest)].point).squaredNorm())
      farthest = kept;
    ++kept;
  }
  const size_t slot = size_t(kept == kMaxContacts ? farthest : kept++);
  contacts_[slot].point = found.point;
  contacts_[slot].thing = found.thing;
  contacts_[slot].smoothKnown = false;
  contactCount_ = kept;
}

void Proxy::place(const Vec3d& p, double clearanceMm) ARGIL_REALTIME {
  // Seen from the other side of a surface its points push the other way.
  if ((clearanceMm < 0) != (clearance_ < 0)) contactCount_ = 0;
  proxy_ = p;
  clearance_ = clearanceMm;
}

void Proxy::prune() ARGIL_REALTIME {
  int kept = 0;
  for (int i = 0; i < contactCount_; ++i)
    if ((proxy_ - contacts_[size_t(i)].point).norm() < radius_ + keep_)
      contacts_[size_t(kept++)] = contacts_[size_t(i)];
  contactCount_ = kept;
}

// The surface's own normal at the contact, as far as it says the same as the direction to the ball.
void Proxy::smoothen(ContactPoint& contact, const Vec3d& normal) ARGIL_REALTIME {
  if (!contact.smoothKnown) {
    contact.smooth = around_->normal(contact.thing, contact.point);
    contact.smoothKnown = true;
  }
  if (contact.smooth.dot(normal) < 0) contact.smooth = -contact.smooth;
}

// Nearest place to the goal under the planes of all contacts, as seen from the proxy: each touches the ball of radius r
// around a point of the surface, so nothing that the point forbids is allowed, and the proxy itself always is. An
// overlap within the tolerance is given back little by little: that only restores what the tolerance took from the
// spring before, and without it the proxy would creep to the tolerance's end and search in vain there. Two passes
// (Ruspini et al. 1997): under planes turned to the smooth normals first, then from there under the true ones.
Proxy::Holding Proxy::holding(const Vec3d& goal) ARGIL_REALTIME {
  Holding result;
  std::array<HalfSpace, kMaxHalfSpaces> planes, smooth;
  std::array<int, kMaxHalfSpaces> source;
  std::array<double, kMaxHalfSpaces> given{};
  const double side = clearance_ < 0 ? -1.0 : 1.0;
  int count = 0, hard = 0;
  bool turned = false;
  const auto take = [&](ContactPoint& contact) {
    const Vec3d away = proxy_ - contact.point;
    const double distance = away.norm();
    if (!(distance > 1e-12)) return;
    const Vec3d normal = away * (side / distance);
    const double apart = side * distance;
    const double giveBack = part_ == 0 && apart > radius_ - 2 * kOverlap * voxel_ ? kGiveBack * voxel_ : 0.0;
    const double offset = normal.dot(contact.point) + std::min(radius_, apart + giveBack);
    const size_t k = size_t(count++);
    planes[k] = smooth[k] = {normal, offset};
    source[k] = static_cast<int>(&contact - contacts_.data());
    given[k] = giveBack;
    if (!smoothNormals_ || side < 0) return;
    smoothen(contact, normal);
    const double cosine = contact.smooth.dot(normal);
    if (cosine <= kEdgeCosine) return;
    const double weight = std::min(1.0, (cosine - kEdgeCosine) / (kSmoothCosine - kEdgeCosine));
    const Vec3d n = weight >= 1 ? contact.smooth : Vec3d((normal + weight * (contact.smooth - normal)).normalized());
    // Leaves the proxy as much room as the true plane does.
    smooth[k] = {n, n.dot(proxy_) - (normal.dot(proxy_) - offset)};
    turned = true;
  };
  // The harder first.
  for (int i = 0; i < contactCount_; ++i)
    if (around_->hard(contacts_[size_t(i)].thing)) take(contacts_[size_t(i)]);
  hard = count;
  for (int i = 0; i < contactCount_; ++i)
    if (!around_->hard(contacts_[size_t(i)].thing)) take(contacts_[size_t(i)]);

  const Subspace within = locked_ ? guides_->lockAt(proxy_) : Subspace();
  ActiveSet active;
  if (turned) {
    active = solve(goal, smooth.data(), count, within, hard);
    Vec3d sub = active.x;
    if (active.feasible && active.count > 0 && !locked_) {
      // Above all true planes it would hover: back onto the nearest of them.
      double least = planes[0].normal.dot(sub) - planes[0].offset;
      int nearest = 0;
      for (int i = 1; i < count; ++i) {
        const double above = planes[size_t(i)].normal.dot(sub) - planes[size_t(i)].offset;
        if (above < least) least = above, nearest = i;
      }
      if (least > 0) sub -= least * planes[size_t(nearest)].normal;
    }
    result.place = solve(active.feasible ? sub : goal, planes.data(), count, within, hard).x;
    // The smooth normals may lead away from the goal, up to where they hold it: little by little.
    const double farther = (result.place - goal).norm() - (proxy_ - goal).norm(),
                 most = kAway[std::min(part_, 2)] * voxel_;
    if (farther > most && !locked_) result.place = proxy_ + (result.place - proxy_) * (most / farther);
  }
  if (!turned || !active.feasible) {
    active = solve(goal, planes.data(), count, within, hard);
    if (!active.feasible) {
      result.conflict = locked_ || hard > 0;
      // In a socket opposite planes cannot all give back. Without that the proxy's own place is always allowed.
      for (size_t i = 0; i < size_t(count); ++i) planes[i].offset -= given[i];
      turned = false;
      active = solve(goal, planes.data(), count, within, hard);
    }
    result.place = active.feasible || locked_ ? active.x : proxy_;
  }
  result.feasible = active.feasible;
  result.push = active.x - within.nearest(goal);
  result.count = active.count;
  for (size_t i = 0; i < size_t(active.count); ++i) {
    const auto k = size_t(active.active[i]);
    const ContactPoint& contact = contacts_[size_t(source[k])];
    result.thing[i] = contact.thing;
    result.point[i] = contact.point;
    result.plane[i] = turned ? smooth[k] : planes[k];
    result.share[i] = active.multiplier[i];
  }
  return result;
}

bool Proxy::touches(const ContactPoint& contact) const ARGIL_REALTIME {
  return (proxy_ - contact.point).norm() < radius_ + 2 * kOverlap * voxel_;
}

// In the frame of what is touched the ball stays where it is while that moves, and what it does not touch
// comes at it. No part of the way is longer than free space and a part of the radius, so the centre cannot pass a
// surface.
Proxy::Carried Proxy::carry(double gentleMm) ARGIL_REALTIME {
  Carried result;
  if (!around_->moving()) return result;
  std::array<int, kMaxContacts> touching{};
  size_t count = 0;
  for (int i = 0; i < contactCount_; ++i)
    if (touches(contacts_[size_t(i)])) touching[count++] = contacts_[size_t(i)].thing;
  around_->startMotion(proxy_, std::span(touching).first(count), gentleMm);
  const int mostSearches = static_cast<int>(kCarrySearches * mostSearches_);
  double done = 0;
  for (int part = 0; done < 1 && result.whole; ++part) {
    const double longest = std::max(0.0, clearance_ - radius_) + kCarryRadii * radius_;
    double step = 1 - done, way = around_->way(proxy_, done, 1);
    while (way > longest && step > 1e-6) {
      step *= std::max(0.1, 0.9 * longest / way);
      way = around_->way(proxy_, done, done + step);
    }
    result.whole = way <= longest && part < kMostCarries && searches_ + kSettleAttempts <= mostSearches;
    if (!result.whole) break;
    const double next = done + step >= 1 ? 1 : done + step;
    const std::array<ContactPoint, kMaxContacts> contacts = contacts_;
    const int contactCount = contactCount_;
    around_->advance(next);
    result.whole = carryOn(way, result);
    if (result.whole) {
      done = next;
    } else {
      around_->advance(done);
      contacts_ = contacts;
      contactCount_ = contactCount;
    }
  }
  around_->endMotion();
  if (done > 0) stuck_ = false;
  return result;
}

// What moves is at the next part of its way, up to `way` from where it was as seen from there. False, and only contacts
// changed, where no place was found for the ball.
bool Proxy::carryOn(double way, Carried& result) ARGIL_REALTIME {
  const Vec3d before = proxy_;
  const double allowed = std::max(kOverlap * voxel_, radius_ - clearance_), side = clearance_ < 0 ? -1.0 : 1.0;
  // With the contact that carries it farthest; as seen from their things the other contacts are where they were.
  Vec3d goal = proxy_;
  double farthest = 0;
  bool carried = false;
  for (int i = 0; i < contactCount_; ++i) {
    const ContactPoint& contact = contacts_[size_t(i)];
    if (!around_->moves(contact.thing) || !touches(contact)) continue;
    carried = true;
    const Vec3d there = around_->carriedBy(contact.thing, before);
    if ((there - before).norm() <= farthest) continue;
    farthest = (there - before).norm();
    goal = there;
  }
  std::array<HalfSpace, kMaxHalfSpaces> planes;
  int count = 0, hard = 0;
  for (const bool first : {true, false}) {
    for (int i = 0; i < contactCount_; ++i) {
      ContactPoint& contact = contacts_[size_t(i)];
      if (around_->hard(contact.thing) != first) continue;
      const Vec3d away = around_->turnedBy(contact.thing, before - contact.point);
      contact.point = around_->carriedBy(contact.thing, contact.point);
      contact.smooth = around_->turnedBy(contact.thing, contact.smooth);
      const double distance = away.norm();
      if (!(distance > 1e-12)) continue;
      const Vec3d normal = away * (side / distance);
      planes[size_t(count++)] = {normal, normal.dot(contact.point) + std::min(radius_, side * distance)};
    }
    if (first) hard = count;
  }
  if (!carried && way <= clearance_ - radius_) {
    clearance_ -= way;
    return true;
  }
  const Subspace within = locked_ ? guides_->lockAt(before) : Subspace();
  const double reach = 2 * way + kCarryRadii * radius_;
  for (int attempt = 0; attempt < kSettleAttempts; ++attempt) {
    const ActiveSet active = solve(goal, planes.data(), count, within, hard);
    const Vec3d at = snapped(active.x);
    if (!active.feasible || (at - before).norm() > reach) return false;
    const Around there = search(at);
    if (radius_ - there.distance <= allowed) {
      place(at, there.distance);
      prune();
      if (there.distance < radius_ + keep_) note(there, kMergeCosine);
      if (carried || at != before) result.pushed = true;
      if (there.found && there.distance < radius_ + keep_) around_->holdIfGentle(there.thing);
      return true;
    }
    const Vec3d away = at - there.point;
    const double distance = away.norm();
    if (!there.found || !(distance > 1e-12) || count == kMaxHalfSpaces) return false;
    const Vec3d normal = away * ((there.distance < 0 ? -1.0 : 1.0) / distance);
    planes[size_t(count)] = {normal, normal.dot(there.point) + radius_};
    if (around_->hard(there.thing)) std::swap(planes[size_t(hard++)], planes[size_t(count)]);
    ++count;
  }
  return false;
}

// Clay grew around the ball: out along the nearest surface; where that brings nothing (held from all sides) it rests.
// False while it is so deep that no surface is in reach: then it does not follow the hand either.
bool Proxy::leave(double stepMm) ARGIL_REALTIME {
  const double length = std::min(stepMm, radius_ - clearance_);
  const Around here = search(proxy_);
  place(proxy_, here.distance);
  if (!here.found) {
    if (clearance_ < 0) leaveDepth(length);
    return clearance_ >= 0;
  }
  escapeRing_ = 0;
  escapeRay_ = -1;
  Vec3d way = (here.distance < 0 ? -1.0 : 1.0) * (proxy_ - here.point);
  // A centre on the surface itself, as where a pointer turns up, has no nearest point to go away from.
  if (!(way.norm() > kOnSurface * voxel_)) way = outwards();
  if (!(way.norm() > 0)) return true;
  way.normalize();
  // The other contacts hold it off where they can.
  const Vec3d before = proxy_;
  Vec3d goal = holding(proxy_ + way * length).place;
  if (const double far = (goal - before).norm(); far > length) goal = before + (goal - before) * (length / far);
  goal = snapped(goal);
  const Around there = search(goal);
  if (there.distance > here.distance + 1e-3 * length) {
    place(goal, there.distance);
    prune();
    note(there, kMergeCosine);
  } else {
    note(there, kMergeCosine);
    note(here, kMergeCosine);
  }
  return true;
}

// To where less of the clay around is.
Vec3d Proxy::outwards() const ARGIL_REALTIME {
  Vec3d sum = Vec3d::Zero();
  for (const Vec3d& direction : kEscape.direction)
    sum += around_->inside(proxy_ + kLookOut * voxel_ * direction) ? Vec3d(-direction) : direction;
  return sum;
}

// Too deep for a search: along the first of 26 rays that leaves the clay, looked for in a few places a tick.
void Proxy::leaveDepth(double length) ARGIL_REALTIME {
  if (escapeRay_ < 0) {
    if (escapeRing_ >= kEscapeRings) escapeRing_ = 0;
    const double reach = (escapeRing_ + 1) * kEscapeStep * voxel_;
    for (size_t i = 0; i < kEscape.direction.size() && escapeRay_ < 0; ++i)
      if (!around_->inside(proxy_ + reach * kEscape.direction[i])) escapeRay_ = static_cast<int>(i);
    ++escapeRing_;
    if (escapeRay_ < 0) return;
  }
  proxy_ += length * kEscape.direction[size_t(escapeRay_)];
  contactCount_ = 0;
}

bool Proxy::follow(const Vec3d& goal, const Holding& held) ARGIL_REALTIME {
  const Vec3d before = proxy_;
  const double wanted = (held.place - proxy_).norm();
  const bool whole = step(goal, held, stuck_ ? kAttemptsStuck : kAttempts + kHalvings);
  stuck_ = proxy_ == before && wanted >= kStill * voxel_;
  return whole;
}

bool Proxy::step(const Vec3d& goal, const Holding& held, int attempts) ARGIL_REALTIME {
  const double allowed = std::max(kOverlap * voxel_, radius_ - clearance_);
  double still = kStill * voxel_;
  Vec3d move = held.place - proxy_;
  for (int part = 0; part < steps_; ++part, still *= kStillGrowth) {
    part_ = part;
    if (part > 0) {
      prune();
      move = holding(goal).place - proxy_;
    }
    double length = move.norm();
    const double open = clearance_ - radius_;
    // Nothing is in between; or hardly anything is left to do.
    const bool little = part > 0 && length < kTrust * voxel_ && length - open < kOverlap * voxel_;
    if (length < still && length > open) return true;
    if (length <= open || little) {
      proxy_ = snapped(proxy_ + move);
      clearance_ -= length;
      return true;
    }
    bool moved = false;
    int halvings = 0;
    for (int attempt = 0; attempt < attempts && !moved; ++attempt) {
      if (searches_ >= mostSearches_) return false;
      const double longest = std::max(open, 0.0) + kStepRadii * radius_;
      if (length > longest) move *= longest / length;
      const Vec3d candidate = snapped(proxy_ + move);
      // Contacts that contradict each other by rounding may ask for a step away.
      if (!locked_ && (candidate - goal).norm() > (proxy_ - goal).norm() + 2 * kGiveBack * voxel_) return true;
      const Around there = search(candidate);
      if (radius_ - there.distance <= allowed) {
        place(candidate, there.distance);
        if (there.distance < radius_ + keep_) note(there, kMergeCosine);
        moved = true;
        break;
      }
      note(there, kSameCosine);
      const Vec3d again = holding(goal).place - proxy_;
      if (attempt + 1 < kAttempts && (again - move).norm() > still) {
        move = again;
      } else {
        // The same step again, or no end of new planes: a straight part of the way, which is always nearer to the goal.
        move = 0.4 * (again.norm() < move.norm() ? again : move);
        if (++halvings > kHalvings) return true;
      }
      length = move.norm();
      if (length < still) return true;
    }
    if (!moved) return true;
  }
  return true;
}

}  // namespace argil::haptics
