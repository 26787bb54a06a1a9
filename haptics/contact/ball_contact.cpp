#include "haptics/contact/ball_contact.h"

#include <algorithm>
#include <cmath>

#include "haptics/scene/part_mesh.h"
#include "haptics/threads/sample_ring.h"

namespace argil::haptics {
namespace {

constexpr double kLeaveSpeedMms = 30;    // Out of clay that grew around the ball.
constexpr double kLeaveForcePerS = 6.0;  // In peaks a second: 6 % of the peak in 10 ms; 7 % is felt (Pang et al. 1991).
constexpr double kSettleS = 0.25;        // How long a finished cut waits for its edit.
constexpr double kPointingNmm = 1e6;     // Of a hand that points: what is cut is where it points within a tick.
// Of a pointer without a button: less is walked in a tick or two, more might end in a groove of the ball's own size.
constexpr double kJumpRadii = 1;
constexpr double kEaseS = 0.02;  // From one material's stiffness to the next one's while touching.

// How fast what grew or jumped may push the ball: `input` with the stiffness of what is touched.
double gentleMms(const Contact::Input& input) ARGIL_REALTIME {
  return std::min(kLeaveSpeedMms, kLeaveForcePerS * input.peakForceN / input.topStiffnessNmm);
}

}  // namespace

void BallContact::reset() noexcept {
  begun_ = false;
  mode_ = Mode::touch;
  guides_.reset();
  around_.clear();
  proxy_.reset(Vec3d::Zero());
  friction_.reset();
  texture_.reset();
  law_.reset();
  stiffness_ = 0;
  touched_ = -1;
  touchNormal_.setZero();
}

void BallContact::changeMode(const Scene& scene, const Input& input) ARGIL_REALTIME {
  Mode wanted = Mode::touch;
  if (input.operate && scene.tool.work == Work::cut) wanted = Mode::cut;
  // Where a mouse or a pen points the tool works: no ball has to climb there out of the grooves that it made.
  const bool through = scene.tool.work == Work::lay || (scene.tool.work == Work::rub && input.pointing);
  if (input.operate && through) wanted = Mode::add;
  if (wanted == Mode::touch && (mode_ == Mode::cut || mode_ == Mode::settle)) {
    // The edit is still on its way: clay that was cut must not push back as if it were there.
    settleS_ = mode_ == Mode::cut ? 0 : settleS_ + input.periodS;
    if (law_.pending() && settleS_ < kSettleS) wanted = Mode::settle;
  }
  if (wanted == Mode::touch && mode_ != Mode::touch) missed_ = true;
  if (wanted != Mode::cut && wanted != Mode::settle) law_.reset();
  if (wanted != Mode::touch) {
    friction_.reset();
    texture_.reset();
  }
  mode_ = wanted;
}

// The material's, as far as the device renders it. Eased while touching: where two materials meet the force has no
// step.
double BallContact::stiffness(const Scene& scene, const Input& input) ARGIL_REALTIME {
  const uint32_t material = around_.there(touched_) ? around_.material(touched_, touchPoint_)
                            : scene.pieces.empty()  ? 0
                                                    : scene.pieces[0].material;
  const double wanted = std::min(scene.materials[material].stiffnessNmm, input.topStiffnessNmm);
  if (touched_ < 0 || stiffness_ <= 0)
    stiffness_ = wanted;
  else
    stiffness_ += (wanted - stiffness_) * std::min(1.0, input.periodS / kEaseS);
  return stiffness_;
}

// Towards the goal; out of what grew around the ball first, at a bounded speed.
void BallContact::go(const Vec3d& goal, const Input& input, const Proxy::Holding& held, Output& out) ARGIL_REALTIME {
  if (proxy_.caught()) {
    out.flags |= kLeaving;
    if (proxy_.leave(gentleMms(input) * input.periodS) && !proxy_.follow(goal, proxy_.holding(goal)))
      out.flags |= kIncomplete;
  } else if (!proxy_.follow(goal, held)) {
    out.flags |= kIncomplete;
  }
}

// How far the hand has stretched the spring to where the ball is held, on whatever texture lies there.
Vec3d BallContact::spring(const Scene& scene, const Vec3d& hand, const Proxy::Holding& held,
                          Output& out) ARGIL_REALTIME {
  std::array<TexturedPlane, 3> planes;
  bool textured = false;
  for (size_t i = 0; i < size_t(held.count); ++i) {
    const int32_t texture = scene.materials[around_.material(held.thing[i], held.point[i])].texture;
    planes[i] = {held.plane[i], texture < 0 ? nullptr : scene.textures[size_t(texture)].get(),
                 &around_.pose(held.thing[i]), held.point[i]};
    textured = textured || texture >= 0;
  }
  if (!textured) {
    texture_.reset();
    return proxy_.at() - hand;
  }
  const TexturePath::Place place = texture_.advance(proxy_.at(), hand, planes.data(), held.count);
  if (!guides_.locked()) out.proxy = place.proxy;  // A lock holds the ball itself; the texture is felt all the same.
  return place.stretch;
}

void BallContact::touch(const Scene& scene, const Input& input, bool changed, Output& out) ARGIL_REALTIME {
  if (changed) proxy_.refresh();
  const double stiffness = input.topStiffnessNmm;
  const Vec3d hand = guides_.goal(input.hand);
  const Proxy::Holding before = proxy_.holding(hand);
  if (before.conflict) out.flags |= kGuideConflict;
  Friction::Touch rub;
  rub.push = before.push;
  rub.stiffnessNmm = stiffness;
  rub.periodS = input.periodS;
  for (int i = 0; i < before.count; ++i) {
    if (around_.hard(before.thing[size_t(i)])) continue;  // A keep-out is no matter: it has no friction.
    const Material& material = scene.materials[around_.material(before.thing[size_t(i)], before.point[size_t(i)])];
    rub.staticMm += material.staticFriction * before.share[size_t(i)];
    rub.dynamicMm += material.dynamicFriction * before.share[size_t(i)];
    rub.viscousNsmm += material.viscousFrictionNsmm;
    // A tool that smears drags the clay along: what the ball slides on is as thick as what it would cut.
    if (input.operate && scene.tool.work == Work::rub) rub.viscousNsmm += material.viscosityNsmm;
  }
  const Subspace within = guides_.locked() ? guides_.lockAt(proxy_.at()) : Subspace();
  const Vec3d goal = before.count > 0 ? friction_.goal(proxy_.at(), within.nearest(hand), rub) : hand;
  go(goal, input, goal == hand ? before : proxy_.holding(goal), out);

  const Proxy::Holding after = proxy_.holding(hand);
  out.planes = after.count;
  if (after.count > 0 || !after.feasible || (out.flags & kLeaving)) out.flags |= kTouching;
  touched_ = after.count > 0 ? after.thing[0] : -1;
  if (touched_ >= 0) touchPoint_ = after.point[0];
  out.proxy = out.cutPoint = proxy_.at();
  const Vec3d stretch = spring(scene, hand, after, out) + (hand - input.hand);
  out.depthMm = stretch.norm();
  const double depth = after.push.norm();
  const bool pushed = depth > 1e-9;
  touchNormal_ = pushed ? Vec3d(after.push / depth) : Vec3d::Zero();
  if (!(out.flags & kTouching) && !guides_.locked() && !guides_.settling()) return;
  out.force = stiffness * stretch;
  // Damping along the normal pushes outwards or less outwards, never inwards; across a lock it holds from both sides.
  if (pushed)
    out.force -= touchNormal_ * std::min(input.dampingNsmm * input.velocity.dot(touchNormal_), stiffness * depth);
  if (guides_.locked()) out.force -= input.dampingNsmm * (input.velocity - within.along(input.velocity));
  react(scene, after, stiffness, out);
}

// Each plane pushes along its normal by its share of the spring; what is left (friction, texture, damping) goes by
// those shares.
void BallContact::react(const Scene& scene, const Proxy::Holding& held, double stiffness,
                        Output& out) const ARGIL_REALTIME {
  double shares = 0;
  for (size_t i = 0; i < size_t(held.count); ++i) shares += held.share[i];
  // What a lock holds back is the lock's.
  const Vec3d rest =
      guides_.locked() || guides_.settling() ? Vec3d(Vec3d::Zero()) : Vec3d(out.force - stiffness * held.push);
  for (size_t i = 0; i < size_t(held.count); ++i) {
    const int thing = held.thing[i], piece = Surroundings::pieceOf(thing), part = Surroundings::partOf(thing);
    if (piece < 0 && part < 0) continue;
    size_t k = 0;
    while (k < size_t(out.reactionCount) && (out.reactions[k].piece != piece || out.reactions[k].part != part)) ++k;
    Reaction& reaction = out.reactions[k];
    if (k == size_t(out.reactionCount)) {
      ++out.reactionCount;
      reaction.piece = piece;
      reaction.part = part;
      reaction.centreMm =
          around_.pose(thing).apply(part < 0 ? Vec3d(Vec3d::Zero()) : scene.parts[size_t(part)].mesh->middleMm());
    }
    Vec3d force = -stiffness * held.share[i] * held.plane[i].normal;
    if (shares > 0) force -= rest * (held.share[i] / shares);
    reaction.forceN += force;
    reaction.torqueNmm += (held.point[i] - reaction.centreMm).cross(force);
  }
}

void BallContact::cut(const Scene& scene, const Input& input, bool changed, Output& out) ARGIL_REALTIME {
  if (changed) proxy_.refresh();
  law_.forget(scene.samplesApplied);
  CutLaw::Input in;
  in.centre = proxy_.at();
  in.hand = guides_.snap(guides_.goal(input.hand));
  in.stiffnessNmm = input.pointing ? kPointingNmm : input.topStiffnessNmm;
  in.radiusMm = radius_;
  in.periodS = input.periodS;
  in.frozen = mode_ == Mode::settle;
  const CutLaw::Result result = law_.advance(around_.workedOn(), scene, in);
  // Through clay as the law says, but not through what cannot be cut, and not off a lock.
  go(result.centre, input, proxy_.holding(result.centre), out);
  out.proxy = out.cutPoint = proxy_.at();
  out.depthMm = result.depthMm;
  out.areaMm2 = result.areaMm2;
  if (mode_ == Mode::cut) {
    law_.remember(proxy_.at(), radius_, input.sampleIndex);
    out.flags |= kCutting;
  }
  const bool held = result.engaged || proxy_.holding(in.hand).count > 0;
  if (held) out.flags |= kTouching;
  if (held || guides_.locked() || guides_.settling()) out.force = input.topStiffnessNmm * (proxy_.at() - input.hand);
}

// Clay that the tool itself lays must not push it away: only drag is felt until the button is let go, and what is no
// clay.
void BallContact::lay(const Scene& scene, const Input& input, bool changed, Output& out) ARGIL_REALTIME {
  if (changed) proxy_.refresh();
  const Vec3d goal = guides_.goal(input.hand);
  go(goal, input, proxy_.holding(goal), out);
  out.proxy = out.cutPoint = proxy_.at();
  out.flags |= kCutting;
  const bool held = proxy_.holding(goal).count > 0;
  if (held) out.flags |= kTouching;
  if (held || guides_.locked() || guides_.settling()) out.force = input.topStiffnessNmm * (proxy_.at() - input.hand);
  if (!scene.pieces.empty())
    out.force -= scene.materials[scene.pieces[0].material].dragNsmm / scene.workspace.scale * input.velocity;
}

Contact::Output BallContact::tick(const Scene& scene, const Input& input) ARGIL_REALTIME {
  Output out;
  // A pointer that turns up far away is there: the ball would walk for long, and be pressed on its way.
  if (input.pointing && input.buttons == 0 && (input.hand - proxy_.at()).norm() > kJumpRadii * scene.tool.radiusMm)
    begun_ = false;
  if (!begun_) {
    proxy_.reset(input.hand);
    begun_ = true;
    missed_ = true;
  }
  changeMode(scene, input);
  guides_.begin(scene, input, proxy_.at(), touchNormal_);
  // Anything new makes what is known of the surface old.
  bool changed = missed_ || radius_ != scene.tool.radiusMm;
  missed_ = false;
  radius_ = scene.tool.radiusMm;
  changed = around_.reset(scene, mode_ == Mode::touch, guides_.keepOuts(), guides_.keepOutsChanged(), input.periodS) ||
            changed;
  proxy_.begin(around_, guides_, scene.quality, radius_);
  // Stiffness is kept at the hand when the workspace is scaled.
  Input in = input;
  in.topStiffnessNmm = stiffness(scene, input) / scene.workspace.scale;
  in.dampingNsmm = input.dampingNsmm / scene.workspace.scale;
  out.flags |= guides_.flags();
  const Proxy::Carried carried = proxy_.carry(gentleMms(in) * in.periodS);
  if (!carried.whole) out.flags |= kIncomplete;

  switch (mode_) {
    case Mode::touch:
      touch(scene, in, changed, out);
      if (input.operate && scene.tool.work == Work::rub) {
        // The harder it is pressed the deeper the smoothing ball reaches, to its centre at most.
        const Vec3d press = input.hand - proxy_.at();
        const double depth = press.norm();
        out.cutPoint = depth > radius_ ? Vec3d(proxy_.at() + press * (radius_ / depth)) : input.hand;
        if (out.flags & kTouching) out.flags |= kCutting;
      }
      break;
    case Mode::cut:
    case Mode::settle:
      cut(scene, in, changed, out);
      break;
    case Mode::add:
      lay(scene, in, changed, out);
      break;
  }
  out.active = (out.flags & kLeaving) != 0 || guides_.settling() || carried.pushed;
  out.ambient = guides_.force();
  out.force += out.ambient;
  // A spring that is stretched further than the motor can pull is not a fault: it saturates.
  if (const double size = out.force.norm(); size > input.peakForceN) {
    out.force *= input.peakForceN / size;
    out.flags |= kClamped;
    for (size_t i = 0; i < size_t(out.reactionCount); ++i) {
      out.reactions[i].forceN *= input.peakForceN / size;
      out.reactions[i].torqueNmm *= input.peakForceN / size;
    }
  }
  return out;
}

}  // namespace argil::haptics
