/* A texture: pebbles of different sizes side by side. */
#include <math.h>
#include <string.h>

#include "argil_plugin.h"

enum { kCount, kParameters };
static const char* const parameters[kParameters] = {"count"};

static float random_of(int32_t x, int32_t y, uint32_t which) {
  uint32_t h = (uint32_t)x * 0x8da6b343u ^ (uint32_t)y * 0xd8163841u ^ which * 0xcb1ab31fu;
  h = (h ^ (h >> 15)) * 0x846ca68bu;
  h ^= h >> 13;
  return (float)(h >> 8) * (1.0f / 16777216);
}

static argil_status heights(const float* given, const float* u, const float* v, float* height, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    const float x = (u[i] + 1) * 0.5f * given[kCount], y = (v[i] + 1) * 0.5f * given[kCount];
    float most = 0;
    for (int32_t dx = -1; dx <= 1; ++dx)
      for (int32_t dy = -1; dy <= 1; ++dy) {
        const int32_t cx = (int32_t)floorf(x) + dx, cy = (int32_t)floorf(y) + dy;
        const float px = (float)cx + random_of(cx, cy, 1) - x, py = (float)cy + random_of(cx, cy, 2) - y;
        const float radius = 0.35f + 0.35f * random_of(cx, cy, 3);
        const float rest = 1 - (px * px + py * py) / (radius * radius);
        if (rest > 0 && sqrtf(rest) * radius > most) most = sqrtf(rest) * radius;
      }
    height[i] = most / 0.7f;
  }
  return ARGIL_OK;
}

static const argil_texture pebbles = {
    sizeof(argil_texture), 0, "org.argil.pebbles.pebbles", 0, kParameters, parameters, heights};

static argil_status init(const argil_host* host) {
  (void)host;
  return ARGIL_OK;
}
static void deinit(void) {}
static const void* get(const char* kind, uint32_t index) {
  return strcmp(kind, ARGIL_TEXTURE_1) == 0 && index == 0 ? &pebbles : NULL;
}

const argil_plugin* argil_plugin_1(void) {
  static const argil_plugin plugin = {
      sizeof(argil_plugin), ARGIL_PLUGIN_MINOR, "org.argil.pebbles", "1.0.0", init, deinit, get};
  return &plugin;
}
