#pragma once
// Where a hand wants to go: time-stamped points of a recorded or a made-up hand.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "haptics/base/pose.h"
#include "haptics/base/realtime.h"

namespace argil::haptics {

/// A point of a hand path, in the frame that its user says (the device's for a simulated hand).
struct HandPoint {
  double timeS = 0;
  Vec3d position = Vec3d::Zero();  ///< mm.
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Vec3d forceN = Vec3d::Zero();  ///< Pushed by the hand on top of holding its place.
  float pressure = 0;            ///< 0 to 1.
  uint32_t buttons = 0;
};

/// How a file of another layout is read. Columns that mean nothing here are passed over.
struct HandPathLayout {
  std::string units;  ///< Of lengths: mm, um, cm, m, in or ft. Must be said: a file of numbers does not tell.
  /// Which column is which, as "t=clock,x=tip_x,y=tip_y,z=tip_z"; roles: t, x, y, z, qx, qy, qz, qw, fx, fy, fz,
  /// pressure, buttons. Roles not named here are found by the usual names in any case of letters: t, t_s, time, time_s,
  /// timestamp (s), t_ms, time_ms, t_us, time_us; x, px, pos_x, position_x, x_mm; qx, qi, quat_x; qw, qr, quat_w; fx,
  /// fx_n, force_x.
  std::string columns;
  std::string rows;  ///< "demo=3": only rows whose column of that name holds that; empty: all.
};

/// Points in order of time. Between two points position, rotation and force are interpolated (straight lines, slerp),
/// buttons and pressure are those of the earlier one; before the first and after the last the path stands still.
class HandPath {
 public:
  HandPath() = default;
  /// Throws Error when a number is not finite or times do not increase.
  explicit HandPath(std::vector<HandPoint> points);
  /// The same without looking at the numbers: to test what happens when a path holds NaN.
  static HandPath unchecked(std::vector<HandPoint> points);

  /// Reads the project's CSV: header `t_s,x_mm,y_mm,z_mm[,qx,qy,qz,qw][,fx_n,fy_n,fz_n][,pressure][,buttons]`, one row
  /// a point. Throws Error that names `name`, the line and what is wrong.
  static HandPath fromCsv(std::string_view text, const std::string& name);
  /// Reads any CSV with a header line, as `layout` says; forces in N, times made to begin at zero. Throws Error as
  /// above, and when a column is missing, is there twice, or the units are unknown.
  static HandPath fromCsv(std::string_view text, const std::string& name, const HandPathLayout& layout);

  [[nodiscard]] bool empty() const noexcept { return points_.empty(); }
  [[nodiscard]] double durationS() const noexcept;  ///< Time of the last point.
  [[nodiscard]] const std::vector<HandPoint>& points() const noexcept { return points_; }

  /// The path at a time. `hint` is the caller's: keeps a walk forward in time at O(1). Real-time safe.
  [[nodiscard]] HandPoint at(double timeS, size_t& hint) const ARGIL_REALTIME;

  // Generators: buttons held all the way, force zero, a point each `stepS`.
  static HandPath hold(const Vec3d& position, double seconds, uint32_t buttons = 0);
  /// From a to b in a smooth push-off and stop (quintic).
  static HandPath line(const Vec3d& a, const Vec3d& b, double seconds, uint32_t buttons = 0, double stepS = 0.005);
  /// `turns` of a circle about `centre` through `start`, about the unit `axis`.
  static HandPath circle(const Vec3d& centre, const Vec3d& start, const Vec3d& axis, double turns, double seconds,
                         uint32_t buttons = 0, double stepS = 0.005);
  /// This path, then `next` moved in time to begin where this one ends. Where the places differ there is a jump.
  [[nodiscard]] HandPath then(const HandPath& next) const;

 private:
  std::vector<HandPoint> points_;
};

}  // namespace argil::haptics
