#include "ui3d/studio/view/plane_cut.h"

#include <array>

#include "engine/document/beside.h"
#include "ui3d/studio/view/context.h"

namespace argil::studio {

using engine::Guide;

std::vector<NamedPlane> planesOf(const engine::Document& document, engine::Id selected,
                                 const std::optional<Vec3d>& middleMm) {
  std::vector<NamedPlane> planes;
  const auto addGuide = [&](const Guide& guide) {
    planes.push_back({guide.name, {guide.pose.translation, guide.axis()}});
  };
  const Guide* first = document.guide(selected);
  if (first && first->kind != Guide::Kind::plane) first = nullptr;
  if (first) addGuide(*first);
  static constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
  const engine::Symmetry& symmetry = document.symmetry;
  const bool mirrors[] = {symmetry.x, symmetry.y, symmetry.z};
  for (int i = 0; i < 3; ++i)
    if (mirrors[i])
      planes.push_back({std::string("Symmetry ") + kAxes[size_t(i)],
                        {symmetry.pose.translation, symmetry.pose.rotation * Vec3d::Unit(i)}});
  for (int i = 0; middleMm && i < 3; ++i)
    planes.push_back({std::string("Across ") + kAxes[size_t(i)] + ", in the middle", {*middleMm, Vec3d::Unit(i)}});
  for (const Guide& guide : document.guides)
    if (guide.kind == Guide::Kind::plane && &guide != first) addGuide(guide);
  return planes;
}

PlaneCut PlaneCut::of(const engine::PieceJob& job, const engine::Document& document, const engine::Piece& piece,
                      engine::Id selected) {
  PlaneCut cut;
  cut.job = &job;
  cut.arguments = engine::standardArguments(job, document);
  cut.arguments.pieces = {piece.id};
  const clay::BoxMm box = engine::boundsOf(piece);
  const Vec3d size = box.high - box.low;
  cut.middleMm = (box.low + box.high) / 2;
  cut.halfMm = std::max(0.5 * size.norm(), 1e-3);
  int longest = 2;
  for (int i = 0; i < 2; ++i)
    if (size[i] > size[longest] * (1 + 1e-6)) longest = i;
  const Guide* guide = document.guide(selected);
  if (guide && guide->kind == Guide::Kind::plane)
    cut.arguments.plane = {guide->pose.translation, guide->axis()};
  else
    cut.arguments.plane = {cut.middleMm, Vec3d::Unit(longest)};
  return cut;
}

bool PlaneCut::choosesSide() const {
  return job->id == "cut-plane";
}

int PlaneCut::kept() const {
  return choosesSide() ? arguments.get<engine::CutValues>().keep : 1;
}

void PlaneCut::keepOther() {
  if (choosesSide() && kept() != 0)
    arguments.change<engine::CutValues>().keep = -kept();
  else
    arguments.plane.normal *= -1;
}

double PlaneCut::offsetMm() const {
  return (arguments.plane.pointMm - middleMm).dot(arguments.plane.normal);
}

void PlaneCut::setOffset(double mm) {
  arguments.plane.pointMm += (mm - offsetMm()) * arguments.plane.normal;
}

std::string PlaneCut::hint() const {
  const std::string verb(job->name);
  return "Drag the arrow and the arcs of the plane. Enter: " + verb + ". Tab: the other side. Esc: give up";
}

bool placesPlane(const engine::PieceJob& job) {
  return job.id == "cut-plane" || job.id == "mirror";
}

void beginPlaneCut(Context& context, const engine::PieceJob& job) {
  const engine::Document& document = *context.now.document;
  const engine::Piece* piece = document.piece(context.state.selected);
  if (!piece) piece = document.piece(document.active);
  if (!piece) return;
  if (piece->locked || !piece->version || piece->version.stats().bricks == 0) {
    context.bench.tell(engine::Message::Level::warning,
                       piece->locked ? piece->name + " is locked: unlock it first." : piece->name + " has no clay.");
    return;
  }
  if (context.state.deformBox) context.state.deformBox->cancel = true;
  if (context.state.drawnCurve) context.state.drawnCurve->cancel = true;
  context.state.gizmo = GizmoMode::none;
  context.state.planeCut = PlaneCut::of(job, document, *piece, context.state.selected);
  context.state.shown.settings = true;
}

bool followPlaneCut(Context& context) {
  if (!context.state.planeCut) return false;
  PlaneCut& cut = *context.state.planeCut;
  const engine::Piece* piece = context.now.document->piece(cut.arguments.pieces.front());
  if (!cut.cancel && piece && !piece->locked) {
    if (!cut.apply || !context.bench.idle()) return false;
    context.bench.operate(std::string(cut.job->id), cut.arguments);
  }
  context.state.planeCut.reset();
  return true;
}

}  // namespace argil::studio
