// Object File Format of Geomview, the text kind: http://www.geomview.org/docs/html/OFF.html
#include <algorithm>
#include <array>

#include "io/bytes/text_cursor.h"
#include "io/models/colour_list.h"
#include "io/models/format_table.h"
#include "io/models/mesh_file.h"

namespace argil::io {

namespace {

constexpr TextCursor::Rules kRules{.hashComments = true, .backslashContinues = false};

struct Header {
  bool found = false;
  bool colours = false;  ///< Behind the position and the normal, if there is one.
  bool normals = false;
  bool homogeneous = false;  ///< Four coordinates a vertex.
  bool anyDimension = false;
};

/// [ST][C][N][4][n]OFF: normals, colours and texture coordinates follow the position on its line, in this order.
Header headerOf(std::string_view word) {
  Header header;
  const auto take = [&word](std::string_view prefix) {
    if (!word.starts_with(prefix)) return false;
    word.remove_prefix(prefix.size());
    return true;
  };
  take("ST");
  header.colours = take("C");
  header.normals = take("N");
  header.homogeneous = take("4");
  header.anyDimension = take("n");
  header.found = word == "OFF";
  return header;
}

uint64_t readCount(TextCursor& cursor, const char* what) {
  const int64_t count = cursor.integer(what, true);
  if (count < 0) cursor.fail(std::string(what) + " is negative; repair the line or export again");
  return uint64_t(count);
}

/// Refuses counts that the rest of the file cannot hold, so that no memory is taken for a lie.
void checkRoom(const TextCursor& cursor, uint64_t count, size_t bytesEach, const char* what) {
  if (count > (cursor.remaining() + 1) / bytesEach || count >= UINT32_MAX) {
    cursor.fail("the file announces " + std::to_string(count) + " " + what + " and has only " +
                std::to_string(cursor.remaining()) + " bytes left; it was cut off or is no OFF, export it again");
  }
}

/// The numbers up to the end of the line, at most N; fewer where something else stands.
template <size_t N>
size_t numbersOnLine(TextCursor& cursor, std::array<double, N>& numbers) {
  size_t count = 0;
  while (count < N && cursor.wordOnLine() && parseNumber(cursor.word(), numbers[count])) ++count;
  return count;
}

}  // namespace

bool recognizesOff(const Input& input) {
  TextCursor cursor(input, kRules);
  return cursor.wordAhead() && headerOf(cursor.word()).found;
}

MeshFile parseOff(const Input& input) {
  TextCursor cursor(input, kRules);
  Header header;
  // The keyword may be missing: then the counts come first.
  if (recognizesOff(input)) {
    cursor.wordAhead();
    header = headerOf(cursor.word());
    if (header.homogeneous || header.anyDimension) {
      cursor.fail("only OFF in three dimensions can be read; export it as plain OFF, STL, OBJ or PLY");
    }
    if (cursor.wordOnLine()) {
      TextCursor ahead = cursor;
      if (ahead.word() == "BINARY") cursor.fail("binary OFF cannot be read; export it as text, STL, OBJ or PLY");
    }
  }
  MeshFile file;
  file.format = "OFF";
  const uint64_t vertices = readCount(cursor, "the count of vertices");
  const uint64_t faces = readCount(cursor, "the count of faces");
  // The count of edges means nothing to anybody; some programs leave it out.
  if (cursor.wordOnLine()) (void)cursor.integer("the count of edges");
  cursor.skipLine();
  checkRoom(cursor, vertices, 6, "vertices");  // "0 0 0\n"
  file.mesh.positions.reserve(vertices);
  Ticker ticker(input);
  ColourList vertexColours, triangleColours;
  for (uint64_t v = 0; v < vertices; ++v) {
    const double x = cursor.number("an x coordinate", true);
    const double y = cursor.number("a y coordinate");
    const double z = cursor.number("a z coordinate");
    file.mesh.positions.emplace_back(x, y, z);
    if (header.colours) {
      std::array<double, 7> more;
      const size_t count = numbersOnLine(cursor, more), before = header.normals ? 3 : 0;
      if (count >= before + 3)
        vertexColours.add(v, std::span(more).subspan(before, std::min<size_t>(count - before, 4)));
    }
    cursor.skipLine();
    ticker.at(cursor.offset());
  }
  checkRoom(cursor, faces, 8, "faces");  // "3 0 1 2\n"
  file.mesh.triangles.reserve(faces);
  std::vector<uint32_t> corners;
  PolygonList polygons;
  for (uint64_t f = 0; f < faces; ++f) {
    const int64_t count = cursor.integer("the count of corners of a face", true);
    if (count < 3) {
      cursor.fail("a face has " + std::to_string(count) + " corners and needs 3; repair the line or export again");
    }
    corners.clear();
    for (int64_t c = 0; c < count; ++c) {
      const int64_t vertex = cursor.integer("a vertex of a face", true);
      if (vertex < 0 || uint64_t(vertex) >= vertices) {
        cursor.fail("a face names vertex " + std::to_string(vertex) + " and they go from 0 to " +
                    std::to_string(vertices) + " - 1; repair the line or export again");
      }
      corners.push_back(uint32_t(vertex));
    }
    const size_t first = file.mesh.triangles.size();
    polygons.add(file, corners);
    // One number would be the place in a table that nobody has.
    std::array<double, 4> colour;
    if (const size_t numbers = numbersOnLine(cursor, colour); numbers >= 3) {
      for (size_t t = first; t < file.mesh.triangles.size(); ++t) triangleColours.add(t, {colour.data(), numbers});
    }
    cursor.skipLine();
    ticker.at(cursor.offset());
  }
  polygons.divide(file, input.job);
  file.vertexColours = vertexColours.take(file.mesh.positions.size());
  file.triangleColours = triangleColours.take(file.mesh.triangles.size());
  if (cursor.wordAhead())
    file.notes.push_back("what follows the last face, from line " + std::to_string(cursor.line()) + " on, was ignored");
  return file;
}

}  // namespace argil::io
