#version 460
#extension GL_GOOGLE_include_directive : require
#include "level.glsl"
#include "level_chunk.glsl"

// How large the level of one chunk is, and the cone that its finest triangles face in.
shared vec3 sum[kLanes];
shared float least[kLanes];
shared uint vertices, triangles;

// Not of unit length: as large as twice the triangle, in voxels.
vec3 normalOf(uvec3 corners) {
  const ivec3 a = kernel.vertices.at[corners.x].xyz;
  const vec3 ab = vec3(kernel.vertices.at[corners.y].xyz - a) / kUnitsPerVoxel,
             ac = vec3(kernel.vertices.at[corners.z].xyz - a) / kUnitsPerVoxel;
  return cross(ab, ac);
}

void main() {
  const uint lane = gl_LocalInvocationIndex;
  if (lane == 0) vertices = triangles = 0;
  loadBricks();
  uint mine = 0;
  vec3 normals = vec3(0);
  for (uint i = lane; i < chunk.indices / 3; i += kLanes) {
    uvec3 corners;
    if (!readTriangle(i, corners)) continue;
    normals += normalOf(corners);
    if (!standingTriangle(corners)) continue;
    for (int n = 0; n < 3; ++n) kernel.placed.at[corners[n]] = 1;
    ++mine;
  }
  atomicAdd(triangles, mine);
  sum[lane] = normals;
  for (uint step = kLanes / 2; step > 0; step /= 2) {
    barrier();
    if (lane < step) sum[lane] += sum[lane + step];
  }
  memoryBarrierBuffer();
  barrier();
  mine = 0;
  for (uint i = lane; i < chunk.scratch; i += kLanes) mine += kernel.placed.at[chunk.firstScratch + i];
  atomicAdd(vertices, mine);

  const float whole = length(sum[0]);
  const vec3 axis = whole > 0 ? sum[0] / whole : vec3(0, 0, 1);
  float cosine = whole > 0 ? 1 : -1;
  for (uint i = lane; i < chunk.indices / 3; i += kLanes) {
    uvec3 corners;
    if (!readTriangle(i, corners)) continue;
    const vec3 normal = normalOf(corners);
    const float size = length(normal);
    if (size > 0) cosine = min(cosine, dot(normal, axis) / size);
  }
  least[lane] = cosine;
  for (uint step = kLanes / 2; step > 0; step /= 2) {
    barrier();
    if (lane < step) least[lane] = min(least[lane], least[lane + step]);
  }
  barrier();
  if (lane == 0) kernel.sizes.at[gl_WorkGroupID.x] = Size(vertices, triangles, uint[2](0, 0), vec4(axis, least[0]));
}
