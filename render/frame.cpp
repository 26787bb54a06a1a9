#include "render/frame.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "render/lettering.h"
#include "render/scale.h"

namespace argil::render {
namespace {

/// The near plane in perspective, as a part of the target's distance. Depth is reversed and floating: precision follows
/// the distance, so this may be small.
constexpr double kNearPart = 1e-3;
/// An orthographic view at most this steep to the ground shows lines in the picture's plane instead of the ground's
/// edge.
constexpr double kEdgeOn = 0.05;

FrameUniforms::Vec4 pack(const Vec3d& v, double w = 0) {
  return {float(v.x()), float(v.y()), float(v.z()), float(w)};
}

float linear(float srgb) {
  return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f);
}

LineInstance line(const Vec3d& a, const Vec3d& b, const Colour& colour, double widthSamples) {
  return {{float(a.x()), float(a.y()), float(a.z())},
          float(widthSamples),
          {float(b.x()), float(b.y()), float(b.z())},
          0,
          {linear(colour.r), linear(colour.g), linear(colour.b), colour.a}};
}

/// Builds one plan; members are what several steps need.
class Planner {
 public:
  Planner(const View& view, const Overlays& overlays, const Subject& subject, const Quality& quality, int width,
          int height)
      : view_(view),
        overlays_(overlays),
        subject_(subject),
        quality_(quality),
        width_(width),
        height_(height),
        axes_(view.axes()),
        interface_(interfaceScale(height)),
        samples_(quality.supersample),
        mmPerSample_(view.heightAtTarget() / (double(height) * quality.supersample)) {
    plan_.eye = view.position;
    diagonal_ = subject.bounds.empty() ? view.heightAtTarget() : subject.bounds.size().norm();
    ground_ = groundHeight(subject.bounds);
  }

  FramePlan plan() {
    camera();
    light();
    if (overlays_.grid) grid();
    if (overlays_.cursor) cursor(*overlays_.cursor);
    for (const Polyline& path : overlays_.polylines) polyline(path);
    if (overlays_.scaleBar) bar();
    plan_.uniforms.marker[2] = overlays_.cavity ? 1.0f : 0.0f;
    return std::move(plan_);
  }

 private:
  void camera() {
    FrameUniforms& u = plan_.uniforms;
    u.cameraRight = pack(axes_.right);
    u.cameraUp = pack(axes_.up);
    u.cameraForward = pack(axes_.forward);
    const double aspect = double(width_) / height_, half = 0.5 * view_.heightAtTarget(), away = view_.distance();
    u.size = {float(width_ * samples_), float(height_ * samples_), float(samples_), float(interface_)};
    if (view_.projection == Projection::perspective) {
      const double tanY = half / away, tanX = tanY * aspect, nearest = kNearPart * away;
      u.scale = {float(1 / tanX), float(1 / tanY), 1, float(mmPerSample_ / away)};
      u.depth = {0, float(nearest), 1, 0};
      for (const double sign : {1.0, -1.0}) {
        plan_.sides.push_back({(sign * axes_.right - tanX * axes_.forward).normalized(), 0});
        plan_.sides.push_back({(sign * axes_.up - tanY * axes_.forward).normalized(), 0});
      }
      plan_.sides.push_back({-axes_.forward, -nearest});
    } else {
      // Everything counts, also what lies behind the camera's position.
      Box all = subject_.bounds;
      all.add(view_.target);
      if (overlays_.cursor) all.add(overlays_.cursor->positionMm);
      for (const Polyline& path : overlays_.polylines) {
        for (const Vec3d& p : path.pointsMm) all.add(p);
      }
      const double middle = (all.centre() - plan_.eye).dot(axes_.forward);
      const double reach = all.size().norm() + 4 * view_.heightAtTarget();
      const double first = middle - reach, last = middle + reach;
      u.scale = {float(1 / (half * aspect)), float(1 / half), 0, float(mmPerSample_)};
      u.depth = {float(-1 / (last - first)), float(last / (last - first)), 0, 1};
      for (const double sign : {1.0, -1.0}) {
        plan_.sides.push_back({sign * axes_.right, half * aspect});
        plan_.sides.push_back({sign * axes_.up, half});
      }
      farthest_ = last;
    }
  }

  void light() {
    FrameUniforms& u = plan_.uniforms;
    toKey_ = (-0.50 * axes_.right + 0.66 * axes_.up - 0.56 * axes_.forward).normalized();
    const bool clay = !subject_.bounds.empty();
    u.keyLight = pack(toKey_, clay && quality_.keyShadow ? 1 : 0);
    u.marker[3] = clay ? 1 : 0;
    if (!clay) return;
    const Vec3d x = toKey_.cross(axes_.up).normalized(), y = toKey_.cross(x);
    const Vec3d centre = subject_.bounds.centre() - plan_.eye;
    const double radius = 0.52 * diagonal_;
    const auto row = [&](const Vec3d& axis, double scale, double offset) {
      return pack(axis * scale, offset - centre.dot(axis) * scale);
    };
    u.shadowX = row(x, 1 / radius, 0);
    u.shadowY = row(y, 1 / radius, 0);
    u.shadowZ = row(toKey_, -0.5 / radius, 0.5);
  }

  void grid() {
    FrameUniforms& u = plan_.uniforms;
    const GridSpacing spacing = gridSpacing(view_, height_);
    const bool facing = view_.projection == Projection::orthographic && std::abs(axes_.forward.z()) < kEdgeOn;
    const Vec3d along = facing ? axes_.right : Vec3d::UnitX(), across = facing ? axes_.up : Vec3d::UnitY();
    const auto snapped = [&](const Vec3d& axis) {
      return axis * std::round(view_.target.dot(axis) / spacing.major) * spacing.major;
    };
    Vec3d crossing = snapped(along) + snapped(across);
    const Vec3d normal = along.cross(across);
    if (facing) {
      // Behind everything.
      crossing += normal * (plan_.eye + axes_.forward * (0.999 * farthest_)).dot(normal);
      plan_.worldLines.push_back(groundLine());
    } else {
      // A hair lower, so that a flat underside on the ground does not flicker through it.
      crossing += normal * (ground_ - 1e-4 * diagonal_);
    }
    u.ground = pack(crossing - plan_.eye, facing ? 2 : 1);
    u.gridU = pack(along, spacing.minor);
    u.gridV = pack(across, spacing.major);
    Vec3d middle = subject_.bounds.empty() ? view_.target : subject_.bounds.centre();
    middle.z() = ground_;
    u.gridFade = pack(middle - plan_.eye, 2.0 * std::max(diagonal_, 0.6 * view_.heightAtTarget()));
  }

  LineInstance groundLine() const {
    const double half = view_.heightAtTarget() * (1 + double(width_) / height_);
    Vec3d middle = view_.target - plan_.eye + axes_.forward * (0.99 * farthest_ - view_.distance());
    middle += axes_.up * (ground_ - (middle + plan_.eye).z()) / axes_.up.z();
    return line(middle - half * axes_.right, middle + half * axes_.right, {0.80f, 0.83f, 0.87f, 0.8f},
                1.5 * interface_ * samples_);
  }

  double mmPerPixelAt(const Vec3d& rel) const {
    const double scale = view_.projection == Projection::perspective
                             ? std::max(rel.dot(axes_.forward), kNearPart * view_.distance()) / view_.distance()
                             : 1;
    return mmPerSample_ * samples_ * interface_ * scale;
  }

  void cursor(const Cursor& cursor) {
    FrameUniforms& u = plan_.uniforms;
    const Vec3d rel = cursor.positionMm - plan_.eye, drop = cursor.drop.normalized();
    const double radius = cursor.radiusMm, pixel = mmPerPixelAt(rel);
    u.ball = pack(rel, radius);
    // The stylus keeps a useful size in the picture however small the ball is.
    const double length = std::clamp(13 * radius, 110 * pixel, 300 * pixel);
    u.shaft = pack(cursor.shaft.normalized(), length);
    const double tip = std::clamp(0.22 * radius, 1.5 * pixel, 5 * pixel);
    u.shaftRadii = {float(tip), float(std::max(0.042 * length, 1.6 * tip)), cursor.contact ? 1.0f : 0.0f, 0};
    u.drop = pack(drop, 0);
    if (!subject_.beamLengthMm) return;
    const double beam = *subject_.beamLengthMm;
    const Vec3d end = rel + beam * drop;
    const double endPixel = mmPerPixelAt(end);
    u.drop[3] = float(std::max(beam, 1e-6 * radius));
    u.marker[0] = float(std::clamp(0.22 * radius, 2.5 * endPixel, 5 * endPixel));
    u.marker[1] = float(1.1 * endPixel);
    if (beam <= radius) return;
    Colour colour = cursor.contact ? Colour{1.0f, 0.71f, 0.30f, 0.9f} : Colour{0.35f, 0.81f, 0.98f, 0.9f};
    const Vec3d start = rel + radius * drop;
    plan_.worldLines.push_back(line(start, end, {colour.r, colour.g, colour.b, 0.22f}, 6 * interface_ * samples_));
    plan_.worldLines.push_back(line(start, end, colour, 1.8 * interface_ * samples_));
  }

  void polyline(const Polyline& path) {
    const double width = path.widthPixels * interface_ * samples_;
    for (size_t i = 0; i + 1 < path.pointsMm.size(); ++i) {
      plan_.worldLines.push_back(
          line(path.pointsMm[i] - plan_.eye, path.pointsMm[i + 1] - plan_.eye, path.colour, width));
    }
  }

  /// Bottom left: the bar with its ends and its length above; beside it the spacing of the grid.
  void bar() {
    const ScaleBar bar = scaleBar(view_, width_, height_);
    const double unit = interface_ * samples_;
    const double left = 28 * unit, right = left + bar.pixels * samples_, y = height_ * samples_ - 28 * unit;
    const double capital = 13 * unit;
    std::vector<LineInstance> lines;
    const Colour white{0.93f, 0.94f, 0.95f, 1}, grey{0.72f, 0.74f, 0.77f, 1};
    const auto add = [&](double ax, double ay, double bx, double by, const Colour& colour, double width) {
      lines.push_back(line({ax, ay, 0}, {bx, by, 0}, colour, width * unit));
    };
    const auto write = [&](const std::string& text, double x, double top, const Colour& colour) {
      for (const Stroke2& s : letter(text, float(x), float(top), float(capital)))
        add(s.ax, s.ay, s.bx, s.by, colour, 1.7);
    };
    add(left, y, right, y, white, 2);
    for (const double x : {left, right}) add(x, y - 5 * unit, x, y + 5 * unit, white, 2);
    add(0.5 * (left + right), y - 3 * unit, 0.5 * (left + right), y, white, 1.5);
    const std::string label = lengthLabel(bar.mm);
    write(label, 0.5 * (left + right) - 0.5 * letterWidth(label, float(capital)), y - 26 * unit, white);
    if (overlays_.grid) {
      write("grid " + lengthLabel(gridSpacing(view_, height_).minor), right + 22 * unit, y - 0.5 * capital, grey);
    }
    for (const LineInstance& each : lines) {
      LineInstance outline = each;
      outline.widthSamples += float(2.6 * unit);
      outline.colour[0] = outline.colour[1] = outline.colour[2] = 0.006f;
      outline.colour[3] = 0.55f;
      plan_.screenLines.push_back(outline);
    }
    plan_.screenLines.insert(plan_.screenLines.end(), lines.begin(), lines.end());
  }

  const View& view_;
  const Overlays& overlays_;
  const Subject& subject_;
  const Quality& quality_;
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

FramePlan planFrame(const View& view, const Overlays& overlays, const Subject& subject, const Quality& quality,
                    int width, int height) {
  return Planner(view, overlays, subject, quality, width, height).plan();
}

}  // namespace argil::render
