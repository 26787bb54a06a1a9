#include <draco/compression/decode.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "clay/base/error.h"
#include "io/reader/mesh_data.h"
#include "io/reader/reader.h"

namespace argil::io::reader {

namespace {

/// A component of a colour, 0 to 1; none for a type that colours do not have.
std::optional<double> colourPart(draco::DataType type, const uint8_t* at) {
  if (type == draco::DT_UINT8) return *at / 255.0;
  if (type == draco::DT_UINT16) {
    uint16_t value;
    std::memcpy(&value, at, sizeof value);
    return value / 65535.0;
  }
  if (type == draco::DT_FLOAT32) {
    float value;
    std::memcpy(&value, at, sizeof value);
    return std::isfinite(value) ? std::optional<double>(value) : std::nullopt;
  }
  return {};
}

void takeColours(const draco::Mesh& mesh, const draco::PointAttribute& attribute,
                 const std::optional<std::array<double, 4>>& linearFactor, MeshData& data) {
  const int components = attribute.num_components();
  if (components < 3 || components > 4 || !colourPart(attribute.data_type(), std::array<uint8_t, 8>{}.data())) return;
  const auto stride = size_t(draco::DataTypeLength(attribute.data_type()));
  std::vector<Bytes4> colours(mesh.num_points());
  std::array<uint8_t, 32> raw{};
  if (size_t(attribute.byte_stride()) > raw.size()) return;
  for (uint32_t i = 0; i < mesh.num_points(); ++i) {
    attribute.GetMappedValue(draco::PointIndex(i), raw.data());
    for (size_t c = 0; c < 4; ++c) {
      const std::optional<double> part =
          c < size_t(components) ? colourPart(attribute.data_type(), raw.data() + stride * c) : 1;
      if (!part) return;
      const double value = *part * (linearFactor ? (*linearFactor)[c] : 1);
      colours[i][c] = linearFactor && c < 3 ? srgbByte(value) : plainByte(value);
    }
  }
  data.colours = std::move(colours);
}

}  // namespace

MeshData decodeDraco(std::span<const unsigned char> bytes, std::optional<uint64_t> positionId,
                     std::optional<uint64_t> colourId, const std::optional<std::array<double, 4>>& linearFactor,
                     std::optional<uint64_t> placesId) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto type = draco::Decoder::GetEncodedGeometryType(&buffer);
  if (!type.ok()) throw Error("its Draco data is damaged (" + type.status().error_msg_string() + "); export it again");
  if (type.value() != draco::TRIANGULAR_MESH)
    throw Error("its Draco data is a cloud of points without triangles; export a mesh");
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok())
    throw Error("its Draco data is damaged (" + decoded.status().error_msg_string() + "); export it again");
  const draco::Mesh& mesh = *decoded.value();

  const auto attributeOf = [&](std::optional<uint64_t> id, draco::GeometryAttribute::Type named) {
    return id ? mesh.GetAttributeByUniqueId(uint32_t(std::min<uint64_t>(*id, UINT32_MAX)))
              : mesh.GetNamedAttribute(named);
  };
  const draco::PointAttribute* position = attributeOf(positionId, draco::GeometryAttribute::POSITION);
  if (position == nullptr || position->num_components() != 3)
    throw Error("its Draco data has no positions of three coordinates; export it again");
  MeshData data;
  data.positions.resize(mesh.num_points());
  for (uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex value = position->mapped_index(draco::PointIndex(i));
    if (value.value() >= position->size() || !position->ConvertValue<double>(value, 3, data.positions[i].data())) {
      throw Error("its Draco data has vertices without a position; export it again");
    }
  }
  data.triangles.resize(mesh.num_faces());
  for (uint32_t i = 0; i < mesh.num_faces(); ++i) {
    const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(i));
    for (size_t c = 0; c < 3; ++c) {
      data.triangles[i][c] = face[c].value();
      if (face[c].value() >= mesh.num_points())
        throw Error("its Draco data names vertices that are not there; export it again");
    }
  }
  if (placesId) {
    const draco::PointAttribute* places = attributeOf(placesId, draco::GeometryAttribute::TEX_COORD);
    if (places != nullptr && places->num_components() == 2) {
      data.texturePlaces.resize(mesh.num_points());
      for (uint32_t i = 0; i < mesh.num_points(); ++i) {
        const draco::AttributeValueIndex value = places->mapped_index(draco::PointIndex(i));
        std::array<float, 2>& at = data.texturePlaces[i];
        if (value.value() >= places->size() || !places->ConvertValue<float>(value, 2, at.data()) ||
            !std::isfinite(at[0]) || !std::isfinite(at[1]))
          at = {0, 0};
      }
    }
  }
  if (!positionId || colourId) {
    const draco::PointAttribute* colour = attributeOf(colourId, draco::GeometryAttribute::COLOR);
    if (colour != nullptr) takeColours(mesh, *colour, linearFactor, data);
  }
  return data;
}

void readDraco(const std::filesystem::path& file, Sender& sender) {
  const MeshData data = decodeDraco(contentOf(file));
  sender.text(wire::Kind::format, "Draco");
  if (data.triangles.empty()) throw Error("holds no triangles (read as Draco); check what was exported");
  sendMesh(data, {}, sender);
}

}  // namespace argil::io::reader
