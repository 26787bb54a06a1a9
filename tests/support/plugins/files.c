/* A format of text, one thing a line: "o NAME VERTICES TRIANGLES", "v X Y Z", "t A B C". A file that begins with '!'
 * and a word makes its reader misbehave in that way. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "plugins/sdk/argil_plugin.h"

static const argil_host* host;
static const argil_export* out;

static argil_status write_line(const char* text) {
  return out->write(out->self, text, strlen(text)) ? ARGIL_OK : ARGIL_FAILED;
}
static void* begin(const argil_export* file) {
  out = file;
  return &out;
}
static argil_status object(void* exporter, const argil_object* object) {
  (void)exporter;
  char line[400];
  snprintf(line, sizeof line, "o %.200s %llu %llu\n", object->name[0] ? object->name : "-",
           (unsigned long long)object->vertex_count, (unsigned long long)object->triangle_count);
  if (strstr(object->name, "crash")) abort();
  if (strstr(object->name, "fail")) {
    host->say(host->self, "it does not like the name");
    return ARGIL_FAILED;
  }
  return write_line(line);
}
static argil_status vertices(void* exporter, const double* at, const uint8_t* colours, uint32_t count) {
  (void)exporter;
  (void)colours;
  char line[400];
  for (uint32_t i = 0; i < count; ++i) {
    snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", at[3 * i], at[3 * i + 1], at[3 * i + 2]);
    if (write_line(line) != ARGIL_OK) return ARGIL_FAILED;
  }
  return ARGIL_OK;
}
static argil_status triangles(void* exporter, const uint32_t* corners, uint32_t count) {
  (void)exporter;
  char line[400];
  for (uint32_t i = 0; i < count; ++i) {
    snprintf(line, sizeof line, "t %u %u %u\n", corners[3 * i], corners[3 * i + 1], corners[3 * i + 2]);
    if (write_line(line) != ARGIL_OK) return ARGIL_FAILED;
  }
  return ARGIL_OK;
}
static argil_status end(void* exporter, bool complete) {
  (void)exporter;
  return complete ? write_line("end\n") : ARGIL_OK;
}
static const argil_exporter exporter = {
    sizeof(argil_exporter), 0, "test.files.tri", begin, object, vertices, triangles, end};

static argil_status misbehave(const argil_import* file, const char* how) {
  const double position[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const double nowhere[] = {0, 0, 0, NAN, 0, 0, 0, 1, 0};
  const uint32_t triangle[] = {0, 1, 2}, far_off[] = {0, 1, 3};
  const argil_object thing = {sizeof thing, false, {0}, "thing", 3, 1},
                     huge = {sizeof huge, false, {0}, "huge", 1ull << 40, 1};
  const struct timespec moment = {0, 5000000};
#define HOW(word) (strncmp(how, word, strlen(word)) == 0)
  if (HOW("crash")) abort();
  if (HOW("hang"))
    while (!host->cancelled(host->self)) nanosleep(&moment, NULL);
  if (HOW("stuck"))
    for (;;) nanosleep(&moment, NULL);
  if (HOW("busy"))
    for (;;) {
    }
  if (HOW("nothing")) return ARGIL_OK;
  if (HOW("huge")) file->object(file->self, &huge);
  if (HOW("orphans")) file->vertices(file->self, position, NULL, 3);
  if (!HOW("huge") && !HOW("orphans")) {
    file->object(file->self, &thing);
    file->vertices(file->self, HOW("nan") ? nowhere : position, NULL, HOW("few") ? 2 : 3);
    if (HOW("many")) file->vertices(file->self, position, NULL, 3);
    file->triangles(file->self, HOW("range") ? far_off : triangle, 1);
  }
  return ARGIL_OK;
}

static argil_status run(const argil_import* file) {
  char* text = malloc(file->file_bytes + 1);
  if (!text) return ARGIL_NO_MEMORY;
  text[file->read(file->self, 0, text, file->file_bytes)] = 0;
  if (text[0] == '!') return misbehave(file, text + 1);
  for (char* line = text; *line;) {
    char* next = strchr(line, '\n');
    next = next ? next + 1 : line + strlen(line);
    unsigned long long vertex_count, triangle_count;
    char name[201];
    double at[1][3];
    uint32_t corners[1][3];
    bool good = true;
    if (sscanf(line, "o %200s %llu %llu", name, &vertex_count, &triangle_count) == 3) {
      const argil_object object = {sizeof object, false, {0}, name, vertex_count, triangle_count};
      good = file->object(file->self, &object);
    } else if (sscanf(line, "v %lf %lf %lf", &at[0][0], &at[0][1], &at[0][2]) == 3) {
      good = file->vertices(file->self, at[0], NULL, 1);
    } else if (sscanf(line, "t %u %u %u", &corners[0][0], &corners[0][1], &corners[0][2]) == 3) {
      good = file->triangles(file->self, corners[0], 1);
    } else if (strncmp(line, "end", 3) != 0) {
      host->say(host->self, "has a line that it does not know");
      good = false;
    }
    if (!good) return ARGIL_FAILED;
    line = next;
  }
  free(text);
  return ARGIL_OK;
}
static const argil_importer importer = {sizeof(argil_importer), 0, "test.files.tri", run};

/* Operations: what the number says. */
static const char* const parameters[] = {"how"};
static argil_status operate(const argil_work* work) {
  static int32_t coords[64][3];
  static float phi[64][512];
  const int how = (int)work->parameters[0];
  const uint32_t count = work->bricks(work->self, 0, 64, coords[0], phi[0]);
  const struct timespec moment = {0, 5000000};
  switch (how) {
    case 1:
      abort();
    case 2:
      phi[0][0] = NAN;
      break;
    case 3:
      while (!host->cancelled(host->self)) nanosleep(&moment, NULL);
      return ARGIL_CANCELLED;
    case 4:
      for (;;) nanosleep(&moment, NULL);
    case 5:
      coords[0][0] = 1 << 30;
      break;
    case 6: { /* The brick that it is given by its place is the one that it was given by its number. */
      float again[512];
      work->brick(work->self, coords[count - 1], again);
      if (memcmp(again, phi[count - 1], sizeof again) != 0) return ARGIL_FAILED;
      const int32_t away[3] = {1000, 1000, 1000};
      work->brick(work->self, away, again);
      return again[7] == work->band ? ARGIL_OK : ARGIL_FAILED;
    }
    default:
      break;
  }
  for (uint32_t n = 0; n < count; ++n)
    for (int v = 0; v < 512; ++v)
      if (fabsf(phi[n][v]) < work->band) phi[n][v] += 0.25f;
  return work->put(work->self, count, coords[0], phi[0]) ? ARGIL_OK : ARGIL_FAILED;
}
static const argil_operation operation = {sizeof(argil_operation), 0, "test.files.operate", 0, 1, parameters, operate};

/* A guide: a plane under the hand that does what its number says. */
static int guide_how, guide_calls;
static void* guide_begin(const float* given) {
  guide_how = (int)given[0];
  guide_calls = 0;
  return &guide_how;
}
static argil_status guide_update(void* guide, const argil_hand* hand, argil_local_model* model) {
  (void)guide;
  (void)hand;
  const struct timespec moment = {0, 5000000};
  const int late = ++guide_calls > 20;
  memset(model, 0, sizeof *model);
  model->size = sizeof *model;
  model->count = 1;
  model->radius_mm = 1000;
  model->elements[0].kind = ARGIL_ELEMENT_PLANE;
  model->elements[0].stiffness_n_mm = 0.2f;
  model->elements[0].normal[2] = 3;
  if (!late) return ARGIL_OK;
  if (guide_how == 1) abort();
  if (guide_how == 2)
    for (;;) nanosleep(&moment, NULL);
  if (guide_how == 3) model->elements[0].place_mm[1] = NAN;
  if (guide_how == 4) model->count = 1000000;
  if (guide_how == 5) model->elements[0].stiffness_n_mm = 1e30f;
  if (guide_how == 6) model->elements[0].normal[2] = 0;
  if (guide_how == 7) return ARGIL_FAILED;
  if (guide_how == 8) model->elements[0].place_mm[2] = (guide_calls % 2) * 100.0; /* Leaps up and down. */
  if (guide_how == 9) memset(model, guide_calls & 255, sizeof *model);
  return ARGIL_OK;
}
static const argil_guide guide = {sizeof(argil_guide), 1000,        "test.files.plane", 0,   1,
                                  parameters,          guide_begin, guide_update,       NULL};

/* A texture: a ramp to the right. */
static argil_status texture_heights(const float* given, const float* u, const float* v, float* height, uint32_t count) {
  const int how = (int)given[0];
  if (how == 1) abort();
  for (uint32_t i = 0; i < count; ++i) height[i] = how == 2 ? NAN : how == 3 ? 1e30f : 0.5f + 0.5f * u[i] * (v[i] > 0);
  return how == 4 ? ARGIL_FAILED : ARGIL_OK;
}
static const argil_texture ramp = {sizeof(argil_texture), 0, "test.files.ramp", 0, 1, parameters, texture_heights};

static argil_status init(const argil_host* given) {
  host = given;
  return ARGIL_OK;
}
static void deinit(void) {}
static const void* get(const char* kind, uint32_t index) {
  if (index > 0) return NULL;
  if (strcmp(kind, ARGIL_EXPORTER_1) == 0) return &exporter;
  if (strcmp(kind, ARGIL_IMPORTER_1) == 0) return &importer;
  if (strcmp(kind, ARGIL_GUIDE_1) == 0) return &guide;
  if (strcmp(kind, ARGIL_TEXTURE_1) == 0) return &ramp;
  return strcmp(kind, ARGIL_OPERATION_1) == 0 ? &operation : NULL;
}
ARGIL_EXPORT const argil_plugin* argil_plugin_1(void) {
  static const argil_plugin plugin = {
      sizeof(argil_plugin), ARGIL_PLUGIN_MINOR, "test.files", "1.0.0", init, deinit, get};
  return &plugin;
}
