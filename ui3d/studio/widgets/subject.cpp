#include "ui3d/studio/widgets/subject.h"

#include <cmath>

namespace argil::studio {
namespace {

using engine::Document;
using engine::Guide;
using engine::Symmetry;
using haptics::Pose;

template <class... Fs>
struct Overloaded : Fs... {
  using Fs::operator()...;
};
template <class... Fs>
Overloaded(Fs...) -> Overloaded<Fs...>;

bool same(const Vec3d& a, const Vec3d& b) {
  return (a - b).norm() <= 1e-9 * (1 + a.norm());
}
bool same(const Pose& a, const Pose& b) {
  return same(a.translation, b.translation) && std::abs(a.rotation.dot(b.rotation)) >= 1 - 1e-14;
}
bool same(const Guide& a, const Guide& b) {
  if (!same(a.pose, b.pose) || !same(a.sizeMm, b.sizeMm) || a.closed != b.closed ||
      a.pointsMm.size() != b.pointsMm.size())
    return false;
  for (size_t i = 0; i < a.pointsMm.size(); ++i)
    if (!same(a.pointsMm[i], b.pointsMm[i])) return false;
  return true;
}

void turnPose(Pose& pose, const Vec3d& pivot, const Eigen::Quaterniond& q) {
  pose.translation = pivot + q * (pose.translation - pivot);
  pose.rotation = (q * pose.rotation).normalized();
}

}  // namespace

Subject readSubject(const World& world, const Target& target) {
  switch (target.kind) {
    case Target::Kind::none:
      break;
    case Target::Kind::thing:
      if (const auto* guide = world.document.guide(target.id)) return *guide;
      if (const auto* piece = world.document.piece(target.id)) return piece->pose;
      if (const auto* part = world.document.part(target.id)) return part->pose;
      break;
    case Target::Kind::symmetry:
      return world.document.symmetry;
    case Target::Kind::section:
      if (world.state.look.section) return *world.state.look.section;
      break;
    case Target::Kind::workspace:
      return world.state.workspace;
    case Target::Kind::lattice:
      if (const auto& box = world.state.deformBox; box && box->piece == target.id)
        return HeldLattice{box->lattice, box->pose, box->clayPlaces, box->warpAfterLattice()};
      break;
    case Target::Kind::cut:
      if (world.state.planeCut) return world.state.planeCut->arguments.plane;
      break;
    case Target::Kind::scale:
      if (world.document.piece(target.id) || world.document.part(target.id)) return HeldScale{};
      break;
  }
  return {};
}

void writeSubject(World& world, const Target& target, const Subject& subject, const std::string& label,
                  const std::string& merge) {
  std::visit(Overloaded{
                 [](std::monostate) {},
                 [&](const Guide& guide) {
                   world.edit(
                       label,
                       [id = target.id, guide](Document& document) {
                         Guide* there = document.guide(id);
                         if (!there) return;
                         there->pose = guide.pose;
                         there->sizeMm = guide.sizeMm;
                         there->pointsMm = guide.pointsMm;
                         there->closed = guide.closed;
                       },
                       merge);
                 },
                 [&](const Pose& pose) {
                   world.edit(
                       label,
                       [id = target.id, pose](Document& document) {
                         if (auto* piece = document.piece(id)) piece->pose = pose;
                         if (auto* part = document.part(id)) part->pose = pose;
                       },
                       merge);
                 },
                 [&](const Symmetry& symmetry) {
                   world.edit(
                       label, [pose = symmetry.pose](Document& document) { document.symmetry.pose = pose; }, merge);
                 },
                 [&](const render::Section& section) {
                   world.state.section = section;
                   world.state.look.section = section;
                 },
                 [&](const haptics::Workspace& workspace) {
                   world.state.workspace = workspace;
                   if (world.setWorkspace) world.setWorkspace(workspace);
                 },
                 [&](const HeldLattice& held) {
                   if (auto& box = world.state.deformBox; box && box->piece == target.id) box->lattice = held.lattice;
                 },
                 [&](const engine::MirrorPlane& plane) {
                   if (world.state.planeCut) world.state.planeCut->arguments.plane = plane;
                 },
                 [&](const HeldScale& held) {  // Shown alone: it is done when it is let go.
                   world.state.scaled.reset();
                   if (held.factors != Vec3d::Ones())
                     world.state.scaled =
                         GrownPiece{.piece = target.id, .factors = held.factors, .aboutMm = held.aboutMm};
                 },
             },
             subject);
}

bool sameSubject(const Subject& a, const Subject& b) {
  if (a.index() != b.index()) return false;
  return std::visit(
      Overloaded{
          [](std::monostate) { return true; },
          [&](const Guide& guide) { return same(guide, std::get<Guide>(b)); },
          [&](const Pose& pose) { return same(pose, std::get<Pose>(b)); },
          [&](const Symmetry& symmetry) { return same(symmetry.pose, std::get<Symmetry>(b).pose); },
          [&](const render::Section& section) {
            const auto& other = std::get<render::Section>(b);
            return same(section.pointMm, other.pointMm) && same(section.normal, other.normal);
          },
          [&](const haptics::Workspace& workspace) {
            const auto& other = std::get<haptics::Workspace>(b);
            return same(workspace.pose, other.pose) &&
                   std::abs(workspace.scale - other.scale) <= 1e-12 * workspace.scale;
          },
          [&](const HeldLattice& held) { return held.lattice.points() == std::get<HeldLattice>(b).lattice.points(); },
          [&](const engine::MirrorPlane& plane) {
            const auto& other = std::get<engine::MirrorPlane>(b);
            return same(plane.pointMm, other.pointMm) && same(plane.normal, other.normal);
          },
          [&](const HeldScale& held) {
            const auto& other = std::get<HeldScale>(b);
            return held.factors == other.factors && same(held.aboutMm, other.aboutMm);
          },
      },
      a);
}

std::vector<Vec3d> axesOf(const Subject& subject) {
  const auto three = [](const Pose& pose) {
    return std::vector<Vec3d>{pose.rotation * Vec3d::UnitX(), pose.rotation * Vec3d::UnitY(),
                              pose.rotation * Vec3d::UnitZ()};
  };
  return std::visit(Overloaded{
                        [](std::monostate) { return std::vector<Vec3d>(); },
                        [&](const Guide& guide) {
                          if (guide.kind == Guide::Kind::line) return std::vector<Vec3d>{guide.axis()};
                          if (guide.pointsMm.size() == 2)
                            return std::vector<Vec3d>{(guide.pointsMm[1] - guide.pointsMm[0]).normalized()};
                          return three(guide.pose);
                        },
                        [&](const Pose& pose) { return three(pose); },
                        [&](const Symmetry& symmetry) { return three(symmetry.pose); },
                        [](const render::Section& section) { return std::vector<Vec3d>{section.normal.normalized()}; },
                        [&](const haptics::Workspace& workspace) { return three(workspace.pose); },
                        [](const HeldLattice&) { return std::vector<Vec3d>(); },  // Its points do not turn.
                        [](const HeldScale&) { return std::vector<Vec3d>(); },
                        [](const engine::MirrorPlane& plane) { return std::vector<Vec3d>{plane.normal.normalized()}; },
                    },
                    subject);
}

void move(Subject& subject, const Vec3d& by) {
  std::visit(Overloaded{
                 [](std::monostate) {},
                 [&](Guide& guide) {
                   guide.pose.translation += by;
                   for (Vec3d& p : guide.pointsMm) p += by;
                 },
                 [&](Pose& pose) { pose.translation += by; },
                 [&](Symmetry& symmetry) { symmetry.pose.translation += by; },
                 [&](render::Section& section) { section.pointMm += by; },
                 [&](haptics::Workspace& workspace) { workspace.pose.translation += by; },
                 [](HeldLattice&) {},
                 [](HeldScale&) {},
                 [&](engine::MirrorPlane& plane) { plane.pointMm += by; },
             },
             subject);
}

void turn(Subject& subject, const Vec3d& pivot, const Vec3d& axis, double angle) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(angle, axis));
  std::visit(Overloaded{
                 [](std::monostate) {},
                 [&](Guide& guide) {
                   turnPose(guide.pose, pivot, q);
                   for (Vec3d& p : guide.pointsMm) p = pivot + q * (p - pivot);
                 },
                 [&](Pose& pose) { turnPose(pose, pivot, q); },
                 [&](Symmetry& symmetry) { turnPose(symmetry.pose, pivot, q); },
                 [&](render::Section& section) {
                   section.pointMm = pivot + q * (section.pointMm - pivot);
                   section.normal = q * section.normal;
                 },
                 [&](haptics::Workspace& workspace) { turnPose(workspace.pose, pivot, q); },
                 [](HeldLattice&) {},
                 [](HeldScale&) {},
                 [&](engine::MirrorPlane& plane) {
                   plane.pointMm = pivot + q * (plane.pointMm - pivot);
                   plane.normal = q * plane.normal;
                 },
             },
             subject);
}

}  // namespace argil::studio
