/* Clay strips: a rake lays strips of clay with square edges, each as high as the last one allows. Where the tip passes
 * again it builds up; what lies below the strips is filled first. */
#include <math.h>
#include <string.h>

#include "argil_plugin.h"

enum { kStrips, kWidth, kRise, kParameters };
static const char* const parameters[kParameters] = {"strips", "width", "rise"};

typedef struct {
  float strips, width, height, amount;
} settings;

/* One stroke at a time is in work in a process. */
static settings now;

static void* begin(const argil_stroke* stroke) {
  now.strips = stroke->parameters[kStrips];
  now.width = stroke->parameters[kWidth];
  now.height = stroke->parameters[kRise];
  now.amount = stroke->amount;
  return &now;
}

typedef struct {
  float along[3], across[3], up[3]; /* Unit vectors. */
  float length, radius, height;     /* Voxels. */
} rake;

static float dot(const float* a, const float* b) {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

/* The rake stands on the surface, its teeth side by side across the path. */
static void hold(const settings* s, const argil_image* image, rake* r) {
  float way[3];
  for (int k = 0; k < 3; ++k) {
    way[k] = (float)(image->b[k] - image->a[k]);
    r->up[k] = image->axes[2][k] * s->amount;
  }
  r->length = sqrtf(dot(way, way));
  const float rise = dot(way, image->axes[2]);
  float flat[3];
  for (int k = 0; k < 3; ++k) flat[k] = way[k] - rise * image->axes[2][k];
  const float length = sqrtf(dot(flat, flat));
  for (int k = 0; k < 3; ++k) r->along[k] = length > 1e-4f ? flat[k] / length : image->axes[0][k];
  /* A mirror image's third axis makes a left-handed system with the others: the strips have no handedness. */
  r->across[0] = image->axes[2][1] * r->along[2] - image->axes[2][2] * r->along[1];
  r->across[1] = image->axes[2][2] * r->along[0] - image->axes[2][0] * r->along[2];
  r->across[2] = image->axes[2][0] * r->along[1] - image->axes[2][1] * r->along[0];
  r->radius = (float)image->radius;
  r->height = s->height * r->radius;
}

/* New distances of a brick for one image, as far as they exceed what `out` has already. */
ARGIL_EVERY_CPU static void lay(const settings* s, const rake* r, const float* middle, const float* phi,
                                const float* weight, float* out) {
  /* Even counts have one strip on either side of the path's middle. */
  const float pitch = 2 * r->radius / s->strips, shift = fmodf(s->strips, 2) < 0.5f ? 0.5f : 0;
  const float round = fminf(1.5f, 0.25f * s->width * pitch);
  const float half = 0.5f * s->width * pitch, per_pitch = 1 / pitch, sign = s->amount;
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      for (int z = 0; z < 8; ++z) {
        const int v = x * 64 + y * 8 + z;
        const float px = ((float)x - 3.5f) + middle[0], py = ((float)y - 3.5f) + middle[1],
                    pz = ((float)z - 3.5f) + middle[2];
        const float u = (px * r->across[0] + py * r->across[1]) + pz * r->across[2];
        const float w = (px * r->along[0] + py * r->along[1]) + pz * r->along[2];
        const float h = (px * r->up[0] + py * r->up[1]) + pz * r->up[2];
        /* Distance from the strips, voxels: flat on top, square at their edges, as deep as it goes. */
        const float from = fabsf(u) * per_pitch + shift;
        const float beside = fabsf(from - floorf(from + 0.5f)) * pitch - half;
        const float ends = fmaxf(-w, w - r->length) - r->radius;
        const float sides = fmaxf(fmaxf(beside, ends), fabsf(u) - r->radius);
        /* Edges are rounded by a little more than a voxel, or they would be as rough as the voxels. */
        const float a = fmaxf(sides + round, 0), b = fmaxf(h - r->height + round, 0);
        const float laid = sqrtf(a * a + b * b) + fminf(fmaxf(sides, h - r->height) + round, 0) - round;
        /* Laid on, or cut in where it is inverted. Of several images the one that does most. */
        const float share = fminf(weight[v], 1), here = phi[v] * sign;
        const float made = here + share * (fminf(here, laid) - here);
        out[v] = fminf(out[v] * sign, made) * sign;
      }
}

static argil_status bricks(void* stroke, const argil_batch* batch) {
  const settings* s = stroke;
  for (uint32_t n = 0; n < batch->count; ++n) {
    const float *phi = batch->phi + (uint64_t)n * batch->brick, *weight = batch->weight + n * 512;
    float* out = batch->out + n * 512;
    memcpy(out, phi, 512 * sizeof(float)); /* Without a margin, bricks lie as results do. */
    for (uint32_t i = 0; i < batch->image_count; ++i) {
      rake r;
      float middle[3]; /* Of the brick, from the path's beginning: mirrored bricks have mirrored places. */
      for (int k = 0; k < 3; ++k) middle[k] = (float)(8.0 * batch->coords[n][k] + 3.5 - batch->images[i].a[k]);
      hold(s, batch->images + i, &r);
      lay(s, &r, middle, phi, weight, out);
    }
  }
  return ARGIL_OK;
}

static const argil_brush brush = {sizeof(argil_brush),
                                  ARGIL_LEAVES_VALUES,
                                  "org.argil.clay-strips.clay-strips",
                                  0,
                                  kParameters,
                                  parameters,
                                  begin,
                                  bricks,
                                  0};

static argil_status init(const argil_host* host) {
  (void)host;
  return ARGIL_OK;
}
static void deinit(void) {}
static const void* get(const char* kind, uint32_t index) {
  for (const char *a = kind, *b = ARGIL_BRUSH_1; *a || *b; ++a, ++b)
    if (*a != *b) return 0;
  return index == 0 ? &brush : 0;
}

const argil_plugin* argil_plugin_1(void) {
  static const argil_plugin plugin = {
      sizeof(argil_plugin), ARGIL_PLUGIN_MINOR, "org.argil.clay-strips", "1.0.0", init, deinit, get};
  return &plugin;
}
