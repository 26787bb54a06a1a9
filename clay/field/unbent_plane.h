#pragma once
// From means of a field back to distances.

#include "clay/kernels/smoothing_kernels.h"

namespace argil::clay {

/// What a mean of a field that ends at its band says of a distance: it is nearer to zero than what it is the mean of,
/// the more the farther from the surface. Exact for planes.
class UnbentPlane {
 public:
  /// `mean(d)`: that of a plane's field at the distance d from 0 to `band`; it grows with d.
  template <class Mean>
  UnbentPlane(const Mean& mean, float band) {
    const double end = mean(static_cast<double>(band));
    scale_ = static_cast<float>(kBendSteps / end);
    double low = 0;
    for (int i = 0; i < kBendSteps; ++i) {
      double high = band;
      for (int k = 0; k < 40; ++k) {
        const double middle = (low + high) / 2;
        (mean(middle) < end * i / kBendSteps ? low : high) = middle;
      }
      table_[i] = static_cast<float>(low);
    }
    table_[kBendSteps] = table_[kBendSteps + 1] = band;
  }
  /// Of a brick's 512 means.
  void distances(float* means) const { bendValues(table_, scale_, means); }

 private:
  float scale_ = 0;
  float table_[kBendSteps + 2] = {};
};

}  // namespace argil::clay
