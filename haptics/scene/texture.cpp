#include "haptics/scene/texture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "clay/base/error.h"

namespace argil::haptics {
namespace {

constexpr double kTau = 2 * std::numbers::pi;
constexpr double kFar = 1e9;  // Of a wavelength or a pixel: keeps conversions to integers defined for any place.

void require(bool good, const char* what) {
  if (!good) throw Error(std::string("texture: ") + what);
}
void requireSizes(double wavelengthMm, double amplitudeMm) {
  require(wavelengthMm >= 1e-3 && wavelengthMm <= 1e4, "a wavelength must be 0.001 to 10 000 mm");
  require(amplitudeMm > 0 && amplitudeMm <= 10, "an amplitude must be above 0 and at most 10 mm");
}

// How much of a wave is left: all from twice the finest that may be rendered, nothing below it.
double left(double wavelengthMm, double finestMm) noexcept {
  const double t = std::clamp(2 * finestMm / wavelengthMm - 1, 0.0, 1.0);
  return 1 - t * t * (3 - 2 * t);
}

// A repeatable value from −1 to 1 for a lattice point.
double latticeValue(int64_t x, int64_t y, int64_t z, uint64_t seed) noexcept {
  uint64_t h = seed + static_cast<uint64_t>(x) * 0x9e3779b97f4a7c15ull;
  h = (h ^ (h >> 32)) + static_cast<uint64_t>(y) * 0xbf58476d1ce4e5b9ull;
  h = (h ^ (h >> 29)) + static_cast<uint64_t>(z) * 0x94d049bb133111ebull;
  h = (h ^ (h >> 32)) * 0xd6e8feb86659fd93ull;
  return double(static_cast<int64_t>(h) >> 11) * 0x1p-52;
}

// Values at lattice points, joined twice continuously differentiably; |value| ≤ 1. `p` in cells.
double latticeNoise(const Vec3d& p, uint64_t seed, Vec3d& slope) noexcept {
  double w[3], d[3];
  int64_t base[3];
  for (int a = 0; a < 3; ++a) {
    const double x = std::clamp(p[a], -kFar, kFar), floor = std::floor(x), t = x - floor;
    base[a] = static_cast<int64_t>(floor);
    w[a] = t * t * t * (10 + t * (6 * t - 15));
    d[a] = 30 * t * t * (1 + t * (t - 2));
  }
  double c[2][2][2];
  for (int i = 0; i < 8; ++i)
    c[i >> 2][(i >> 1) & 1][i & 1] =
        latticeValue(base[0] + (i >> 2), base[1] + ((i >> 1) & 1), base[2] + (i & 1), seed);
  double y[2], dy[2], dz[2];
  for (int i = 0; i < 2; ++i) {
    const double low = c[i][0][0] + w[2] * (c[i][0][1] - c[i][0][0]),
                 high = c[i][1][0] + w[2] * (c[i][1][1] - c[i][1][0]);
    const double lowZ = c[i][0][1] - c[i][0][0], highZ = c[i][1][1] - c[i][1][0];
    y[i] = low + w[1] * (high - low);
    dy[i] = high - low;
    dz[i] = lowZ + w[1] * (highZ - lowZ);
  }
  slope = {d[0] * (y[1] - y[0]), d[1] * (dy[0] + w[0] * (dy[1] - dy[0])), d[2] * (dz[0] + w[0] * (dz[1] - dz[0]))};
  return y[0] + w[0] * (y[1] - y[0]);
}

// A row of pixels at half its length or less, by area.
std::vector<float> shrink(const std::vector<float>& from, int width, int height, int toWidth, int toHeight) {
  const auto along = [](const std::vector<float>& in, int n, int m, int rows, size_t stride, size_t rowStride) {
    std::vector<float> out(size_t(m) * size_t(rows));
    const double scale = double(n) / m;
    for (int r = 0; r < rows; ++r)
      for (int i = 0; i < m; ++i) {
        const double begin = i * scale, end = (i + 1) * scale;
        double sum = 0;
        for (int k = static_cast<int>(begin); k < n && k < end; ++k)
          sum += double(in[size_t(r) * rowStride + size_t(k) * stride]) *
                 (std::min(end, k + 1.0) - std::max(begin, double(k)));
        out[size_t(r) * size_t(m) + size_t(i)] = static_cast<float>(sum / scale);
      }
    return out;
  };
  const std::vector<float> rows = along(from, width, toWidth, height, 1, size_t(width));
  // Columns of it: the answer comes back turned, column by column.
  const std::vector<float> columns = along(rows, height, toHeight, toWidth, size_t(toWidth), 1);
  std::vector<float> out(columns.size());
  for (int x = 0; x < toWidth; ++x)
    for (int y = 0; y < toHeight; ++y)
      out[size_t(y) * size_t(toWidth) + size_t(x)] = columns[size_t(x) * size_t(toHeight) + size_t(y)];
  return out;
}

// Quadratic B-spline around the nearest pixel, and mirrored indices of the three pixels.
struct Taps {
  int index[3];
  double weight[3], slope[3];
  Taps(double x, int n) noexcept {
    const double u = std::clamp(x - 0.5, -kFar, kFar), nearest = std::floor(u + 0.5), t = u - nearest;
    const auto middle = static_cast<int64_t>(nearest);
    for (int i = 0; i < 3; ++i) {
      const int64_t period = 2 * int64_t{n};
      const int64_t m = ((middle + i - 1) % period + period) % period;
      index[i] = static_cast<int>(m < n ? m : period - 1 - m);
    }
    weight[0] = 0.5 * (0.5 - t) * (0.5 - t);
    weight[1] = 0.75 - t * t;
    weight[2] = 0.5 * (0.5 + t) * (0.5 + t);
    slope[0] = t - 0.5;
    slope[1] = -2 * t;
    slope[2] = t + 0.5;
  }
};

}  // namespace

Texture::Texture(const Ridges& shape) : amplitude_(shape.amplitudeMm), finest_(shape.wavelengthMm) {
  requireSizes(shape.wavelengthMm, shape.amplitudeMm);
  require(shape.across.allFinite() && shape.across.norm() > 1e-9, "the direction across ridges must not be zero");
  Ridges unit = shape;
  unit.across.normalize();
  shape_ = unit;
}

Texture::Texture(const Bumps& shape) : shape_(shape), amplitude_(shape.amplitudeMm), finest_(shape.wavelengthMm) {
  requireSizes(shape.wavelengthMm, shape.amplitudeMm);
}

Texture::Texture(const Grain& shape) : shape_(shape), amplitude_(shape.amplitudeMm) {
  requireSizes(shape.wavelengthMm, shape.amplitudeMm);
  require(shape.octaves >= 1 && shape.octaves <= 6, "grain has 1 to 6 octaves");
  finest_ = shape.wavelengthMm / double(1 << shape.octaves);
}

Texture::Texture(const HeightMap& shape) : amplitude_(shape.amplitudeMm), finest_(2 * shape.mmPerPixel) {
  requireSizes(1, shape.amplitudeMm);
  require(shape.mmPerPixel >= 1e-3 && shape.mmPerPixel <= 1e3, "a pixel must be 0.001 to 1 000 mm");
  require(shape.width >= 2 && shape.height >= 2 && shape.width <= 4096 && shape.height <= 4096,
          "an image must be 2 to 4096 pixels along each edge");
  require(shape.grey.size() == size_t(shape.width) * size_t(shape.height), "an image holds a grey level a pixel");
  std::vector<float> pixels(shape.grey.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    require(shape.grey[i] >= 0 && shape.grey[i] <= 1, "grey levels must be 0 to 1");
    pixels[i] = 2 * shape.grey[i] - 1;
  }
  Image image;
  image.pitch = shape.mmPerPixel;
  int width = shape.width, height = shape.height;
  while (true) {
    image.levels.push_back({width, height, shape.mmPerPixel * shape.width / width,
                            shape.mmPerPixel * shape.height / height, image.pixels.size()});
    image.pixels.insert(image.pixels.end(), pixels.begin(), pixels.end());
    if (width == 1 && height == 1) break;
    const int w = (width + 1) / 2, h = (height + 1) / 2;
    pixels = shrink(pixels, width, height, w, h);
    width = w;
    height = h;
  }
  image.mean = pixels[0];
  shape_ = std::move(image);
}

double Texture::ridges(const Ridges& r, const Vec3d& at, double finestMm, Vec3d& slope) const ARGIL_REALTIME {
  const double share = left(r.wavelengthMm, finestMm);
  if (share <= 0) return 0;
  const double k = kTau / r.wavelengthMm, phase = k * at.dot(r.across);
  slope = (-share * k * std::sin(phase)) * r.across;
  return share * std::cos(phase);
}

double Texture::grain(const Grain& g, const Vec3d& at, double finestMm, Vec3d& slope) const ARGIL_REALTIME {
  double sum = 0, height = 1, total = 0, cell = g.wavelengthMm / 2;
  for (int octave = 0; octave < g.octaves; ++octave, cell /= 2, height /= 2) {
    total += height;
    const double share = height * left(cell, finestMm);
    if (share <= 0) continue;
    Vec3d d;
    // Each octave moved, or all would have a lattice point at zero.
    sum += share * latticeNoise(at / cell + Vec3d::Constant(0.37 * octave), uint64_t{g.seed} * 8 + uint64_t(octave), d);
    slope += share / cell * d;
  }
  slope /= total;
  return sum / total;
}

double Texture::level(const Image& image, const Level& l, double u, double v, double& du,
                      double& dv) const ARGIL_REALTIME {
  const Taps x(u / l.pitchX, l.width), y(v / l.pitchY, l.height);
  const float* pixels = image.pixels.data() + l.first;
  double value = 0;
  du = dv = 0;
  for (int j = 0; j < 3; ++j) {
    const float* row = pixels + size_t(y.index[j]) * size_t(l.width);
    double sum = 0, slope = 0;
    for (int i = 0; i < 3; ++i) {
      sum += x.weight[i] * double(row[x.index[i]]);
      slope += x.slope[i] * double(row[x.index[i]]);
    }
    value += y.weight[j] * sum;
    du += y.weight[j] * slope;
    dv += y.slope[j] * sum;
  }
  du /= l.pitchX;
  dv /= l.pitchY;
  return value;
}

// On a plane: −1 to 1.
double Texture::plane(double u, double v, double finestMm, double& du, double& dv) const ARGIL_REALTIME {
  du = dv = 0;
  if (const Bumps* b = std::get_if<Bumps>(&shape_)) {
    const double share = left(b->wavelengthMm, finestMm), k = kTau / b->wavelengthMm;
    if (share <= 0) return 0;
    du = -0.5 * share * k * std::sin(k * u);
    dv = -0.5 * share * k * std::sin(k * v);
    return 0.5 * share * (std::cos(k * u) + std::cos(k * v));
  }
  const Image& image = std::get<Image>(shape_);
  // A level shows waves of two of its pixels and longer; half as much again, for its pixels are boxes and leak.
  const double wanted = std::log2(std::max(0.75 * finestMm / image.pitch, 1.0)), top = double(image.levels.size()) - 1;
  if (wanted >= top) return double(image.mean);
  const auto fine = static_cast<size_t>(wanted);
  const double part = wanted - double(fine);
  const double value = level(image, image.levels[fine], u, v, du, dv);
  if (part <= 0) return value;
  double cu, cv;
  const double coarse = level(image, image.levels[fine + 1], u, v, cu, cv);
  du += part * (cu - du);
  dv += part * (cv - dv);
  return value + part * (coarse - value);
}

// Along the three axes, blended by the square of how much the surface faces each.
double Texture::projected(const Vec3d& at, const Vec3d& normal, double finestMm, Vec3d& slope) const ARGIL_REALTIME {
  double weight[3], total = 0;
  for (int a = 0; a < 3; ++a) {
    const double facing = std::max(0.0, normal[a] * normal[a] - 0.05);
    weight[a] = facing * facing;
    total += weight[a];
  }
  if (!(total > 0)) return 0;
  double sum = 0;
  for (int a = 0; a < 3; ++a) {
    if (weight[a] <= 0) continue;
    const int u = (a + 1) % 3, v = (a + 2) % 3;
    const double w = weight[a] / total;
    double du, dv;
    sum += w * plane(at[u], at[v], finestMm, du, dv);
    slope[u] += w * du;
    slope[v] += w * dv;
  }
  return sum;
}

double Texture::height(const Vec3d& at, const Vec3d& normal, double finestMm, Vec3d* slope) const ARGIL_REALTIME {
  Vec3d along = Vec3d::Zero();
  double value = 0;
  if (const Ridges* r = std::get_if<Ridges>(&shape_))
    value = ridges(*r, at, finestMm, along);
  else if (const Grain* g = std::get_if<Grain>(&shape_))
    value = grain(*g, at, finestMm, along);
  else
    value = projected(at, normal, finestMm, along);
  if (slope) *slope = amplitude_ * (along - normal * normal.dot(along));
  return amplitude_ * (value - 1);
}

}  // namespace argil::haptics
