#include "io/models/model_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <utility>

#include "io/bytes/gzip.h"
#include "io/bytes/input.h"
#include "io/bytes/zip_reader.h"
#include "io/models/colour_list.h"
#include "io/models/foreign_files.h"
#include "io/models/format_table.h"
#include "io/models/three_mf_read.h"
#include "io/models/three_mf_write.h"

namespace argil::io {

namespace {

bool isRead(const Format& format) {
  return format.parseMesh || format.parseModel || format.readInProcess;
}

bool isWritten(const Format& format) {
  return format.encoder || format.write;
}

template <class Is>
std::string endingsOf(const Is& is) {
  std::string endings;
  for (const Format& format : formats())
    if (is(format)) endings += (endings.empty() ? "" : ", ") + std::string(format.extension);
  return endings;
}

std::string readable() {
  std::string names;
  for (const Format& format : formats()) {
    if (isRead(format)) names += (names.empty() ? "" : ", ") + std::string(format.name);
  }
  return names;
}

const Format& formatOf(const Input& input) {
  if (const std::string foreign = whatForeignFileIs(input); !foreign.empty()) fail(input.name, foreign);
  for (const Format& format : formats()) {
    if (isRead(format) && format.recognizes(input)) return format;
  }
  std::string ending = endingOf(input.name);
  if (ending == ".gz") ending = endingOf(std::filesystem::path(input.name).stem());
  for (const Format& format : formats()) {
    if (isRead(format) && format.extension == ending) return format;
  }
  if (input.text().starts_with("PK\x03\x04")) {
    const ZipReader zip(input);  // which says what is wrong with it
    fail(input.name, "is a ZIP archive without a model; unpack it first");
  }
  fail(input.name, "is in no format that can be read; export it as one of " + readable());
}

ModelFile modelOf(MeshFile&& file) {
  ModelFile model;
  ModelObject object;
  object.mesh = std::move(file.mesh);
  object.vertexColours = std::move(file.vertexColours);
  object.triangleColours = std::move(file.triangleColours);
  if (!object.mesh.triangles.empty()) model.objects.push_back(std::move(object));
  model.unitMm = file.unitMm;
  model.format = std::move(file.format);
  model.faces = file.faces;
  model.polygons = file.polygons;
  model.welded = file.welded;
  model.notes = std::move(file.notes);
  return model;
}

ModelFile parsed(const Format& format, const Input& input) {
  try {
    ModelFile model = format.parseMesh ? modelOf(format.parseMesh(input)) : format.parseModel(input);
    if (model.objects.empty())
      fail(input.name, "holds no triangles (read as " + std::string(format.name) + "); check what was exported");
    if (input.job != nullptr) input.job->step(1);
    return model;
  } catch (const std::bad_alloc&) {
    fail(input.name, "does not fit into memory; reduce it first");
  }
}

ModelFile parseUnpacked(const Input& input) {
  const Format& format = formatOf(input);
  if (format.readInProcess) fail(input.name, "is " + std::string(format.name) + " in an archive; unpack it first");
  return parsed(format, input);
}

/// An archive of one model, whatever lies beside it.
ModelFile readZipped(const Input& input) {
  ZipReader zip(input);
  const ZipReader::Part* model = nullptr;
  size_t models = 0;
  for (const ZipReader::Part& part : zip.parts()) {
    const std::string ending = endingOf(part.name);
    // Where the Finder keeps its own notes, under the names of the files.
    const bool hidden = part.name.starts_with("__MACOSX/");
    if (hidden || std::none_of(formats().begin(), formats().end(),
                               [&](const Format& each) { return isRead(each) && each.extension == ending; }))
      continue;
    model = &part;
    ++models;
  }
  if (models == 0) fail(input.name, "is a ZIP archive without a model in it");
  if (models > 1) fail(input.name, "is a ZIP archive of " + std::to_string(models) + " models; unpack it and take one");
  const FileBytes inside = zip.read(*model);
  if (inside.size == 0) fail(input.name, "holds an empty model; export it again");
  return parseUnpacked({inside.bytes(), input.name + ": " + cleanName(model->name), input.job, input.bytes.size()});
}

}  // namespace

std::string readableEndings() {
  return endingsOf(isRead);
}
std::string writableEndings() {
  return endingsOf(isWritten);
}

ModelFile parseModel(std::span<const std::byte> bytes, const std::string& name, Job* job) {
  const Input input{bytes, name, job};
  if (bytes.empty()) fail(name, "is empty (0 bytes); export it again");
  const Format& format = formatOf(input);
  if (format.readInProcess) fail(name, std::string(format.name) + " is read from files only");
  return parsed(format, input);
}

ModelFile readModel(const std::filesystem::path& path, Job* job) {
  // What a process of its own reads is not read twice.
  const std::string ending = endingOf(path);
  for (const Format& format : formats()) {
    if (format.byEnding && format.readInProcess && format.extension == ending) return format.readInProcess(path, job);
  }
  const std::string head = headOf(path);
  const Input sniffed{std::as_bytes(std::span(head)), displayName(path), job};
  for (const Format& format : formats()) {
    if (format.readInProcess && format.recognizes(sniffed)) return format.readInProcess(path, job);
  }
  const FileBytes file = readFile(path, job);
  const Input input{file.bytes(), displayName(path), job, 0, path.has_parent_path() ? path.parent_path() : "."};
  if (isGzip(input)) {
    const FileBytes inside = gunzipped(input);
    return parseUnpacked({inside.bytes(), input.name, job, input.bytes.size()});
  }
  if (input.text().starts_with("PK\x03\x04") && !recognizesThreeMf(input)) return readZipped(input);
  const Format& format = formatOf(input);
  return format.readInProcess ? format.readInProcess(path, job) : parsed(format, input);
}

ModelObject merged(std::vector<ModelObject>&& objects) {
  if (objects.size() == 1) return std::move(objects.front());
  ModelObject all;
  bool byVertex = false, byTriangle = false;
  for (const ModelObject& each : objects) {
    byTriangle = byTriangle || !each.triangleColours.empty();
    byVertex = byVertex || !each.vertexColours.empty() || each.colour;
  }
  byVertex = byVertex && !byTriangle;
  for (ModelObject& each : objects) {
    const auto first = static_cast<uint32_t>(all.mesh.positions.size());
    if (all.mesh.positions.size() + each.mesh.positions.size() > UINT32_MAX)
      throw Error("the objects of the model have too many vertices together: reduce them first");
    const Colour plain = each.colour.value_or(Colour());
    if (byVertex) {
      if (each.vertexColours.empty()) each.vertexColours.resize(each.mesh.positions.size(), plain);
      all.vertexColours.insert(all.vertexColours.end(), each.vertexColours.begin(), each.vertexColours.end());
    }
    if (byTriangle) {
      if (each.triangleColours.empty() && !each.vertexColours.empty()) {
        for (const auto& [a, b, c] : each.mesh.triangles)
          each.triangleColours.push_back(meanOf(each.vertexColours[a], each.vertexColours[b], each.vertexColours[c]));
      }
      if (each.triangleColours.empty()) each.triangleColours.resize(each.mesh.triangles.size(), plain);
      all.triangleColours.insert(all.triangleColours.end(), each.triangleColours.begin(), each.triangleColours.end());
    }
    all.mesh.positions.insert(all.mesh.positions.end(), each.mesh.positions.begin(), each.mesh.positions.end());
    for (auto triangle : each.mesh.triangles) {
      for (uint32_t& corner : triangle) corner += first;
      all.mesh.triangles.push_back(triangle);
    }
    if (!each.places.empty()) {
      all.places.resize(all.mesh.triangles.size() - each.mesh.triangles.size());
      for (PicturePlaces places : each.places) {
        if (places.picture != PicturePlaces::kNone) places.picture += static_cast<uint32_t>(all.pictures.size());
        all.places.push_back(places);
      }
      all.pictures.insert(all.pictures.end(), each.pictures.begin(), each.pictures.end());
    }
    all.faces.insert(all.faces.end(), each.faces.begin(), each.faces.end());
    each.mesh = {};
  }
  if (!all.places.empty()) all.places.resize(all.mesh.triangles.size());
  return all;
}

Colour meanOf(const Colour& a, const Colour& b, const Colour& c) {
  const auto mean = [](int x, int y, int z) { return static_cast<uint8_t>((x + y + z + 1) / 3); };
  return {mean(a.red, b.red, c.red), mean(a.green, b.green, c.green), mean(a.blue, b.blue, c.blue),
          mean(a.alpha, b.alpha, c.alpha)};
}

std::string notCutAway(size_t negatives) {
  return std::to_string(negatives) +
         (negatives == 1 ? " negative volume was left out and not cut away"
                         : " negative volumes were left out and not cut away") +
         ": only clay is cut";
}

/// Mean of what the pictures of an object show, each triangle as a whole.
std::optional<Colour> meanOfPictures(const ModelObject& object) {
  const PictureColours pictures(object, object.mesh);
  double sum[3] = {}, covered = 0, area = 0;
  for (size_t i = 0; i < object.mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = object.mesh.triangles[i];
    const auto& p = object.mesh.positions;
    const double weight = (p[b] - p[a]).cross(p[c] - p[a]).norm();
    const Colour colour = pictures.at(i, Vec3d::Constant(1.0 / 3), std::sqrt(weight));
    const double covers = weight * colour.alpha / 255;
    sum[0] += covers * colour.red, sum[1] += covers * colour.green, sum[2] += covers * colour.blue;
    covered += covers;
    area += weight;
  }
  if (!(covered > 0)) return std::nullopt;
  const auto part = [&](double s) { return static_cast<uint8_t>(s / covered + 0.5); };
  // No less than all counts as all.
  return Colour{part(sum[0]), part(sum[1]), part(sum[2]), static_cast<uint8_t>(255 * covered / area + 1e-6)};
}

std::optional<Colour> meanColour(const ModelObject& object) {
  if (!object.places.empty()) return meanOfPictures(object);
  if (object.triangleColours.empty() && object.vertexColours.empty()) return object.colour;
  double sum[4] = {}, area = 0;
  for (size_t i = 0; i < object.mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = object.mesh.triangles[i];
    const auto& p = object.mesh.positions;
    const double weight = (p[b] - p[a]).cross(p[c] - p[a]).norm();
    const auto add = [&](const Colour& colour, double w) {
      const uint8_t parts[4] = {colour.red, colour.green, colour.blue, colour.alpha};
      for (int k = 0; k < 4; ++k) sum[k] += w * parts[k];
    };
    if (!object.triangleColours.empty()) {
      add(object.triangleColours[i], weight);
    } else {
      for (const uint32_t corner : {a, b, c}) add(object.vertexColours[corner], weight / 3);
    }
    area += weight;
  }
  if (!(area > 0)) return object.colour;
  const auto part = [&](int k) { return static_cast<uint8_t>(sum[k] / area + 0.5); };
  return Colour{part(0), part(1), part(2), part(3)};
}

}  // namespace argil::io
