#pragma once
// Meshes for the tests of clay, which may not include io/: shapes, and the least that reads the test data.

#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>

#include "clay/mesh/triangle_mesh.h"

namespace argil::clay::testing {

/// Unit icosahedron divided `levels` times, scaled and moved; 20·4^levels triangles facing outwards.
inline TriangleMesh icosphere(const Vec3d& centre, double radius, int levels) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  TriangleMesh mesh;
  mesh.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                    {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (auto& p : mesh.positions) p.normalize();
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
      const auto [at, fresh] = middles.try_emplace(std::minmax(a, b), uint32_t(mesh.positions.size()));
      if (fresh) mesh.positions.push_back((mesh.positions[a] + mesh.positions[b]).normalized());
      return at->second;
    };
    std::vector<std::array<uint32_t, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (auto& p : mesh.positions) p = centre + radius * p;
  return mesh;
}

/// Axis-aligned box of 12 triangles facing outwards.
inline TriangleMesh box(const Vec3d& low, const Vec3d& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z());
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

inline void append(TriangleMesh& mesh, const TriangleMesh& other) {
  const auto base = uint32_t(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (auto t : other.triangles) mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}

inline void flip(std::array<uint32_t, 3>& triangle) {
  std::swap(triangle[1], triangle[2]);
}

/// Signed volume by the divergence theorem, about the first corner so that far origins cost no digits.
inline double meshVolume(const TriangleMesh& mesh) {
  double six = 0;
  const Vec3d o = mesh.positions[mesh.triangles[0][0]];
  for (const auto& [a, b, c] : mesh.triangles) {
    six += (mesh.positions[a] - o).dot((mesh.positions[b] - o).cross(mesh.positions[c] - o));
  }
  return six / 6;
}

/// Rims of open edges closed by fans around their middle: an independent estimate of what an open mesh bounds, good for
/// holes that are nearly flat.
inline TriangleMesh withHolesFanned(TriangleMesh mesh) {
  std::map<std::pair<uint32_t, uint32_t>, int> net;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      ++net[{t[size_t(k)], t[size_t((k + 1) % 3)]}];
      --net[{t[size_t((k + 1) % 3)], t[size_t(k)]}];
    }
  }
  std::multimap<uint32_t, uint32_t> open;  // against the open side
  for (const auto& [edge, count] : net) {
    if (count > 0) open.emplace(edge.second, edge.first);
  }
  while (!open.empty()) {
    std::vector<uint32_t> loop = {open.begin()->first};
    do {
      const auto next = open.find(loop.back());
      loop.push_back(next->second);
      open.erase(next);
    } while (loop.back() != loop.front());
    Vec3d middle = Vec3d::Zero();
    for (size_t i = 1; i < loop.size(); ++i) middle += mesh.positions[loop[i]] / double(loop.size() - 1);
    const auto apex = uint32_t(mesh.positions.size());
    mesh.positions.push_back(middle);
    for (size_t i = 1; i < loop.size(); ++i) mesh.triangles.push_back({loop[i - 1], loop[i], apex});
  }
  return mesh;
}

/// Path of a file of the test data, empty when there is none.
inline std::string dataFile(const std::string& name) {
  const char* root = std::getenv("ARGIL_DATA");
  return root ? std::string(root) + "/" + name : std::string();
}

/// Reads well-formed OBJ, PLY (float positions first, faces last) and STL. Polygons become fans.
inline TriangleMesh readMesh(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error("cannot open " + path);
  TriangleMesh mesh;
  const auto polygon = [&](const std::vector<uint32_t>& p) {
    for (size_t i = 2; i < p.size(); ++i) mesh.triangles.push_back({p[0], p[i - 1], p[i]});
  };
  std::string ending = path.substr(path.find_last_of('.') + 1), line;
  for (char& c : ending) c = char(std::tolower(c));
  if (ending == "obj") {
    while (std::getline(in, line)) {
      std::istringstream words(line);
      std::string word;
      words >> word;
      if (word == "v") {
        double x, y, z;
        words >> x >> y >> z;
        mesh.positions.emplace_back(x, y, z);
      } else if (word == "f") {
        std::vector<uint32_t> p;
        while (words >> word) p.push_back(uint32_t(std::stoul(word) - 1));
        polygon(p);
      }
    }
  } else if (ending == "ply") {
    std::map<std::string, size_t> sizes = {{"float", 4}, {"uchar", 1}, {"int", 4}, {"uint", 4}};
    size_t vertices = 0, faces = 0, stride = 0;
    bool ascii = false, inFaces = false;
    std::vector<size_t> afterList;
    while (std::getline(in, line) && line.substr(0, 10) != "end_header") {
      std::istringstream words(line);
      std::string key, type;
      words >> key >> type;
      if (key == "format") ascii = type == "ascii";
      if (key == "element" && type == "vertex") words >> vertices;
      if (key == "element" && type == "face") words >> faces, inFaces = true;
      if (key == "property" && !inFaces) stride += sizes.at(type);
      if (key == "property" && inFaces && type != "list") afterList.push_back(sizes.at(type));
    }
    if (ascii) {
      for (size_t i = 0; i < vertices; ++i) {
        std::getline(in, line);
        std::istringstream words(line);
        double x, y, z;
        words >> x >> y >> z;
        mesh.positions.emplace_back(x, y, z);
      }
      for (size_t i = 0; i < faces; ++i) {
        size_t n;
        in >> n;
        std::vector<uint32_t> p(n);
        for (auto& v : p) in >> v;
        polygon(p);
      }
    } else {
      std::vector<char> bytes(stride);
      for (size_t i = 0; i < vertices; ++i) {
        in.read(bytes.data(), std::streamsize(stride));
        float xyz[3];
        std::memcpy(xyz, bytes.data(), 12);
        mesh.positions.emplace_back(xyz[0], xyz[1], xyz[2]);
      }
      for (size_t i = 0; i < faces; ++i) {
        std::vector<uint32_t> p(size_t(uint8_t(in.get())));
        in.read(reinterpret_cast<char*>(p.data()), std::streamsize(4 * p.size()));
        for (const size_t skip : afterList) in.ignore(std::streamsize(skip));
        polygon(p);
      }
    }
  } else if (ending == "stl") {
    char head[80];
    uint32_t count = 0;
    in.read(head, 80);
    in.read(reinterpret_cast<char*>(&count), 4);
    in.seekg(0, std::ios::end);
    if (uint64_t(in.tellg()) != 84 + 50 * uint64_t(count)) {  // text
      in.seekg(0);
      for (std::string word; in >> word;) {
        if (word != "vertex") continue;
        double x, y, z;
        in >> x >> y >> z;
        mesh.positions.emplace_back(x, y, z);
      }
      for (uint32_t i = 0; i + 2 < mesh.positions.size(); i += 3) mesh.triangles.push_back({i, i + 1, i + 2});
      return mesh;
    }
    in.seekg(84);
    for (uint32_t i = 0; i < count; ++i) {
      float f[12];
      in.read(reinterpret_cast<char*>(f), 48);
      in.ignore(2);
      for (int k = 1; k < 4; ++k) mesh.positions.emplace_back(f[3 * k], f[3 * k + 1], f[3 * k + 2]);
      mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
  }
  if (mesh.triangles.empty()) throw std::runtime_error("no triangles in " + path);
  return mesh;
}

}  // namespace argil::clay::testing
