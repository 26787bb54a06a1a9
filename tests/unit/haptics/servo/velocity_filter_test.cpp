// The velocity filter: what it passes, how late, and how much of the encoder's steps.

#include "haptics/servo/velocity_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

namespace argil::haptics {
namespace {

struct Response {
  double gain = 0, lagMs = 0;
};

// By a sine of that amplitude and frequency through encoder steps, settled for a second, then one second long.
Response respond(double rateHz, double stepMm, double amplitudeMm, double hz) {
  VelocityFilter filter(1 / rateHz, stepMm);
  const double w = 2 * std::numbers::pi * hz;
  std::complex<double> sum = 0;
  const int second = static_cast<int>(rateHz);
  for (int i = 0; i < 2 * second; ++i) {
    const double t = i / rateHz, x = amplitudeMm * std::sin(w * t + 0.3);
    const double y = filter.add({0, stepMm > 0 ? stepMm * std::nearbyint(x / stepMm) : x, 0}).y();
    if (i >= second) sum += y * std::exp(std::complex<double>(0, -w * t));
  }
  const std::complex<double> g = 2.0 / second * sum / (amplitudeMm * w * std::exp(std::complex<double>(0, 0.3)));
  return {std::abs(g), -std::arg(g) / w * 1e3};
}

// The lowest frequency at which less than 1/√2 comes through.
double cutoffHz(double rateHz, double stepMm, double amplitudeMm) {
  for (double hz = 5; hz < 0.4 * rateHz; hz += 5)
    if (respond(rateHz, stepMm, amplitudeMm, hz).gain < std::numbers::sqrt2 / 2) return hz;
  return 0.4 * rateHz;
}

TEST(VelocityFilter, HasAMeasuredCutOffAndDelay) {
  for (const double rate : {1000.0, 2000.0, 4000.0})
    for (const double step : {0.055, 0.01})
      for (const double amplitude : {0.5, 3.0}) {
        const double cutoff = cutoffHz(rate, step, amplitude);
        const Response slow = respond(rate, step, amplitude, 10), quick = respond(rate, step, amplitude, 30);
        std::printf(
            "%4.0f Hz, step %.3f mm, swing ±%.1f mm: -3 dB at %3.0f Hz; lag %.1f ms at 10 Hz, %.1f ms at 30 Hz\n", rate,
            step, amplitude, cutoff, slow.lagMs, quick.lagMs);
        EXPECT_GE(cutoff, 100) << "a low-pass of 40 Hz was there before";
        EXPECT_LE(cutoff, 250);
        EXPECT_LT(slow.lagMs, 8);
        EXPECT_LT(quick.lagMs, 3.4) << "what a low-pass of 40 Hz lags";
        EXPECT_NEAR(slow.gain, 1, 0.1);
      }
}

TEST(VelocityFilter, MakesLessOfEncoderStepsThanALowPassOf40Hz) {
  for (const double step : {0.055, 0.023, 0.01})
    for (const double speed : {0.0, 0.5, 2.0, 10.0, 50.0}) {
      VelocityFilter filter(1e-3, step);
      double lowPass = 0, last = 0, worst = 0, worstBefore = 0;
      const double smoothing = 1 - std::exp(-2 * std::numbers::pi * 40 * 1e-3);
      for (int i = 0; i < 4000; ++i) {
        const double x = step * std::nearbyint(speed * i * 1e-3 / step);
        lowPass += smoothing * ((x - last) / 1e-3 - lowPass);
        last = x;
        const double v = filter.add({x, 0, 0}).x();
        if (i < 1000) continue;
        worst = std::max(worst, std::abs(v - speed));
        worstBefore = std::max(worstBefore, std::abs(lowPass - speed));
      }
      EXPECT_LE(worst, std::max(0.6 * worstBefore, 1e-9)) << step << " mm, " << speed << " mm/s";
      EXPECT_LE(worst, step / 0.008) << "half of the longest window for one step";
    }
}

TEST(VelocityFilter, BeginsAnew) {
  VelocityFilter filter(1e-3, 0.05);
  EXPECT_EQ(filter.add({1, 2, 3}), Vec3d::Zero());
  EXPECT_GT(filter.add({2, 2, 3}).x(), 100);
  filter.reset();
  EXPECT_EQ(filter.add({50, 2, 3}), Vec3d::Zero()) << "no speed comes from a gap";
}

}  // namespace
}  // namespace argil::haptics
