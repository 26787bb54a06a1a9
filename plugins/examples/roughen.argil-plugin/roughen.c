/* An operation on a whole piece: its surface becomes rough, like stone. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "argil_plugin.h"

enum { kHeight, kSize, kParameters, kBlock = 256 };
static const char* const parameters[kParameters] = {"height", "size"};
static const argil_host* host;

static float corner(int32_t x, int32_t y, int32_t z) {
  uint32_t h = (uint32_t)x * 0x8da6b343u ^ (uint32_t)y * 0xd8163841u ^ (uint32_t)z * 0xcb1ab31fu;
  h = (h ^ (h >> 15)) * 0x846ca68bu;
  h ^= h >> 13;
  return (float)(h >> 8) * (2.0f / 16777215) - 1;
}

/* Smooth hills and valleys, -1 to 1, about 2 apart. */
static float noise(float x, float y, float z) {
  const float fx = floorf(x), fy = floorf(y), fz = floorf(z);
  const int32_t i = (int32_t)fx, j = (int32_t)fy, k = (int32_t)fz;
  float t[3] = {x - fx, y - fy, z - fz};
  for (int a = 0; a < 3; ++a) t[a] = t[a] * t[a] * (3 - 2 * t[a]);
  float plane[2];
  for (int dx = 0; dx < 2; ++dx) {
    float row[2];
    for (int dy = 0; dy < 2; ++dy) {
      const float low = corner(i + dx, j + dy, k), high = corner(i + dx, j + dy, k + 1);
      row[dy] = low + t[2] * (high - low);
    }
    plane[dx] = row[0] + t[1] * (row[1] - row[0]);
  }
  return plane[0] + t[0] * (plane[1] - plane[0]);
}

static argil_status run(const argil_work* work) {
  /* Distances are known within the band alone: the surface is moved by as much at a time as it allows. */
  const float most = work->band * 0.5f;
  float height = work->parameters[kHeight] / (float)work->voxel_mm;
  if (height > most) height = most;
  const float per_voxel = (float)work->voxel_mm / work->parameters[kSize];
  int32_t(*coords)[3] = malloc(kBlock * sizeof *coords);
  float(*phi)[512] = malloc(kBlock * sizeof *phi);
  argil_status status = coords && phi ? ARGIL_OK : ARGIL_NO_MEMORY;
  for (uint64_t first = 0; status == ARGIL_OK && first < work->brick_count;) {
    const uint32_t count = work->bricks(work->self, first, kBlock, coords[0], phi[0]);
    for (uint32_t n = 0; n < count; ++n)
      for (int v = 0; v < 512; ++v) {
        const float x = (float)(8 * coords[n][0] + (v >> 6)), y = (float)(8 * coords[n][1] + ((v >> 3) & 7)),
                    z = (float)(8 * coords[n][2] + (v & 7));
        if (fabsf(phi[n][v]) < work->band) phi[n][v] -= height * noise(x * per_voxel, y * per_voxel, z * per_voxel);
      }
    if (count == 0 || !work->put(work->self, count, coords[0], phi[0])) status = ARGIL_FAILED;
    if (host->cancelled(host->self)) status = ARGIL_CANCELLED;
    first += count;
    host->progress(host->self, (double)first / (double)work->brick_count);
  }
  free(coords);
  free(phi);
  return status;
}

static const argil_operation roughen = {
    sizeof(argil_operation), 0, "org.argil.roughen.roughen", 0, kParameters, parameters, run};

static argil_status init(const argil_host* given) {
  host = given;
  return ARGIL_OK;
}
static void deinit(void) {}
static const void* get(const char* kind, uint32_t index) {
  return strcmp(kind, ARGIL_OPERATION_1) == 0 && index == 0 ? &roughen : NULL;
}

const argil_plugin* argil_plugin_1(void) {
  static const argil_plugin plugin = {
      sizeof(argil_plugin), ARGIL_PLUGIN_MINOR, "org.argil.roughen", "1.0.0", init, deinit, get};
  return &plugin;
}
