// .drc files, and the Draco streams of glTF.

#include <draco/compression/expert_encode.h>
#include <draco/core/quantization_utils.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "io/models/draco_mesh.h"
#include "io/models/format_table.h"

namespace argil::io {

namespace {

constexpr int kDefaultBits = 16;
constexpr int kNormalBits = 10;  // of each of the two numbers that a direction becomes
constexpr int kMostBits = 29;    // Draco's own predictions overflow above
constexpr int kSpeed = 3;

[[noreturn]] void failWork(const std::string& what) {
  throw Error(what, Error::Kind::work);
}

/// Draco's own rounding, step by step: what its decoder will give back.
class Quantization {
 public:
  Quantization(const FilePoint& low, const FilePoint& high, int bits) : origin_(low) {
    for (size_t k = 0; k < 3; ++k) range_ = std::max(range_, high[k] - low[k]);
    if (!(range_ > 0)) range_ = 1;
    most_ = int32_t((uint32_t{1} << bits) - 1);
    to_.Init(range_, most_);
    if (!std::isfinite(range_) || !back_.Init(range_, most_))
      failWork("the model is too large for Draco; move it nearer to the origin or write .obj");
  }
  [[nodiscard]] FilePoint rounded(const FilePoint& p) const {
    FilePoint result;
    for (size_t k = 0; k < 3; ++k) result[k] = back_.DequantizeFloat(to_.QuantizeFloat(p[k] - origin_[k])) + origin_[k];
    return result;
  }

 private:
  FilePoint origin_;
  float range_ = 0;
  int32_t most_ = 0;
  draco::Quantizer to_;
  draco::Dequantizer back_;
};

/// Bits that keep coordinates within errorMm of their places.
int bitsFor(double extentMm, double errorMm) {
  if (!(errorMm > 0)) return kDefaultBits;
  int bits = 1;
  while (bits < kMostBits && extentMm / double((uint64_t{1} << bits) - 1) / 2 > errorMm) ++bits;
  return bits;
}

void step(Job* job, double fraction) {
  if (job != nullptr) job->step(fraction);
}

}  // namespace

uint16_t linearOf(uint8_t srgb) {
  const double s = srgb / 255.0;
  return uint16_t(65535 * (s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4)) + 0.5);
}

std::span<const std::byte> DracoStream::bytes() const {
  return {reinterpret_cast<const std::byte*>(buffer->data()), buffer->size()};
}

DracoStream packDraco(std::span<const ModelObject> objects, const Placement& placement, double errorMm, DracoFor what,
                      Normals normals, Job* job) {
  const bool linear = what == DracoFor::gltf;
  DracoStream stream;
  size_t vertices = 0, triangles = 0, points = 0;
  bool coloured = false;
  std::vector<SurfacePoints> split;
  for (const ModelObject& object : objects) {
    split.push_back(pointsOf(object, normals));
    vertices += object.mesh.positions.size();
    triangles += object.mesh.triangles.size();
    points += split.back().count(object);
    // One object's own colour is its material in glTF; in one mesh of many it can only be the vertices'.
    coloured = coloured || !split.back().colours.empty() || (!linear && object.colour);
  }
  if (std::max({points, vertices, triangles}) > size_t{INT32_MAX})
    failWork("Draco holds 2 147 483 647 triangles and vertices at most; reduce the surface first");

  draco::Mesh mesh;
  mesh.set_num_points(uint32_t(points));
  const auto attribute = [&](draco::GeometryAttribute::Type type, int8_t components, draco::DataType data,
                             size_t values) {
    auto made = std::make_unique<draco::PointAttribute>();
    made->Init(type, components, data, type == draco::GeometryAttribute::COLOR, values);
    return mesh.attribute(mesh.AddAttribute(std::move(made)));
  };
  draco::PointAttribute* position = attribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32, vertices);
  const bool identity = points == vertices && std::all_of(split.begin(), split.end(), [](const SurfacePoints& each) {
                          return each.vertex.empty();
                        });
  if (!identity) position->SetExplicitMapping(points);
  draco::PointAttribute* colour =
      coloured ? attribute(draco::GeometryAttribute::COLOR, 4, linear ? draco::DT_UINT16 : draco::DT_UINT8, points)
               : nullptr;
  draco::PointAttribute* normal =
      linear ? attribute(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32, points) : nullptr;
  mesh.SetNumFaces(triangles);

  FilePoint low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
  double extentMm = 0;
  {
    Vec3d lowMm = Vec3d::Constant(INFINITY), highMm = -lowMm;
    for (const ModelObject& object : objects) {
      for (const Vec3d& p : object.mesh.positions) {
        lowMm = lowMm.cwiseMin(p);
        highMm = highMm.cwiseMax(p);
      }
    }
    extentMm = (highMm - lowMm).maxCoeff();
  }
  uint32_t vertex = 0, point = 0, face = 0;
  for (size_t o = 0; o < objects.size(); ++o) {
    const ModelObject& object = objects[o];
    const SurfacePoints& its = split[o];
    const size_t count = its.count(object);
    for (size_t i = 0; i < count && !identity; ++i) {
      position->SetPointMapEntry(
          draco::PointIndex(uint32_t(point + i)),
          draco::AttributeValueIndex(uint32_t(vertex + (its.vertex.empty() ? i : its.vertex[i]))));
    }
    for (size_t i = 0; i < count && coloured; ++i) {
      const Colour c = its.colours.empty() ? object.colour.value_or(Colour()) : its.colours[i];
      const draco::AttributeValueIndex at(uint32_t(point + i));
      const std::array<uint8_t, 4> bytes = {c.red, c.green, c.blue, c.alpha};
      const std::array<uint16_t, 4> words = {linearOf(c.red), linearOf(c.green), linearOf(c.blue),
                                             uint16_t(c.alpha * 257)};
      colour->SetAttributeValue(
          at, linear ? static_cast<const void*>(words.data()) : static_cast<const void*>(bytes.data()));
    }
    for (size_t i = 0; i < count && normal != nullptr; ++i) {
      const FilePoint direction = placement.directionToFile(its.normals[i]);
      normal->SetAttributeValue(draco::AttributeValueIndex(uint32_t(point + i)), direction.data());
    }
    for (const auto& [a, b, c] : its.triangles.empty() ? object.mesh.triangles : its.triangles) {
      mesh.SetFace(draco::FaceIndex(face++),
                   {draco::PointIndex(a + point), draco::PointIndex(b + point), draco::PointIndex(c + point)});
    }
    for (const Vec3d& p : object.mesh.positions) {
      const FilePoint at = placement.toFile(p);
      for (size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], at[k]);
        high[k] = std::max(high[k], at[k]);
      }
      position->SetAttributeValue(draco::AttributeValueIndex(vertex++), at.data());
    }
    point += uint32_t(count);
    split[o] = {};
    step(job, 0.2 * double(face) / double(triangles));
  }

  const int bits = bitsFor(extentMm, errorMm);
  const Quantization quantization(low, high, bits);
  stream.low = {INFINITY, INFINITY, INFINITY};
  stream.high = {-INFINITY, -INFINITY, -INFINITY};
  for (const ModelObject& object : objects) {
    for (const Vec3d& p : object.mesh.positions) {
      const FilePoint at = quantization.rounded(placement.toFile(p));
      for (size_t k = 0; k < 3; ++k) {
        stream.low[k] = std::min(stream.low[k], at[k]);
        stream.high[k] = std::max(stream.high[k], at[k]);
      }
      const Vec3d moved = placement.toMm(at) - p;
      stream.coordinateMm = std::max(stream.coordinateMm, moved.cwiseAbs().maxCoeff());
      stream.distanceMm = std::max(stream.distanceMm, moved.norm());
    }
  }
  step(job, 0.3);

  draco::ExpertEncoder encoder(mesh);
  encoder.SetTrackEncodedProperties(true);
  encoder.SetSpeedOptions(kSpeed, kSpeed);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  // Not the explicit kind, whose numbers Draco keeps as text of six decimals: it takes the same box from the values
  // themselves.
  encoder.SetAttributeQuantization(0, bits);
  if (normal != nullptr)
    encoder.SetAttributeQuantization(mesh.GetNamedAttributeId(draco::GeometryAttribute::NORMAL), kNormalBits);
  stream.buffer = std::make_shared<draco::EncoderBuffer>();
  const draco::Status status = encoder.EncodeToBuffer(stream.buffer.get());
  if (!status.ok())
    failWork("Draco could not pack the surface (" + status.error_msg_string() + "); write another format");
  step(job, 0.9);
  stream.points = encoder.num_encoded_points();
  stream.triangles = encoder.num_encoded_faces();
  stream.position = int(mesh.attribute(0)->unique_id());
  if (coloured) stream.colour = int(colour->unique_id());
  if (normal != nullptr) stream.normal = int(normal->unique_id());
  return stream;
}

void writeDraco(AtomicFile& file, const ModelView& model, const WriteOptions& options, WriteReport& report, Job* job) {
  const Placement placement{[](const Vec3d& p) {
                              return FilePoint{float(p.x()), float(p.y()), float(p.z())};
                            },
                            [](const FilePoint& p) { return Vec3d(double(p[0]), double(p[1]), double(p[2])); },
                            [](const FilePoint& d) { return d; }};
  const DracoStream stream =
      packDraco(model.objects, placement, options.quantization, DracoFor::drc, Normals::none, job);
  file.write(stream.bytes());
  report.vertices = stream.points;
  report.triangles = stream.triangles;
  report.rounding = stream.coordinateMm;
  report.deviation = stream.distanceMm;
}

}  // namespace argil::io
