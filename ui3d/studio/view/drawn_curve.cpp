#include "ui3d/studio/view/drawn_curve.h"

#include <algorithm>
#include <cmath>

#include "clay/base/error.h"
#include "clay/whole/cut.h"
#include "ui3d/studio/view/context.h"

namespace argil::studio {
namespace {

constexpr double kStepUnits = 2;      // Of the window, between points.
constexpr size_t kMostPoints = 2000;  // Less than a cut takes.
constexpr double kLeastUnits = 12;    // A shorter way is no curve.
// The end is at the beginning: so near, and by this part of the way at the most.
constexpr double kCloseUnits = 18, kClosePart = 0.2;
constexpr int kCells = 96;        // Of the longer edge of what is shown of the sides.
constexpr double kAround = 0.12;  // Of the extent, about piece and curve.
constexpr double kBefore = 0.02;  // Of the extent: the sheet stands so far before the piece.

std::array<Vec3d, 8> cornersOf(const DrawnCurve& curve) {
  std::array<Vec3d, 8> corners;
  for (int i = 0; i < 8; ++i)
    corners[size_t(i)] = curve.pose.apply(Vec3d((i & 1 ? curve.box.high : curve.box.low).x(),
                                                (i & 2 ? curve.box.high : curve.box.low).y(),
                                                (i & 4 ? curve.box.high : curve.box.low).z()));
  return corners;
}

// Where the line of sight meets the sheet; in a view that looks along it there is none.
std::optional<Vec3d> onSheet(const DrawnCurve& curve, const Camera& camera, float x, float y, float width,
                             float height) {
  double nearest = INFINITY, farthest = -INFINITY;
  for (const Vec3d& corner : cornersOf(curve)) {
    nearest = std::min(nearest, corner.dot(curve.directionMm));
    farthest = std::max(farthest, corner.dot(curve.directionMm));
  }
  const Camera::Ray ray = camera.ray(x, y, width, height);
  const double ahead = ray.direction.dot(curve.directionMm);
  if (!(ahead > 1e-6)) return {};
  const double before = nearest - kBefore * (farthest - nearest);
  double along = (before - ray.origin.dot(curve.directionMm)) / ahead;
  // An eye within the piece draws at some distance from itself.
  if (camera.view().projection == render::Projection::perspective)
    along = std::max(along, 0.01 * camera.view().distance());
  return Vec3d(ray.origin + along * ray.direction);
}

double unitsOf(const std::vector<Vec3d>& points, double unitMm) {
  double way = 0;
  for (size_t i = 1; i < points.size(); ++i) way += (points[i] - points[i - 1]).norm();
  return way / unitMm;
}

double unitMm(const Camera& camera, float height) {
  return camera.view().heightAtTarget() / std::max(1.0f, height);
}

using Vec2d = Eigen::Vector2d;

// A piece of a row of cells, or of one cell, where `inside` corners count.
struct Corner {
  Vec2d at;
  double distance;
};
void addPart(const std::array<Corner, 4>& cell, int sign, std::vector<Vec2d>& triangles) {
  std::vector<Vec2d> part;
  for (size_t i = 0; i < 4; ++i) {
    const Corner &a = cell[i], &b = cell[(i + 1) % 4];
    const bool in = sign * a.distance < 0, next = sign * b.distance < 0;
    if (in) part.push_back(a.at);
    if (in != next) part.push_back(a.at + (b.at - a.at) * (a.distance / (a.distance - b.distance)));
  }
  for (size_t i = 2; i < part.size(); ++i) triangles.insert(triangles.end(), {part[0], part[i - 1], part[i]});
}

}  // namespace

DrawnCurve DrawnCurve::of(const engine::PieceJob& job, const engine::Document& document, const engine::Piece& piece) {
  DrawnCurve curve;
  curve.job = &job;
  curve.arguments = engine::standardArguments(job, document);
  curve.arguments.pieces = {piece.id};
  curve.atOnce = job.group == "Mask";
  curve.box = clay::brickBoundsOf(piece.version);
  curve.pose = piece.pose;
  return curve;
}

void DrawnCurve::clear() {
  pointsMm.clear();
  sides = {};
  closed = held = apply = false;
}

bool DrawnCurve::press(const Camera& camera, float x, float y, float width, float height) {
  if (apply) return false;
  clear();
  directionMm = camera.view().axes().forward;
  const auto place = onSheet(*this, camera, x, y, width, height);
  if (!place) return false;
  pointsMm = {*place};
  held = true;
  return true;
}

void DrawnCurve::move(const Camera& camera, float x, float y, float width, float height, bool straight) {
  if (!held) return;
  const auto place = onSheet(*this, camera, x, y, width, height);
  if (!place) return;
  if (straight) pointsMm.resize(1);
  const bool full = pointsMm.size() >= kMostPoints;
  if (!full && (*place - pointsMm.back()).norm() < kStepUnits * unitMm(camera, height)) return;
  if (full)
    pointsMm.back() = *place;
  else
    pointsMm.push_back(*place);
}

void DrawnCurve::release(const Camera& camera, float, float height) {
  if (!held) return;
  held = false;
  const double unit = unitMm(camera, height), way = unitsOf(pointsMm, unit);
  if (way < kLeastUnits) {
    clear();
    return;
  }
  closed = atOnce || (pointsMm.back() - pointsMm.front()).norm() / unit < std::min(kCloseUnits, kClosePart * way);
  if (closed && pointsMm.size() < 3) {
    clear();
    return;
  }
  if (atOnce)
    apply = true;
  else
    findSides();
}

void DrawnCurve::findSides() {
  sides = {};
  if (!drawn()) return;
  const Vec3d across = directionMm.unitOrthogonal(), up = across.cross(directionMm);
  const Vec3d sheet = directionMm * directionMm.dot(pointsMm.front());
  const auto flat = [&](const Vec3d& p) { return Vec2d(p.dot(across), p.dot(up)); };
  const auto lifted = [&](const Vec2d& p) { return Vec3d(sheet + p.x() * across + p.y() * up); };
  Vec2d low = Vec2d::Constant(INFINITY), high = -low;
  const auto add = [&](const Vec3d& p) {
    low = low.cwiseMin(flat(p));
    high = high.cwiseMax(flat(p));
  };
  for (const Vec3d& p : pointsMm) add(p);
  for (const Vec3d& p : cornersOf(*this)) add(p);
  const double extent = (high - low).maxCoeff();
  low -= Vec2d::Constant(kAround * extent);
  high += Vec2d::Constant(kAround * extent);
  const double step = (high - low).maxCoeff() / kCells;
  const int columns = std::max(1, static_cast<int>(std::ceil((high.x() - low.x()) / step))),
            rows = std::max(1, static_cast<int>(std::ceil((high.y() - low.y()) / step)));
  // Its number is named smooth, where it has one.
  double smooth = 0;
  for (const auto& parameter : job->parameters)
    if (parameter.id == "smooth") smooth = parameter.get(arguments);
  std::vector<double> distances(size_t(columns + 1) * size_t(rows + 1));
  try {
    const clay::CurveDivider divider({pointsMm, directionMm, closed, smooth});
    for (int j = 0; j <= rows; ++j)
      for (int i = 0; i <= columns; ++i)
        distances[size_t(j) * size_t(columns + 1) + size_t(i)] = divider.distance(lifted(low + step * Vec2d(i, j)));
  } catch (const Error&) {
    return;  // The operation itself will say why.
  }
  const auto corner = [&](int i, int j) {
    return Corner{low + step * Vec2d(i, j), distances[size_t(j) * size_t(columns + 1) + size_t(i)]};
  };
  for (size_t side = 0; side < 2; ++side) {
    const int sign = side == 0 ? 1 : -1;
    std::vector<Vec2d> triangles;
    double widest = 0;
    for (int j = 0; j < rows; ++j) {
      int begin = -1;  // Of a run of cells that lie within: one rectangle.
      for (int i = 0; i <= columns; ++i) {
        const bool there = i < columns;
        const std::array<Corner, 4> cell{corner(i, j), corner(there ? i + 1 : i, j), corner(there ? i + 1 : i, j + 1),
                                         corner(i, j + 1)};
        const bool whole =
            there && std::all_of(cell.begin(), cell.end(), [&](const Corner& c) { return sign * c.distance < 0; });
        if (whole && begin < 0) begin = i;
        if (!whole && begin >= 0) {
          addPart({corner(begin, j), corner(i, j), corner(i, j + 1), corner(begin, j + 1)}, sign, triangles);
          begin = -1;
        }
        if (there && !whole) addPart(cell, sign, triangles);
        const double room =
            std::min({-sign * cell[0].distance, step * i, step * (columns - i), step * j, step * (rows - j)});
        if (room > widest) {
          widest = room;
          sides.sides[side].middleMm = lifted(cell[0].at);
        }
      }
    }
    for (const Vec2d& p : triangles) sides.sides[side].trianglesMm.push_back(lifted(p));
  }
}

std::string DrawnCurve::hint() const {
  if (held) return "Let go to end the curve; Shift: a straight line; Esc: away with it";
  if (atOnce) return apply ? std::string("…") : "Draw around what is to be masked. Esc: done";
  if (!drawn()) return "Draw over the clay, where it is to be cut. Esc: give up";
  return "Enter: cut. Tab: the other side stays. Draw again for another curve. Esc: give up";
}

void beginDrawnCurve(Context& context, const engine::PieceJob& job) {
  const engine::Document& document = *context.now.document;
  const engine::Piece* piece = document.piece(context.state.selected);
  if (!piece) piece = document.workedOn();
  if (!piece || !piece->version || piece->version.stats().bricks == 0) return;
  const bool had = context.state.drawnCurve && context.state.drawnCurve->hadPerspective;
  context.state.drawnCurve = DrawnCurve::of(job, document, *piece);
  context.state.drawnCurve->hadPerspective = had || context.camera.view().projection == render::Projection::perspective;
  if (context.camera.view().projection == render::Projection::perspective) context.camera.toggleProjection();
  context.state.shown.settings = true;
}

bool followDrawnCurve(Context& context) {
  if (!context.state.drawnCurve) return false;
  DrawnCurve& curve = *context.state.drawnCurve;
  const engine::Piece* piece = context.now.document->piece(curve.arguments.pieces.front());
  bool ends = curve.cancel || !piece || piece->locked;
  if (!ends && curve.apply && !curve.drawn()) curve.apply = false;
  if (!ends && curve.apply && context.bench.idle()) {
    curve.arguments.pointsMm = curve.pointsMm;
    curve.arguments.directionMm = curve.directionMm;
    curve.arguments.closed = curve.closed;
    context.bench.operate(std::string(curve.job->id), curve.arguments);
    curve.clear();
    ends = !curve.atOnce;
    if (!ends) return true;
  }
  if (!ends) return false;
  if (curve.hadPerspective && context.camera.view().projection == render::Projection::orthographic)
    context.camera.toggleProjection();
  context.state.drawnCurve.reset();
  return true;
}

}  // namespace argil::studio
