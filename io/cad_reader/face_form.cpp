#include "io/cad_reader/face_form.h"

#include <BRepAdaptor_Surface.hxx>
#include <BRepTools.hxx>
#include <Standard_Failure.hxx>

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "clay/base/vec.h"

namespace argil::io::reader {

namespace {

constexpr int kSteps = 8;           // places along each parameter, less one
constexpr double kOff = 1e-5;       // of the model's diagonal: how far places may lie off a form
constexpr double kOwnOff = 1e-4;    // the same, of the face's own size
constexpr double kNoNormal = 1e-9;  // of the face's size, squared: where it comes to a point

enum Kind : uint32_t { plane = 0, axis = 1, middle = 2 };

struct Form {
  uint32_t kind = plane;
  Vec3d at = Vec3d::Zero(), along = Vec3d::UnitZ();
  std::optional<Vec3d> across;   // along the face's own parameters where there is none
  std::optional<double> radius;  // the mean of what is seen where there is none
};

struct Places {
  std::vector<Vec3d> at;
  std::vector<std::pair<Vec3d, Vec3d>> normals;  // where, unit
  Vec3d low, high;
  [[nodiscard]] double size() const { return (high - low).maxCoeff(); }
};

Vec3d vec(const gp_XYZ& v) {
  return {v.X(), v.Y(), v.Z()};
}

Places placesOf(const BRepAdaptor_Surface& surface, double u0, double u1, double v0, double v1) {
  Places places;
  std::vector<std::pair<Vec3d, Vec3d>> crossed;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j) {
      gp_Pnt p;
      gp_Vec du, dv;
      surface.D1(u0 + (u1 - u0) * i / kSteps, v0 + (v1 - v0) * j / kSteps, p, du, dv);
      places.at.push_back(vec(p.XYZ()));
      // As long as the face is, so that where it comes to a point is told from a slow parameter.
      crossed.emplace_back(places.at.back(), vec((du * (u1 - u0)).Crossed(dv * (v1 - v0)).XYZ()));
    }
  places.low = places.high = places.at.front();
  for (const Vec3d& p : places.at) places.low = places.low.cwiseMin(p), places.high = places.high.cwiseMax(p);
  const double least = kNoNormal * places.size() * places.size();
  for (const auto& [p, n] : crossed)
    if (n.norm() > least) places.normals.emplace_back(p, n.normalized());
  return places;
}

// What the file says the face is.
std::optional<Form> toldForm(const BRepAdaptor_Surface& surface) {
  gp_Ax3 frame;
  Form form;
  switch (surface.GetType()) {
    case GeomAbs_Plane:
      frame = surface.Plane().Position();
      break;
    case GeomAbs_Cylinder:
      form.kind = axis, form.radius = surface.Cylinder().Radius(), frame = surface.Cylinder().Position();
      break;
    case GeomAbs_Cone:
      form.kind = axis, frame = surface.Cone().Position();
      break;
    case GeomAbs_Torus:
      form.kind = axis, form.radius = surface.Torus().MajorRadius(), frame = surface.Torus().Position();
      break;
    case GeomAbs_Sphere:
      form.kind = middle, form.radius = surface.Sphere().Radius(), frame = surface.Sphere().Position();
      break;
    default:
      return std::nullopt;
  }
  form.at = vec(frame.Location().XYZ()), form.along = vec(frame.Direction().XYZ());
  if (form.kind != plane) form.across = vec(frame.XDirection().XYZ());
  return form;
}

// Centre and radius of the circle or ball through points, by least squares.
template <int N>
std::pair<Eigen::Matrix<double, N, 1>, double> roundOf(const std::vector<Eigen::Matrix<double, N, 1>>& points) {
  Eigen::Matrix<double, Eigen::Dynamic, N + 1> rows(points.size(), N + 1);
  Eigen::VectorXd right(points.size());
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    rows.row(i) << 2 * points[size_t(i)].transpose(), 1;
    right[i] = points[size_t(i)].squaredNorm();
  }
  const Eigen::Matrix<double, N + 1, 1> x = rows.colPivHouseholderQr().solve(right);
  const Eigen::Matrix<double, N, 1> centre = x.template head<N>();
  return {centre, std::sqrt(std::max(0.0, x[N] + centre.squaredNorm()))};
}

template <int N>
bool lieOn(const std::vector<Eigen::Matrix<double, N, 1>>& points,
           const std::pair<Eigen::Matrix<double, N, 1>, double>& round, double off) {
  return std::ranges::all_of(points,
                             [&](const auto& p) { return std::abs((p - round.first).norm() - round.second) <= off; });
}

// What the face is, whatever it was written as. Lengths are of its size, about its middle.
std::optional<Form> seenForm(const Places& places, double diagonal) {
  const double size = places.size();
  if (!(size > 0) || places.normals.size() < 9) return std::nullopt;
  const Vec3d origin = (places.low + places.high) / 2;
  const double off = std::min(kOff * diagonal / size, kOwnOff);
  std::vector<Vec3d> points;
  for (const Vec3d& p : places.at) points.emplace_back((p - origin) / size);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero(), turned = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 6, 6> motions = Eigen::Matrix<double, 6, 6>::Zero();
  Vec3d mean = Vec3d::Zero();
  for (const Vec3d& p : points) mean += p / double(points.size());
  for (const Vec3d& p : points) spread += (p - mean) * (p - mean).transpose();
  for (const auto& [at, n] : places.normals) {
    Eigen::Matrix<double, 6, 1> row;
    row << ((at - origin) / size).cross(n), n;
    motions += row * row.transpose() / double(places.normals.size());
    turned += n * n.transpose();
  }
  Form form;
  const Vec3d flat = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
  if (std::ranges::all_of(points, [&](const Vec3d& p) { return std::abs((p - mean).dot(flat)) <= off; })) {
    form.at = origin + size * mean, form.along = flat;
    return form;
  }
  if (const auto ball = roundOf<3>(points); lieOn<3>(points, ball, off)) {
    form.kind = middle, form.at = origin + size * ball.first, form.radius = size * ball.second;
    return form;
  }
  form.kind = axis;
  // All normals of a cylinder are perpendicular to its axis.
  form.along = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(turned).eigenvectors().col(0);
  const Vec3d x = form.along.unitOrthogonal(), y = form.along.cross(x);
  std::vector<Eigen::Vector2d> seen;
  for (const Vec3d& p : points) seen.emplace_back(p.dot(x), p.dot(y));
  if (const auto circle = roundOf<2>(seen); lieOn<2>(seen, circle, off)) {
    form.at = origin + size * (circle.first.x() * x + circle.first.y() * y), form.radius = size * circle.second;
    return form;
  }
  // The motion that leaves the surface most where it is (Pottmann and Wallner, Computational Line Geometry, 2001); it
  // is a turn if all normals meet its axis.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solved(motions);
  const Eigen::Matrix<double, 6, 1> motion = solved.eigenvectors().col(0);
  const double turn = motion.head<3>().norm();
  if (!(turn > 1e-3)) return std::nullopt;  // moved along a line
  form.along = motion.head<3>() / turn;
  const Vec3d way = motion.tail<3>() / turn, foot = form.along.cross(way);
  for (const auto& [at, n] : places.normals)
    if (std::abs(n.dot(form.along.cross((at - origin) / size - foot))) > off) return std::nullopt;
  form.at = origin + size * foot;
  return form;
}

}  // namespace

std::optional<wire::Face> formOf(const TopoDS_Face& face, double diagonal) try {
  const BRepAdaptor_Surface surface(face);
  double u0 = 0, u1 = 0, v0 = 0, v1 = 0;
  BRepTools::UVBounds(face, u0, u1, v0, v1);
  // An endless one has bounds of 1e100.
  if (!(std::abs(u0) < 1e50 && std::abs(u1) < 1e50 && std::abs(v0) < 1e50 && std::abs(v1) < 1e50)) return std::nullopt;
  const Places places = placesOf(surface, u0, u1, v0, v1);
  if (!places.low.allFinite() || !places.high.allFinite() || places.normals.empty()) return std::nullopt;
  std::optional<Form> form = toldForm(surface);
  if (!form) form = seenForm(places, diagonal);
  if (!form) return std::nullopt;
  Vec3d across = form->across.value_or(form->along.unitOrthogonal());
  if (form->kind == plane) {
    const Vec3d way = places.at.back() - places.at[kSteps], flat = way - form->along * form->along.dot(way);
    if (flat.norm() > kOff * diagonal) across = flat.normalized();
  }
  const Vec3d other = form->along.cross(across);
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  Vec3d low = Vec3d::Constant(kInfinite), high = -low;
  double radius = 0;
  for (const Vec3d& p : places.at) {
    const Vec3d q((p - form->at).dot(across), (p - form->at).dot(other), (p - form->at).dot(form->along));
    low = low.cwiseMin(q), high = high.cwiseMax(q);
    radius += q.head<2>().norm() / double(places.at.size());
  }
  const Vec3d size = high - low, inside = (low + high) / 2;
  wire::Face told{};
  told.kind = form->kind;
  if (form->kind == plane) {
    told.width = size.x(), told.depth = size.y();
    form->at += inside.x() * across + inside.y() * other;
    // Outwards, as the face is used.
    if ((places.normals.front().second.dot(form->along) < 0) != (face.Orientation() == TopAbs_REVERSED))
      form->along = -form->along;
  } else {
    told.depth = form->radius.value_or(radius);
    told.width = form->kind == axis ? size.z() : told.depth;
    if (form->kind == axis) form->at += inside.z() * form->along;
  }
  if (!(told.width > 0 && told.width <= diagonal && told.depth <= diagonal)) return std::nullopt;
  for (int k = 0; k < 3; ++k) told.at[k] = form->at[k], told.along[k] = form->along[k], told.across[k] = across[k];
  return told;
} catch (const Standard_Failure&) {
  return std::nullopt;  // a surface without normals, offset into itself
}

}  // namespace argil::io::reader
