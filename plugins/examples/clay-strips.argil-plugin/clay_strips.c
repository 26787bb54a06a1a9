/* Clay strips: a rake lays strips of clay with square edges, each as high as the last one allows. Where the tip passes
 * again it builds up; what lies below the strips is filled first. */
#include <math.h>

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

/* Distance from the strips, voxels: flat on top, square at their edges, as deep as it goes. */
static float strips(const settings* s, const rake* r, const float* p) {
  const float u = dot(p, r->across), w = dot(p, r->along);
  const float pitch = 2 * r->radius / s->strips;
  /* From the middle of the nearest strip: even counts have one on either side of the path's middle. */
  const float shift = fmodf(s->strips, 2) < 0.5f ? 0.5f : 0;
  const float from = fabsf(u) / pitch + shift;
  const float beside = fabsf(from - floorf(from + 0.5f)) * pitch - 0.5f * s->width * pitch;
  const float ends = (w < 0 ? -w : w > r->length ? w - r->length : 0) - r->radius;
  const float sides = fmaxf(fmaxf(beside, ends), fabsf(u) - r->radius);
  return fmaxf(sides, dot(p, r->up) - r->height);
}

static argil_status bricks(void* stroke, const argil_batch* batch) {
  const settings* s = stroke;
  for (uint32_t n = 0; n < batch->count; ++n) {
    const float *phi = batch->phi + (uint64_t)n * batch->brick, *weight = batch->weight + n * 512;
    float* out = batch->out + n * 512;
    for (uint32_t v = 0; v < 512; ++v) out[v] = phi[(v >> 6) * batch->plane + ((v >> 3) & 7) * batch->row + (v & 7)];
    for (uint32_t i = 0; i < batch->image_count; ++i) {
      rake r;
      hold(s, batch->images + i, &r);
      float middle[3]; /* Of the brick, from the path's beginning: mirrored bricks have mirrored places. */
      for (int k = 0; k < 3; ++k) middle[k] = (float)(8.0 * batch->coords[n][k] + 3.5 - batch->images[i].a[k]);
      for (uint32_t v = 0; v < 512; ++v) {
        if (!(weight[v] > 0)) continue;
        const float p[3] = {((float)(v >> 6) - 3.5f) + middle[0], ((float)((v >> 3) & 7) - 3.5f) + middle[1],
                            ((float)(v & 7) - 3.5f) + middle[2]};
        const float here = phi[(v >> 6) * batch->plane + ((v >> 3) & 7) * batch->row + (v & 7)];
        const float laid = strips(s, &r, p) * s->amount, share = weight[v] < 1 ? weight[v] : 1;
        /* Laid on, or cut in where it is inverted. Of several images the one that does most. */
        const float to = s->amount > 0 ? fminf(here, laid) : fmaxf(here, laid);
        const float made = here + share * (to - here);
        out[v] = s->amount > 0 ? fminf(out[v], made) : fmaxf(out[v], made);
      }
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
