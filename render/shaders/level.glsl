// Levels of detail on the device (render/gpu/level_kernel.h). Integers but for the cones: what stands for a vertex is
// what render/view/lod.cpp finds, to the bit.
#extension GL_EXT_buffer_reference : require

const int kUnitsPerVoxel = 16384, kBrickEdge = 8, kLastLayerUnits = 6 * kUnitsPerVoxel,
          kLastCreaseUnits = 7 * kUnitsPerVoxel / 2;
const uint kOwn = 8;        // of Brick.flags: of the chunk itself
const uint kMostBricks = 729;  // that one chunk's triangles name

struct Brick {
  uint first, count;  // its vertices
  uint scratch;       // where the first of them is in scratch
  uint flags;         // bits 0 to 2: last of its chunk along x, y, z; kOwn; from bit 4: cells of a group
  ivec4 zero;         // its place, in units
};
struct Chunk {
  uint firstBrick, bricks;
  uint firstIndex, indices;
  uint firstScratch, scratch;
  uint outVertex, outIndex;
};
struct Size {
  uint vertices, triangles;
  uint unused[2];
  vec4 cone;  // axis, cosine
};

layout(buffer_reference, std430, buffer_reference_align = 16) buffer Vertices { ivec4 at[]; };
layout(buffer_reference, std430, buffer_reference_align = 4) buffer Words { uint at[]; };
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Bricks { Brick at[]; };
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Chunks { Chunk at[]; };
layout(buffer_reference, std430, buffer_reference_align = 16) writeonly buffer Sizes { Size at[]; };
layout(buffer_reference, std430, buffer_reference_align = 4) coherent buffer Marks { uint at[]; };

layout(push_constant) uniform Kernel {
  Vertices vertices;
  Words indices;
  Words paint;
  Words standing;  // one a vertex of a brick: where in scratch the one that stands for it is
  Marks placed;    // as many: whether a triangle names it; then its place in the level, and one
  Bricks bricks;
  Chunks chunks;
  Sizes sizes;
  uint painted;
} kernel;
