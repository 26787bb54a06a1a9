// Stanford polygon format, text and binary: http://paulbourke.net/dataformats/ply/
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <optional>

#include "io/bytes/text_cursor.h"
#include "io/models/colour_list.h"
#include "io/models/format_table.h"
#include "io/models/mesh_file.h"

namespace argil::io {

namespace {

enum class Scalar { i8, u8, i16, u16, i32, u32, f32, f64 };
enum class Encoding { text, little, big };

struct ScalarName {
  std::string_view name;
  Scalar type;
};
constexpr ScalarName kScalarNames[] = {
    {"char", Scalar::i8},   {"int8", Scalar::i8},     {"uchar", Scalar::u8},   {"uint8", Scalar::u8},
    {"short", Scalar::i16}, {"int16", Scalar::i16},   {"ushort", Scalar::u16}, {"uint16", Scalar::u16},
    {"int", Scalar::i32},   {"int32", Scalar::i32},   {"uint", Scalar::u32},   {"uint32", Scalar::u32},
    {"float", Scalar::f32}, {"float32", Scalar::f32}, {"double", Scalar::f64}, {"float64", Scalar::f64},
};

size_t sizeOf(Scalar type) {
  constexpr size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[size_t(type)];
}
bool isWhole(Scalar type) {
  return type < Scalar::f32;
}

struct Property {
  std::string name;
  Scalar type{};
  std::optional<Scalar> countType;  ///< Of a list.
};

struct Element {
  std::string name;
  uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding{};
  std::vector<Element> elements;
  size_t body = 0;  ///< Byte where it begins.
};

Scalar readScalar(TextCursor& cursor) {
  const std::string word{cursor.word()};
  for (const ScalarName& row : kScalarNames) {
    if (row.name == word) return row.type;
  }
  cursor.fail(shown(word) + " is no type of PLY; repair the header or export again");
}

Encoding readEncoding(TextCursor& cursor) {
  const std::string_view kind = cursor.word();
  const std::string_view version = cursor.word();
  if (version != "1.0") cursor.fail("PLY of version " + shown(version) + " is unknown; export as PLY 1.0");
  if (kind == "ascii") return Encoding::text;
  if (kind == "binary_little_endian") return Encoding::little;
  if (kind == "binary_big_endian") return Encoding::big;
  cursor.fail(shown(kind) + " is no format of PLY; repair the header or export again");
}

void readProperty(TextCursor& cursor, Header& header) {
  if (header.elements.empty()) cursor.fail("a property comes before any element; repair the header or export again");
  Property property;
  TextCursor ahead = cursor;
  if (ahead.word() == "list") {
    cursor.word();
    property.countType = readScalar(cursor);
    if (!isWhole(*property.countType)) cursor.fail("a list is counted in fractions; repair the header or export again");
  }
  property.type = readScalar(cursor);
  property.name = cursor.word();
  if (property.name.empty()) cursor.fail("a property has no name; repair the header or export again");
  header.elements.back().properties.push_back(std::move(property));
}

Header readHeader(const Input& input) {
  TextCursor cursor(input, {});
  if (cursor.word() != "ply") cursor.fail("a PLY begins with \"ply\" and this does not; check the file's kind");
  cursor.skipLine();
  Header header;
  bool hasFormat = false;
  while (true) {
    if (!cursor.wordAhead()) cursor.fail("the file ends inside its header; it was cut off, export it again");
    const std::string_view word = cursor.word();
    if (word == "end_header") break;
    if (word == "format") {
      header.encoding = readEncoding(cursor);
      hasFormat = true;
    } else if (word == "element") {
      Element element;
      element.name = cursor.word();
      const int64_t count = cursor.integer("the count of an element");
      if (count < 0) cursor.fail("the count of an element is negative; repair the header or export again");
      element.count = uint64_t(count);
      header.elements.push_back(std::move(element));
    } else if (word == "property") {
      readProperty(cursor, header);
    } else if (word != "comment" && word != "obj_info") {
      cursor.fail(shown(word) + " is no word of a PLY header; repair the header or export again");
    }
    cursor.skipLine();
  }
  if (!hasFormat) cursor.fail("the header has no \"format\"; repair it or export again");
  if (header.encoding == Encoding::text) {
    cursor.skipLine();
    header.body = cursor.offset();
    return header;
  }
  // The body begins after the line end. A CR alone counts as one only when the first line ended so too: otherwise a
  // first data byte that looks like LF would be swallowed.
  const std::string_view text = input.text();
  size_t at = cursor.offset();
  while (at < text.size() && (text[at] == ' ' || text[at] == '\t')) ++at;
  const size_t firstEnd = text.find_first_of("\r\n");
  const bool bareReturn = text[firstEnd] == '\r' && text[firstEnd + 1] != '\n';
  if (at < text.size() && text[at] == '\r') ++at;
  if (!bareReturn && at < text.size() && text[at] == '\n') ++at;
  header.body = at;
  return header;
}

/// Values of a binary body, one after another.
class BinaryValues {
 public:
  BinaryValues(const Input& input, size_t body, bool big) : input_(input), at_(body), big_(big) {}

  int64_t whole(Scalar type) {
    switch (type) {
      case Scalar::i8:
        return take<int8_t>();
      case Scalar::u8:
        return take<uint8_t>();
      case Scalar::i16:
        return take<int16_t>();
      case Scalar::u16:
        return take<uint16_t>();
      case Scalar::i32:
        return take<int32_t>();
      case Scalar::u32:
        return take<uint32_t>();
      default:
        return int64_t(real(type));
    }
  }
  double real(Scalar type) {
    if (type == Scalar::f32) return double(take<float>());
    if (type == Scalar::f64) return take<double>();
    return double(whole(type));
  }
  void pass(Scalar type, uint64_t count) {
    if (count > remaining() / sizeOf(type)) cutOff();
    at_ += size_t(count) * sizeOf(type);
  }
  [[nodiscard]] size_t remaining() const { return input_.bytes.size() - at_; }
  [[nodiscard]] size_t offset() const { return at_; }
  /// The fewest bytes that a value can take.
  static size_t least(Scalar type) { return sizeOf(type); }
  [[noreturn]] void fail(const std::string& wrong) const {
    io::fail(input_.name, "byte " + std::to_string(at_) + ": " + wrong);
  }

 private:
  [[noreturn]] void cutOff() const { fail("the file ends inside its data; it was cut off, export it again"); }

  template <class T>
  T take() {
    if (remaining() < sizeof(T)) cutOff();
    std::array<std::byte, sizeof(T)> raw;
    std::memcpy(raw.data(), input_.bytes.data() + at_, sizeof(T));
    at_ += sizeof(T);
    if (big_) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }

  const Input& input_;
  size_t at_;
  bool big_;
};

/// Values of a text body: words, wherever the lines end.
class TextValues {
 public:
  /// `cursor` stands at the body.
  explicit TextValues(const TextCursor& cursor) : cursor_(cursor) {}

  int64_t whole(Scalar) { return cursor_.integer("a whole number", true); }
  double real(Scalar) { return cursor_.number("a number", true); }
  void pass(Scalar, uint64_t count) {
    for (uint64_t i = 0; i < count; ++i) {
      if (!cursor_.wordAhead()) fail("the file ends inside its data; it was cut off, export it again");
      cursor_.word();
    }
  }
  [[nodiscard]] size_t remaining() const {
    return cursor_.remaining() + 1;
  }  // The last value needs no blank behind it.
  [[nodiscard]] size_t offset() const { return cursor_.offset(); }
  static size_t least(Scalar) { return 2; }
  [[noreturn]] void fail(const std::string& wrong) const { cursor_.fail(wrong); }

 private:
  TextCursor cursor_;
};

/// The list of a face, or of strips, that names vertices.
bool namesVertices(const Property& p) {
  return p.countType && isWhole(p.type) && (p.name == "vertex_indices" || p.name == "vertex_index");
}
bool isCorners(const Element& element, const Property& p) {
  return element.name == "face" && namesVertices(p);
}
bool isStrips(const Element& element) {
  return element.name == "tristrips";
}

/// Part of a colour that a property holds, 0 to 3, or -1.
int colourPart(const Property& p) {
  constexpr std::string_view kParts[] = {"red", "green", "blue", "alpha"};
  if (p.countType) return -1;
  const std::string_view name = std::string_view(p.name).substr(p.name.starts_with("diffuse_") ? 8 : 0);
  const auto part = std::find(std::begin(kParts), std::end(kParts), name);
  return part == std::end(kParts) ? -1 : int(part - std::begin(kParts));
}

/// Collects the colours of one element: whole numbers have their type's range, the others decide at the end.
class ElementColours {
 public:
  explicit ElementColours(const Element& element) {
    int parts = 0;
    for (const Property& p : element.properties) {
      const int part = colourPart(p);
      if (part < 0) continue;
      parts |= 1 << part;
      // One scale for all parts; no program mixes types.
      scale_ = p.type == Scalar::u8 || p.type == Scalar::i8 ? 1 : isWhole(p.type) ? 1 / 257.0 : 0;
    }
    there_ = (parts & 7) == 7;
    count_ = parts == 15 ? 4 : 3;
  }
  [[nodiscard]] bool there() const { return there_; }
  void set(int part, double value) { numbers_[size_t(part)] = value; }
  /// What was set is the colour of `count` items from `index` on.
  void put(size_t index, size_t count) {
    if (!there_) return;
    if (scale_ == 0) {
      for (size_t i = 0; i < count; ++i) fractions_.add(index + i, {numbers_.data(), count_});
      return;
    }
    const auto byte = [this](size_t part) { return uint8_t(std::clamp(numbers_[part] * scale_, 0.0, 255.0) + 0.5); };
    bytes_.resize(index);
    bytes_.insert(bytes_.end(), count, Colour{byte(0), byte(1), byte(2), count_ == 4 ? byte(3) : uint8_t{255}});
  }
  [[nodiscard]] std::vector<Colour> take(size_t count) {
    return scale_ == 0 ? fractions_.take(count) : std::move(bytes_);
  }

 private:
  bool there_ = false;
  size_t count_ = 0;
  double scale_ = 0;  ///< From the numbers of the file to 255; 0 for fractions.
  std::array<double, 4> numbers_{};
  ColourList fractions_;
  std::vector<Colour> bytes_;
};

/// Refuses a count that the rest of the file cannot hold.
template <class Values>
void checkRoom(const Values& values, const Element& element) {
  if (element.count == 0) return;
  size_t least = 0;
  for (const Property& p : element.properties) {
    least += Values::least(p.countType.value_or(p.type));
    if (isCorners(element, p)) least += 3 * Values::least(p.type);
  }
  if (least == 0) {
    values.fail("the element " + shown(element.name) + " has no properties; repair the header or export again");
  }
  if (element.count > values.remaining() / least) {
    values.fail("the header announces " + std::to_string(element.count) + " of " + shown(element.name) + ", at least " +
                std::to_string(least) + " bytes each, and " + std::to_string(values.remaining()) +
                " bytes are left; it was cut off, export it again");
  }
}

template <class Values>
void passProperty(Values& values, const Property& property) {
  if (!property.countType) {
    values.pass(property.type, 1);
    return;
  }
  const int64_t count = values.whole(*property.countType);
  if (count < 0) values.fail("a list has a negative count; repair the file or export it again");
  values.pass(property.type, uint64_t(count));
}

template <class Values>
void readVertices(Values& values, const Element& element, MeshFile& file, Ticker& ticker) {
  constexpr std::string_view kAxes[] = {"x", "y", "z"};
  std::vector<int> axes;
  int found = 0;
  for (const Property& p : element.properties) {
    const auto axis = std::find(std::begin(kAxes), std::end(kAxes), p.name);
    const bool isAxis = axis != std::end(kAxes) && !p.countType;
    axes.push_back(isAxis ? int(axis - std::begin(kAxes)) : -1);
    if (isAxis) found |= 1 << axes.back();
  }
  if (found != 7) values.fail("the vertices do not have x, y and z; export it again with positions");
  if (element.count >= UINT32_MAX) values.fail("there are too many vertices; reduce the mesh first");
  file.mesh.positions.reserve(element.count);
  ElementColours colours(element);
  for (uint64_t v = 0; v < element.count; ++v) {
    Vec3d position = Vec3d::Zero();
    for (size_t i = 0; i < axes.size(); ++i) {
      const Property& property = element.properties[i];
      if (axes[i] >= 0) {
        position[axes[i]] = values.real(property.type);
      } else if (const int part = colourPart(property); part >= 0 && colours.there()) {
        colours.set(part, values.real(property.type));
      } else {
        passProperty(values, property);
      }
    }
    if (!position.allFinite()) {
      values.fail("vertex " + std::to_string(v) +
                  " has a coordinate that is not finite; repair the file or export it again");
    }
    colours.put(file.mesh.positions.size(), 1);
    file.mesh.positions.push_back(position);
    ticker.at(values.offset());
  }
  file.vertexColours = colours.take(file.mesh.positions.size());
}

template <class Values>
uint32_t checkedVertex(const Values& values, int64_t vertex, uint64_t vertices, const char* of, uint64_t number) {
  if (vertex < 0 || uint64_t(vertex) >= vertices) {
    values.fail(of + std::to_string(number) + " names vertex " + std::to_string(vertex) + " and there are " +
                std::to_string(vertices) + ", counted from 0; repair the file or export it again");
  }
  return uint32_t(vertex);
}

template <class Values>
void readFaces(Values& values, const Element& element, uint64_t vertices, MeshFile& file, PolygonList& polygons,
               Ticker& ticker) {
  if (std::none_of(element.properties.begin(), element.properties.end(),
                   [&](const Property& p) { return isCorners(element, p); })) {
    values.fail("the faces have no list \"vertex_indices\" of whole numbers; export it again");
  }
  file.mesh.triangles.reserve(element.count);
  std::vector<uint32_t> corners;
  ElementColours colours(element);
  for (uint64_t f = 0; f < element.count; ++f) {
    const size_t first = file.mesh.triangles.size();
    for (const Property& property : element.properties) {
      if (const int part = colourPart(property); part >= 0 && colours.there()) {
        colours.set(part, values.real(property.type));
        continue;
      }
      if (!isCorners(element, property)) {
        passProperty(values, property);
        continue;
      }
      const int64_t count = values.whole(*property.countType);
      if (count < 3) {
        values.fail("face " + std::to_string(f) + " has " + std::to_string(count) +
                    " corners and needs 3; repair the file or export it again");
      }
      corners.clear();
      for (int64_t c = 0; c < count; ++c)
        corners.push_back(checkedVertex(values, values.whole(property.type), vertices, "face ", f));
      polygons.add(file, corners);
    }
    colours.put(first, file.mesh.triangles.size() - first);
    ticker.at(values.offset());
  }
  if (colours.there()) file.triangleColours = colours.take(file.mesh.triangles.size());
}

/// Strips of triangles: each vertex makes one with the two before it, every other one turned; -1 begins a new strip. A
/// triangle that names a vertex twice only leads to the next.
template <class Values>
void readStrips(Values& values, const Element& element, uint64_t vertices, MeshFile& file, Ticker& ticker) {
  uint64_t strips = 0;
  for (uint64_t s = 0; s < element.count; ++s) {
    for (const Property& property : element.properties) {
      if (!namesVertices(property)) {
        passProperty(values, property);
        continue;
      }
      const int64_t count = values.whole(*property.countType);
      if (count < 0) values.fail("a list has a negative count; repair the file or export it again");
      std::array<uint32_t, 2> before{};
      uint64_t length = 0;
      for (int64_t i = 0; i < count; ++i) {
        const int64_t number = values.whole(property.type);
        if (number == -1) {
          length = 0;
          continue;
        }
        if (length == 0) ++strips;
        const uint32_t vertex = checkedVertex(values, number, vertices, "strip ", strips - 1);
        if (length >= 2 && before[0] != before[1] && before[0] != vertex && before[1] != vertex) {
          const bool turned = length % 2 == 1;
          file.mesh.triangles.push_back({before[turned], before[!turned], vertex});
          ++file.faces;
        }
        before = {before[1], vertex};
        ++length;
        ticker.at(values.offset());
      }
    }
  }
}

template <class Values>
void readBody(Values values, const Input& input, const Header& header, MeshFile& file) {
  Ticker ticker(input);
  PolygonList polygons;
  uint64_t vertices = 0;
  for (const Element& element : header.elements) {
    if (element.name != "vertex") continue;
    if (vertices != 0) values.fail("the header has two elements \"vertex\"; repair it or export again");
    vertices = element.count;
  }
  for (const Element& element : header.elements) {
    checkRoom(values, element);
    if (element.name == "vertex") {
      readVertices(values, element, file, ticker);
    } else if (element.name == "face") {
      readFaces(values, element, vertices, file, polygons, ticker);
    } else if (isStrips(element)) {
      readStrips(values, element, vertices, file, ticker);
    } else {
      for (uint64_t i = 0; i < element.count; ++i) {
        for (const Property& property : element.properties) passProperty(values, property);
        ticker.at(values.offset());
      }
      if (element.count != 0) {
        file.notes.push_back(std::to_string(element.count) + " of the element " + shown(element.name) +
                             " were left out");
      }
    }
  }
  polygons.divide(file, input.job);
  // Strips, or other faces, may have come without a colour.
  if (!file.triangleColours.empty()) file.triangleColours.resize(file.mesh.triangles.size());
}

class PlyEncoder : public MeshEncoder {
 public:
  explicit PlyEncoder(bool doubles) : doubles_(doubles) {}

  void begin(ByteSink& sink, const MeshCounts& counts) override {
    const std::string_view type = doubles_ ? "double" : "float";
    sink.text("ply\nformat binary_little_endian 1.0\ncomment Written by Argil, units: mm\nelement vertex ");
    sink.decimal(counts.vertices);
    for (const char axis : {'x', 'y', 'z'}) {
      sink.text("\nproperty ");
      sink.text(type);
      sink.text(" ");
      sink.text({&axis, 1});
    }
    if (counts.colours) sink.text("\nproperty uchar red\nproperty uchar green\nproperty uchar blue");
    sink.text("\nelement face ");
    sink.decimal(counts.triangles);
    // Most readers want int; it reaches to 2^31 - 1.
    sink.text(counts.vertices <= INT32_MAX ? "\nproperty list uchar int vertex_indices"
                                           : "\nproperty list uchar uint vertex_indices");
    if (counts.triangleColours) sink.text("\nproperty uchar red\nproperty uchar green\nproperty uchar blue");
    sink.text("\nend_header\n");
  }

  void vertices(ByteSink& sink, std::span<const Vec3d> positions) override { colouredVertices(sink, positions, {}); }

  void colouredVertices(ByteSink& sink, std::span<const Vec3d> positions, std::span<const Colour> colours) override {
    const size_t place = doubles_ ? sizeof(Vec3d) : sizeof(Vec3f), size = place + (colours.empty() ? 0 : 3);
    for (size_t i = 0; i < positions.size(); ++i) {
      std::byte* const at = sink.room(size);
      const Vec3f narrow = positions[i].cast<float>();
      std::memcpy(at, doubles_ ? static_cast<const void*>(positions[i].data()) : narrow.data(), place);
      if (!colours.empty()) std::memcpy(at + place, &colours[i], 3);
    }
  }

  void triangles(ByteSink& sink, std::span<const std::array<uint32_t, 3>> triangles) override {
    colouredTriangles(sink, triangles, {});
  }

  void colouredTriangles(ByteSink& sink, std::span<const std::array<uint32_t, 3>> triangles,
                         std::span<const Colour> colours) override {
    constexpr size_t kCorners = sizeof triangles[0];
    for (size_t i = 0; i < triangles.size(); ++i) {
      std::byte* const at = sink.room(1 + kCorners + (colours.empty() ? 0 : 3));
      *at = std::byte{3};
      std::memcpy(at + 1, triangles[i].data(), kCorners);
      if (!colours.empty()) std::memcpy(at + 1 + kCorners, &colours[i], 3);
    }
  }

  void end(ByteSink&) override {}

 private:
  static_assert(std::endian::native == std::endian::little && sizeof(Vec3d) == 24 && sizeof(Vec3f) == 12);
  static_assert(offsetof(Colour, red) == 0 && offsetof(Colour, green) == 1 && offsetof(Colour, blue) == 2);

  bool doubles_;
};

}  // namespace

bool recognizesPly(const Input& input) {
  const std::string_view text = withoutMark(input.text());
  return text.starts_with("ply\n") || text.starts_with("ply\r");
}

MeshFile parsePly(const Input& input) {
  const Header header = readHeader(input);
  MeshFile file;
  if (header.encoding == Encoding::text) {
    file.format = "PLY (text)";
    TextCursor cursor(input, {});
    while (cursor.offset() < header.body) cursor.skipLine();
    readBody(TextValues(cursor), input, header, file);
  } else {
    file.format = "PLY (binary)";
    readBody(BinaryValues(input, header.body, header.encoding == Encoding::big), input, header, file);
  }
  return file;
}

std::unique_ptr<MeshEncoder> makePlyEncoder(const WriteOptions& options) {
  return std::make_unique<PlyEncoder>(options.doubles);
}

}  // namespace argil::io
