/* A felt guide: a rail that winds up around the vertical axis. The hand is drawn to it and glides along. */
#include <math.h>
#include <string.h>

#include "argil_plugin.h"

enum { kRadius, kRise, kStiffness, kRange, kParameters };
static const char* const parameters[kParameters] = {"radius", "rise", "stiffness", "range"};

static float now[kParameters];

static void* begin(const float* given) {
  memcpy(now, given, sizeof now);
  return now;
}

/* A spring to the place of the rail at the hand's side of the axis: it holds across the rail, and along it the place
 * goes with the hand. */
static argil_status update(void* guide, const argil_hand* hand, argil_local_model* model) {
  const float* p = guide;
  const double pi = 3.14159265358979323846, turn = 2 * pi;
  const double x = hand->position_mm[0], y = hand->position_mm[1], z = hand->position_mm[2];
  const double around = atan2(y, x);
  /* The nearest winding at this side of the axis. */
  const double height = p[kRise] * around / turn;
  const double winding = floor((z - height) / p[kRise] + 0.5);
  const double place[3] = {p[kRadius] * cos(around), p[kRadius] * sin(around), height + winding * p[kRise]};
  model->count = 1;
  for (int k = 0; k < 3; ++k) model->middle_mm[k] = model->elements[0].place_mm[k] = place[k];
  model->radius_mm = p[kRange];
  model->elements[0].kind = ARGIL_ELEMENT_SPRING;
  model->elements[0].stiffness_n_mm = p[kStiffness];
  model->elements[0].range_mm = p[kRange];
  return ARGIL_OK;
}

static const argil_guide rail = {
    sizeof(argil_guide), 500, "org.argil.rail.rail", 0, kParameters, parameters, begin, update, NULL};

static argil_status init(const argil_host* host) {
  (void)host;
  return ARGIL_OK;
}
static void deinit(void) {}
static const void* get(const char* kind, uint32_t index) {
  return strcmp(kind, ARGIL_GUIDE_1) == 0 && index == 0 ? &rail : NULL;
}

const argil_plugin* argil_plugin_1(void) {
  static const argil_plugin plugin = {
      sizeof(argil_plugin), ARGIL_PLUGIN_MINOR, "org.argil.rail", "1.0.0", init, deinit, get};
  return &plugin;
}
