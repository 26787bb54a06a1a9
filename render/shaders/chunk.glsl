// Clay vertices are integers, 1/16384 voxel; the chunk's corner is subtracted before anything is rounded.
layout(push_constant) uniform Chunk {
  ivec3 corner;    // in vertex units
  float unit;      // mm a unit
  vec3 cornerRel;  // the corner in mm, relative to the eye
  vec4 surface;    // as clay.frag reads it
} chunk;

vec3 chunkPosition(ivec3 position) { return vec3(position - chunk.corner) * chunk.unit + chunk.cornerRel; }
