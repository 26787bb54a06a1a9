#version 460
#extension GL_GOOGLE_include_directive : require
#include "level.glsl"
#include "level_chunk.glsl"

// Writes the level of one chunk: vertices in the order of the finer ones, triangles in theirs.
shared uint counts[kLanes];

// How many of the lanes before this one count, after `before` of earlier rounds; the sum of all goes to `before`.
uint placeAmong(bool counted, inout uint before) {
  const uint lane = gl_LocalInvocationIndex;
  counts[lane] = counted ? 1 : 0;
  for (uint step = 1; step < kLanes; step *= 2) {
    barrier();
    const uint lower = lane >= step ? counts[lane - step] : 0;
    barrier();
    counts[lane] += lower;
  }
  barrier();
  const uint place = before + counts[lane] - (counted ? 1 : 0);
  before += counts[kLanes - 1];
  barrier();
  return place;
}

void main() {
  const uint lane = gl_LocalInvocationIndex;
  loadBricks();
  uint before = 0;
  for (uint round = 0; round < chunk.scratch; round += kLanes) {
    const uint at = chunk.firstScratch + round + lane;
    const bool named = round + lane < chunk.scratch && kernel.placed.at[at] != 0;
    const uint place = placeAmong(named, before);
    if (!named) continue;
    kernel.placed.at[at] = place + 1;
    const uint vertex = vertexOf(at);
    kernel.vertices.at[chunk.outVertex + place] = kernel.vertices.at[vertex];
    if (kernel.painted != 0) kernel.paint.at[chunk.outVertex + place] = kernel.paint.at[vertex];
  }
  memoryBarrierBuffer();
  barrier();
  before = 0;
  for (uint round = 0; round < chunk.indices / 3; round += kLanes) {
    uvec3 corners;
    const bool left = round + lane < chunk.indices / 3 && readTriangle(round + lane, corners) &&
                      standingTriangle(corners);
    const uint place = placeAmong(left, before);
    if (!left) continue;
    for (int n = 0; n < 3; ++n)
      kernel.indices.at[chunk.outIndex + 3 * place + n] = chunk.outVertex + kernel.placed.at[corners[n]] - 1;
  }
}
