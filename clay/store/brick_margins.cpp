#include "clay/store/brick_margins.h"

#include <algorithm>
#include <cstring>

namespace argil::clay {
namespace {

// What stands at one of the bricks around: one of the two, or neither where it is the same all over.
struct Source {
  const float* values = nullptr;
  const int16_t* codes = nullptr;
  float unit = 0;  // a code's step, or the value
};

Source sourceOf(Sampler& field, Coord coord) noexcept {
  const Slot slot = field.slot(coord);
  if (slot.isTile()) return {.unit = slot.phi(0, field.band())};
  if (field.step() == 0) return {.values = static_cast<const FloatBrick*>(slot.brick())->value};
  return {.codes = static_cast<const FixedBrick*>(slot.brick())->code, .unit = field.step()};
}

// Rows of `length` voxels from `first` on, xs slices of ys rows. Lengths known to the compiler are what makes gathering
// quick: rows copied by calls took most of a smoothing stamp.
template <int length, int slice, int row>
void copyBox(const Source from, const int first, const int xs, const int ys, float* to) noexcept {
  const auto rows = [=](const auto& copy) {
    for (int x = 0; x < xs; ++x)
      for (int y = 0; y < ys; ++y) copy(first + Brick::offset(x, y, 0), to + x * slice + y * row);
  };
  if (from.values)
    rows([values = from.values](int at, float* out) { std::memcpy(out, values + at, length * sizeof(float)); });
  else if (from.codes)
    rows([codes = from.codes, step = from.unit](int at, float* out) {
      for (int z = 0; z < length; ++z) out[z] = static_cast<float>(codes[at + z]) * step;
    });
  else
    rows([value = from.unit](int, float* out) { std::fill_n(out, length, value); });
}

// `own`: the index of the brick's first voxel along each axis of the layout.
template <int margin, int own, int slice, int row>
void gather(Sampler& field, Coord coord, float* out, const float* const* instead) noexcept {
  struct Span {
    int first, count, to;
  };
  constexpr Span kSpans[3] = {
      {kBrickEdge - margin, margin, own - margin}, {0, kBrickEdge, own}, {0, margin, own + kBrickEdge}};
  for (size_t i = 0; i < kBricksAround; ++i) {
    const Source from = instead && instead[i] ? Source{.values = instead[i]} : sourceOf(field, coord + kAroundSteps[i]);
    const Span &x = kSpans[i / 9], &y = kSpans[i / 3 % 3], &z = kSpans[i % 3];
    float* to = out + x.to * slice + y.to * row + z.to;
    const int first = Brick::offset(x.first, y.first, z.first);
    if (i % 3 == 1)
      copyBox<kBrickEdge, slice, row>(from, first, x.count, y.count, to);
    else
      copyBox<margin, slice, row>(from, first, x.count, y.count, to);
  }
}

}  // namespace

void gatherPadded(Sampler& field, Coord coord, float* padded) noexcept {
  gather<1, 1, 10 * kPaddedRow, kPaddedRow>(field, coord, padded, nullptr);
}

void gatherBroad(Sampler& field, Coord coord, int margin, float* broad, const float* const* instead) noexcept {
  constexpr int kSlice = 16 * kBroadRow;
  if (margin == 1)
    gather<1, 4, kSlice, kBroadRow>(field, coord, broad, instead);
  else if (margin == 2)
    gather<2, 4, kSlice, kBroadRow>(field, coord, broad, instead);
  else if (margin == 3)
    gather<3, 4, kSlice, kBroadRow>(field, coord, broad, instead);
  else
    gather<4, 4, kSlice, kBroadRow>(field, coord, broad, instead);
}

}  // namespace argil::clay
