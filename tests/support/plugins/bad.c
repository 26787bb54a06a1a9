/* Plugins that do what no plugin should, one for each value of BAD. All smooth a little where they behave. */
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "plugins/sdk/argil_plugin.h"

#define STRING_OF(x) #x
#define STRING(x) STRING_OF(x)
#define IS(name) (strcmp(STRING(BAD), #name) == 0)
#define ID "test.bad." STRING(BAD)

static const argil_host* host;

static void sleeps(void) {
  const struct timespec long_time = {1000, 0};
  for (;;) nanosleep(&long_time, NULL);
}
static int stamps;
static double place; /* of the last stamp: one comes in several batches */

__attribute__((constructor)) static void constructed(void) {
  if (IS(constructor_crash)) abort();
  if (IS(constructor_hang)) sleeps();
}

static void* begin(const argil_stroke* stroke) {
  static int dummy;
  (void)stroke;
  stamps = 0;
  return IS(begins_not) ? NULL : &dummy;
}
static void end(void* stroke) {
  (void)stroke;
}

static argil_status bricks(void* stroke, const argil_batch* batch) {
  (void)stroke;
  if (stamps == 0 || batch->images[0].a[0] != place) ++stamps;
  place = batch->images[0].a[0];
  const int third = stamps >= 3;
  for (uint32_t n = 0; n < batch->count; ++n)
    for (uint32_t v = 0; v < 512; ++v) {
      const float phi = batch->phi[n * batch->brick + ((v >> 6) + batch->margin) * batch->plane +
                                   (((v >> 3) & 7) + batch->margin) * batch->row + (v & 7) + batch->margin];
      batch->out[n * 512 + v] = phi - 0.1f * batch->weight[n * 512 + v];
    }
  if (!third) return ARGIL_OK;
  static volatile uintptr_t nowhere = 8;
  if (IS(crash)) *(int*)nowhere = 1;
  if (IS(exit)) exit(0);
  if (IS(kill)) raise(SIGKILL);
  if (IS(hang))
    for (;;) {
    }
  if (IS(sleep)) sleeps();
  if (IS(slow)) {
    const struct timespec some_time = {0, 20000000};
    nanosleep(&some_time, NULL);
  }
  if (IS(nan))
    for (uint32_t i = 0; i < batch->count * 512; ++i) batch->out[i] = NAN;
  if (IS(infinite))
    for (uint32_t i = 0; i < batch->count * 512; ++i) batch->out[i] = INFINITY;
  if (IS(huge))
    for (uint32_t i = 0; i < batch->count * 512; ++i) batch->out[i] = i % 2 ? 1e30f : -1e30f;
  if (IS(outside)) batch->out[batch->count * 512 + 3] = 1;
  if (IS(input)) memset((void*)batch->weight, 1, 64);
  if (IS(fork)) (void)fork();
  if (IS(socket)) (void)socket(AF_INET, SOCK_STREAM, 0);
  if (IS(file)) (void)open("/etc/passwd", O_RDONLY);
  if (IS(hog)) {
    for (;;) {
      char* memory = malloc(1 << 24);
      if (!memory) return ARGIL_NO_MEMORY;
      *memory = 1;
    }
  }
  if (IS(fails)) {
    host->say(host->self, "the moon is in the wrong place");
    return ARGIL_FAILED;
  }
  if (IS(status)) return 12345;
  static void* volatile last;
  if (IS(leak)) {
    last = malloc(1 << 20);
    memset(last, 1, 1 << 20);
  }
  if (IS(batches)) batch->out[3] -= 0.001f * (float)batch->count * batch->weight[3];
  if (IS(remembers))
    for (uint32_t i = 0; i < batch->count * 512; ++i)
      batch->out[i] -= 0.001f * (float)(clock() & 1023) * batch->weight[i];
  return ARGIL_OK;
}

static const char* const parameters[] = {"depth"};
static const argil_brush brush = {
    sizeof(argil_brush), ARGIL_LEAVES_VALUES, ID ".brush", 1, 0, 0, begin, bricks, end,
};
static const argil_brush other_margin = {
    sizeof(argil_brush), ARGIL_LEAVES_VALUES, ID ".brush", 2, 0, 0, begin, bricks, end};
static const argil_brush more_numbers = {
    sizeof(argil_brush), ARGIL_LEAVES_VALUES, ID ".brush", 1, 1, parameters, begin, bricks, end};
/* As a version before `begin` was there would have it. */
static const argil_brush short_brush = {16, ARGIL_LEAVES_VALUES, ID ".brush", 1, 0, 0, begin, bricks, end};

static argil_status init(const argil_host* given) {
  host = given;
  if (IS(init_fails)) {
    host->say(host->self, "it needs a tambourine");
    return ARGIL_FAILED;
  }
  if (IS(init_crash)) abort();
  return ARGIL_OK;
}
static void deinit(void) {}
static const void* get(const char* kind, uint32_t index) {
  if (strcmp(kind, ARGIL_BRUSH_1) != 0 || index > 0 || IS(nothing)) return NULL;
  if (IS(margin)) return &other_margin;
  if (IS(numbers)) return &more_numbers;
  if (IS(short)) return &short_brush;
  return &brush;
}

static const argil_plugin plugin = {sizeof(argil_plugin), ARGIL_PLUGIN_MINOR, ID, "1.0.0", init, deinit, get};
static const argil_plugin other_id = {
    sizeof(argil_plugin), ARGIL_PLUGIN_MINOR, "test.other", "1.0.0", init, deinit, get};
static const argil_plugin other_version = {sizeof(argil_plugin), ARGIL_PLUGIN_MINOR, ID, "2.0.0", init, deinit, get};

#if defined(WRONG_VERSION)
ARGIL_EXPORT const argil_plugin* argil_plugin_2(void) {
#else
const argil_plugin* argil_plugin_1(void) {
#endif
  if (IS(entry_null)) return NULL;
  if (IS(id)) return &other_id;
  if (IS(version)) return &other_version;
  return &plugin;
}
