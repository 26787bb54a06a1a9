#include "haptics/ball_contact.h"

#include <algorithm>
#include <cmath>

#include "haptics/sample_ring.h"

namespace argil::haptics {
namespace {

// Lengths in voxels of the finest piece.
constexpr double kOverlap = 0.02;       // Of ball and clay that counts as touching: below what a search resolves.
constexpr double kGiveBack = 0.005;     // Of that overlap, a tick.
constexpr double kStill = 1e-3;         // A shorter step is no step; in each further step of a tick it grows:
constexpr double kStillGrowth = 3;      // the next tick does what is left, a hundredth of a voxel.
constexpr double kKeep = 0.35;          // Contacts farther off than the radius and this are forgotten.
constexpr double kLookAhead = 4;        // How far beyond the ball free space is measured: later ticks need no search.
constexpr double kEscapeStep = 4;       // Between two looks along a ray out of deep clay.
constexpr int kEscapeRings = 256;       // So many looks along each ray.

constexpr int kSteps = 8;               // Of the proxy in a tick (methods, §12.1).
constexpr int kAttempts = 3;            // To bring one step onto the surface before it is halved.
constexpr int kHalvings = 4;
constexpr int kAttemptsStuck = 2;       // After a tick in which none of them brought anything (a ball in a socket of its own size).
constexpr int kSearches = 20;           // Bound of a tick's cost: then the proxy goes on in the next tick.
constexpr double kStepRadii = 0.8;      // Longest step beyond free space, in radii: the centre cannot pass a surface.
constexpr double kMergeCosine = 0.995;  // Contacts at rest whose normals are within 6° are one,
constexpr double kSameCosine = 0.99998; // and within 0.4° while a step is tried: dropping one would let it in again.

constexpr double kLeaveSpeedMms = 30;       // Out of clay that grew around the ball (methods, §12.5).
constexpr double kLeaveForcePerS = 6.0;     // In peaks a second: 6 % of the peak in 10 ms; 7 % is felt (methods, §10).
constexpr double kSettleS = 0.25;           // How long a finished cut waits for its edit.

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

void BallContact::reset() noexcept {
  begun_ = false;
  mode_ = Mode::touch;
  contactCount_ = 0;
  clearance_ = 0;
  escapeRing_ = 0;
  escapeRay_ = -1;
  nearKnown_ = false;
  stuck_ = false;
  law_.reset();
}

// The nearest surface of all pieces within the radius and kLookAhead. Inside of any piece counts as inside.
Nearest BallContact::search(const Vec3d& p) ARGIL_REALTIME {
  ++searches_;
  const double reach = radius_ + kLookAhead * voxel_;
  Nearest best{false, p, reach};
  for (TouchableClay& piece : used_) {
    // Deeper inside one piece beats any distance outside of another.
    const Nearest n = piece.nearest(p, reach, nearKnown_ ? &near_ : nullptr);
    if (n.distance < best.distance) best = n;
  }
  nearKnown_ = best.found;
  if (best.found) near_ = best.point;
  return best;
}

// A point that holds the ball, in place of those that say the same: their normals differ by less than the angle.
void BallContact::note(const Nearest& nearest, double mergeCosine) ARGIL_REALTIME {
  if (!nearest.found) return;
  const Vec3d normal = (proxy_ - nearest.point).normalized();
  int kept = 0, farthest = 0;
  for (int i = 0; i < contactCount_; ++i) {
    const Vec3d old = contacts_[size_t(i)];
    if ((proxy_ - old).normalized().dot(normal) > mergeCosine) continue;
    contacts_[size_t(kept)] = old;
    if ((proxy_ - old).squaredNorm() > (proxy_ - contacts_[size_t(farthest)]).squaredNorm()) farthest = kept;
    ++kept;
  }
  if (kept == kMaxContacts) contacts_[size_t(farthest)] = nearest.point;
  else contacts_[size_t(kept++)] = nearest.point;
  contactCount_ = kept;
}

void BallContact::place(const Vec3d& p, double clearanceMm) ARGIL_REALTIME {
  // Seen from the other side of a surface its points push the other way.
  if ((clearanceMm < 0) != (clearance_ < 0)) contactCount_ = 0;
  proxy_ = p;
  clearance_ = clearanceMm;
}

void BallContact::prune() ARGIL_REALTIME {
  int kept = 0;
  for (int i = 0; i < contactCount_; ++i)
    if ((proxy_ - contacts_[size_t(i)]).norm() < radius_ + kKeep * voxel_) contacts_[size_t(kept++)] = contacts_[size_t(i)];
  contactCount_ = kept;
}

// Nearest place to the goal under the planes of all contacts, as seen from the proxy: each touches the ball of radius r around
// a point of the surface, so nothing that the point forbids is allowed, and the proxy itself always is. An overlap within the
// tolerance is given back little by little: that only restores what the tolerance took from the spring before, and without it
// the proxy would creep to the tolerance's end and search in vain there.
ActiveSet BallContact::target(const Vec3d& goal) const ARGIL_REALTIME {
  std::array<HalfSpace, kMaxHalfSpaces> planes;
  const double side = clearance_ < 0 ? -1.0 : 1.0;
  int count = 0;
  for (int i = 0; i < contactCount_; ++i) {
    const Vec3d& point = contacts_[size_t(i)];
    const Vec3d away = proxy_ - point;
    const double distance = away.norm();
    if (!(distance > 1e-12)) continue;
    const Vec3d normal = away * (side / distance);
    const double apart = side * distance;
    const double giveBack = giving_ && apart > radius_ - 2 * kOverlap * voxel_ ? kGiveBack * voxel_ : 0.0;
    planes[size_t(count++)] = {normal, normal.dot(point) + std::min(radius_, apart + giveBack)};
  }
  return nearestAllowed(goal, planes.data(), count);
}

// Clay grew around the ball: out along the nearest surface at a bounded speed; where that brings nothing (held from all sides)
// it rests. False while it is so deep that no surface is in reach: then it does not follow the hand either.
bool BallContact::leave(double periodS, double stiffness, double peakN) ARGIL_REALTIME {
  const double speed = std::min(kLeaveSpeedMms, kLeaveForcePerS * peakN / stiffness);
  const double overlap = radius_ - clearance_;
  const double step = std::min(speed * periodS, overlap);
  const Nearest here = search(proxy_);
  place(proxy_, here.distance);
  if (!here.found) {
    if (clearance_ < 0) leaveDepth(step);
    return clearance_ >= 0;
  }
  escapeRing_ = 0;
  escapeRay_ = -1;
  const double side = here.distance < 0 ? -1.0 : 1.0;
  Vec3d way = proxy_ - here.point;
  if (!(way.norm() > 1e-9 * voxel_)) return true;
  way *= side / way.norm();
  // The other contacts hold it off where they can.
  const Vec3d before = proxy_;
  Vec3d goal = proxy_ + way * step;
  const ActiveSet open = target(goal);
  goal = open.feasible ? open.x : goal;
  if (const double length = (goal - before).norm(); length > step) goal = before + (goal - before) * (step / length);
  const Nearest there = search(goal);
  if (there.distance > here.distance + 1e-3 * step) {
    place(goal, there.distance);
    prune();
    note(there, kMergeCosine);
  } else {
    note(there, kMergeCosine);
    note(here, kMergeCosine);
  }
  return true;
}

// Too deep for a search: along the first of 26 rays that leaves the clay, looked for in a few places a tick.
void BallContact::leaveDepth(double step) ARGIL_REALTIME {
  if (escapeRay_ < 0) {
    if (escapeRing_ >= kEscapeRings) escapeRing_ = 0;
    const double reach = (escapeRing_ + 1) * kEscapeStep * voxel_;
    for (size_t i = 0; i < kEscape.direction.size() && escapeRay_ < 0; ++i) {
      bool inside = false;
      for (TouchableClay& piece : used_) {
        const Vec3d at = proxy_ + reach * kEscape.direction[i];
        inside = inside || piece.surface().inside(piece.toVoxel(at));
      }
      if (!inside) escapeRay_ = static_cast<int>(i);
    }
    ++escapeRing_;
    if (escapeRay_ < 0) return;
  }
  proxy_ += step * kEscape.direction[size_t(escapeRay_)];
  contactCount_ = 0;
}

// The proxy towards the hand, in straight steps that end at first contact, then along the surface (methods, §§1, 12).
void BallContact::follow(const Vec3d& hand, uint32_t& flags) ARGIL_REALTIME {
  const Vec3d before = proxy_;
  const double wanted = (target(hand).x - proxy_).norm();
  step(hand, stuck_ ? kAttemptsStuck : kAttempts + kHalvings, flags);
  stuck_ = proxy_ == before && wanted >= kStill * voxel_;
}

void BallContact::step(const Vec3d& hand, int attempts, uint32_t& flags) ARGIL_REALTIME {
  const double allowed = std::max(kOverlap * voxel_, radius_ - clearance_);
  double still = kStill * voxel_;
  for (int part = 0; part < kSteps; ++part, still *= kStillGrowth) {
    prune();
    giving_ = part == 0;
    Vec3d move = target(hand).x - proxy_;
    double length = move.norm();
    if (length < still) return;
    const double open = clearance_ - radius_;
    if (length <= open) {  // Nothing is in between.
      proxy_ += move;
      clearance_ -= length;
      return;
    }
    bool moved = false;
    int halvings = 0;
    for (int attempt = 0; attempt < attempts && !moved; ++attempt) {
      if (searches_ >= kSearches) {
        flags |= kIncomplete;
        return;
      }
      const double longest = std::max(open, 0.0) + kStepRadii * radius_;
      if (length > longest) move *= longest / length;
      const Vec3d candidate = proxy_ + move;
      const Nearest there = search(candidate);
      if (radius_ - there.distance <= allowed) {
        place(candidate, there.distance);
        if (there.distance < radius_ + kKeep * voxel_) note(there, kMergeCosine);
        moved = true;
        break;
      }
      note(there, kSameCosine);
      const Vec3d again = target(hand).x - proxy_;
      if (attempt + 1 < kAttempts && (again - move).norm() > still) {
        move = again;
      } else {
        // The same step again, or no end of new planes: a straight part of the way, which is always nearer to the hand.
        move = 0.4 * (again.norm() < move.norm() ? again : move);
        if (++halvings > kHalvings) return;
      }
      length = move.norm();
      if (length < still) return;
    }
    if (!moved) return;
  }
}

void BallContact::changeMode(const Scene& scene, const Input& input) ARGIL_REALTIME {
  Mode wanted = Mode::touch;
  if (input.operate && scene.tool.operation == clay::Operation::carve) wanted = Mode::cut;
  if (input.operate && scene.tool.operation == clay::Operation::add) wanted = Mode::add;
  if (wanted == Mode::touch && (mode_ == Mode::cut || mode_ == Mode::settle)) {
    // The edit is still on its way: clay that was cut must not push back as if it were there.
    settleS_ = mode_ == Mode::cut ? 0 : settleS_ + input.periodS;
    if (law_.pending() && settleS_ < kSettleS) wanted = Mode::settle;
  }
  if (wanted == Mode::touch && mode_ != Mode::touch) missed_ = true;
  if (wanted != Mode::cut && wanted != Mode::settle) law_.reset();
  mode_ = wanted;
}

void BallContact::touch(const Input& input, bool changed, Output& out) ARGIL_REALTIME {
  const double stiffness = input.topStiffnessNmm;
  if (changed) {
    stuck_ = false;
    // What was known of the surface is old: begin from the nearest point of the new one.
    const Nearest here = search(proxy_);
    place(proxy_, here.distance);
    int kept = 0;
    for (int i = 0; i < contactCount_; ++i) {
      // Contacts stay where the new surface still has them.
      const Vec3d c = contacts_[size_t(i)];
      for (TouchableClay& piece : used_) {
        const Vec3d at = piece.toVoxel(c);
        if (std::abs(piece.surface().sampler().trilinear(at)) < 0.05f) {
          contacts_[size_t(kept++)] = c;
          break;
        }
      }
    }
    contactCount_ = kept;
    if (here.distance < radius_ + kKeep * voxel_) note(here, kMergeCosine);
  }
  if (radius_ - clearance_ > 1.2 * kOverlap * voxel_) {
    out.flags |= kLeaving;
    if (leave(input.periodS, stiffness, input.peakForceN)) follow(input.hand, out.flags);
  } else {
    follow(input.hand, out.flags);
  }
  const ActiveSet holding = target(input.hand);
  out.planes = holding.count;
  if (holding.count > 0 || (out.flags & kLeaving)) out.flags |= kTouching;
  out.proxy = out.cutPoint = proxy_;
  const Vec3d stretch = proxy_ - input.hand;
  out.depthMm = stretch.norm();
  if (!(out.flags & kTouching)) return;
  out.force = stiffness * stretch;
  if (out.depthMm > 1e-9) {
    // Damping pushes outwards or less outwards, never inwards.
    const Vec3d normal = stretch / out.depthMm;
    const double push = stiffness * out.depthMm;
    out.force += normal * (std::max(0.0, push - input.dampingNsmm * input.velocity.dot(normal)) - push);
  }
}

void BallContact::cut(const Scene& scene, const Input& input, Output& out) ARGIL_REALTIME {
  law_.forget(scene.samplesApplied);
  CutLaw::Input in;
  in.centre = proxy_;
  in.hand = input.hand;
  in.stiffnessNmm = input.topStiffnessNmm;
  in.radiusMm = radius_;
  in.periodS = input.periodS;
  in.frozen = mode_ == Mode::settle;
  const CutLaw::Result result = law_.advance(used_, scene, in);
  proxy_ = out.proxy = out.cutPoint = result.centre;
  out.depthMm = result.depthMm;
  out.areaMm2 = result.areaMm2;
  if (mode_ == Mode::cut) {
    law_.remember(proxy_, radius_, input.sampleIndex);
    out.flags |= kCutting;
  }
  if (!result.engaged) return;
  out.flags |= kTouching;
  out.force = input.topStiffnessNmm * (proxy_ - input.hand);
}

Contact::Output BallContact::tick(const Scene& scene, const Input& input) ARGIL_REALTIME {
  Output out;
  searches_ = 0;
  if (!begun_) {
    proxy_ = input.hand;
    begun_ = true;
    missed_ = true;
  }
  // Pieces and radius as of now; anything new makes what is known of the surface old.
  bool changed = missed_ || radius_ != scene.tool.radiusMm || used_.size() != scene.pieces.size();
  missed_ = false;
  radius_ = scene.tool.radiusMm;
  used_ = std::span(pieces_).first(std::min(scene.pieces.size(), kMaxPieces));
  voxel_ = radius_;
  for (size_t i = 0; i < used_.size(); ++i) {
    changed = used_[i].reset(scene.pieces[i]) || changed;
    voxel_ = i ? std::min(voxel_, used_[i].voxelMm()) : used_[i].voxelMm();
  }
  changeMode(scene, input);
  changed = changed || missed_;

  // One spring for all: the material's, as far as the device renders it, kept at the hand when the workspace is scaled.
  Input in = input;
  const double wanted = scene.pieces.empty() ? input.topStiffnessNmm : scene.materials[scene.pieces[0].material].stiffnessNmm;
  in.topStiffnessNmm = std::min(wanted, input.topStiffnessNmm) / scene.workspace.scale;
  in.dampingNsmm = input.dampingNsmm / scene.workspace.scale;

  switch (mode_) {
    case Mode::touch:
      missed_ = false;
      touch(in, changed, out);
      if (input.operate && scene.tool.operation == clay::Operation::smooth) {
        // The harder it is pressed the deeper the smoothing ball reaches, to its centre at most.
        const Vec3d press = input.hand - proxy_;
        const double depth = press.norm();
        out.cutPoint = depth > radius_ ? Vec3d(proxy_ + press * (radius_ / depth)) : input.hand;
        if (out.flags & kTouching) out.flags |= kCutting;
      }
      break;
    case Mode::cut:
    case Mode::settle:
      contactCount_ = 0;
      cut(scene, in, out);
      break;
    case Mode::add:
      // Clay that the tool itself lays must not push it away: only drag is felt until the button is let go.
      contactCount_ = 0;
      proxy_ = out.proxy = out.cutPoint = input.hand;
      out.flags |= kCutting;
      if (!scene.pieces.empty()) out.force = -scene.materials[scene.pieces[0].material].dragNsmm / scene.workspace.scale * input.velocity;
      break;
  }
  // A spring that is stretched further than the motor can pull is not a fault: it saturates.
  if (const double size = out.force.norm(); size > input.peakForceN) {
    out.force *= input.peakForceN / size;
    out.flags |= kClamped;
  }
  return out;
}

}  // namespace argil::haptics
