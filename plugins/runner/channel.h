#pragma once
// What argil and argil-plugin share: a file without a name, mapped by both. Argil asks, the other answers; neither
// believes the other. Layout of one build: both programs are installed together.

#include <atomic>
#include <cstdint>

#include "plugins/runner/shared_value.h"
#include "plugins/sdk/argil_plugin.h"

namespace argil::plugin {

inline constexpr uint64_t kChannelMagic = 0x31474c5050475241;  // of this layout
inline constexpr uint32_t kMostText = 512;                     // of a sentence, an id, a version
inline constexpr uint32_t kMostParameters = 8, kMostImages = 64;
inline constexpr uint32_t kMostThreads = 8;
/// Behind the Channel, for what is worked on.
inline constexpr uint64_t kWindowBytes = uint64_t{64} << 20;
/// Descriptors that argil-plugin is started with: the pipe that ends with argil, the channel.
inline constexpr int kLifeFd = 0, kChannelFd = 3;

enum class Command : uint32_t {
  none,
  describe,  ///< Channel::kind and thing: flags, margin, parameters.
  beginStroke,
  bricks,
  endStroke,
  beginExport,
  exportObject,
  exportVertices,
  exportTriangles,
  endExport,  ///< count: whether all was there.
  import,
  operate,
  beginGuide,
  endGuide,
  texture,  ///< count: places in the window, u, v and heights behind each other.
  beginDevice,
  endDevice,
};
enum class ThingKind : uint32_t { brush, exporter, importer, operation, guide, texture, device };

/// What argil-plugin asks for while it does what it was asked: it answers with kAsking, and the next question is the
/// answer.
enum class Upcall : uint32_t {
  none,
  write,      ///< count bytes at the window's beginning.
  read,       ///< count bytes from first on: to the window's beginning; result: how many.
  object,     ///< object.
  vertices,   ///< count, at the window's beginning; first: whether colours stand behind them.
  triangles,  ///< count.
  bricks,     ///< count from first on: coordinates, then distances; result: how many.
  brick,      ///< At coord: distances.
  put,        ///< count: coordinates, then distances.
};
inline constexpr int32_t kAsking = 1000;  ///< Channel::status.
/// Elements of an upcall, or of a block that is exported, at most.
inline constexpr uint32_t kMostElements = 65536, kMostBricks = 4096;
inline constexpr uint64_t kMostBytesAtOnce = uint64_t{8} << 20;

/// How far argil-plugin came before it answered for the first time.
enum class Stage : uint32_t {
  starting,
  confining,
  loading,   ///< In dlopen(): the library's constructors.
  entering,  ///< In argil_plugin_1() or init().
  ready,
};

/// Why it could not begin; Channel::text says the rest.
enum class Refusal : uint32_t {
  none,
  cannotLoad,   ///< dlopen() failed.
  noEntry,      ///< It does not export argil_plugin_1.
  nothing,      ///< argil_plugin_1() gave nothing, or a struct without what this version needs.
  initFailed,   ///< init() failed.
  unknownThing  ///< It has nothing of the kind and id that was asked for.
};

struct BatchPlace {
  uint32_t count = 0, margin = 0;
  uint32_t brick = 0, plane = 0, row = 0;  ///< Floats.
  // Bytes from the window's beginning.
  uint64_t coords = 0, phi = 0, weight = 0, out = 0;
};

struct Channel {
  uint64_t magic;
  // Count questions and answers: words that the other side sleeps on.
  std::atomic<uint32_t> asked, answered;
  std::atomic<uint32_t> cancel;  ///< Not zero: stop.
  std::atomic<uint32_t> stage;
  std::atomic<uint32_t> refusedCall;   ///< 1 + the number of the first system call that was refused; 0: none was.
  std::atomic<uint32_t> unconfined;    ///< Bits: 1: files are not confined, 2: system calls are not.
  std::atomic<uint64_t> progressBits;  ///< A double.
  Command command;
  int32_t status;
  Refusal refusal;
  char text[kMostText];  ///< The last sentence.
  char id[kMostText], version[kMostText];

  // Of the thing that is asked for.
  ThingKind kind;
  char thing[kMostText];
  uint32_t flags, margin, parameterCount;
  char parameterIds[kMostParameters][kMostText];

  argil_stroke stroke;  ///< Its pointer is set by the other side.
  float parameters[kMostParameters];
  uint32_t imageCount;
  argil_image images[kMostImages];
  BatchPlace batch;
  // Bricks of the batch that are in the window already, from the first on: it is worked on while it is filled. And how
  // many threads sleep until there are more.
  alignas(64) std::atomic<uint32_t> filled;
  std::atomic<uint32_t> sleepers;

  // Files and operations.
  Upcall upcall;
  uint64_t first, count, result;
  int32_t coord[3];
  uint32_t frame, frameCount, objectCount;
  uint64_t fileBytes;
  struct Object {
    uint64_t vertices, triangles;
    uint32_t colours;
    char name[kMostText];
  } object;

  // A felt guide at work.
  alignas(64) SharedValue<argil_hand> hand;
  alignas(64) SharedValue<argil_local_model> model;

  // A device at work: argil counts `turn` up with each force, the other side answers with a state of the same turn.
  alignas(64) std::atomic<uint32_t> turn;
  SharedValue<std::array<double, 3>> force;
  alignas(64) std::atomic<uint32_t> turned;
  struct DeviceSaid {
    uint32_t turn;
    argil_status status;
    argil_device_state state;
  };
  SharedValue<DeviceSaid> said;
};
static_assert(std::atomic<uint32_t>::is_always_lock_free && std::atomic<uint64_t>::is_always_lock_free);

inline constexpr uint64_t kWindowAt = (sizeof(Channel) + 4095) / 4096 * 4096;
inline constexpr uint64_t kChannelBytes = kWindowAt + kWindowBytes;

}  // namespace argil::plugin
