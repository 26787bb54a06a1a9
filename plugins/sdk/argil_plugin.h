/* Argil's plugin interface, version 1. Needs C11 and these two headers; a plugin links nothing of Argil.
 *
 * A plugin is a folder NAME.argil-plugin with
 *   plugin.json                 what it brings, read without running it: docs/plugins.md
 *   x86_64-linux/LIBRARY.so     the library that plugin.json names, which exports argil_plugin_1()
 *
 * The library runs in a process of its own, argil-plugin, which is confined before the library is loaded and once more
 * after init(): it can compute and start threads; it opens no file but its own folder and the system's libraries, and
 * none at all after init(); it opens no connection and starts no process. A call that is refused fails with EPERM, and
 * the user is told. When the process ends or does not answer, the stroke or job that it worked for ends, what it had
 * not finished is as before, and the user is told which plugin it was.
 *
 * Rules for every struct: the first member is its size, as the side that made it knows the struct. Versions only append
 * members, so whoever reads one looks at no more than `size` bytes and takes what lies beyond it for absent (0).
 * Rules for every pointer: what a call is given is valid until it returns; what the plugin returns by pointer stays its
 * own and valid until deinit(). Memory never changes owner. Texts are UTF-8 and end with a 0. No exception and no
 * longjmp may leave a call.
 *
 * Threads, as each function says: [main] the process's first thread; [worker] any thread of the host's in the process,
 * several at once.
 *
 * Equal input must give equal bits, on every CPU and for every division of the work. Compile with -ffp-contract=off and
 * keep to + - * / sqrtf, min and max (libm's sinf differs from system to system). */
#ifndef ARGIL_PLUGIN_H
#define ARGIL_PLUGIN_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define ARGIL_PLUGIN_MAJOR 1
#define ARGIL_PLUGIN_MINOR 0

/* What a call ended with. Other values count as ARGIL_FAILED. */
typedef int32_t argil_status;
#define ARGIL_OK ((argil_status)0)
#define ARGIL_FAILED ((argil_status)1)    /* say() has told why, if anything is known. */
#define ARGIL_CANCELLED ((argil_status)2) /* cancelled() said true. */
#define ARGIL_NO_MEMORY ((argil_status)3)

/* What the program does for a plugin. Valid from init() to deinit(). */
typedef struct argil_host {
  uint32_t size;
  uint32_t minor; /* ARGIL_PLUGIN_MINOR of the program. */
  void* self;     /* First argument of each function below. */
  /* A sentence for the user, cut after 400 bytes: the last one before a failure is its reason. [main, worker] */
  void (*say)(void* self, const char* sentence);
  /* How much of an operation, an import or an export is done, 0 to 1. Costs nothing. [main] */
  void (*progress)(void* self, double done);
  /* Whether the user has asked to stop: return ARGIL_CANCELLED within 100 ms. Costs nothing. [main, worker] */
  bool (*cancelled)(void* self);
} argil_host;

/* The entry. A new major version gets a new symbol; a library may export both. */
typedef struct argil_plugin {
  uint32_t size;
  uint32_t minor;      /* ARGIL_PLUGIN_MINOR that it was compiled with. */
  const char* id;      /* As plugin.json has it. */
  const char* version; /* As plugin.json has it. */
  /* Called before anything else but argil_plugin_1() itself, and again, nested, when the library is opened twice:
   * count. What it does not allow for is read here, as no file can be opened afterwards. [main] */
  argil_status (*init)(const argil_host* host);
  /* As often as init() succeeded. [main] */
  void (*deinit)(void);
  /* The index-th thing of a kind ("argil.brush/1", …): a pointer to the struct of that kind; null behind the last, and
   * for kinds that it does not know. The same every time. [main] */
  const void* (*get)(const char* kind, uint32_t index);
} argil_plugin;

#if defined(__GNUC__)
#define ARGIL_EXPORT __attribute__((visibility("default")))
#else
#define ARGIL_EXPORT
#endif

/* Before the definition of a function that computes: it is compiled for more than one CPU, and the best one runs. Equal
 * bits, as nothing is fused. What it calls has to be inlined into it. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define ARGIL_EVERY_CPU __attribute__((target_clones("avx2", "default")))
#else
#define ARGIL_EVERY_CPU
#endif

/* What a library exports. Null: it cannot work here. [main, once] */
ARGIL_EXPORT const argil_plugin* argil_plugin_1(void);
#define ARGIL_PLUGIN_SYMBOL "argil_plugin_1"

/* ------------------------------------------------------------------------------------------------------------------
 * Brushes. Clay is a signed distance field in bricks of 8 x 8 x 8 voxels: phi in voxels, below zero inside, true within
 * `band` of the surface and no farther. A stamp is one place of a stroke where the tip works, swept from a to b; it has
 * images where symmetry is on. For each stamp the brush is given all bricks within reach that hold or touch the
 * surface, and says their new distances. */
#define ARGIL_BRUSH_1 "argil.brush/1"

/* What has to be renewed of the distances beside the surface that a brush leaves. */
#define ARGIL_LEAVES_DISTANCES 0u /* They are distances still. */
#define ARGIL_LEAVES_SLOPES 1u    /* Slopes may have changed. */
#define ARGIL_LEAVES_VALUES 2u    /* Anything may have: the usual case. */
#define ARGIL_BRUSH_LEAVES 3u     /* Mask of these in argil_brush::flags. */
#define ARGIL_BRUSH_SERIAL 4u     /* bricks() is called by one thread at a time. */

typedef struct argil_image {
  uint32_t size;
  float strength;    /* 0 to 1. */
  double a[3], b[3]; /* Voxels: voxel (x, y, z) of brick (i, j, k) is at (8 i + x, 8 j + y, 8 k + z). */
  double radius;     /* At a, voxels. */
  double end_radius; /* At b. */
  float axes[3][3];  /* axes[n]: the tip's n-th axis; unit vectors, mirrored in a mirror image. */
  uint32_t reserved;
} argil_image;

typedef struct argil_stroke {
  uint32_t size;
  float band;          /* Voxels. */
  double voxel_mm;     /* Edge of a voxel. */
  double origin_mm[3]; /* Of voxel (0, 0, 0), in the piece. */
  float amount;        /* 1, or -1 where the user inverts the brush. */
  float per_stamp;     /* A stamp stands for so many of those that a brush is made for: 1 at usual spacing. */
  uint32_t parameter_count;
  uint32_t reserved;
  const float* parameters; /* In the order of argil_brush::parameters. */
} argil_stroke;

typedef struct argil_batch {
  uint32_t size;
  uint32_t image_count; /* 1 to 64. */
  const argil_image* images;
  uint32_t count;             /* Bricks. */
  uint32_t margin;            /* argil_brush::margin. */
  const int32_t (*coords)[3]; /* Of each brick, in bricks. */
  /* Distances: brick n, voxel (x, y, z) is phi[n * brick + (x + margin) * plane + (y + margin) * row + (z + margin)],
   * x, y and z from -margin to 7 + margin. */
  const float* phi;
  uint32_t brick, plane, row; /* Floats. */
  uint32_t reserved;
  const float* weight; /* count x 512, x * 64 + y * 8 + z: the falloff times strength, the largest of all images. */
  /* count x 512: new distances, phi where nothing changes. A value may differ from phi by 1.5 voxels, no more counts. A
   * value that is not finite fails the stamp. Values of voxels whose weight is 0 do not count. */
  float* out;
} argil_batch;

typedef struct argil_brush {
  uint32_t size;
  uint32_t flags;                /* ARGIL_LEAVES_..., ARGIL_BRUSH_SERIAL. */
  const char* id;                /* As plugin.json has it. */
  uint32_t margin;               /* Voxels around each brick that bricks() reads: 0, 1, 2 or 4. */
  uint32_t parameter_count;      /* 0 to 8. */
  const char* const* parameters; /* Their ids, as plugin.json has them. */
  /* A stroke begins; what it returns is handed to the calls below. Null fails the stroke, unless `end` is null too.
   * [main] */
  void* (*begin)(const argil_stroke* stroke);
  /* The new distances of some bricks of a stamp. Bricks have nothing to do with one another: what it gives for one
   * follows from that brick, the images and what begin() returned alone, so that any division into batches gives the
   * same; a stamp comes in several. At most 250 ms of processor time a call. [worker] */
  argil_status (*bricks)(void* stroke, const argil_batch* batch);
  /* May be null. [main] */
  void (*end)(void* stroke);
} argil_brush;

/* ------------------------------------------------------------------------------------------------------------------
 * Exporters and importers. A file is a row of bytes; a model is objects of triangles, vertices first. All calls [main].
 * Positions are in mm when they go out, in the file's unit (plugin.json says which) when they come in; z is up. A
 * triangle's corners go around counter-clockwise, seen from outside; they count the object's own vertices from 0.
 * Colours are sRGB and alpha, one a vertex. A vertex is 3 doubles, a triangle 3 corners, a colour 4 bytes, one behind
 * the other; `count` counts vertices or triangles. */
#define ARGIL_EXPORTER_1 "argil.exporter/1"
#define ARGIL_IMPORTER_1 "argil.importer/1"

typedef struct argil_object {
  uint32_t size;
  bool has_colours;
  bool reserved[3];
  const char* name; /* May be empty. */
  uint64_t vertex_count, triangle_count;
} argil_object;

typedef struct argil_export {
  uint32_t size;
  uint32_t object_count;
  /* Of a sequence: which file of how many this is, from 0; else 0 of 1. */
  uint32_t frame, frame_count;
  void* self; /* First argument of each function below. */
  /* Appends to the file. False: the disk is full, or the user has asked to stop: return ARGIL_FAILED. */
  bool (*write)(void* self, const void* bytes, uint64_t count);
} argil_export;

typedef struct argil_exporter {
  uint32_t size;
  uint32_t flags; /* 0. */
  const char* id; /* As plugin.json has it. */
  /* One file. For each object: object(), all its vertices, all its triangles, in blocks; then end(). What begin()
   * returns is handed to the calls below; null fails, unless `end` is null too. `file` is valid until end() returns.
   * After any failure end() is called once with `complete` false. */
  void* (*begin)(const argil_export* file);
  argil_status (*object)(void* exporter, const argil_object* object);
  argil_status (*vertices)(void* exporter, const double* positions, const uint8_t* colours, uint32_t count);
  argil_status (*triangles)(void* exporter, const uint32_t* corners, uint32_t count);
  argil_status (*end)(void* exporter, bool complete);
} argil_exporter;

typedef struct argil_import {
  uint32_t size;
  uint32_t reserved;
  uint64_t file_bytes;
  void* self; /* First argument of each function below. */
  /* Copies bytes of the file from `offset` on; how many there were. */
  uint64_t (*read)(void* self, uint64_t offset, void* bytes, uint64_t count);
  /* An object, then its vertices and its triangles, as many as announced, in blocks of any size. False: too many, or
   * the user has asked to stop: return ARGIL_FAILED. */
  bool (*object)(void* self, const argil_object* object);
  bool (*vertices)(void* self, const double* positions, const uint8_t* colours, uint32_t count);
  bool (*triangles)(void* self, const uint32_t* corners, uint32_t count);
} argil_import;

typedef struct argil_importer {
  uint32_t size;
  uint32_t flags; /* 0. */
  const char* id; /* As plugin.json has it. */
  argil_status (*run)(const argil_import* file);
} argil_importer;

/* ------------------------------------------------------------------------------------------------------------------
 * Operations on a whole piece, in the background. Bricks as brushes have them; those that hold or touch the surface are
 * numbered from 0 in a fixed order. What is not put() stays. Distances that are put are renewed afterwards: they need
 * be right within a voxel of the surface. All calls [main]; ask cancelled() at least every 100 ms. */
#define ARGIL_OPERATION_1 "argil.operation/1"

typedef struct argil_work {
  uint32_t size;
  float band;
  double voxel_mm, origin_mm[3]; /* As argil_stroke has them. */
  uint64_t brick_count;
  uint32_t parameter_count;
  uint32_t reserved;
  const float* parameters;
  void* self; /* First argument of each function below. */
  /* Bricks `first` to `first + count`, as they were before: 3 coordinates and 512 distances each. How many were given:
   * 4096 at most. */
  uint32_t (*bricks)(void* self, uint64_t first, uint32_t count, int32_t* coords, float* phi);
  /* Any brick, as it was before: where there is none, all of it is `band` or -`band`. */
  void (*brick)(void* self, const int32_t* coord, float* phi);
  /* New distances of some bricks. False: too many, one that is not finite, or the user has asked to stop: return
   * ARGIL_FAILED. */
  bool (*put)(void* self, uint32_t count, const int32_t* coords, const float* phi);
} argil_work;

typedef struct argil_operation {
  uint32_t size;
  uint32_t flags; /* 0. */
  const char* id; /* As plugin.json has it. */
  uint32_t reserved;
  uint32_t parameter_count;      /* 0 to 8. */
  const char* const* parameters; /* Their ids, as plugin.json has them. */
  argil_status (*run)(const argil_work* work);
} argil_operation;

/* ------------------------------------------------------------------------------------------------------------------
 * Guides that are felt. The hand's servo never waits for a plugin: it renders the last model that the plugin gave, up
 * to eight planes and springs near the hand, within the device's limits, and lets it fade when no newer one has come
 * for 20 ms. World mm. */
#define ARGIL_GUIDE_1 "argil.guide/1"

typedef struct argil_hand {
  uint32_t size;
  uint32_t buttons; /* Bit 0: the tool works. */
  double position_mm[3], velocity_mm_s[3];
} argil_hand;

#define ARGIL_ELEMENT_PLANE 0u  /* Pushes out along `normal` where the hand is behind the plane through `place`. */
#define ARGIL_ELEMENT_SPRING 1u /* Draws to `place`, within `range_mm` of it. */

typedef struct argil_element {
  uint32_t kind;
  float stiffness_n_mm; /* No more than half of what the device bears counts. */
  double place_mm[3];
  double normal[3]; /* Of any length but 0. */
  double range_mm;
} argil_element;

typedef struct argil_local_model {
  uint32_t size;
  uint32_t count;      /* 0 to 8. */
  double middle_mm[3]; /* The model holds within `radius_mm` of here: elsewhere nothing is felt. */
  double radius_mm;
  argil_element elements[8];
} argil_local_model;

typedef struct argil_guide {
  uint32_t size;
  uint32_t rate_hz; /* How often update() is to be called: 10 to 1000. */
  const char* id;   /* As plugin.json has it. */
  uint32_t reserved;
  uint32_t parameter_count;      /* 0 to 8. */
  const char* const* parameters; /* Their ids, as plugin.json has them. */
  /* What begin() returns is handed to the calls below. Null fails, unless `end` is null too. [main] */
  void* (*begin)(const float* parameters);
  /* The model near this hand, into `model`, which holds the last one. Anything else than ARGIL_OK: there is none now.
   * [worker, one] */
  argil_status (*update)(void* guide, const argil_hand* hand, argil_local_model* model);
  /* May be null. [main] */
  void (*end)(void* guide);
} argil_guide;

/* ------------------------------------------------------------------------------------------------------------------
 * Textures: heights that a tool presses into the surface, over its tip. */
#define ARGIL_TEXTURE_1 "argil.texture/1"

typedef struct argil_texture {
  uint32_t size;
  uint32_t flags; /* 0. */
  const char* id; /* As plugin.json has it. */
  uint32_t reserved;
  uint32_t parameter_count;      /* 0 to 8. */
  const char* const* parameters; /* Their ids, as plugin.json has them. */
  /* Heights, 0 to 1, of `count` places: u to the right and v upwards, -1 to 1 over the tip. [main] */
  argil_status (*heights)(const float* parameters, const float* u, const float* v, float* height, uint32_t count);
} argil_texture;

/* ------------------------------------------------------------------------------------------------------------------
 * Devices that a hand holds. plugin.json says what one can do (its sheet) and which nodes in /dev it needs: the library
 * may open those, and no other, to read and write, in init() alone; ioctl() works on them. A process is started for the
 * device, and anew, at most ten times a second, after exchange() has failed: so init() fails where nothing is plugged
 * in. Argil limits forces to the sheet, tells zero when it stops, and takes what it reads for what it is: a state that
 * is not finite or out of reach counts as none. */
#define ARGIL_DEVICE_1 "argil.device/1"

typedef struct argil_device_state {
  uint32_t size;
  uint32_t buttons; /* Bit a button. */
  float pressure;   /* 0 to 1. */
  uint32_t reserved;
  double position_mm[3]; /* Of the tip, from the middle of its reach: x to the right, y away from the hand, z up. */
  double rotation[4];    /* Of the stylus: x, y, z, w of a quaternion of any length; all 0 where it is not measured. */
} argil_device_state;

typedef struct argil_device {
  uint32_t size;
  uint32_t flags; /* 0. */
  const char* id; /* As plugin.json has it. */
  /* What begin() returns is handed to the calls below. Null fails, unless `end` is null too. [main] */
  void* (*begin)(void);
  /* Sends a force, N, axes as above, and reads the state into `state`; may wait for its bus. Called at the rate that
   * plugin.json says; with zero when argil has said nothing for 100 ms. Anything else than ARGIL_OK: it is gone.
   * [worker, one] */
  argil_status (*exchange)(void* device, const double* force_n, argil_device_state* state);
  /* Motors off. May be null. [main] */
  void (*end)(void* device);
} argil_device;

#ifdef __cplusplus
}
#endif
#endif
