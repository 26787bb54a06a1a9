// For plugins in C++17: brushes as classes, over argil_plugin.h. Nothing else is needed; what is not here is done as in
// C.
#ifndef ARGIL_PLUGIN_HPP
#define ARGIL_PLUGIN_HPP

#include <cstddef>
#include <cstring>
#include <exception>
#include <new>

#include "argil_plugin.h"

namespace argil_plugin_cpp {

/// From init() to deinit().
inline const argil_host* host = nullptr;
/// A sentence for the user: the last one before a failure is its reason.
inline void say(const char* sentence) {
  if (host != nullptr) host->say(host->self, sentence);
}

/// A brick of a batch. Voxels are counted from 0 to 7 along each axis; the margin lies before and behind.
class Brick {
 public:
  Brick(const argil_batch& batch, uint32_t n)
      : coord(batch.coords[n]),
        phi_(batch.phi + uint64_t{n} * batch.brick + uint64_t{batch.margin} * (uint64_t{batch.plane} + batch.row + 1)),
        weight_(batch.weight + uint64_t{n} * 512),
        out_(batch.out + uint64_t{n} * 512),
        plane_(batch.plane),
        row_(batch.row) {}

  const int32_t* coord;  ///< In bricks: x, y, z.
  /// The distance as it was, -margin to 7 + margin.
  [[nodiscard]] float phi(int x, int y, int z) const { return phi_[x * plane_ + y * row_ + z]; }
  [[nodiscard]] float weight(int x, int y, int z) const { return weight_[x * 64 + y * 8 + z]; }
  /// What it becomes. Every voxel is to be set.
  float& out(int x, int y, int z) const { return out_[x * 64 + y * 8 + z]; }

 private:
  const float *phi_, *weight_;
  float* out_;
  std::ptrdiff_t plane_, row_;
};

/// What is thrown becomes a status: no exception may leave a call.
template <class Work>
argil_status guarded(const Work& work) {
  try {
    work();
    return ARGIL_OK;
  } catch (const std::bad_alloc&) {
    return ARGIL_NO_MEMORY;
  } catch (const std::exception& error) {
    say(error.what());
  } catch (...) {
    say("it failed for a reason that it does not tell");
  }
  return ARGIL_FAILED;
}

/// A brush whose strokes are objects of `Stroke`, constructed from (const argil_stroke&), called as
/// stroke(const argil_batch&, const Brick&) for each brick, by several threads at once unless `flags` say
/// ARGIL_BRUSH_SERIAL. What it throws fails the stamp; its words are the reason.
template <class Stroke>
constexpr argil_brush brush(const char* id, uint32_t margin, uint32_t flags, const char* const* parameters = nullptr,
                            uint32_t count = 0) {
  argil_brush made{};
  made.size = sizeof made;
  made.flags = flags;
  made.id = id;
  made.margin = margin;
  made.parameter_count = count;
  made.parameters = parameters;
  made.begin = [](const argil_stroke* stroke) -> void* {
    void* object = nullptr;
    (void)guarded([&] { object = new Stroke(*stroke); });
    return object;
  };
  made.bricks = [](void* stroke, const argil_batch* batch) -> argil_status {
    return guarded([&] {
      for (uint32_t n = 0; n < batch->count; ++n) (*static_cast<Stroke*>(stroke))(*batch, Brick(*batch, n));
    });
  };
  made.end = [](void* stroke) { delete static_cast<Stroke*>(stroke); };
  return made;
}

}  // namespace argil_plugin_cpp

/// The entry of a library with these brushes (an array of argil_brush), once in it.
#define ARGIL_PLUGIN_BRUSHES(ID, VERSION, BRUSHES)                                                      \
  extern "C" const argil_plugin* argil_plugin_1(void) {                                                 \
    static const argil_plugin plugin = {                                                                \
        sizeof(argil_plugin),                                                                           \
        ARGIL_PLUGIN_MINOR,                                                                             \
        ID,                                                                                             \
        VERSION,                                                                                        \
        [](const argil_host* host) -> argil_status {                                                    \
          argil_plugin_cpp::host = host;                                                                \
          return ARGIL_OK;                                                                              \
        },                                                                                              \
        [] {},                                                                                          \
        [](const char* kind, uint32_t index) -> const void* {                                           \
          constexpr uint32_t kCount = sizeof(BRUSHES) / sizeof((BRUSHES)[0]);                           \
          return std::strcmp(kind, ARGIL_BRUSH_1) == 0 && index < kCount ? &(BRUSHES)[index] : nullptr; \
        }};                                                                                             \
    return &plugin;                                                                                     \
  }

#endif
