// STL, binary and text: https://www.loc.gov/preservation/digital/formats/fdd/fdd000505.shtml and fdd000506.shtml
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>

#include "clay/mesh/weld.h"
#include "io/bytes/empty_objects.h"
#include "io/bytes/text_cursor.h"
#include "io/models/format_table.h"

namespace argil::io {

namespace {

constexpr size_t kHeader = 80;
constexpr size_t kStart = kHeader + 4;
constexpr size_t kTriangle = 50;  ///< Normal and three corners of three 32-bit floats, two bytes of attributes.
constexpr size_t kBatch = 4096;   ///< Triangles read between two looks at the job.
constexpr size_t kWritten = 256;  ///< Triangles whose normals are found together.
static_assert(kTriangle * kWritten <= ByteSink::kSize);
/// A binary file that begins with "solid" has a zero byte here, in its padding or in the upper byte of its count.
constexpr size_t kTextProbe = 84;

bool is(std::string_view word, std::string_view keyword) {
  return std::equal(word.begin(), word.end(), keyword.begin(), keyword.end(),
                    [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
}

uint32_t claimedTriangles(const Input& input) {
  uint32_t count = 0;
  std::memcpy(&count, input.bytes.data() + kHeader, sizeof count);
  return count;
}

bool exactlyBinary(const Input& input) {
  const size_t size = input.bytes.size();
  return size > kStart && size == kStart + kTriangle * size_t(claimedTriangles(input));
}

bool beginsWithSolid(const Input& input) {
  TextCursor cursor(input, {});
  return cursor.wordAhead() && is(cursor.word(), "solid");
}

/// Colours of a binary file as Magics writes them: the header says "COLOR=" and four bytes, the colour of the whole,
/// and a triangle whose attribute has bit 15 clear has its own, five bits each of red, green and blue from bit 0 up
/// (https://en.wikipedia.org/wiki/STL_(file_format)#Color). Others use the bits otherwise and do not say so.
class Attributes {
 public:
  explicit Attributes(const Input& input) : bytes_(input.bytes) {
    constexpr std::string_view kKey = "COLOR=";
    const std::string_view header = input.text().substr(0, kHeader);
    const size_t at = header.find(kKey);
    coloured_ = at != std::string_view::npos && at + kKey.size() + 4 <= kHeader;
    if (!coloured_) return;
    const auto byte = [&](size_t i) { return static_cast<uint8_t>(header[at + kKey.size() + i]); };
    whole_ = {byte(0), byte(1), byte(2), byte(3)};
  }
  void read(size_t t, ModelObject& object) {
    uint16_t bits = 0;
    std::memcpy(&bits, bytes_.data() + kStart + kTriangle * (t + 1) - sizeof bits, sizeof bits);
    if (!coloured_) {
      passedOver_ += bits != 0;
      return;
    }
    const auto part = [bits](int shift) { return static_cast<uint8_t>(((bits >> shift) & 31) * 255 / 31); };
    object.triangleColours.push_back((bits & 0x8000) != 0 ? whole_ : Colour{part(0), part(5), part(10), 255});
  }
  [[nodiscard]] uint64_t passedOver() const { return passedOver_; }

 private:
  std::span<const std::byte> bytes_;
  bool coloured_ = false;
  Colour whole_;
  uint64_t passedOver_ = 0;
};

/// Appends the corners of triangle `t` of a binary file.
void readCorners(const Input& input, size_t t, std::vector<Vec3d>& corners) {
  const size_t at = kStart + kTriangle * t;
  std::array<float, 9> numbers;
  std::memcpy(numbers.data(), input.bytes.data() + at + 12, sizeof numbers);
  for (const float x : numbers) {
    if (!std::isfinite(x)) {
      fail(input.name, "byte " + std::to_string(at) + ": triangle " + std::to_string(t + 1) +
                           " has a coordinate that is not finite; repair the file or export it again");
    }
  }
  for (size_t c = 0; c < 9; c += 3) corners.emplace_back(numbers[c], numbers[c + 1], numbers[c + 2]);
}

ModelFile parseBinary(const Input& input) {
  const size_t size = input.bytes.size();
  if (size < kStart) {
    fail(input.name, "is cut off: a binary STL has at least " + std::to_string(kStart) + " bytes and this has " +
                         std::to_string(size) + "; export it again");
  }
  const size_t count = claimedTriangles(input);
  const size_t whole = kStart + kTriangle * count;
  if (whole > size) {
    fail(input.name, "is cut off or no STL: it announces " + std::to_string(count) + " triangles (" +
                         std::to_string(whole) + " bytes) and has " + std::to_string(size) + " bytes; export it again");
  }
  ModelFile file;
  file.format = "STL (binary)";
  file.welded = true;
  if (size > whole) file.notes.push_back(std::to_string(size - whole) + " bytes after the last triangle were ignored");
  file.faces = count;
  if (count == 0) return file;
  ModelObject& object = file.objects.emplace_back();
  object.mesh.triangles.reserve(count);
  clay::VertexWelder welder;
  std::vector<Vec3d> corners;
  std::vector<uint32_t> indices;
  Attributes attributes(input);
  for (size_t begin = 0; begin < count; begin += kBatch) {
    const size_t end = std::min(begin + kBatch, count);
    corners.clear();
    for (size_t t = begin; t < end; ++t) {
      readCorners(input, t, corners);
      attributes.read(t, object);
    }
    indices.resize(corners.size());
    welder.add(corners, indices);
    for (size_t i = 0; i < indices.size(); i += 3) {
      object.mesh.triangles.push_back({indices[i], indices[i + 1], indices[i + 2]});
    }
    if (input.job != nullptr) input.job->step(0.1 + 0.9 * double(end) / double(count));
  }
  object.mesh.positions = welder.take();
  if (attributes.passedOver() != 0) {
    file.notes.push_back("the attribute bytes of " + std::to_string(attributes.passedOver()) +
                         " triangles were left out: they may be colours, but the file does not say which");
  }
  return file;
}

void expect(TextCursor& cursor, std::string_view keyword) {
  if (!cursor.wordAhead()) {
    cursor.fail("the file ends where \"" + std::string(keyword) + "\" should stand; it was cut off, export it again");
  }
  const std::string_view word = cursor.word();
  if (!is(word, keyword)) {
    cursor.fail(shown(word) + " stands where \"" + std::string(keyword) +
                "\" should; repair the file or export it again");
  }
}

/// The normal is passed over: many programs write zeros or NaN there.
void passNormal(TextCursor& cursor) {
  expect(cursor, "normal");
  double unused = 0;
  for (int i = 0; i < 3; ++i) {
    const bool any = cursor.wordAhead();
    const std::string_view word = cursor.word();
    if (!any || !parseNumber(word, unused)) cursor.fail(shown(word) + " stands in a normal; three numbers are needed");
  }
}

/// Several solids that touch nowhere are objects of their own; else all is one surface, which would be torn.
void putTogether(ModelFile& file) {
  if (file.objects.size() < 2) {
    // What follows "solid" is what its program likes to write there: the file's own name says more.
    for (ModelObject& only : file.objects) only.name.clear();
    return;
  }
  clay::VertexWelder all;
  size_t vertices = 0;
  for (const ModelObject& object : file.objects) {
    vertices += object.mesh.positions.size();
    for (const Vec3d& position : object.mesh.positions) all.add(position);
  }
  if (all.positions().size() == vertices) return;
  file.notes.push_back("the " + std::to_string(file.objects.size()) + " solids share vertices and were put together");
  ModelObject whole = merged(std::move(file.objects));
  whole.mesh = clay::weldExact(whole.mesh);
  file.objects.clear();
  file.objects.push_back(std::move(whole));
}

ModelFile parseText(const Input& input) {
  TextCursor cursor(input, {});
  ModelFile file;
  file.format = "STL (text)";
  file.welded = true;
  ModelObject solid;
  clay::VertexWelder welder;
  std::vector<std::string> empty;
  bool named = false;  // a solid that was begun by its word
  const auto finishSolid = [&] {
    solid.mesh.positions = welder.take();
    if (!solid.mesh.triangles.empty())
      file.objects.push_back(std::move(solid));
    else if (named)
      empty.push_back(std::move(solid.name));
    solid = {};
  };
  Ticker ticker(input);
  bool open = false;
  while (cursor.wordAhead()) {
    const std::string_view word = cursor.word();
    if (is(word, "facet")) {
      passNormal(cursor);
      expect(cursor, "outer");
      expect(cursor, "loop");
      std::array<uint32_t, 3> triangle;
      for (uint32_t& corner : triangle) {
        expect(cursor, "vertex");
        const double x = cursor.number("an x coordinate", true);
        const double y = cursor.number("a y coordinate", true);
        const double z = cursor.number("a z coordinate", true);
        corner = welder.add({x, y, z});
      }
      expect(cursor, "endloop");
      expect(cursor, "endfacet");
      solid.mesh.triangles.push_back(triangle);
      ++file.faces;
      ticker.at(cursor.offset());
    } else if (is(word, "solid")) {
      finishSolid();
      open = named = true;
      solid.name = cleanName(cursor.restOfLine());
      cursor.skipLine();
    } else if (is(word, "endsolid")) {
      open = false;
      cursor.skipLine();
    } else {
      cursor.fail(shown(word) + " is no word of a text STL; repair the file or export it again");
    }
  }
  if (open) cursor.fail("the file ends without \"endsolid\"; it was cut off, export it again");
  finishSolid();
  putTogether(file);
  if (!empty.empty()) file.notes.push_back(emptyObjects(empty));
  return file;
}

/// STL repeats its vertices, so they are kept until their triangles come: as the floats that are written.
class StlEncoder : public MeshEncoder {
 public:
  explicit StlEncoder(const WriteOptions& options) : text_(options.text), distinct_(options.distinct) {
    for (auto* values : {&x_, &y_, &z_}) values->setZero();
  }

  void begin(ByteSink& sink, const MeshCounts& counts) override {
    positions_.reserve(counts.vertices);
    if (text_) {
      sink.text("solid argil\n");
      return;
    }
    std::array<char, kHeader> header{};
    // Not "solid": readers take that for a text file.
    constexpr std::string_view kTitle = "Binary STL written by Argil, units: mm";
    std::copy(kTitle.begin(), kTitle.end(), header.begin());
    sink.text({header.data(), header.size()});
    sink.little(uint32_t(counts.triangles));
  }

  void vertices(ByteSink&, std::span<const Vec3d> positions) override {
    for (const Vec3d& p : positions) {
      positions_.push_back(p.cast<float>());
      if (distinct_) moveApart(positions_.back());
    }
  }

  void triangles(ByteSink& sink, std::span<const std::array<uint32_t, 3>> triangles) override {
    for (; !triangles.empty(); triangles = triangles.subspan(std::min(kWritten, triangles.size()))) {
      const auto piece = triangles.first(std::min(kWritten, triangles.size()));
      if (text_) {
        for (const auto& triangle : piece) describe(sink, triangle);
      } else {
        pack(piece, sink.room(kTriangle * piece.size()));
      }
    }
  }

  void end(ByteSink& sink) override {
    if (text_) sink.text("endsolid argil\n");
  }

 private:
  /// As the file has it, but for padding at the end.
  struct Record {
    std::array<Vec3f, 4> vectors;
    uint16_t attributes;
  };
  static_assert(std::endian::native == std::endian::little && sizeof(Vec3f) == 12 &&
                offsetof(Record, attributes) == kTriangle - 2);

  /// Products of four 32-bit numbers are far from the limits of a double: neither tiny nor huge triangles need care.
  static Vec3d crossOf(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
    const Vec3d from = a.cast<double>();
    return (b.cast<double>() - from).cross(c.cast<double>() - from);
  }

  /// Root and division, half of all the work, go over many triangles at once. A triangle without direction gets a
  /// normal of zero, as the format allows.
  void pack(std::span<const std::array<uint32_t, 3>> triangles, std::byte* to) {
    for (size_t i = 0; i < triangles.size(); ++i) {
      const auto& [a, b, c] = triangles[i];
      const Vec3d cross = crossOf(positions_[a], positions_[b], positions_[c]);
      x_[Eigen::Index(i)] = cross.x(), y_[Eigen::Index(i)] = cross.y(), z_[Eigen::Index(i)] = cross.z();
    }
    scale_ = (x_ * x_ + y_ * y_ + z_ * z_).max(std::numeric_limits<double>::min()).sqrt().inverse();
    x_ *= scale_, y_ *= scale_, z_ *= scale_;
    for (size_t i = 0; i < triangles.size(); ++i, to += kTriangle) {
      const auto& [a, b, c] = triangles[i];
      const auto at = Eigen::Index(i);
      const Record record{
          {Vec3f(float(x_[at]), float(y_[at]), float(z_[at])), positions_[a], positions_[b], positions_[c]}, 0};
      std::memcpy(to, &record, kTriangle);
    }
  }

  void describe(ByteSink& sink, const std::array<uint32_t, 3>& triangle) const {
    const auto& [a, b, c] = triangle;
    sink.text("facet normal");
    const Vec3d cross = crossOf(positions_[a], positions_[b], positions_[c]);
    const double length = cross.norm();
    decimals(sink, length > 0 ? Vec3f((cross / length).cast<float>()) : Vec3f::Zero());
    sink.text("\n outer loop\n");
    for (const uint32_t v : triangle) {
      sink.text("  vertex");
      decimals(sink, positions_[v]);
      sink.text("\n");
    }
    sink.text(" endloop\nendfacet\n");
  }

  /// Until nobody was there before, axis by axis; the step is a few last digits, and not lost beside zero.
  void moveApart(Vec3f& p) {
    const auto count = [this] { return taken_.positions().size(); };
    for (int axis = 0;; axis = (axis + 1) % 3) {
      const size_t before = count();
      taken_.add(p.cast<double>());
      if (count() > before) return;
      p[axis] += std::max(std::abs(p[axis]), 1e-2f) * 0x1p-22f;
    }
  }

  static void decimals(ByteSink& sink, const Vec3f& v) {
    for (const float x : {v.x(), v.y(), v.z()}) {
      sink.text(" ");
      sink.decimal(x);
    }
  }

  bool text_, distinct_;
  Eigen::Array<double, kWritten, 1> x_, y_, z_, scale_;  // Of pack(); behind the last triangle what was there before.
  std::vector<Vec3f> positions_;
  clay::VertexWelder taken_;
};

}  // namespace

bool recognizesStl(const Input& input) {
  if (exactlyBinary(input)) return true;
  TextCursor cursor(input, {});
  if (!cursor.wordAhead() || !is(cursor.word(), "solid")) return false;
  cursor.skipLine();
  if (!cursor.wordAhead()) return false;
  const std::string_view second = cursor.word();
  return is(second, "facet") || is(second, "endsolid");
}

ModelFile parseStl(const Input& input) {
  if (exactlyBinary(input) || !beginsWithSolid(input)) return parseBinary(input);
  const bool hasZero = input.text().substr(0, kTextProbe).find('\0') != std::string_view::npos;
  return hasZero ? parseBinary(input) : parseText(input);
}

std::unique_ptr<MeshEncoder> makeStlEncoder(const WriteOptions& options) {
  return std::make_unique<StlEncoder>(options);
}

}  // namespace argil::io
