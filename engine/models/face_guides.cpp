#include "engine/models/face_guides.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <span>
#include <utility>

namespace argil::engine {
namespace {

using Kind = io::ModelFace::Kind;

constexpr double kSameMm = 1e-3, kSameTurn = 1e-9;  // 1 − cosine: 0.003°
constexpr size_t kMostCounted = 1000;               // each is compared with all before it
constexpr double kFarthestMm = 2e6;                 // clay reaches half as far
constexpr double kSticksOut = 1.2;                  // a line reaches so much farther than its face

const char* wordOf(Kind kind) {
  return kind == Kind::plane ? "plane" : kind == Kind::axis ? "axis" : "middle";
}

double areaOf(const io::ModelFace& face) {
  switch (face.kind) {
    case Kind::plane:
      return face.width * face.depth;
    case Kind::axis:
      return 2 * std::numbers::pi * face.depth * face.width;
    case Kind::middle:
      return 4 * std::numbers::pi * face.depth * face.depth;
  }
  return 0;
}

// Whether two give the same guide.
bool same(const io::ModelFace& a, const io::ModelFace& b) {
  if (a.kind != b.kind) return false;
  const Vec3d way = b.at - a.at;
  if (a.kind == Kind::middle) return way.norm() < kSameMm;
  if (1 - std::abs(a.along.dot(b.along)) > kSameTurn) return false;
  const double off = way.dot(a.along);
  return a.kind == Kind::plane ? std::abs(off) < kSameMm : (way - off * a.along).norm() < kSameMm;
}

Guide guideOf(const io::ModelFace& face) {
  Guide guide;
  guide.pose.translation = face.at;
  Eigen::Matrix3d axes;
  axes << face.across, face.along.cross(face.across), face.along;
  guide.pose.rotation = Eigen::Quaterniond(axes).normalized();
  switch (face.kind) {
    case Kind::plane:
      guide.kind = Guide::Kind::plane;
      guide.sizeMm = {face.width, face.depth, 0};
      break;
    case Kind::axis:
      guide.kind = Guide::Kind::line;
      guide.sizeMm.z() = kSticksOut * face.width;
      break;
    case Kind::middle:
      guide.kind = Guide::Kind::point;
      break;
  }
  return guide;
}

}  // namespace

FaceGuides::FaceGuides(const std::vector<io::ModelObject>& objects) {
  for (const io::ModelObject& object : objects)
    for (const io::ModelFace& face : object.faces) {
      faces_.push_back({face, object.name});
      for (const Vec3d& place : {Vec3d(face.at), Vec3d(face.at + face.along), Vec3d(face.at + face.across)})
        places_.positions.push_back(place);
    }
}

FaceGuides::Made FaceGuides::make() const {
  std::vector<Face> moved = faces_;
  for (size_t i = 0; i < moved.size(); ++i) {
    const Vec3d* place = &places_.positions[3 * i];
    io::ModelFace& face = moved[i].face;
    const Vec3d along = place[1] - place[0], across = place[2] - place[0];
    const double scale = along.norm();
    face.at = place[0];
    face.along = along / scale;
    face.across = (across - across.dot(face.along) * face.along).normalized();
    face.width *= scale, face.depth *= scale;
  }
  std::erase_if(moved, [](const Face& each) { return !(each.face.at.cwiseAbs().maxCoeff() < kFarthestMm); });
  std::stable_sort(moved.begin(), moved.end(),
                   [](const Face& a, const Face& b) { return areaOf(a.face) > areaOf(b.face); });
  std::vector<Face> found;
  for (Face& each : moved) {
    if (found.size() > kMostCounted) break;
    if (std::none_of(found.begin(), found.end(), [&](const Face& other) { return same(other.face, each.face); }))
      found.push_back(std::move(each));
  }
  Made made;
  std::map<std::pair<std::string, Kind>, int> counts;
  for (const Face& each : std::span(found).first(std::min(found.size(), kMost))) {
    Guide& guide = made.guides.emplace_back(guideOf(each.face));
    const int number = ++counts[{each.object, each.face.kind}];
    guide.name = fmt::format("{}{} {}", each.object.empty() ? "" : each.object + ": ", wordOf(each.face.kind), number);
  }
  const size_t count = made.guides.size();
  if (count == 0)
    made.note = "It has no plane or round faces, so there are no guides of them.";
  else if (found.size() > count)
    made.note = fmt::format("{} guides of its largest faces, of {}{}.", count,
                            found.size() > kMostCounted ? "more than " : "", std::min(found.size(), kMostCounted));
  else
    made.note = fmt::format("{} guide{} of its faces.", count, count == 1 ? "" : "s");
  return made;
}

}  // namespace argil::engine
