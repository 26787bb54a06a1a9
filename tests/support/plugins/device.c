/* Devices for tests: one that says ten times its force as its place, some that misbehave, and one behind a node. */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include "plugins/sdk/argil_plugin.h"

enum { kOpenedOther = 1, kOpenedLater = 2, kNoIoctl = 4 };
static int node = -1;
static uint32_t wrong = 0;
static int calls = 0;

static void* begin(void) {
  calls = 0;
  return &calls;
}
static argil_status echo(void* device, const double* force, argil_device_state* state) {
  (void)device;
  ++calls;
  for (int k = 0; k < 3; ++k) state->position_mm[k] = 10 * force[k];
  state->rotation[3] = 2;
  state->buttons = 5;
  state->pressure = 0.5f;
  return ARGIL_OK;
}
/* Good for a while; then not. */
#define BAD(name, what)                                                                    \
  static argil_status name(void* device, const double* force, argil_device_state* state) { \
    const argil_status status = echo(device, force, state);                                \
    if (calls > 100) what;                                                                 \
    return status;                                                                         \
  }
BAD(nan_place, state->position_mm[1] = NAN)
BAD(far_away, state->position_mm[1] = 1e5)
BAD(nan_turn, state->rotation[0] = NAN)
BAD(pressure, state->pressure = INFINITY)
BAD(gone, return ARGIL_FAILED)
BAD(crash, abort())
BAD(hang, for (;;) pause())
BAD(busy, for (volatile int forever = 1; forever;) continue)

static argil_status behind(void* device, const double* force, argil_device_state* state) {
  (void)device;
  char byte = 'F';
  struct pollfd wait = {node, POLLIN, 0};
  struct termios terminal;
  state->buttons = wrong;
  if (open("/dev/null", O_RDONLY) >= 0) state->buttons |= kOpenedLater;
  if (tcgetattr(node, &terminal) != 0) state->buttons |= kNoIoctl;
  if (write(node, &byte, 1) != 1 || poll(&wait, 1, 50) != 1 || read(node, &byte, 1) != 1) return ARGIL_FAILED;
  state->position_mm[0] = byte + force[0];
  return ARGIL_OK;
}

#define DEVICE(id, exchange) \
  { sizeof(argil_device), 0, "test.device." id, begin, exchange, NULL }
static const argil_device devices[] = {DEVICE("echo", echo),         DEVICE("nan-place", nan_place),
                                       DEVICE("far-away", far_away), DEVICE("nan-turn", nan_turn),
                                       DEVICE("pressure", pressure), DEVICE("gone", gone),
                                       DEVICE("crash", crash),       DEVICE("hang", hang),
                                       DEVICE("busy", busy),         DEVICE("behind", behind)};

static argil_status init(const argil_host* host) {
  (void)host;
  node = open("/dev/argil-test", O_RDWR | O_NOCTTY);
  if (open("/dev/zero", O_RDWR) >= 0) wrong |= kOpenedOther;
  return ARGIL_OK;
}
static void deinit(void) {}
static const void* get(const char* kind, uint32_t index) {
  return strcmp(kind, ARGIL_DEVICE_1) == 0 && index < sizeof devices / sizeof *devices ? &devices[index] : NULL;
}
const argil_plugin* argil_plugin_1(void) {
  static const argil_plugin plugin = {
      sizeof(argil_plugin), ARGIL_PLUGIN_MINOR, "test.device", "1.0.0", init, deinit, get};
  return &plugin;
}
