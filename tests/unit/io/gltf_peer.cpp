#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_ENABLE_DRACO  // the package's library is built without
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include "tests/unit/io/gltf_peer.h"

#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <cmath>
#include <cstring>

namespace argil::io {

namespace {

uint8_t srgb(double linear) {
  const double s = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  return uint8_t(std::lround(255 * s));
}

template <class T>
T at(const tinygltf::Model& model, int accessor, size_t element, size_t component) {
  const tinygltf::Accessor& it = model.accessors.at(size_t(accessor));
  const tinygltf::BufferView& view = model.bufferViews.at(size_t(it.bufferView));
  T value;
  std::memcpy(
      &value,
      &model.buffers.at(size_t(view.buffer))
           .data.at(view.byteOffset + it.byteOffset + element * size_t(it.ByteStride(view)) + component * sizeof(T)),
      sizeof value);
  return value;
}

tinygltf::Model loaded(const std::filesystem::path& path) {
  tinygltf::TinyGLTF loader;
  tinygltf::Model model;
  std::string error, warning;
  // Pictures stay packed.
  loader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*, int,
                           void*) { return true; },
                        nullptr);
  EXPECT_TRUE(path.extension() == ".glb" ? loader.LoadBinaryFromFile(&model, &error, &warning, path.string())
                                         : loader.LoadASCIIFromFile(&model, &error, &warning, path.string()))
      << error;
  EXPECT_EQ(warning, "");
  return model;
}

}  // namespace

std::vector<std::string> requiredByPeer(const std::filesystem::path& path) {
  return loaded(path).extensionsRequired;
}

std::vector<PeerObject> readByPeer(const std::filesystem::path& path) {
  const tinygltf::Model model = loaded(path);
  std::vector<PeerObject> objects;
  for (const tinygltf::Node& node : model.nodes) {
    PeerObject& object = objects.emplace_back();
    object.name = node.name;
    const tinygltf::Primitive& primitive = model.meshes.at(size_t(node.mesh)).primitives.at(0);
    const int positions = primitive.attributes.at("POSITION");
    const tinygltf::Accessor& accessor = model.accessors.at(size_t(positions));
    for (size_t i = 0; i < accessor.count; ++i) {
      std::array<double, 3> p{};
      for (size_t k = 0; k < 3; ++k) {
        p[k] = double(at<float>(model, positions, i, k));
        EXPECT_GE(p[k], accessor.minValues.at(k));
        EXPECT_LE(p[k], accessor.maxValues.at(k));
        p[k] = 1000 * (p[k] + node.translation.at(k));
      }
      object.positionsMm.emplace_back(p[0], -p[2], p[1]);
    }
    const tinygltf::Accessor& indices = model.accessors.at(size_t(primitive.indices));
    for (size_t i = 0; i < indices.count; i += 3) {
      std::array<uint32_t, 3> triangle{};
      for (size_t k = 0; k < 3; ++k) {
        triangle[k] = indices.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT
                          ? at<uint32_t>(model, primitive.indices, i + k, 0)
                          : at<uint16_t>(model, primitive.indices, i + k, 0);
      }
      object.triangles.push_back(triangle);
    }
    if (const auto colour = primitive.attributes.find("COLOR_0"); colour != primitive.attributes.end()) {
      for (size_t i = 0; i < accessor.count; ++i) {
        std::array<uint8_t, 4> c{};
        for (size_t k = 0; k < 4; ++k) {
          const double part = at<uint16_t>(model, colour->second, i, k) / 65535.0;
          c[k] = k < 3 ? srgb(part) : uint8_t(std::lround(255 * part));
        }
        object.colours.push_back(c);
      }
    }
    if (const auto normal = primitive.attributes.find("NORMAL"); normal != primitive.attributes.end()) {
      EXPECT_EQ(model.accessors.at(size_t(normal->second)).count, accessor.count);
      for (size_t i = 0; i < accessor.count; ++i) {
        std::array<double, 3> n{};
        for (size_t k = 0; k < 3; ++k) n[k] = double(at<float>(model, normal->second, i, k));
        object.normals.emplace_back(n[0], -n[2], n[1]);
      }
    }
    if (primitive.material >= 0) {
      const auto& surface = model.materials.at(size_t(primitive.material)).pbrMetallicRoughness;
      object.material = true;
      object.metallic = surface.metallicFactor;
      object.roughness = surface.roughnessFactor;
      const auto& factor = surface.baseColorFactor;
      for (size_t k = 0; k < 4; ++k)
        object.baseColour[k] = k < 3 ? srgb(factor.at(k)) : uint8_t(std::lround(255 * factor.at(k)));
    }
  }
  return objects;
}

}  // namespace argil::io
