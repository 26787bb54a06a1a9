#pragma once
// Models written by hand, in what Argil's own writers do not write: text PLY and OFF, scene graphs of glTF and 3MF,
// materials of OBJ, colours of STL. In mm, z up.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "io/models/model_file.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/package_samples.h"

namespace argil::samples {

using io::Colour;
using io::ModelObject;

inline std::string plyText(const ModelObject& object) {
  const auto& mesh = object.mesh;
  const bool byVertex = !object.vertexColours.empty(), byFace = !object.triangleColours.empty();
  const std::string colours = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  const auto of = [](const Colour& c) { return fmt::format(" {} {} {}", c.red, c.green, c.blue); };
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n{}"
      "element face {}\nproperty list uchar int vertex_indices\n{}end_header\n",
      mesh.positions.size(), byVertex ? colours : "", mesh.triangles.size(), byFace ? colours : "");
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3d& p = mesh.positions[i];
    text += fmt::format("{} {} {}{}\n", p.x(), p.y(), p.z(), byVertex ? of(object.vertexColours[i]) : "");
  }
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    text += fmt::format("3 {} {} {}{}\n", a, b, c, byFace ? of(object.triangleColours[t]) : "");
  }
  return text;
}

inline std::string offText(const ModelObject& object) {
  const auto& mesh = object.mesh;
  const bool byVertex = !object.vertexColours.empty(), byFace = !object.triangleColours.empty();
  const auto of = [](const Colour& c) { return fmt::format(" {} {} {} 255", c.red, c.green, c.blue); };
  std::string text = fmt::format("{}OFF\n{} {} 0\n", byVertex ? "C" : "", mesh.positions.size(), mesh.triangles.size());
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3d& p = mesh.positions[i];
    text += fmt::format("{} {} {}{}\n", p.x(), p.y(), p.z(), byVertex ? of(object.vertexColours[i]) : "");
  }
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    text += fmt::format("3 {} {} {}{}\n", a, b, c, byFace ? of(object.triangleColours[t]) : "");
  }
  return text;
}

/// One "solid" each.
inline std::string stlText(std::span<const ModelObject> objects) {
  std::string text;
  for (const ModelObject& object : objects) {
    text += "solid " + object.name + "\n";
    for (const auto& triangle : object.mesh.triangles) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const uint32_t v : triangle) {
        const Vec3d& p = object.mesh.positions[v];
        text += fmt::format("vertex {} {} {}\n", p.x(), p.y(), p.z());
      }
      text += "endloop\nendfacet\n";
    }
    text += "endsolid " + object.name + "\n";
  }
  return text;
}

/// As Magics writes colours of triangles: five bits a part, so choose parts of 0 and 255.
inline std::string stlColoured(const ModelObject& object) {
  std::string bytes = "COLOR=";
  bytes += std::string("\xff\xff\xff\xff", 4);
  bytes.resize(80, ' ');
  append(bytes, uint32_t(object.mesh.triangles.size()));
  for (size_t t = 0; t < object.mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) append(bytes, 0.0f);
    for (const uint32_t v : object.mesh.triangles[t])
      for (const double x : object.mesh.positions[v]) append(bytes, float(x));
    const Colour& c = object.triangleColours[t];
    append(bytes, uint16_t(c.red >> 3 | (c.green >> 3) << 5 | (c.blue >> 3) << 10));
  }
  return bytes;
}

/// Faces by material, in the file `materials` beside it.
inline std::string objWithMaterials(const ModelObject& object, const std::string& materials, std::string& mtl) {
  std::string text = "mtllib " + materials + "\no painted\n";
  for (const Vec3d& p : object.mesh.positions) text += fmt::format("v {} {} {}\n", p.x(), p.y(), p.z());
  for (size_t t = 0; t < object.mesh.triangles.size(); ++t) {
    const Colour& c = object.triangleColours[t];
    const std::string name = fmt::format("m{:02x}{:02x}{:02x}", c.red, c.green, c.blue);
    if (mtl.find(name) == std::string::npos)
      mtl += fmt::format("newmtl {}\nKd {} {} {}\n", name, c.red / 255.0, c.green / 255.0, c.blue / 255.0);
    const auto& [x, y, z] = object.mesh.triangles[t];
    text += fmt::format("usemtl {}\nf {} {} {}\n", name, x + 1, y + 1, z + 1);
  }
  return text;
}

inline std::string meshXml(const clay::TriangleMesh& mesh, const std::vector<std::string>& properties = {}) {
  std::string text = "<mesh><vertices>";
  for (const Vec3d& p : mesh.positions)
    text += fmt::format("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", p.x(), p.y(), p.z());
  text += "</vertices><triangles>";
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    text +=
        fmt::format("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"{}/>", a, b, c, properties.empty() ? "" : properties[t]);
  }
  return text + "</triangles></mesh>";
}

/// The object wherever `places` says (outer transforms, then what is common to all), as an object of components.
inline std::string threeMfPlaced(const ModelObject& object, const std::vector<Eigen::Affine3d>& places,
                                 const Eigen::Affine3d& inner) {
  // Row vectors, as the format has them.
  const auto attribute = [](const Eigen::Affine3d& t) {
    std::string text;
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 3; ++row) text += fmt::format("{}{}", text.empty() ? "" : " ", t.matrix()(row, column));
    return " transform=\"" + text + "\"";
  };
  std::string text = "<resources><object id=\"1\" type=\"model\" name=\"" + object.name + "\">" + meshXml(object.mesh) +
                     "</object><object id=\"2\" type=\"model\"><components><component objectid=\"1\"" +
                     attribute(inner) + "/></components></object></resources><build>";
  for (const Eigen::Affine3d& place : places) text += "<item objectid=\"2\"" + attribute(place) + "/>";
  return threeMf(text + "</build>");
}

/// Each corner of each triangle has the colour of its own vertex: for meshes whose vertices belong to one triangle.
inline std::string threeMfCorners(const ModelObject& loose) {
  const clay::TriangleMesh mesh = clay::weldExact(loose.mesh);
  std::string colours;
  std::vector<std::string> properties;
  for (const Colour& c : loose.vertexColours)
    colours += fmt::format("<m:color color=\"#{:02X}{:02X}{:02X}FF\"/>", c.red, c.green, c.blue);
  for (const auto& [a, b, c] : loose.mesh.triangles)
    properties.push_back(fmt::format(" pid=\"5\" p1=\"{}\" p2=\"{}\" p3=\"{}\"", a, b, c));
  return threeMf("<resources><m:colorgroup id=\"5\">" + colours +
                 "</m:colorgroup><object id=\"1\" type=\"model\" pid=\"5\" pindex=\"0\">" + meshXml(mesh, properties) +
                 "</object></resources><build><item objectid=\"1\"/></build>");
}

/// The JSON of a .glb or .gltf, and the same file with another.
inline nlohmann::json gltfJson(const std::string& file) {
  if (!file.starts_with("glTF")) return nlohmann::json::parse(file);
  uint32_t length = 0;
  std::memcpy(&length, file.data() + 12, 4);
  return nlohmann::json::parse(file.substr(20, length));
}
inline std::string withJson(const std::string& file, const nlohmann::json& json) {
  std::string text = json.dump();
  if (!file.starts_with("glTF")) return text;
  uint32_t length = 0;
  std::memcpy(&length, file.data() + 12, 4);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::string rest = file.substr(20 + length);
  std::string bytes = "glTF";
  for (const size_t number : {size_t{2}, 20 + text.size() + rest.size(), text.size()}) append(bytes, uint32_t(number));
  return bytes + "JSON" + text + rest;
}

/// The one object of this file wherever `places` says, through a node above the one that has the mesh.
inline std::string gltfPlaced(const std::string& file, const std::vector<Eigen::Affine3d>& places,
                              const Eigen::Affine3d& inner) {
  nlohmann::json json = gltfJson(file);
  Eigen::Matrix4d turn = Eigen::Matrix4d::Identity();  // From mm with z up to metres with y up.
  turn.topLeftCorner<3, 3>() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  turn.topLeftCorner<3, 3>() /= 1000;
  const auto matrix = [&](const Eigen::Affine3d& t, const Eigen::Affine3d& own) {
    const Eigen::Matrix4d m = turn * t.matrix() * Eigen::Affine3d(turn).inverse().matrix() * own.matrix();
    return std::vector<double>(m.data(), m.data() + 16);
  };
  Eigen::Affine3d own = Eigen::Affine3d::Identity();
  nlohmann::json leaf = json["nodes"][0];
  own.translate(Vec3d(leaf["translation"][0], leaf["translation"][1], leaf["translation"][2]));
  leaf.erase("translation");
  leaf["matrix"] = matrix(inner, own);
  json["nodes"] = json["scenes"][0]["nodes"] = nlohmann::json::array();
  for (const Eigen::Affine3d& place : places) {
    const size_t first = json["nodes"].size();
    json["scenes"][0]["nodes"].push_back(first);
    json["nodes"].push_back({{"children", {first + 1}}, {"matrix", matrix(place, Eigen::Affine3d::Identity())}});
    json["nodes"].push_back(leaf);
  }
  return withJson(file, json);
}

}  // namespace argil::samples
