#pragma once
// One model part of a 3MF package: objects with meshes or components, colours, what is built. For this module's files.

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/bytes/input.h"
#include "io/models/model_file.h"

namespace argil::io::three_mf {

inline constexpr const char* kCore = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
inline constexpr const char* kMaterial = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02";
inline constexpr const char* kProduction = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";
inline constexpr const char* kModelRelation = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";

/// Row vectors: (x y z 1) times four rows of three, m00 to m32 as the attribute has them.
struct Transform {
  std::array<double, 12> m = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  [[nodiscard]] Vec3d operator()(const Vec3d& p) const;
  /// This one first.
  [[nodiscard]] Transform then(const Transform& next) const;
  [[nodiscard]] bool mirrors() const;
  [[nodiscard]] bool isIdentity() const { return *this == Transform(); }
  friend bool operator==(const Transform&, const Transform&) = default;
};

/// An item of the build or a component of an object.
struct Use {
  uint32_t object = 0;
  std::string path;  ///< Of the part that has it; empty: the same.
  Transform transform;
};

struct Object {
  ModelObject content;  ///< Without triangles when it has components; its places name Part::textures, not `pictures`.
  std::vector<Use> components;
  bool printed = true;  ///< No support and nothing of another purpose.
};

/// What was there and is not kept.
struct Losses {
  uint64_t badColours = 0;  ///< Triangles or objects that name a property that is not there.
  uint64_t supports = 0;    ///< Objects.
  bool textures = false, mixtures = false, beams = false, slices = false;
  [[nodiscard]] std::vector<std::string> sentences() const;
};

/// A picture of the package, as surfaces have it.
struct Texture {
  std::string path;
  SurfacePicture::Wrap wrapU = SurfacePicture::Wrap::repeat, wrapV = SurfacePicture::Wrap::repeat;
};

struct Part {
  std::string path;
  double unitMm = 1;
  std::map<uint32_t, Object> objects;
  std::vector<Use> items;
  std::vector<Texture> textures;
  std::vector<std::pair<std::string, std::string>> metadata;
  bool hasResources = false, hasBuild = false;
};

/// Reads the XML of one part. Coordinates are finite, indices in range. Throws Error: not well formed, against the
/// specification in what matters to geometry, an extension that is required and not known. Memory: the meshes, 12 bytes
/// a triangle beside where triangles have colours.
Part readPart(const Input& input, const std::string& path, Losses& losses);

}  // namespace argil::io::three_mf
