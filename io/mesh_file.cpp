#include "io/mesh_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <new>
#include <stdexcept>

#include "io/format.h"

namespace argil::io {

namespace {

constexpr std::array kFormats = {
    Format{"STL", ".stl", recognizesStl, parseStl, makeStlEncoder, true},
    Format{"OBJ", ".obj", recognizesObj, parseObj, makeObjEncoder, false},
    Format{"PLY", ".ply", recognizesPly, parsePly, makePlyEncoder, true},
    Format{"OFF", ".off", recognizesOff, parseOff, nullptr, false},
};

std::string endingOf(const std::string& name) {
  std::string ending = std::filesystem::path(name).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return ending;
}

const Format& formatOf(const Input& input) {
  const std::string_view text = input.text();
  if (text.starts_with("\x1f\x8b")) fail(input.name, "is compressed with gzip; unpack it first (gunzip)");
  if (text.starts_with("PK\x03\x04")) fail(input.name, "is a ZIP archive; unpack it, or export STL, OBJ, PLY or OFF");
  for (const Format& format : kFormats) {
    if (format.recognizes(input)) return format;
  }
  const std::string ending = endingOf(input.name);
  for (const Format& format : kFormats) {
    if (format.extension == ending) return format;
  }
  fail(input.name, "is in no format that can be read; export it as STL, OBJ, PLY or OFF");
}

}  // namespace

std::span<const Format> formats() {
  return kFormats;
}

void addPolygon(MeshFile& file, std::span<const uint32_t> corners) {
  ++file.faces;
  if (corners.size() > 3) ++file.polygons;
  for (size_t i = 2; i < corners.size(); ++i) file.mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
}

MeshFile parseMesh(std::span<const std::byte> bytes, const std::string& name, Job* job) {
  const Input input{bytes, name, job};
  if (bytes.empty()) fail(name, "is empty (0 bytes); export it again");
  const Format& format = formatOf(input);
  try {
    MeshFile file = format.parse(input);
    if (file.mesh.triangles.empty()) {
      fail(name, "holds no triangles (read as " + std::string(format.name) + "); check what was exported");
    }
    if (job != nullptr) job->step(1);
    return file;
  } catch (const std::bad_alloc&) {
    fail(name, "does not fit into memory; reduce it first");
  }
}

MeshFile readMesh(const std::filesystem::path& path, Job* job) {
  const FileBytes file = readFile(path, job);
  return parseMesh(file.bytes(), displayName(path), job);
}

}  // namespace argil::io
