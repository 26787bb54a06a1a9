#include "clay/kernels/cover_kernels.h"

#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clay/kernels/cover_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace argil::clay::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using PlaceTag = hn::CappedTag<double, kPlaceLanes>;

// Squared distances of the places from `i` on; `places`: x, y and z.
HWY_INLINE hn::Vec<PlaceTag> squaresTo(const double* at, const double* const* places, size_t i) {
  const PlaceTag d;
  const auto x = hn::Sub(hn::LoadU(d, places[0] + i), hn::Set(d, at[0]));
  const auto y = hn::Sub(hn::LoadU(d, places[1] + i), hn::Set(d, at[1]));
  const auto z = hn::Sub(hn::LoadU(d, places[2] + i), hn::Set(d, at[2]));
  return hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
}

double NearestPlace(const double* const* places, size_t count, const double* at) {
  const PlaceTag d;
  auto least = hn::Set(d, std::numeric_limits<double>::infinity());
  for (size_t i = 0; i < count; i += hn::Lanes(d)) least = hn::Min(least, squaresTo(at, places, i));
  return hn::GetLane(hn::MinOfLanes(d, least));
}

// Sums of weights, and of weights times values.
void WeighPlaces(const double* const* places, size_t count, const double* at, double nearest, double blend,
                 double* sums) {
  const PlaceTag d;
  const double root = std::sqrt(nearest), reach = root + blend;
  const auto most = hn::Set(d, reach * reach), from = hn::Set(d, root), over = hn::Set(d, blend);
  const auto one = hn::Set(d, 1), whole = hn::Set(d, kPlaceWeight);
  auto weights = hn::Zero(d), values = hn::Zero(d);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto square = squaresTo(at, places, i);
    const auto counts = hn::Le(square, most);
    if (hn::AllFalse(d, counts)) continue;
    const auto farther = hn::Div(hn::Sub(hn::Sqrt(square), from), over);
    const auto weight = hn::IfThenElseZero(counts, hn::Trunc(hn::Mul(whole, hn::Sub(one, farther))));
    weights = hn::Add(weights, weight);
    values = hn::Add(values, hn::Mul(weight, hn::LoadU(d, places[3] + i)));
  }
  sums[0] = hn::GetLane(hn::SumOfLanes(d, weights));
  sums[1] = hn::GetLane(hn::SumOfLanes(d, values));
}

}  // namespace argil::clay::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace argil::clay {

HWY_EXPORT(NearestPlace);
HWY_EXPORT(WeighPlaces);

namespace {
constexpr double kNever = 1e9;  // No place is so far off, and its square is finite.
}  // namespace

void ValuedPlaces::clear() {
  for (auto* each : {&x_, &y_, &z_, &value_}) each->clear();
  size_ = 0;
}

void ValuedPlaces::add(int x, int y, int z, int value) {
  x_.push_back(x);
  y_.push_back(y);
  z_.push_back(z);
  value_.push_back(value);
  ++size_;
}

void ValuedPlaces::close() {
  const size_t padded = (size_ + kPlaceLanes - 1) / kPlaceLanes * kPlaceLanes;
  for (auto* each : {&x_, &y_, &z_}) each->resize(padded, kNever);
  value_.resize(padded, 0);
}

double ValuedPlaces::nearestSquared(int x, int y, int z) const noexcept {
  const double at[3] = {double(x), double(y), double(z)};
  const double* const places[3] = {x_.data(), y_.data(), z_.data()};
  return HWY_DYNAMIC_DISPATCH(NearestPlace)(places, size_, at);
}

int ValuedPlaces::mean(int x, int y, int z, double nearest, double blend) const noexcept {
  const double at[3] = {double(x), double(y), double(z)};
  const double* const places[4] = {x_.data(), y_.data(), z_.data(), value_.data()};
  double sums[2];
  HWY_DYNAMIC_DISPATCH(WeighPlaces)(places, size_, at, nearest, blend, sums);
  return int((int64_t(sums[1]) + int64_t(sums[0]) / 2) / int64_t(sums[0]));
}

}  // namespace argil::clay
#endif
