/* OBJ files of every step of a document, numbered, for time-lapses: argil convert work.argil lapse.objs. Colours of
 * vertices stand behind their positions, as many programs read them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "argil_plugin.h"

enum { kRoom = 1 << 20, kLine = 256 };

typedef struct {
  const argil_export* file;
  uint64_t first; /* OBJ counts vertices of all objects together, from 1. */
  uint64_t vertices;
  uint32_t used;
  bool full; /* The disk. */
  char text[kRoom];
} writer;

static void flush(writer* w) {
  if (w->used > 0 && !w->full) w->full = !w->file->write(w->file->self, w->text, w->used);
  w->used = 0;
}

/* Room for one more line. */
static char* room(writer* w) {
  if (w->used + kLine > kRoom) flush(w);
  return w->text + w->used;
}

static void* begin(const argil_export* file) {
  writer* w = malloc(sizeof *w);
  if (!w) return NULL;
  w->file = file;
  w->first = 1;
  w->vertices = 0;
  w->used = 0;
  w->full = false;
  w->used += (uint32_t)snprintf(room(w), kLine, "# Frame %u of %u\n", file->frame + 1, file->frame_count);
  return w;
}

static argil_status object(void* exporter, const argil_object* object) {
  writer* w = exporter;
  w->first += w->vertices;
  w->vertices = object->vertex_count;
  if (object->name[0]) w->used += (uint32_t)snprintf(room(w), kLine, "o %.200s\n", object->name);
  return w->full ? ARGIL_FAILED : ARGIL_OK;
}

static argil_status vertices(void* exporter, const double* at, const uint8_t* colours, uint32_t count) {
  writer* w = exporter;
  for (uint32_t i = 0; i < count; ++i) {
    char* line = room(w);
    if (colours)
      w->used +=
          (uint32_t)snprintf(line, kLine, "v %.9g %.9g %.9g %.4g %.4g %.4g\n", at[3 * i], at[3 * i + 1], at[3 * i + 2],
                             colours[4 * i + 0] / 255.0, colours[4 * i + 1] / 255.0, colours[4 * i + 2] / 255.0);
    else
      w->used += (uint32_t)snprintf(line, kLine, "v %.9g %.9g %.9g\n", at[3 * i], at[3 * i + 1], at[3 * i + 2]);
  }
  return w->full ? ARGIL_FAILED : ARGIL_OK;
}

static argil_status triangles(void* exporter, const uint32_t* corners, uint32_t count) {
  writer* w = exporter;
  for (uint32_t i = 0; i < count; ++i)
    w->used += (uint32_t)snprintf(
        room(w), kLine, "f %llu %llu %llu\n", (unsigned long long)(w->first + corners[3 * i + 0]),
        (unsigned long long)(w->first + corners[3 * i + 1]), (unsigned long long)(w->first + corners[3 * i + 2]));
  return w->full ? ARGIL_FAILED : ARGIL_OK;
}

static argil_status end(void* exporter, bool complete) {
  writer* w = exporter;
  if (complete) flush(w);
  const argil_status status = w->full ? ARGIL_FAILED : ARGIL_OK;
  free(w);
  return status;
}

static const argil_exporter obj = {
    sizeof(argil_exporter), 0, "org.argil.obj-sequence.obj-sequence", begin, object, vertices, triangles, end};

static argil_status init(const argil_host* host) {
  (void)host;
  return ARGIL_OK;
}
static void deinit(void) {}
static const void* get(const char* kind, uint32_t index) {
  return strcmp(kind, ARGIL_EXPORTER_1) == 0 && index == 0 ? &obj : NULL;
}

const argil_plugin* argil_plugin_1(void) {
  static const argil_plugin plugin = {
      sizeof(argil_plugin), ARGIL_PLUGIN_MINOR, "org.argil.obj-sequence", "1.0.0", init, deinit, get};
  return &plugin;
}
