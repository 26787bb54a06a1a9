/* A device without hardware, for trials and stands: a hand of 50 g that is drawn along a path over the middle of its
 * reach, and that the clay's force holds up. Real hardware would be opened in init(), and read and told in exchange().
 */
#define _POSIX_C_SOURCE 200809L /* clock_gettime() */

#include <math.h>
#include <string.h>
#include <time.h>

#include "argil_plugin.h"

static struct { double at[3], speed[3], began, before; } hand;

static double now(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void* begin(void) {
  memset(&hand, 0, sizeof hand);
  hand.began = hand.before = now();
  return &hand;
}

/* Where the hand means to be: to and fro within 20 s, 40 mm to each side, a little below the middle. */
static void wanted(double time, double* at) {
  const double turn = 6.283185307179586;
  at[0] = 40 * sin(turn * time / 20);
  at[1] = 10 * sin(turn * time / 7);
  at[2] = 10 * cos(turn * time / 20) - 5;
}

static argil_status exchange(void* device, const double* force_n, argil_device_state* state) {
  (void)device;
  const double mass_kg = 0.05, stiffness_n_mm = 0.1, damping_ns_mm = 0.004;
  const double time = now();
  double left = fmin(time - hand.before, 0.1), aim[3];
  hand.before = time;
  wanted(time - hand.began, aim);
  /* In steps that are short beside a swing of the mass on its spring, 140 ms. */
  while (left > 0) {
    const double step = fmin(left, 0.0005);
    for (int k = 0; k < 3; ++k) {
      const double force = force_n[k] + stiffness_n_mm * (aim[k] - hand.at[k]) - damping_ns_mm * hand.speed[k];
      hand.speed[k] += 1000 * force / mass_kg * step; /* N/kg is 1000 mm/s². */
      hand.at[k] = fmin(fmax(hand.at[k] + hand.speed[k] * step, -80), 80);
    }
    left -= step;
  }
  memcpy(state->position_mm, hand.at, sizeof hand.at);
  state->pressure = 1;
  state->buttons = 1;
  return ARGIL_OK;
}

static const argil_device device = {sizeof(argil_device), 0, "org.argil.pendulum.hand", begin, exchange, NULL};

static argil_status init(const argil_host* host) {
  (void)host;
  return ARGIL_OK;
}
static void deinit(void) {}
static const void* get(const char* kind, uint32_t index) {
  return strcmp(kind, ARGIL_DEVICE_1) == 0 && index == 0 ? &device : NULL;
}

const argil_plugin* argil_plugin_1(void) {
  static const argil_plugin plugin = {
      sizeof(argil_plugin), ARGIL_PLUGIN_MINOR, "org.argil.pendulum", "1.0.0", init, deinit, get};
  return &plugin;
}
