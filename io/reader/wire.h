#pragma once
// What argil-reader says to the program that started it: kMagic, then messages, each a head and its payload, until
// `end`, `error` or `memory`. All little endian, as both ends run on one machine. The receiver believes none of it.

#include <bit>
#include <cstdint>

namespace argil::io::wire {

static_assert(std::endian::native == std::endian::little, "swap the bytes of messages here for a big-endian machine");

inline constexpr char kMagic[8] = {'A', 'R', 'G', 'I', 'L', 'R', 'D', '1'};
inline constexpr uint32_t kMostBytes = uint32_t{4} << 20;  ///< Of a payload: longer arrays come in pieces.
inline constexpr uint32_t kMostText = 1000;                ///< Of a name, a note, a sentence.
// How many there are: each costs the receiver more than it costs the sender.
inline constexpr uint32_t kMostTexts = 1000;  ///< Notes and metadata together; the sender drops the rest.
inline constexpr uint32_t kMostObjects = uint32_t{1} << 18;
inline constexpr uint32_t kMostGrids = 1000;

enum class Kind : uint32_t {
  error = 1,        ///< Text: what is wrong with the file and what to do; the last message.
  memory,           ///< Nothing: there was not enough of it; the last message.
  note,             ///< Text.
  format,           ///< Text.
  metadata,         ///< Text: key, a zero byte, value.
  object,           ///< Object, then its name. Its arrays follow, each complete before the next begins.
  positions,        ///< Of 3 doubles.
  triangles,        ///< Of 3 uint32_t.
  colours,          ///< Of 4 bytes, sRGB and alpha, one a vertex; where announced.
  grid,             ///< Grid, then its name. Its tiles follow, then its bricks.
  tiles,            ///< Of Tile: what is inside.
  bricks,           ///< Of Brick.
  colourBricks,     ///< Of ColourBrick; each where a brick was sent.
  picture,          ///< Picture. Its levels, or its pixels, follow.
  levels,           ///< Of float, 0 black to 1 white, row by row from the top.
  pixels,           ///< Of 4 bytes, sRGB and alpha, row by row from the top.
  end,              ///< Nothing: all was sent.
  faces,            ///< Of Face: of the object before, once it is complete.
  triangleColours,  ///< Of 4 bytes, sRGB and alpha, one a triangle; where announced.
  surface,          ///< Surface: of the picture before, which is complete; between objects.
  places,           ///< Of Places, one a triangle; where announced.
};

// What a level set says of its colours in a .vdb file: the name of their grid, and the one that it has itself, linear
// light.
inline constexpr const char* kColoursMeta = "colours";
inline constexpr const char* kColourMeta = "colour";

struct Head {
  Kind kind;
  uint32_t bytes;
};

struct Object {
  uint64_t vertices, triangles;
  uint8_t colour[4];
  uint8_t hasColour, hasColours, hasTriangleColours;
  uint8_t hasPlaces = 0;
};

/// How a picture lies on surfaces, in the order of their numbers.
struct Surface {
  float factor[4];       ///< Linear light and alpha, 0 to 1.
  float cutoff;          ///< Of alpha.
  uint8_t wrapU, wrapV;  ///< 0 repeat, 1 mirror, 2 clamp.
  uint8_t alpha;         ///< 0 opaque, 1 mask, 2 blend.
  uint8_t tinted;        ///< Multiplied by colours of vertices.
  uint32_t picture;      ///< Counts from 0.
};

/// Where the corners of a triangle lie on the picture of a surface.
struct Places {
  float at[6];       ///< u and v of each, v from the top down.
  uint32_t surface;  ///< kNoSurface: none.
};
inline constexpr uint32_t kNoSurface = UINT32_MAX;
inline constexpr uint32_t kMostSurfaces = 4096;  ///< Pictures, too.
inline constexpr uint32_t kMostPictureEdge = 8192;

/// A face of a CAD model that has a plane, an axis or a middle.
struct Face {
  double at[3];         ///< The middle of the plane's part that is used, or of the axis'; the middle.
  double along[3];      ///< Unit vector: normal, outwards; direction of the axis.
  double across[3];     ///< Unit vector perpendicular to it.
  double width, depth;  ///< Plane: sizes along `across` and perpendicular to it. Axis: length; radius. Middle: radius.
  uint32_t kind;        ///< 0 plane, 1 axis, 2 middle.
  uint8_t padding[4] = {};
};
inline constexpr uint32_t kMostFaces = 1u << 16;  ///< Of an object; the sender leaves the rest out.

struct Grid {
  double voxel, origin[3];  ///< In units of the file.
  double rotation[4];       ///< w, x, y, z: of all of it about zero; a unit quaternion.
  uint64_t tiles, bricks;
  uint8_t colour[3], hasColour;  ///< sRGB.
  uint8_t padding[4] = {};
};

struct Tile {
  int32_t x, y, z;  ///< First brick.
  int32_t edge;     ///< Bricks: 1, 16 or 512.
};

struct Brick {
  int32_t x, y, z;
  float phi[512];  ///< Distances in voxels, x · 64 + y · 8 + z.
};

struct ColourBrick {
  int32_t x, y, z;
  uint8_t channel[4][512];  ///< sRGB and how much of it covers the colour of the whole; in order of Brick.
};

struct Picture {
  uint32_t width, height;
};

}  // namespace argil::io::wire
