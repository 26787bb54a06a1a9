#include "engine/document/stroke_images.h"

#include <cmath>
#include <numbers>

namespace argil::engine {

ImageMaps::ImageMaps(const StrokeImages& images, const clay::Grid& grid, const haptics::Pose& pose) {
  const auto place = [&](const Vec3d& worldMm) { return grid.toVoxel(pose.applyInverse(worldMm)); };
  const auto direction = [&](const Vec3d& world) { return Vec3d((pose.rotation.conjugate() * world).normalized()); };
  for (const MirrorPlane& plane : images.mirrors) {
    const Vec3d normal = direction(plane.normal);
    // p − 2 ((p − point) · n) n
    Map mirror;
    mirror.turn -= 2 * normal * normal.transpose();
    mirror.shift = 2 * place(plane.pointMm).dot(normal) * normal;
    const size_t before = maps_.size();
    for (size_t i = 0; i < before; ++i)
      maps_.push_back({mirror.turn * maps_[i].turn, mirror.turn * maps_[i].shift + mirror.shift});
  }
  const size_t mirrored = maps_.size();
  for (int i = 1; i < images.turns; ++i) {
    const double angle = 2 * std::numbers::pi * i / images.turns;
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, direction(images.axis)).toRotationMatrix();
    const Vec3d middle = place(images.axisPointMm);
    for (size_t j = 0; j < mirrored; ++j)
      maps_.push_back({turn * maps_[j].turn, turn * (maps_[j].shift - middle) + middle});
  }
}

void ImageMaps::bringBack(clay::WallAhead& wall) const {
  const Map& map = maps_.at(wall.image);
  wall.place = map.turn.transpose() * (wall.place - map.shift);
  wall.wall = map.turn.transpose() * wall.wall;
  wall.image = 0;
}

void ImageMaps::apply(const clay::Stamp& stamp, std::vector<clay::Stamp>& out) const {
  out.assign(maps_.size(), stamp);
  for (size_t i = 1; i < maps_.size(); ++i) {
    out[i].a = maps_[i].turn * stamp.a + maps_[i].shift;
    out[i].b = maps_[i].turn * stamp.b + maps_[i].shift;
    out[i].axes = maps_[i].turn.cast<float>() * stamp.axes;
  }
}

}  // namespace argil::engine
