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
// The last brick whose first vertex is at most number `at`, of the buffer or of scratch: they are in the order of both.
uint brickOf(uint at, bool inScratch) {
  uint low = 0, high = chunk.bricks;
  while (high - low > 1) {
    const uint middle = (low + high) / 2;
    if ((inScratch ? scratches[middle] : firsts[middle]) <= at) low = middle; else high = middle;
  }
  return low;
}
uint scratchOf(uint vertex) {
  const uint brick = brickOf(vertex, false);
  return vertex - firsts[brick] + scratches[brick];
}
uint vertexOf(uint scratch) {
  const uint brick = brickOf(scratch, true);
  return scratch - scratches[brick] + firsts[brick];
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
