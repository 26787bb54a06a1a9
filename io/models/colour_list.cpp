#include "io/models/colour_list.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace argil::io {

namespace {

constexpr float kNone = -1;  ///< In place of red: no colour was given.

}  // namespace

void ColourList::add(size_t index, std::span<const double> numbers) {
  colours_.resize(index, {kNone, 0, 0, 0});
  std::array<float, 4>& colour = colours_.emplace_back(std::array<float, 4>{0, 0, 0, kNone});
  for (size_t i = 0; i < std::min<size_t>(numbers.size(), 4); ++i) {
    const double part = std::isfinite(numbers[i]) ? std::clamp(numbers[i], 0.0, 255.0) : 0.0;
    largest_ = std::max(largest_, part);
    colour[i] = static_cast<float>(part);
  }
}

std::vector<Colour> ColourList::take(size_t count) {
  std::vector<Colour> result;
  if (!colours_.empty()) {
    const float scale = largest_ > 1 ? 1.0f : 255.0f;
    const auto part = [scale](float number) { return static_cast<uint8_t>(number * scale + 0.5f); };
    result.resize(count);
    for (size_t i = 0; i < std::min(count, colours_.size()); ++i) {
      const auto& [red, green, blue, alpha] = colours_[i];
      if (red != kNone) result[i] = {part(red), part(green), part(blue), alpha == kNone ? uint8_t{255} : part(alpha)};
    }
  }
  *this = {};
  return result;
}

void setCornerColours(ModelObject& object, std::span<const std::array<Colour, 3>> corners) {
  object.vertexColours.clear();
  object.triangleColours.clear();
  const auto isPlain = [](const std::array<Colour, 3>& c) { return c[0] == c[1] && c[0] == c[2]; };
  if (std::all_of(corners.begin(), corners.end(), isPlain)) {
    object.triangleColours.reserve(corners.size());
    for (const auto& each : corners) object.triangleColours.push_back(each[0]);
    return;
  }
  std::vector<Colour>& colours = object.vertexColours;
  colours.resize(object.mesh.positions.size());
  std::vector<bool> taken(colours.size());
  // Further vertices at the place of one whose first colour is another.
  std::map<std::tuple<uint32_t, uint8_t, uint8_t, uint8_t, uint8_t>, uint32_t> more;
  for (size_t t = 0; t < corners.size(); ++t) {
    for (size_t k = 0; k < 3; ++k) {
      uint32_t& vertex = object.mesh.triangles[t][k];
      const Colour& colour = corners[t][k];
      if (!taken[vertex]) {
        colours[vertex] = colour;
        taken[vertex] = true;
      }
      if (colours[vertex] == colour) continue;
      const auto [at, isNew] = more.try_emplace({vertex, colour.red, colour.green, colour.blue, colour.alpha},
                                                uint32_t(object.mesh.positions.size()));
      if (isNew) {
        object.mesh.positions.push_back(Vec3d(object.mesh.positions[vertex]));
        colours.push_back(colour);
        taken.push_back(true);
      }
      vertex = at->second;
    }
  }
}

namespace {

/// Linear light of an sRGB byte, 0 to 1 (IEC 61966-2-1).
float linear(uint8_t srgb) {
  static const std::array<float, 256> kTable = [] {
    std::array<float, 256> table{};
    for (size_t i = 0; i < table.size(); ++i) {
      const double s = double(i) / 255;
      table[i] = float(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
    }
    return table;
  }();
  return kTable[srgb];
}

uint8_t byteOf(double part) {
  return uint8_t(std::clamp(part, 0.0, 1.0) * 255 + 0.5);
}

uint8_t srgb(double linear) {
  const double l = std::clamp(linear, 0.0, 1.0);
  return byteOf(l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055);
}

/// Sums colours as linear light, each by its share of what is covered.
struct Sum {
  double red = 0, green = 0, blue = 0, alpha = 0, weight = 0;
  void add(const std::array<uint8_t, 4>& c, double w) {
    const double covers = w * c[3] / 255;
    red += covers * double(linear(c[0])), green += covers * double(linear(c[1])), blue += covers * double(linear(c[2]));
    alpha += covers;
    weight += w;
  }
  [[nodiscard]] std::array<double, 4> mean() const {
    if (!(alpha > 0)) return {0, 0, 0, 0};
    return {red / alpha, green / alpha, blue / alpha, alpha / weight};
  }
};

/// The pixel for one that may lie beyond the edges.
int wrapped(int64_t at, int count, SurfacePicture::Wrap wrap) {
  if (wrap == SurfacePicture::Wrap::clamp) return int(std::clamp<int64_t>(at, 0, count - 1));
  const int64_t period = wrap == SurfacePicture::Wrap::mirror ? 2 * int64_t{count} : count;
  const int64_t in = (at % period + period) % period;
  return int(in < count ? in : period - 1 - in);
}

Colour plainColour(const ModelObject& object, const clay::TriangleMesh& mesh, size_t triangle, const Vec3d& shares) {
  if (!object.triangleColours.empty()) return object.triangleColours[triangle];
  if (object.vertexColours.empty()) return object.colour.value_or(Colour());
  std::array<double, 4> sum{};
  for (size_t k = 0; k < 3; ++k) {
    const Colour& c = object.vertexColours[mesh.triangles[triangle][k]];
    const double share = shares[Eigen::Index(k)];
    sum[0] += share * c.red, sum[1] += share * c.green, sum[2] += share * c.blue, sum[3] += share * c.alpha;
  }
  const auto part = [&](size_t k) { return uint8_t(std::clamp(sum[k] + 0.5, 0.0, 255.0)); };
  return {part(0), part(1), part(2), part(3)};
}

}  // namespace

PictureColours::Levels PictureColours::levelsOf(const ColourImage& picture, bool opaque) {
  Levels levels(1);
  levels[0] = {picture.width, picture.height, {}};
  levels[0].pixels.resize(picture.rgba.size() / 4);
  for (size_t i = 0; i < levels[0].pixels.size(); ++i) {
    const uint8_t* const at = picture.rgba.data() + 4 * i;
    levels[0].pixels[i] = {at[0], at[1], at[2], opaque ? uint8_t{255} : at[3]};
  }
  while (levels.back().width > 1 || levels.back().height > 1) {
    const Level& fine = levels.back();
    Level coarse{std::max(1, fine.width / 2), std::max(1, fine.height / 2), {}};
    coarse.pixels.reserve(size_t(coarse.width) * size_t(coarse.height));
    for (int y = 0; y < coarse.height; ++y) {
      for (int x = 0; x < coarse.width; ++x) {
        // An odd last row or column belongs to the pixel before it.
        const int x1 = x + 1 == coarse.width ? fine.width : 2 * x + 2;
        const int y1 = y + 1 == coarse.height ? fine.height : 2 * y + 2;
        Sum sum;
        for (int fy = 2 * y; fy < y1; ++fy)
          for (int fx = 2 * x; fx < x1; ++fx) sum.add(fine.pixels[size_t(fy) * size_t(fine.width) + size_t(fx)], 1);
        const auto [red, green, blue, alpha] = sum.mean();
        coarse.pixels.push_back({srgb(red), srgb(green), srgb(blue), byteOf(alpha)});
      }
    }
    levels.push_back(std::move(coarse));
  }
  return levels;
}

PictureColours::PictureColours(const ModelObject& object, const clay::TriangleMesh& mesh)
    : object_(object), mesh_(mesh) {
  if (object.places.empty()) return;
  std::map<std::pair<const ColourImage*, bool>, std::shared_ptr<const Levels>> made;
  std::vector<bool> used(object.pictures.size());
  for (const PicturePlaces& each : object.places)
    if (each.picture != PicturePlaces::kNone) used[each.picture] = true;
  for (size_t i = 0; i < object.pictures.size(); ++i) {
    const SurfacePicture& each = object.pictures[i];
    if (!used[i]) {
      levels_.emplace_back();
      continue;
    }
    const bool opaque = each.alpha == SurfacePicture::Alpha::opaque;
    std::shared_ptr<const Levels>& levels = made[{each.picture.get(), opaque}];
    if (levels == nullptr) levels = std::make_shared<const Levels>(levelsOf(*each.picture, opaque));
    levels_.push_back(levels);
  }
}

Colour PictureColours::at(size_t triangle, const Vec3d& shares, double width) const {
  const Colour plain = plainColour(object_, mesh_, triangle, shares);
  if (object_.places.empty() || object_.places[triangle].picture == PicturePlaces::kNone) return plain;
  const PicturePlaces& places = object_.places[triangle];
  const SurfacePicture& surface = object_.pictures[places.picture];
  const Levels& levels = *levels_[places.picture];
  const auto& [a, b, c] = places.corners;
  // Pixels that a width covers, from the areas of the triangle on the picture and in space.
  const auto& corners = mesh_.triangles[triangle];
  const Vec3d &p = mesh_.positions[corners[0]], &q = mesh_.positions[corners[1]], &r = mesh_.positions[corners[2]];
  const double onPicture = std::abs((double(b[0]) - double(a[0])) * (double(c[1]) - double(a[1])) -
                                    (double(b[1]) - double(a[1])) * (double(c[0]) - double(a[0]))) *
                           levels[0].width * levels[0].height;
  const double inSpace = (q - p).cross(r - p).norm(), pixels = width * std::sqrt(onPicture / inSpace);
  const double level = pixels > 1 ? std::min(std::round(std::log2(pixels)), double(levels.size() - 1)) : 0;
  const Level& from = levels[size_t(level)];
  const double u = shares[0] * double(a[0]) + shares[1] * double(b[0]) + shares[2] * double(c[0]),
               v = shares[0] * double(a[1]) + shares[1] * double(b[1]) + shares[2] * double(c[1]);
  // So far beyond the edges that no pixel is meant.
  constexpr double kFar = 1e6;
  if (!(std::abs(u) < kFar && std::abs(v) < kFar)) return plain;
  const double x = u * from.width - 0.5, y = v * from.height - 0.5;
  const double x0 = std::floor(x), y0 = std::floor(y);
  Sum sum;
  for (int dy = 0; dy < 2; ++dy) {
    for (int dx = 0; dx < 2; ++dx) {
      const int px = wrapped(int64_t(x0) + dx, from.width, surface.wrapU),
                py = wrapped(int64_t(y0) + dy, from.height, surface.wrapV);
      const double w = (dx == 0 ? x0 + 1 - x : x - x0) * (dy == 0 ? y0 + 1 - y : y - y0);
      sum.add(from.pixels[size_t(py) * size_t(from.width) + size_t(px)], w);
    }
  }
  std::array<double, 4> colour = sum.mean();
  for (size_t k = 0; k < 4; ++k) colour[k] *= double(surface.factor[k]);
  if (surface.tinted && !object_.vertexColours.empty()) {
    const Colour& tint = plain;
    colour[0] *= double(linear(tint.red)), colour[1] *= double(linear(tint.green)),
        colour[2] *= double(linear(tint.blue)), colour[3] *= tint.alpha / 255.0;
  }
  switch (surface.alpha) {
    case SurfacePicture::Alpha::opaque:
      colour[3] = 1;
      break;
    case SurfacePicture::Alpha::mask:
      colour[3] = colour[3] >= double(surface.cutoff) ? 1 : 0;
      break;
    case SurfacePicture::Alpha::blend:
      break;
  }
  return {srgb(colour[0]), srgb(colour[1]), srgb(colour[2]), byteOf(colour[3])};
}

void picturesToVertices(ModelObject& object) {
  if (object.places.empty()) return;
  std::vector<std::array<Colour, 3>> corners;
  {
    const PictureColours colours(object, object.mesh);
    corners.reserve(object.mesh.triangles.size());
    for (size_t t = 0; t < object.mesh.triangles.size(); ++t) {
      const auto& [a, b, c] = object.mesh.triangles[t];
      const auto& p = object.mesh.positions;
      // Half as wide as the triangle, so that a corner stands for what lies around it.
      const double width = std::sqrt((p[b] - p[a]).cross(p[c] - p[a]).norm()) / 2;
      auto& of = corners.emplace_back();
      for (size_t k = 0; k < 3; ++k) of[k] = colours.at(t, Vec3d(Vec3d::Unit(Eigen::Index(k))), width);
    }
  }
  object.pictures.clear();
  object.places.clear();
  setCornerColours(object, corners);
}

}  // namespace argil::io
