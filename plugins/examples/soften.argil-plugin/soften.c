/* A brush: every voxel goes towards the mean of the 27 around it, near ones more. */
#include "argil_plugin.h"

static void* begin(const argil_stroke* stroke) {
  static float amounts[2] = {1, -1};
  return &amounts[stroke->amount < 0];
}

/* 1 2 1 along an axis. */
static float across(const float* p, uint32_t step) {
  return (p[0] + p[2 * step]) + 2 * p[step];
}

ARGIL_EVERY_CPU static argil_status bricks(void* stroke, const argil_batch* batch) {
  const float amount = *(const float*)stroke;
  for (uint32_t n = 0; n < batch->count; ++n) {
    const float *phi = batch->phi + (uint64_t)n * batch->brick, *weight = batch->weight + n * 512;
    float* out = batch->out + n * 512;
    float z1[10][10][8], y1[10][8][8];
    for (uint32_t x = 0; x < 10; ++x)
      for (uint32_t y = 0; y < 10; ++y)
        for (uint32_t z = 0; z < 8; ++z) z1[x][y][z] = across(phi + x * batch->plane + y * batch->row + z, 1);
    for (uint32_t x = 0; x < 10; ++x)
      for (uint32_t y = 0; y < 8; ++y)
        for (uint32_t z = 0; z < 8; ++z) y1[x][y][z] = across(&z1[x][y][z], 8);
    for (uint32_t x = 0; x < 8; ++x)
      for (uint32_t y = 0; y < 8; ++y)
        for (uint32_t z = 0; z < 8; ++z) {
          const uint32_t v = x * 64 + y * 8 + z;
          const float here = phi[(x + 1) * batch->plane + (y + 1) * batch->row + z + 1];
          const float mean = across(&y1[x][y][z], 64) * (1.0f / 64);
          out[v] = here + weight[v] * amount * (mean - here);
        }
  }
  return ARGIL_OK;
}

static const argil_brush soften = {
    sizeof(argil_brush), ARGIL_LEAVES_VALUES, "org.argil.soften.soften", 1, 0, 0, begin, bricks, 0};

static argil_status init(const argil_host* host) {
  (void)host;
  return ARGIL_OK;
}
static void deinit(void) {}
static const void* get(const char* kind, uint32_t index) {
  for (const char *a = kind, *b = ARGIL_BRUSH_1; *a || *b; ++a, ++b)
    if (*a != *b) return 0;
  return index == 0 ? &soften : 0;
}

const argil_plugin* argil_plugin_1(void) {
  static const argil_plugin plugin = {
      sizeof(argil_plugin), ARGIL_PLUGIN_MINOR, "org.argil.soften", "1.0.0", init, deinit, get};
  return &plugin;
}
