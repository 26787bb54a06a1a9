// A chunk's bricks, looked up by vertex: for kernels of one workgroup a chunk.
const uint kLanes = 256;
layout(local_size_x = 256) in;

shared uint firsts[kMostBricks], scratches[kMostBricks];
Chunk chunk;

void loadBricks() {
  chunk = kernel.chunks.at[gl_WorkGroupID.x];
  for (uint i = gl_LocalInvocationIndex; i < chunk.bricks; i += kLanes) {
    firsts[i] = kernel.bricks.at[chunk.firstBrick + i].first;
    scratches[i] = kernel.bricks.at[chunk.firstBrick + i].scratch;
  }
  barrier();
}
// Where in scratch a vertex is. Bricks are in the order of their first vertices.
uint scratchOf(uint vertex) {
  uint low = 0, high = chunk.bricks;
  while (high - low > 1) {
    const uint middle = (low + high) / 2;
    if (firsts[middle] <= vertex) low = middle; else high = middle;
  }
  return vertex - firsts[low] + scratches[low];
}
uint vertexOf(uint scratch) {
  uint low = 0, high = chunk.bricks;
  while (high - low > 1) {
    const uint middle = (low + high) / 2;
    if (scratches[middle] <= scratch) low = middle; else high = middle;
  }
  return scratch - scratches[low] + firsts[low];
}
// False for the empty ones.
bool readTriangle(uint triangle, out uvec3 corners) {
  const uint at = chunk.firstIndex + 3 * triangle;
  corners = uvec3(kernel.indices.at[at], kernel.indices.at[at + 1], kernel.indices.at[at + 2]);
  return corners.x != corners.y && corners.y != corners.z && corners.z != corners.x;
}
// What it becomes; false where nothing is left of it.
bool standingTriangle(inout uvec3 corners) {
  for (int i = 0; i < 3; ++i) corners[i] = kernel.standing.at[scratchOf(corners[i])];
  return corners.x != corners.y && corners.y != corners.z && corners.z != corners.x;
}
