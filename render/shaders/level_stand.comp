#version 460
#extension GL_GOOGLE_include_directive : require
#include "level.glsl"

// What stands for each vertex of one brick: see representatives() in render/view/lod.cpp.
layout(local_size_x = 64) in;

const uint kLanes = 64, kGroups = 64, kClusters = 128;
shared int spread[kGroups * 3];
shared int alongAxis[kGroups];
shared int sums[kClusters * 3];
shared int counts[kClusters];
shared uint nearest[kClusters];
shared uint vertices[kClusters];

Brick brick;

ivec4 vertexAt(uint i) {
  ivec4 v = kernel.vertices.at[brick.first + i];
  v.xyz -= brick.zero.xyz;
  return v;
}
int groupOf(ivec4 vertex) {
  const ivec3 at = vertex.xyz;
  const int last = (vertex.w >> 16 & 1) != 0 ? kLastCreaseUnits : kLastLayerUnits;
  for (int axis = 0; axis < 3; ++axis)
    if ((brick.flags >> axis & 1) != 0 && at[axis] >= last) return -1;
  const int size = int(brick.flags >> 4), groups = (kBrickEdge + size - 1) / size;
  const ivec3 cell = clamp(at / kUnitsPerVoxel, 0, kBrickEdge - 1) / size;
  return (cell.x * groups + cell.y) * groups + cell.z;
}
ivec3 facing(int packed) {
  const int one = 32767, u = bitfieldExtract(packed, 0, 16), v = bitfieldExtract(packed, 16, 16);
  const int up = one - abs(u) - abs(v);
  if (up >= 0) return ivec3(u, v, up);
  return ivec3((one - abs(v)) * (u < 0 ? -1 : 1), (one - abs(u)) * (v < 0 ? -1 : 1), up);
}
int clusterOf(ivec4 vertex) {
  const int group = groupOf(vertex);
  if (group < 0) return -1;
  return 2 * group + (facing(vertex.w)[alongAxis[group]] < 0 ? 1 : 0);
}
uint offMean(ivec3 at, int cluster) {
  const ivec3 mean = ivec3(sums[3 * cluster], sums[3 * cluster + 1], sums[3 * cluster + 2]) / counts[cluster];
  const ivec3 off = (at - mean) / 8;
  return uint(off.x * off.x) + uint(off.y * off.y) + uint(off.z * off.z);
}

void main() {
  brick = kernel.bricks.at[gl_WorkGroupID.x];
  const uint lane = gl_LocalInvocationIndex;
  for (uint i = lane; i < brick.count; i += kLanes) kernel.placed.at[brick.scratch + i] = 0;
  if ((brick.flags & kOwn) == 0) {
    for (uint i = lane; i < brick.count; i += kLanes) kernel.standing.at[brick.scratch + i] = brick.scratch + i;
    return;
  }
  for (uint i = lane; i < kGroups * 3; i += kLanes) spread[i] = 0;
  for (uint i = lane; i < kClusters * 3; i += kLanes) sums[i] = 0;
  for (uint i = lane; i < kClusters; i += kLanes) {
    counts[i] = 0;
    nearest[i] = vertices[i] = 0xffffffffu;
  }
  barrier();
  for (uint i = lane; i < brick.count; i += kLanes) {
    const ivec4 vertex = vertexAt(i);
    const int group = groupOf(vertex);
    if (group < 0) continue;
    const ivec3 way = abs(facing(vertex.w));
    for (int axis = 0; axis < 3; ++axis) atomicAdd(spread[3 * group + axis], way[axis]);
  }
  barrier();
  for (uint i = lane; i < kGroups; i += kLanes) {
    const int x = spread[3 * i], y = spread[3 * i + 1], z = spread[3 * i + 2];
    alongAxis[i] = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
  }
  barrier();
  for (uint i = lane; i < brick.count; i += kLanes) {
    const ivec4 vertex = vertexAt(i);
    const int cluster = clusterOf(vertex);
    if (cluster < 0) continue;
    for (int axis = 0; axis < 3; ++axis) atomicAdd(sums[3 * cluster + axis], vertex[axis]);
    atomicAdd(counts[cluster], 1);
  }
  barrier();
  for (uint i = lane; i < brick.count; i += kLanes) {
    const ivec4 vertex = vertexAt(i);
    const int cluster = clusterOf(vertex);
    if (cluster >= 0) atomicMin(nearest[cluster], offMean(vertex.xyz, cluster));
  }
  barrier();
  for (uint i = lane; i < brick.count; i += kLanes) {
    const ivec4 vertex = vertexAt(i);
    const int cluster = clusterOf(vertex);
    if (cluster >= 0 && nearest[cluster] == offMean(vertex.xyz, cluster)) atomicMin(vertices[cluster], i);
  }
  barrier();
  for (uint i = lane; i < brick.count; i += kLanes) {
    const int cluster = clusterOf(vertexAt(i));
    kernel.standing.at[brick.scratch + i] = brick.scratch + (cluster < 0 ? i : vertices[cluster]);
  }
}
