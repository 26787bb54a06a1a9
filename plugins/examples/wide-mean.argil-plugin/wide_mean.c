/* A brush: every voxel goes towards a mean of the seven voxels along each axis, all the way for tips of 22 voxels: a
 * mean's reach (the sum of its squared distances) then grows as the square of the tip's radius, up to what the margin
 * of four voxels allows. */
#include <stdlib.h>

#include "argil_plugin.h"

#define FINE_RADIUS 10.0 /* Voxels: a tip as small smooths as far as the nearest neighbours' mean. */
#define STEPS 256

/* Distances end at the band, so the mean of a plane's distances is nearer to zero than the plane. The table takes it
 * back: distances for means of 0, 1 / scale, 2 / scale and so on. */
typedef struct {
  float amount, scale, table[STEPS + 2];
} stroke_state;

static double mean_at(double distance, double band) {
  double sum = 0;
  for (int k = -3; k <= 3; ++k) {
    const double d = distance + k;
    sum += (4 - abs(k)) * (d < -band ? -band : d > band ? band : d);
  }
  return sum / 16;
}

static void* begin(const argil_stroke* stroke) {
  stroke_state* state = malloc(sizeof(stroke_state));
  if (!state) return 0;
  const double band = stroke->band, last = mean_at(band, band);
  state->amount = stroke->amount < 0 ? -1 : 1;
  state->scale = (float)(STEPS / last);
  double low = 0;
  for (int i = 0; i < STEPS; ++i) {
    double high = band;
    for (int round = 0; round < 40; ++round) {
      const double middle = (low + high) / 2;
      if (mean_at(middle, band) < last * i / STEPS)
        low = middle;
      else
        high = middle;
    }
    state->table[i] = (float)low;
  }
  state->table[STEPS] = state->table[STEPS + 1] = stroke->band;
  return state;
}

static float distance_of(const stroke_state* state, float mean) {
  const float size = (mean < 0 ? -mean : mean) * state->scale, at = size < STEPS ? size : STEPS;
  const int i = (int)at;
  const float distance = state->table[i] + (state->table[i + 1] - state->table[i]) * (at - (float)i);
  return mean < 0 ? -distance : distance;
}

/* 1 2 3 4 3 2 1 along an axis: sums are 16 times the mean. */
static float across(const float* p, uint32_t step) {
  return 4 * p[3 * step] + 3 * (p[2 * step] + p[4 * step]) + 2 * (p[step] + p[5 * step]) + (p[0] + p[6 * step]);
}

/* How much of the mean the largest tip wants. */
static float share(const argil_batch* batch) {
  double radius = FINE_RADIUS;
  for (uint32_t i = 0; i < batch->image_count; ++i) {
    if (batch->images[i].radius > radius) radius = batch->images[i].radius;
    if (batch->images[i].end_radius > radius) radius = batch->images[i].end_radius;
  }
  const double wanted = 0.5 * (radius / FINE_RADIUS) * (radius / FINE_RADIUS), reached = 2.5;
  return wanted < reached ? (float)(wanted / reached) : 1;
}

ARGIL_EVERY_CPU static argil_status bricks(void* stroke, const argil_batch* batch) {
  const stroke_state* state = stroke;
  const float amount = state->amount * share(batch);
  for (uint32_t n = 0; n < batch->count; ++n) {
    /* From three voxels before the brick on. */
    const float* phi = batch->phi + (uint64_t)n * batch->brick + batch->plane + batch->row + 1;
    const float* weight = batch->weight + n * 512;
    float* out = batch->out + n * 512;
    float z1[14][14][8], y1[14][8][8];
    for (uint32_t x = 0; x < 14; ++x)
      for (uint32_t y = 0; y < 14; ++y)
        for (uint32_t z = 0; z < 8; ++z) z1[x][y][z] = across(phi + x * batch->plane + y * batch->row + z, 1);
    for (uint32_t x = 0; x < 14; ++x)
      for (uint32_t y = 0; y < 8; ++y)
        for (uint32_t z = 0; z < 8; ++z) y1[x][y][z] = across(&z1[x][y][z], 8);
    for (uint32_t x = 0; x < 8; ++x)
      for (uint32_t y = 0; y < 8; ++y)
        for (uint32_t z = 0; z < 8; ++z) {
          const uint32_t v = x * 64 + y * 8 + z;
          const float here = phi[(x + 3) * batch->plane + (y + 3) * batch->row + z + 3];
          const float mean = distance_of(state, across(&y1[x][y][z], 64) * (1.0f / 4096));
          out[v] = here + weight[v] * amount * (mean - here);
        }
  }
  return ARGIL_OK;
}

static const argil_brush smooth = {
    sizeof(argil_brush), ARGIL_LEAVES_VALUES, "org.argil.wide-mean.smooth", 4, 0, 0, begin, bricks, free};

static argil_status init(const argil_host* host) {
  (void)host;
  return ARGIL_OK;
}
static void deinit(void) {}
static const void* get(const char* kind, uint32_t index) {
  for (const char *a = kind, *b = ARGIL_BRUSH_1; *a || *b; ++a, ++b)
    if (*a != *b) return 0;
  return index == 0 ? &smooth : 0;
}

const argil_plugin* argil_plugin_1(void) {
  static const argil_plugin plugin = {
      sizeof(argil_plugin), ARGIL_PLUGIN_MINOR, "org.argil.wide-mean", "1.0.0", init, deinit, get};
  return &plugin;
}
