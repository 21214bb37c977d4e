// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/window_stability.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace twang {
namespace {

/// A decay at 240 samples a second whose frequency rises by `stiffening_hz` from full amplitude to
/// none.
Trace decay(double stiffening_hz, double noise, unsigned seed) {
  constexpr double kFrequency_hz = 40.0;
  constexpr double kDecay_per_s = 6.0;
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0.0, noise);
  Trace trace;
  trace.channels.push_back({"y", {}});
  for (int n = 0; n < 240; ++n) {
    const double t = n / 240.0;
    const double amplitude = std::exp(-kDecay_per_s * t);
    // the integral of f + stiffening (1 - amplitude)
    const double cycles =
        kFrequency_hz * t + stiffening_hz * (t - (1.0 - amplitude) / kDecay_per_s);
    trace.time_s.push_back(t);
    trace.channels[0].values.push_back(amplitude * std::sin(kTwoPi * cycles + 0.3) +
                                       normal(generator));
  }
  return trace;
}

WindowStability stability_of(const Trace& trace) {
  InversionOptions options;
  options.start_s = 0.0;
  const InversionResult whole = invert_harmonics(trace, {"y"}, options);
  EXPECT_TRUE(whole.usable()) << whole.message;
  return window_stability(trace, {"y"}, whole, options);
}

TEST(WindowStability, SaysOfATrueDecayWhatItsNoiseExplains) {
  double sum_hz = 0.0;
  constexpr int kDraws = 20;
  for (unsigned seed = 1; seed <= kDraws; ++seed) {
    const WindowStability stability = stability_of(decay(0.0, 0.005, seed));
    EXPECT_GE(stability.windows, 2);
    sum_hz += stability.frequency_spread_hz / kDraws;
  }
  // sigma of f is d/(pi snr sqrt(N_eff)) = 6 / pi * 0.005 / sqrt(20), about 2e-3 Hz; the excess
  // must not dwarf it
  EXPECT_LT(sum_hz, 0.006);
}

TEST(WindowStability, SeesAFrequencyThatDependsOnTheAmplitude) {
  const WindowStability stability = stability_of(decay(0.5, 0.005, 1));
  // 0.35 and 0.7 decay times in, the frequency has risen by a few tenths of the half hertz
  EXPECT_GT(stability.frequency_spread_hz, 0.03);
  EXPECT_LT(stability.frequency_spread_hz, 0.5);
}

TEST(WindowStability, WidensSigmasInQuadrature) {
  DampedSinusoid sinusoid;
  sinusoid.frequency_sigma_hz = 3.0;
  sinusoid.decay_sigma_per_s = 5.0;
  const DampedSinusoid wider = widened(sinusoid, {4.0, 12.0, 2});
  EXPECT_DOUBLE_EQ(wider.frequency_sigma_hz, 5.0);
  EXPECT_DOUBLE_EQ(wider.decay_sigma_per_s, 13.0);
}

}  // namespace
}  // namespace twang
