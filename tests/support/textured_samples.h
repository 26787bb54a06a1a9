#pragma once
// A cube with a picture on each side, as OBJ and glTF, and the colour that each of its points has: for tests of
// textures.

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/mesh_samples.h"
#include "tests/support/package_samples.h"

namespace argil::samples {

using Rgba = std::array<uint8_t, 4>;

/// Pixels by column and row, from the top left.
using PixelAt = std::function<Rgba(int x, int y)>;

/// A PNG file, its bytes not packed (RFC 1950, RFC 1951 3.2.4).
inline std::string pngOf(int width, int height, const PixelAt& at) {
  std::string rows;
  for (int y = 0; y < height; ++y) {
    rows += '\0';
    for (int x = 0; x < width; ++x)
      for (const uint8_t part : at(x, y)) rows += char(part);
  }
  std::string packed = "\x78\x01";
  constexpr size_t kBlock = 65535;
  for (size_t from = 0; from < rows.size(); from += kBlock) {
    const size_t size = std::min(kBlock, rows.size() - from);
    packed += char(from + size == rows.size() ? 1 : 0);
    append(packed, uint16_t(size));
    append(packed, uint16_t(~uint16_t(size)));
    packed += rows.substr(from, size);
  }
  uint32_t a = 1, b = 0;
  for (const char c : rows) a = (a + uint8_t(c)) % 65521, b = (b + a) % 65521;
  append(packed, uint32_t(b << 16 | a), true);
  std::string png = "\x89PNG\r\n\x1a\n";
  const auto chunk = [&](const std::string& kind, const std::string& body) {
    append(png, uint32_t(body.size()), true);
    png += kind + body;
    append(png, crc32(kind + body), true);
  };
  std::string head;
  append(head, uint32_t(width), true);
  append(head, uint32_t(height), true);
  chunk("IHDR", head + std::string("\x08\x06\0\0\0", 5));
  chunk("IDAT", packed);
  chunk("IEND", "");
  return png;
}

constexpr int kChecks = 4, kCheckPixels = 16, kCheckerPixels = kChecks * kCheckPixels;

/// The colour of a square of the checker board; no two are alike, so that a turned or mirrored picture is seen.
inline Rgba checkColour(int column, int row) {
  return {uint8_t(40 + 50 * column), uint8_t(30 + 60 * row), uint8_t((column + row) % 2 == 0 ? 250 : 20), 255};
}
inline std::string checkerPng() {
  return pngOf(kCheckerPixels, kCheckerPixels,
               [](int x, int y) { return checkColour(x / kCheckPixels, y / kCheckPixels); });
}

/// A cube of 16 mm about zero. The picture lies once on each side: (0, 0) to (1, 1), times `times`, moved by `from`.
struct TexturedCube {
  double half = 8;
  std::array<double, 2> times{1, 1}, from{0, 0};

  struct Side {
    Vec3d low, across, upwards;  ///< The corner at the picture's lower left, and the edges from it.
  };
  [[nodiscard]] std::vector<Side> sides() const {
    std::vector<Side> all;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        Side side;
        side.across = 2 * half * Vec3d(Vec3d::Unit((axis + 1) % 3));
        side.upwards = 2 * half * Vec3d(Vec3d::Unit((axis + 2) % 3));
        if (sign < 0) std::swap(side.across, side.upwards);  // Seen from outside, counterclockwise.
        side.low = sign * half * Vec3d(Vec3d::Unit(axis)) - side.across / 2 - side.upwards / 2;
        all.push_back(side);
      }
    }
    return all;
  }
  /// Of a corner counted from the lower left counterclockwise.
  [[nodiscard]] static Vec3d cornerOf(const Side& side, int corner) {
    return side.low + (corner == 1 || corner == 2 ? side.across : Vec3d(Vec3d::Zero())) +
           (corner >= 2 ? side.upwards : Vec3d(Vec3d::Zero()));
  }
  [[nodiscard]] std::array<double, 2> placeOf(int corner) const {
    return {from[0] + (corner == 1 || corner == 2 ? times[0] : 0), from[1] + (corner >= 2 ? times[1] : 0)};
  }
  /// The place on the picture, u to the right and v upwards, of a point on a side.
  [[nodiscard]] std::array<double, 2> placeAt(const Side& side, const Vec3d& point) const {
    const double u = (point - side.low).dot(side.across) / side.across.squaredNorm(),
                 v = (point - side.low).dot(side.upwards) / side.upwards.squaredNorm();
    return {from[0] + times[0] * u, from[1] + times[1] * v};
  }
  /// The side that a point lies on, the nearest.
  [[nodiscard]] Side sideAt(const Vec3d& point) const {
    Side best;
    double least = INFINITY;
    for (const Side& side : sides()) {
      const double away = std::abs((point - side.low).dot(side.across.cross(side.upwards).normalized()));
      if (away < least) least = away, best = side;
    }
    return best;
  }

  /// `library`: what follows mtllib; the material is called "board".
  [[nodiscard]] std::string obj(const std::string& library = "cube.mtl") const {
    std::string text = "mtllib " + library + "\nusemtl board\n";
    int vertex = 1;
    for (const Side& side : sides()) {
      std::string face = "f";
      for (int corner = 0; corner < 4; ++corner, ++vertex) {
        const Vec3d p = cornerOf(side, corner);
        const auto [u, v] = placeOf(corner);
        for (const double number : {p.x(), p.y(), p.z()})
          text += (number == p.x() && text.back() == '\n' ? "v " : " ") + std::to_string(number);
        text += "\nvt " + std::to_string(u) + " " + std::to_string(v) + "\n";
        face += " " + std::to_string(vertex) + "/" + std::to_string(vertex);
      }
      text += face + "\n";
    }
    return text;
  }

  /// The buffer of the glTF: 24 positions, 24 places, 36 short indices. glTF has y up, metres, and v downwards.
  [[nodiscard]] std::string bytes() const {
    std::string positions, places, indices;
    uint16_t first = 0;
    for (const Side& side : sides()) {
      for (int corner = 0; corner < 4; ++corner) {
        const Vec3d p = cornerOf(side, corner) / 1000;
        for (const double number : {p.x(), p.z(), -p.y()}) append(positions, float(number));
        const auto [u, v] = placeOf(corner);
        append(places, float(u)), append(places, float(1 - v));
      }
      for (const int corner : {0, 1, 2, 0, 2, 3}) append(indices, uint16_t(first + corner));
      first = uint16_t(first + 4);
    }
    return positions + places + indices;
  }
  /// The document without its buffer's place and its images: material 0 has texture 0, with sampler 0 and image 0.
  [[nodiscard]] static nlohmann::json gltf() {
    return nlohmann::json::parse(R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
      "nodes":[{"mesh":0,"name":"cube"}],
      "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,"material":0}]}],
      "materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],
      "textures":[{"source":0,"sampler":0}],"samplers":[{}],"images":[{"uri":"board.png"}],
      "accessors":[{"bufferView":0,"componentType":5126,"count":24,"type":"VEC3"},
        {"bufferView":1,"componentType":5126,"count":24,"type":"VEC2"},
        {"bufferView":2,"componentType":5123,"count":36,"type":"SCALAR"}],
      "bufferViews":[{"buffer":0,"byteLength":288},{"buffer":0,"byteOffset":288,"byteLength":192},
        {"buffer":0,"byteOffset":480,"byteLength":72}],
      "buffers":[{"byteLength":552,"uri":"cube.bin"}]})");
  }
};

/// Linear light of sRGB, 0 to 1 each (IEC 61966-2-1), and back.
inline double linearLight(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}
inline double srgbOf(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

}  // namespace argil::samples
