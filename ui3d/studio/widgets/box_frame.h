#pragma once
// A box in the picture: edges, corners, faces. Shared by the keep-out box and the workspace's.

#include <array>
#include <vector>

#include "haptics/base/pose.h"

namespace argil::studio {

struct BoxFrame {
  haptics::Pose pose;
  Vec3d half;

  [[nodiscard]] Vec3d at(double x, double y, double z) const { return pose.apply(half.cwiseProduct(Vec3d(x, y, z))); }
  /// Unit, outwards; face 2 i is at −1 along axis i, 2 i + 1 at +1.
  [[nodiscard]] Vec3d normal(int face) const {
    return pose.rotation * ((face & 1 ? 1.0 : -1.0) * Vec3d::Unit(face / 2));
  }
  [[nodiscard]] Vec3d faceCentre(int face) const { return pose.translation + half[face / 2] * normal(face); }
  [[nodiscard]] std::vector<std::array<Vec3d, 2>> edges() const {
    std::vector<std::array<Vec3d, 2>> result;
    for (const double a : {-1.0, 1.0})
      for (const double b : {-1.0, 1.0}) {
        result.push_back({at(-1, a, b), at(1, a, b)});
        result.push_back({at(a, -1, b), at(a, 1, b)});
        result.push_back({at(a, b, -1), at(a, b, 1)});
      }
    return result;
  }
  [[nodiscard]] std::vector<Vec3d> triangles() const {
    std::vector<Vec3d> result;
    for (int face = 0; face < 6; ++face) {
      const int i = face / 2, j = (i + 1) % 3, k = (i + 2) % 3;
      const auto corner = [&](double u, double v) {
        Vec3d p = (face & 1 ? 1.0 : -1.0) * Vec3d::Unit(i) + u * Vec3d::Unit(j) + v * Vec3d::Unit(k);
        return at(p.x(), p.y(), p.z());
      };
      for (const auto& [u, v] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, -1}, {1, 1}, {-1, 1}})
        result.push_back(corner(u, v));
    }
    return result;
  }
};

}  // namespace argil::studio
