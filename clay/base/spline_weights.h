#pragma once
// Weights of four even samples at −1, 0, 1 and 2 for a place `t` from 0 to 1: value, slope and bend of cubic splines.

namespace argil::clay {

/// Catmull-Rom: through every sample, once continuously differentiable.
inline void catmullRom(float t, float (&w)[4]) noexcept {
  const float t2 = t * t, t3 = t2 * t;
  w[0] = 0.5f * (-t3 + 2 * t2 - t);
  w[1] = 0.5f * (3 * t3 - 5 * t2 + 2);
  w[2] = 0.5f * (-3 * t3 + 4 * t2 + t);
  w[3] = 0.5f * (t3 - t2);
}

/// Its derivative.
inline void catmullRomSlope(float t, float (&d)[4]) noexcept {
  const float t2 = t * t;
  d[0] = 0.5f * (-3 * t2 + 4 * t - 1);
  d[1] = 0.5f * (9 * t2 - 10 * t);
  d[2] = 0.5f * (-9 * t2 + 8 * t + 1);
  d[3] = 0.5f * (3 * t2 - 2 * t);
}

/// The second derivative, linear between the samples' second differences (as a cubic B-spline's): the derivative of
/// catmullRomSlope() jumps at the samples.
inline void splineBend(float t, float (&b)[4]) noexcept {
  b[0] = 1 - t;
  b[1] = 3 * t - 2;
  b[2] = 1 - 3 * t;
  b[3] = t;
}

}  // namespace argil::clay
