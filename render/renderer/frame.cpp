#include "render/renderer/frame.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "render/view/lettering.h"
#include "render/view/scale.h"

namespace argil::render {
namespace {

/// The near plane in perspective, as a part of the target's distance. Depth is reversed and floating: precision follows
/// the distance, so this may be small.
constexpr double kNearPart = 1e-3;
/// An orthographic view at most this steep to the ground shows lines in the picture's plane instead of the ground's
/// edge.
constexpr double kEdgeOn = 0.05;
/// Segments that turn less than this (cosine) at a joint meet with flat ends, so that what is see-through does not
/// overlap.
constexpr double kSmoothJoint = 0.978;
constexpr int kRingSegments = 72, kDotSegments = 12;
constexpr double kDotPixels = 2.6;  // Radius of a pointer's dot.

const Colour kTouch{1.0f, 0.71f, 0.30f, 1}, kForce{1.0f, 0.80f, 0.26f, 0.95f};

FrameUniforms::Vec4 pack(const Vec3d& v, double w = 0) {
  return {float(v.x()), float(v.y()), float(v.z()), float(w)};
}

float linear(float srgb) {
  return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f);
}
FrameUniforms::Vec4 linear(const Colour& c) {
  return {linear(c.r), linear(c.g), linear(c.b), c.a};
}

LineInstance line(const Vec3d& a, const Vec3d& b, const Colour& colour, double widthSamples) {
  const auto c = linear(colour);
  return {{float(a.x()), float(a.y()), float(a.z())},
          float(widthSamples),
          {float(b.x()), float(b.y()), float(b.z())},
          0,
          {c[0], c[1], c[2], c[3]}};
}

/// Builds one plan; members are what several steps need.
class Planner {
 public:
  Planner(const Shot& shot, const Subject& subject, const Quality& quality, int width, int height)
      : view_(shot.view),
        stereo_(shot.stereo),
        overlays_(shot.overlays),
        subject_(subject),
        width_(width),
        height_(height),
        axes_(shot.view.axes()),
        interface_(interfaceScale(height)),
        samples_(quality.supersample),
        mmPerSample_(shot.view.heightAtTarget() / (double(height) * quality.supersample)) {
    plan_.eye = view_.position;
    plan_.look = shot.look;
    plan_.stereo = shot.stereo.mode;
    plan_.perspective = view_.projection == Projection::perspective;
    const bool clay = !subject.bounds.empty();
    plan_.look.keyShadow = shot.look.keyShadow && quality.keyShadow && clay;
    plan_.look.cavity = shot.look.cavity && quality.cavity && clay && shot.look.cavityStrength > 0;
    plan_.look.depthFade = shot.look.depthFade && shot.look.depthFadeStrength > 0 && clay;
    diagonal_ = clay ? subject.bounds.size().norm() : view_.heightAtTarget();
    ground_ = groundHeight(subject.bounds);
  }

  FramePlan plan() {
    camera();
    light();
    theme();
    section();
    planes();
    if (plan_.look.grid) grid();
    for (const Fill& each : overlays_.fills) fill(each.trianglesMm, each.colour, each.depth);
    if (overlays_.cursor) cursor(*overlays_.cursor);
    for (const Polyline& path : overlays_.polylines) polyline(path);
    if (plan_.look.scaleBar) bar();
    return std::move(plan_);
  }

 private:
  const Look& look() const { return plan_.look; }
  /// Interface pixels as samples.
  double unit() const { return interface_ * samples_; }

  void camera() {
    FrameUniforms& u = plan_.uniforms;
    u.cameraRight = pack(axes_.right);
    u.cameraUp = pack(axes_.up);
    u.cameraForward = pack(axes_.forward);
    const double aspect = double(width_) / height_, half = 0.5 * view_.heightAtTarget(), away = view_.distance();
    const double apart = stereo_.mode == StereoMode::mono ? 0 : stereo_.eyeDistancePart * away,
                 converge = stereo_.convergencePart * away;
    u.size = {float(width_ * samples_), float(height_ * samples_), float(samples_), float(interface_)};
    if (plan_.perspective) {
      const double tanY = half / away, tanX = tanY * aspect, nearest = kNearPart * away;
      u.scale = {float(1 / tanX), float(1 / tanY), 1, float(mmPerSample_ / away)};
      u.depth = {0, float(nearest), 1, 0};
      // The eyes' frusta share their window at the convergence; these sides hold both.
      const double wideX = tanX + 0.5 * apart / converge;
      for (const double sign : {1.0, -1.0}) {
        const Vec3d across = sign * axes_.right - wideX * axes_.forward;
        plan_.sides.push_back({across.normalized(), 0.5 * apart / across.norm()});
        plan_.sides.push_back({(sign * axes_.up - tanY * axes_.forward).normalized(), 0});
      }
      plan_.sides.push_back({-axes_.forward, -nearest});
      eyes([&](double side, FrameUniforms::Eye& eye) {
        eye = {pack(axes_.right), pack(axes_.up), pack(axes_.forward),
               pack(side * 0.5 * apart * axes_.right, side * 0.5 * apart / (converge * tanX))};
      });
    } else {
      // Everything counts, also what lies behind the camera's position.
      Box all = subject_.bounds;
      all.add(view_.target);
      if (overlays_.cursor) all.add(overlays_.cursor->positionMm);
      for (const Polyline& path : overlays_.polylines) {
        for (const Vec3d& p : path.pointsMm) all.add(p);
      }
      for (const Fill& each : overlays_.fills) {
        for (const Vec3d& p : each.trianglesMm) all.add(p);
      }
      const double middle = (all.centre() - plan_.eye).dot(axes_.forward);
      const double reach = all.size().norm() + 4 * view_.heightAtTarget();
      const double first = middle - reach, last = middle + reach;
      u.scale = {float(1 / (half * aspect)), float(1 / half), 0, float(mmPerSample_)};
      u.depth = {float(-1 / (last - first)), float(last / (last - first)), 0, 1};
      const double turn = std::atan2(0.5 * apart, away), s = std::sin(turn), c = std::cos(turn);
      const double depth = std::max(std::abs(first - converge), std::abs(last - converge));
      for (const double sign : {1.0, -1.0}) {
        plan_.sides.push_back({sign * axes_.right, (half * aspect + depth * s) / c});
        plan_.sides.push_back({sign * axes_.up, half});
      }
      farthest_ = last;
      eyes([&](double side, FrameUniforms::Eye& eye) {
        const Vec3d forward = c * axes_.forward - side * s * axes_.right,
                    right = c * axes_.right + side * s * axes_.forward;
        eye = {pack(right), pack(axes_.up), pack(forward), pack(converge * (axes_.forward - forward))};
      });
    }
  }

  /// Calls with −1 for a left eye, 1 for a right eye, 0 without stereo.
  template <class Make>
  void eyes(const Make& make) {
    auto& out = plan_.uniforms.eyes;
    const double first = stereo_.mode == StereoMode::mono      ? 0
                         : stereo_.both()                      ? (stereo_.swapEyes ? 1 : -1)
                         : stereo_.mode == StereoMode::leftEye ? -1
                                                               : 1;
    make(first, out[0]);
    make(-first, out[1]);
  }

  void light() {
    FrameUniforms& u = plan_.uniforms;
    toKey_ = (-0.50 * axes_.right + 0.66 * axes_.up - 0.56 * axes_.forward).normalized();
    u.keyLight = pack(toKey_, look().keyShadow ? 1 : 0);
    u.marker[2] = look().cavity ? float(look().cavityStrength) : 0;
    if (subject_.bounds.empty()) return;
    u.marker[3] = 1;
    const Vec3d x = toKey_.cross(axes_.up).normalized(), y = toKey_.cross(x);
    const Vec3d centre = subject_.bounds.centre() - plan_.eye;
    const double radius = 0.52 * diagonal_;
    const auto row = [&](const Vec3d& axis, double scale, double offset) {
      return pack(axis * scale, offset - centre.dot(axis) * scale);
    };
    u.shadowX = row(x, 1 / radius, 0);
    u.shadowY = row(y, 1 / radius, 0);
    u.shadowZ = row(toKey_, -0.5 / radius, 0.5);
    // From the nearest to the farthest of the clay.
    const Vec3d halfSize = 0.5 * subject_.bounds.size();
    const double spread = std::max(halfSize.dot(axes_.forward.cwiseAbs()), 1e-9 * diagonal_);
    u.fade = {float(centre.dot(axes_.forward) - spread), float(0.5 / spread),
              look().depthFade ? float(look().depthFadeStrength) : 0, 0};
  }

  void theme() {
    FrameUniforms& u = plan_.uniforms;
    if (look().lightBackground) {
      u.backTop = {0.80f, 0.825f, 0.86f, 0.08f};
      u.backBottom = {0.56f, 0.58f, 0.61f, 0};
      u.groundColour = {0.62f, 0.63f, 0.645f, 0.75f};
      u.minorLine = {0.22f, 0.23f, 0.25f, 0.20f};
      u.majorLine = {0.10f, 0.11f, 0.125f, 0.34f};
    } else {
      u.backTop = {0.058f, 0.066f, 0.080f, 0.22f};
      u.backBottom = {0.020f, 0.022f, 0.026f, 0};
      u.groundColour = {0.074f, 0.075f, 0.079f, 0.75f};
      u.minorLine = {0.30f, 0.32f, 0.35f, 0.20f};
      u.majorLine = {0.50f, 0.53f, 0.57f, 0.34f};
    }
  }

  void planes() {
    FrameUniforms& u = plan_.uniforms;
    for (size_t i = 0; i < overlays_.planes.size(); ++i) {
      const PlaneMark& mark = overlays_.planes[i];
      const Vec3d normal = mark.normal.normalized();
      u.planes[i] = pack(normal, -normal.dot(mark.pointMm - plan_.eye));
      u.planeLines[i] = linear(mark.line);
      u.planeTints[i] = linear(mark.beyond);
      u.planeSizes[i] = {0.5f * mark.widthPixels, mark.dimmedToo ? 1.f : 0.f, float(overlays_.planes.size()), 0};
    }
  }

  void section() {
    if (!look().section) return;
    const Vec3d normal = look().section->normal.normalized();
    plan_.uniforms.section = pack(normal, -normal.dot(look().section->pointMm - plan_.eye));
  }

  void grid() {
    FrameUniforms& u = plan_.uniforms;
    const GridSpacing spacing = gridSpacing(view_, height_);
    const bool facing = !plan_.perspective && std::abs(axes_.forward.z()) < kEdgeOn;
    const Vec3d along = facing ? axes_.right : Vec3d::UnitX(), across = facing ? axes_.up : Vec3d::UnitY();
    const auto snapped = [&](const Vec3d& axis) {
      return axis * std::round(view_.target.dot(axis) / spacing.major) * spacing.major;
    };
    Vec3d crossing = snapped(along) + snapped(across);
    const Vec3d normal = along.cross(across);
    Vec3d middle = subject_.bounds.empty() ? view_.target : subject_.bounds.centre();
    double radius = 2.0 * std::max(diagonal_, 0.6 * view_.heightAtTarget());
    if (facing) {
      // Behind everything.
      crossing += normal * (plan_.eye + axes_.forward * (0.99 * farthest_)).dot(normal);
      middle = view_.target + normal * normal.dot(crossing - view_.target);
      radius = view_.heightAtTarget() * (1 + double(width_) / height_);
      worldLines(Depth::hidden).push_back(groundLine());
    } else {
      // A hair lower, so that a flat underside on the ground does not flicker through it.
      crossing += normal * (ground_ - 1e-4 * diagonal_);
      middle.z() = crossing.z();
    }
    const bool below = plan_.perspective ? plan_.eye.z() < crossing.z() : axes_.forward.z() > 0;
    plan_.ground = facing ? FramePlan::Ground::facing : below ? FramePlan::Ground::below : FramePlan::Ground::level;
    u.ground = pack(crossing - plan_.eye, facing ? 2 : 1);
    u.gridU = pack(along, spacing.minor);
    u.gridV = pack(across, spacing.major);
    u.gridFade = pack(middle - plan_.eye, radius);
  }

  LineInstance groundLine() const {
    const double half = view_.heightAtTarget() * (1 + double(width_) / height_);
    Vec3d middle = view_.target - plan_.eye + axes_.forward * (0.98 * farthest_ - view_.distance());
    middle += axes_.up * (ground_ - (middle + plan_.eye).z()) / axes_.up.z();
    const Colour colour =
        look().lightBackground ? Colour{0.25f, 0.27f, 0.30f, 0.8f} : Colour{0.80f, 0.83f, 0.87f, 0.8f};
    LineInstance ground = line(middle - half * axes_.right, middle + half * axes_.right, colour, 1.5 * unit());
    ground.ends = 4;
    return ground;
  }

  double mmPerPixelAt(const Vec3d& rel) const {
    const double scale =
        plan_.perspective ? std::max(rel.dot(axes_.forward), kNearPart * view_.distance()) / view_.distance() : 1;
    return mmPerSample_ * unit() * scale;
  }

  void cursor(const Cursor& cursor) {
    if (cursor.flat) {
      if (cursor.footprint) mark(*cursor.footprint, cursor.radiusMm, cursor.contact ? kTouch : cursor.tint);
      return;
    }
    plan_.cursor = true;
    FrameUniforms& u = plan_.uniforms;
    const Vec3d rel = cursor.positionMm - plan_.eye;
    const double radius = cursor.radiusMm, pixel = mmPerPixelAt(rel);
    const Colour tint = cursor.contact ? kTouch : cursor.tint;
    u.ball = pack(rel, radius);
    u.tint = linear(tint);
    // The stylus keeps a useful size in the picture however small the ball is.
    const double length = std::clamp(13 * radius, 110 * pixel, 300 * pixel);
    u.shaft = pack(cursor.shaft.normalized(), length);
    const double tip = std::clamp(0.22 * radius, 1.5 * pixel, 5 * pixel);
    u.shaftRadii = {float(tip), float(std::max(0.042 * length, 1.6 * tip)), 0, 0};
    if (cursor.footprint) {
      footprint(*cursor.footprint, radius, tint);
    } else if (look().beam && subject_.beamLengthMm) {
      beam(rel, radius, cursor.drop.normalized(), *subject_.beamLengthMm, tint);
    }
    if (cursor.forceN.norm() > 1e-6 * cursor.fullForceN) force(cursor, rel, length, pixel);
  }

  void beam(const Vec3d& rel, double radius, const Vec3d& drop, double beam, const Colour& tint) {
    FrameUniforms& u = plan_.uniforms;
    const Vec3d end = rel + beam * drop;
    const double endPixel = mmPerPixelAt(end);
    u.drop = pack(drop, std::max(beam, 1e-6 * radius));
    u.marker[0] = float(std::clamp(0.22 * radius, 2.5 * endPixel, 5 * endPixel));
    u.marker[1] = float(1.1 * endPixel);
    plan_.landing =
        rectangle(end, std::hypot(1.5 * radius + 2 * double(u.marker[0]), radius + 2 * double(u.marker[1])));
    if (beam <= radius) return;
    const Vec3d start = rel + radius * drop;
    worldLines(Depth::hidden).push_back(line(start, end, {tint.r, tint.g, tint.b, 0.22f}, 6 * unit()));
    worldLines(Depth::hidden).push_back(line(start, end, {tint.r, tint.g, tint.b, 0.9f}, 1.8 * unit()));
  }

  /// Samples that hold a ball, for all eyes.
  FramePlan::Rectangle rectangle(const Vec3d& rel, double radius) const {
    const FrameUniforms& u = plan_.uniforms;
    const auto vec = [](const FrameUniforms::Vec4& v) { return Vec3d(double(v[0]), double(v[1]), double(v[2])); };
    const double width = width_ * samples_, height = height_ * samples_;
    double left = width, top = height, right = 0, bottom = 0;
    for (int i = 0; i < plan_.eyes(); ++i) {
      const FrameUniforms::Eye& eye = u.eyes[size_t(i)];
      const Vec3d p = rel - vec(eye.place);
      for (int corner = 0; corner < 8; ++corner) {
        const double x = p.dot(vec(eye.right)) + ((corner & 1) ? radius : -radius),
                     y = p.dot(vec(eye.up)) + ((corner & 2) ? radius : -radius),
                     z = p.dot(vec(eye.forward)) + ((corner & 4) ? radius : -radius), w = plan_.perspective ? z : 1;
        if (w <= 0) return {0, 0, int(width), int(height)};
        const double px = (0.5 + 0.5 * (x * double(u.scale[0]) / w + double(eye.place[3]))) * width;
        const double py = (0.5 - 0.5 * y * double(u.scale[1]) / w) * height;
        left = std::min(left, px);
        right = std::max(right, px);
        top = std::min(top, py);
        bottom = std::max(bottom, py);
      }
    }
    const auto within = [](double at, double most) { return int(std::clamp(at, 0.0, most)); };
    return {within(left - 1, width), within(top - 1, height), within(right + 2, width), within(bottom + 2, height)};
  }

  void footprint(const Cursor::Footprint& print, double radius, const Colour& tint) {
    const Vec3d n = print.normal.normalized(), x = n.unitOrthogonal(), y = n.cross(x);
    Polyline ring{{}, {tint.r, tint.g, tint.b, 0.95f}, 2.2f, Depth::xray};
    for (int i = 0; i <= kRingSegments; ++i) {
      const double angle = 2 * std::numbers::pi * i / kRingSegments;
      ring.pointsMm.push_back(print.pointMm + radius * (std::cos(angle) * x + std::sin(angle) * y));
    }
    polyline(ring);
  }

  /// The footprint's ring, and a dot where the tool points: on top, so that neither a bump nor the eye's angle hides
  /// it.
  void mark(const Cursor::Footprint& print, double radius, const Colour& tint) {
    footprint(print, radius, tint);
    const double dot = kDotPixels * mmPerPixelAt(print.pointMm - plan_.eye);
    std::vector<Vec3d> corners;
    for (int i = 0; i < kDotSegments; ++i) {
      for (const int at : {i, i + 1}) {
        const double angle = 2 * std::numbers::pi * at / kDotSegments;
        corners.push_back(print.pointMm + dot * (std::cos(angle) * axes_.right + std::sin(angle) * axes_.up));
      }
      corners.push_back(print.pointMm);
    }
    fill(corners, tint, Depth::onTop);
  }

  /// From the ball along the force on the hand, a head at its end that faces the viewer.
  void force(const Cursor& cursor, const Vec3d& rel, double stylus, double pixel) {
    const Vec3d along = cursor.forceN.normalized();
    const double head = 13 * pixel, length = std::max(cursor.forceN.norm() / cursor.fullForceN * stylus, head);
    const Vec3d start = rel + cursor.radiusMm * along, neck = start + (length - head) * along;
    if (length > head) worldLines(Depth::xray).push_back(line(start, neck, kForce, 3.2 * unit()));
    const Vec3d sight = plan_.perspective ? neck : axes_.forward;
    const Vec3d side = along.cross(sight).norm() > 1e-6 * sight.norm() ? along.cross(sight).normalized() : axes_.right;
    const Vec3d at = plan_.eye + neck;
    fill({at + 0.45 * head * side, at + head * along, at - 0.45 * head * side}, kForce, Depth::xray);
  }

  std::vector<LineInstance>& worldLines(Depth depth) {
    return plan_.worldLines[size_t(depth == Depth::xray && !look().xray ? Depth::hidden : depth)];
  }

  void fill(const std::vector<Vec3d>& trianglesMm, const Colour& colour, Depth depth) {
    if (depth == Depth::xray && !look().xray) depth = Depth::hidden;
    const auto first = uint32_t(plan_.fillVertices.size());
    const auto c = linear(colour);
    for (const Vec3d& p : trianglesMm) {
      const Vec3f rel = (p - plan_.eye).cast<float>();
      plan_.fillVertices.push_back({{rel.x(), rel.y(), rel.z()}, {c[0], c[1], c[2], c[3]}});
    }
    const uint32_t count = uint32_t(plan_.fillVertices.size()) - first;
    if (count > 0) plan_.fills.push_back({depth, first, count});
  }

  void polyline(const Polyline& path) {
    const double width = path.widthPixels * unit();
    const auto& p = path.pointsMm;
    std::vector<LineInstance>& out = worldLines(path.depth);
    const auto smooth = [&](size_t i) {
      if (p.size() < 3 || i == 0 || i + 1 == p.size()) {
        // A closed ring joins its last point to its first.
        return p.size() > 3 && p.front() == p.back() &&
               (p[1] - p[0]).normalized().dot((p[p.size() - 1] - p[p.size() - 2]).normalized()) > kSmoothJoint;
      }
      return (p[i] - p[i - 1]).normalized().dot((p[i + 1] - p[i]).normalized()) > kSmoothJoint;
    };
    for (size_t i = 0; i + 1 < p.size(); ++i) {
      out.push_back(line(p[i] - plan_.eye, p[i + 1] - plan_.eye, path.colour, width));
      out.back().ends = float((smooth(i) ? 1 : 0) + (smooth(i + 1) ? 2 : 0));
    }
  }

  /// Bottom left: the bar with its ends and its length above; beside it the spacing of the grid.
  void bar() {
    const ScaleBar bar = scaleBar(view_, width_, height_);
    const double unit = this->unit();
    const double left = 28 * unit, right = left + bar.pixels * samples_, y = height_ * samples_ - 28 * unit;
    const double capital = 13 * unit;
    std::vector<LineInstance> lines;
    const bool light = look().lightBackground;
    const Colour strong = light ? Colour{0.10f, 0.11f, 0.12f, 1} : Colour{0.93f, 0.94f, 0.95f, 1};
    const Colour weak = light ? Colour{0.30f, 0.31f, 0.33f, 1} : Colour{0.72f, 0.74f, 0.77f, 1};
    const auto add = [&](double ax, double ay, double bx, double by, const Colour& colour, double width) {
      lines.push_back(line({ax, ay, 0}, {bx, by, 0}, colour, width * unit));
    };
    const auto write = [&](const std::string& text, double x, double top, const Colour& colour) {
      for (const Stroke2& s : letter(text, float(x), float(top), float(capital)))
        add(s.ax, s.ay, s.bx, s.by, colour, 1.7);
    };
    add(left, y, right, y, strong, 2);
    for (const double x : {left, right}) add(x, y - 5 * unit, x, y + 5 * unit, strong, 2);
    add(0.5 * (left + right), y - 3 * unit, 0.5 * (left + right), y, strong, 1.5);
    const std::string label = lengthLabel(bar.mm);
    write(label, 0.5 * (left + right) - 0.5 * letterWidth(label, float(capital)), y - 26 * unit, strong);
    if (look().grid) {
      write("grid " + lengthLabel(gridSpacing(view_, height_).minor), right + 22 * unit, y - 0.5 * capital, weak);
    }
    for (const LineInstance& each : lines) {
      LineInstance outline = each;
      outline.widthSamples += float(2.6 * unit);
      outline.colour[0] = outline.colour[1] = outline.colour[2] = light ? 0.9f : 0.006f;
      outline.colour[3] = 0.55f;
      plan_.screenLines.push_back(outline);
    }
    plan_.screenLines.insert(plan_.screenLines.end(), lines.begin(), lines.end());
  }

  const View& view_;
  const Stereo& stereo_;
  const Overlays& overlays_;
  const Subject& subject_;
  const int width_, height_;
  const View::Axes axes_;
  const double interface_, samples_;
  const double mmPerSample_;  // in the plane through the target
  double diagonal_ = 1, ground_ = 0, farthest_ = 0;
  Vec3d toKey_;
  FramePlan plan_;
};

}  // namespace

double groundHeight(const Box& bounds) {
  return bounds.empty() ? 0 : bounds.min.z();
}

FramePlan planFrame(const Shot& shot, const Subject& subject, const Quality& quality, int width, int height) {
  return Planner(shot, subject, quality, width, height).plan();
}

}  // namespace argil::render
