#pragma once
// ZIP archives and 3MF packages made by hand: for tests of their readers.

#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/mesh_samples.h"

namespace argil::samples {

struct PackedPart {
  std::string name;
  std::string content;
  bool deflated = false;  ///< In one stored block of deflate.
};

inline uint32_t crc32(std::string_view bytes) {
  uint32_t crc = ~0u;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int k = 0; k < 8; ++k) crc = crc >> 1 ^ (0xedb88320u & (0u - (crc & 1)));
  }
  return ~crc;
}

/// An archive with a table; `wide` puts its numbers into ZIP64 fields.
inline std::string zip(const std::vector<PackedPart>& parts, bool wide = false) {
  std::string bytes, table;
  for (const PackedPart& part : parts) {
    std::string packed = part.content;
    if (part.deflated) {
      packed = "\x01";
      append(packed, uint16_t(part.content.size()));
      append(packed, uint16_t(~part.content.size()));
      packed += part.content;
    }
    const size_t header = bytes.size();
    const auto common = [&](std::string& to) {
      append(to, uint16_t(wide ? 45 : 20));
      append(to, uint16_t(0));
      append(to, uint16_t(part.deflated ? 8 : 0));
      append(to, uint32_t(0x21 << 16));
      append(to, crc32(part.content));
    };
    append(bytes, uint32_t(0x04034b50));
    common(bytes);
    append(bytes, uint32_t(packed.size()));
    append(bytes, uint32_t(part.content.size()));
    append(bytes, uint16_t(part.name.size()));
    append(bytes, uint16_t(0));
    bytes += part.name + packed;
    append(table, uint32_t(0x02014b50));
    append(table, uint16_t(45));
    common(table);
    append(table, wide ? ~0u : uint32_t(packed.size()));
    append(table, wide ? ~0u : uint32_t(part.content.size()));
    append(table, uint16_t(part.name.size()));
    append(table, uint16_t(wide ? 28 : 0));
    append(table, uint16_t(0));
    append(table, uint16_t(0));
    append(table, uint16_t(0));
    append(table, uint32_t(0));
    append(table, wide ? ~0u : uint32_t(header));
    table += part.name;
    if (wide) {
      append(table, uint16_t(1));
      append(table, uint16_t(24));
      append(table, uint64_t(part.content.size()));
      append(table, uint64_t(packed.size()));
      append(table, uint64_t(header));
    }
  }
  const size_t begin = bytes.size();
  bytes += table;
  if (wide) {
    const size_t end = bytes.size();
    append(bytes, uint32_t(0x06064b50));
    append(bytes, uint64_t(44));
    append(bytes, uint32_t(45 << 16 | 45));
    append(bytes, uint64_t(0));
    append(bytes, uint64_t(parts.size()));
    append(bytes, uint64_t(parts.size()));
    append(bytes, uint64_t(table.size()));
    append(bytes, uint64_t(begin));
    append(bytes, uint32_t(0x07064b50));
    append(bytes, uint32_t(0));
    append(bytes, uint64_t(end));
    append(bytes, uint32_t(1));
  }
  append(bytes, uint32_t(0x06054b50));
  append(bytes, uint32_t(0));
  append(bytes, uint16_t(wide ? 0xffff : parts.size()));
  append(bytes, uint16_t(wide ? 0xffff : parts.size()));
  append(bytes, wide ? ~0u : uint32_t(table.size()));
  append(bytes, wide ? ~0u : uint32_t(begin));
  append(bytes, uint16_t(0));
  return bytes;
}

inline const std::string kRelations =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Relationships "
    "xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"
    "<Relationship Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\" Target=\"/3D/3dmodel.model\" "
    "Id=\"rel0\"/></Relationships>";

/// What stands between <model> and </model>, as a whole document; `attributes` go to the model.
inline std::string modelXml(const std::string& inside, const std::string& attributes = "unit=\"millimeter\"") {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model " + attributes +
         " xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
         "xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\""
         " xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\">\n" +
         inside + "\n</model>\n";
}

inline std::string threeMf(const std::string& inside, const std::string& attributes = "unit=\"millimeter\"",
                           std::vector<PackedPart> more = {}) {
  more.insert(more.begin(), {{"[Content_Types].xml", "<Types/>"},
                             {"_rels/.rels", kRelations},
                             {"3D/3dmodel.model", modelXml(inside, attributes), true}});
  return zip(more);
}

/// <mesh> of a tetrahedron with corners 0, x, y, z at 1; `extra` are attributes of its triangles.
inline std::string tetrahedronXml(const std::vector<std::string>& extra = {"", "", "", ""}) {
  return "<mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/><vertex x=\"0\" y=\"1\" "
         "z=\"0\"/><vertex x=\"0\" y=\"0\" z=\"1\"/></vertices>\n"
         "<triangles><triangle v1=\"0\" v2=\"2\" v3=\"1\" " +
         extra[0] + "/><triangle v1=\"0\" v2=\"1\" v3=\"3\" " + extra[1] + "/>\n<triangle v1=\"0\" v2=\"3\" v3=\"2\" " +
         extra[2] + "/><triangle v1=\"1\" v2=\"2\" v3=\"3\" " + extra[3] + "/></triangles></mesh>";
}

}  // namespace argil::samples
