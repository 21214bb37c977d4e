// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/amplitude_dependence.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/synthesize.hpp"
#include "tests/harmonic_inversion/found_modes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace twang {
namespace {

bool says(const InversionResult& result, const std::string& part) {
  return std::any_of(result.notes.begin(), result.notes.end(), [&](const std::string& note) {
    return note.find(part) != std::string::npos;
  });
}

/// q'' = a(q, q') from rest at `start`, by Runge-Kutta in 64 steps a sample, with noise.
Trace move(const std::function<double(double, double)>& acceleration,
           double start,
           double duration_s,
           double noise,
           unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> error(0.0, noise);
  constexpr int kSteps = 64;
  const double h = 1.0 / (kRate_hz * kSteps);
  double q = start;
  double v = 0.0;
  Trace trace;
  trace.channels.push_back({"y_mm", {}});
  for (int i = 0; i / kRate_hz <= duration_s; ++i) {
    trace.time_s.push_back(i / kRate_hz);
    trace.channels[0].values.push_back(q + error(random));
    for (int k = 0; k < kSteps; ++k) {
      const double a1 = acceleration(q, v);
      const double a2 = acceleration(q + 0.5 * h * v, v + 0.5 * h * a1);
      const double v2 = v + 0.5 * h * a1;
      const double a3 = acceleration(q + 0.5 * h * v2, v + 0.5 * h * a2);
      const double v3 = v + 0.5 * h * a2;
      const double a4 = acceleration(q + h * v3, v + h * a3);
      q += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v + h * a3);
      v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
  }
  return trace;
}

TEST(AmplitudeDependence, WindowsOfAPureDecayAgreeWithinTheirSigmas) {
  int spoke = 0;
  double squares = 0.0;
  double count = 0.0;
  constexpr int kDraws = 100;
  for (unsigned seed = 1; seed <= kDraws; ++seed) {
    SynthesisOptions options;
    options.noise_sigma = 0.01;
    options.offset = 3.0;
    options.seed = seed;
    const InversionResult result =
        invert_harmonics(synthesize_sinusoids({{20.0, 3.0, 1.0, 0.7}}, options), {"y"});
    ASSERT_EQ(result.modes.size(), 1U);
    ASSERT_GE(result.amplitude_windows.size(), 3U);
    spoke += says(result, "pure exponential") ? 1 : 0;
    for (const AmplitudeWindow& window : result.amplitude_windows) {
      squares += std::pow((window.frequency_hz - 20.0) / window.frequency_sigma_hz, 2);
      squares += std::pow((window.decay_per_s - 3.0) / window.decay_sigma_per_s, 2);
      count += 2.0;
      const double middle = 0.5 * (window.start_s + window.end_s);
      // A fifth for half a sample's doubt about the middle and for noise at the end.
      EXPECT_NEAR(window.amplitude, std::exp(-3.0 * middle), 0.2 * window.amplitude);
    }
  }
  // Two trends at three sigmas are crossed by 0.5 % of the draws; a few more for the sigma's own
  // error.
  EXPECT_LE(spoke, 4);
  EXPECT_NEAR(squares / count, 1.0, 0.15);  // some 1000 squares of mean 1
}

TEST(AmplitudeDependence, HardeningSpringShowsItsFrequencyAgainstAmplitude) {
  // Duffing: w(A) = w0 (1 + 3/8 e A²) to first order in e A², here up to 3 %.
  const double w0 = kTwoPi * 15.0;
  constexpr double kHardening = 0.08;
  const Trace trace =
      move([&](double q, double v) { return -w0 * w0 * (q + kHardening * q * q * q) - 4.0 * v; },
           1.0,
           2.0,
           0.002,
           1);
  const InversionResult result = invert_harmonics(trace, {"y_mm"});
  ASSERT_FALSE(result.modes.empty());
  EXPECT_TRUE(says(result, "it stiffens with amplitude")) << result.message;
  ASSERT_GE(result.amplitude_windows.size(), 4U);
  for (const AmplitudeWindow& window : result.amplitude_windows) {
    const double expected_hz =
        15.0 * (1.0 + 0.375 * kHardening * window.amplitude * window.amplitude);
    // Over a window the amplitude falls, and the next order is (e A²)².
    EXPECT_NEAR(window.frequency_hz, expected_hz, 4.0 * window.frequency_sigma_hz + 0.015)
        << window.amplitude;
  }
}

TEST(AmplitudeDependence, SofteningSpringIsCalledSo) {
  const double w0 = kTwoPi * 15.0;
  const Trace trace =
      move([&](double q, double v) { return -w0 * w0 * (q - 0.08 * q * q * q) - 4.0 * v; },
           1.0,
           2.0,
           0.002,
           2);
  EXPECT_TRUE(says(invert_harmonics(trace, {"y_mm"}), "it softens with amplitude"));
}

TEST(AmplitudeDependence, DryFrictionRaisesTheDecayAtSmallAmplitude) {
  // Friction takes 4 F / (w0² period) off the amplitude a period: d(A) = d0 + 2 F / (pi w0 A).
  const double w0 = kTwoPi * 15.0;
  constexpr double kFriction = 60.0;  // [mm/s²]
  constexpr double kSlow = 1e-3;      // speed within which it is smooth [mm/s]
  const Trace trace = move(
      [&](double q, double v) { return -w0 * w0 * q - 2.0 * v - kFriction * std::tanh(v / kSlow); },
      1.0,
      1.2,
      0.002,
      3);
  const InversionResult result = invert_harmonics(trace, {"y_mm"});
  ASSERT_FALSE(result.modes.empty());
  EXPECT_TRUE(says(result, "as with dry friction")) << result.message;
  ASSERT_GE(result.amplitude_windows.size(), 3U);
  for (const AmplitudeWindow& window : result.amplitude_windows) {
    const double expected = 1.0 + 2.0 * kFriction / (kPi * w0 * window.amplitude);
    // Over a window the amplitude falls by a third.
    EXPECT_NEAR(
        window.decay_per_s, expected, 4.0 * window.decay_sigma_per_s + 0.1 * (expected - 1.0))
        << window.amplitude;
  }
}

TEST(AmplitudeDependence, QuadraticDragRaisesTheDecayAtLargeAmplitude) {
  const double w0 = kTwoPi * 15.0;
  const Trace trace =
      move([&](double q, double v) { return -w0 * w0 * q - 2.0 * v - 0.1 * std::abs(v) * v; },
           1.0,
           2.0,
           0.002,
           4);
  EXPECT_TRUE(says(invert_harmonics(trace, {"y_mm"}), "more at large amplitude"));
}

TEST(AmplitudeDependence, OtherModesAreTakenAway) {
  SynthesisOptions options;
  options.noise_sigma = 0.005;
  const InversionResult result = invert_harmonics(
      synthesize_sinusoids({{20.0, 3.0, 1.0, 0.7}, {27.0, 5.0, 0.5, 0.0}}, options), {"y"});
  ASSERT_EQ(result.modes.size(), 2U);
  EXPECT_FALSE(says(result, "pure exponential"));
  for (const AmplitudeWindow& window : result.amplitude_windows) {
    EXPECT_NEAR(window.frequency_hz, 20.0, 5.0 * window.frequency_sigma_hz);
  }
}

TEST(AmplitudeDependence, ASignalWithoutDecayHasNoWindows) {
  SynthesisOptions options;
  options.noise_sigma = 0.01;
  const InversionResult result =
      invert_harmonics(synthesize_sinusoids({{20.0, 0.0, 1.0, 0.7}}, options), {"y"});
  EXPECT_TRUE(result.amplitude_windows.empty());
}

}  // namespace
}  // namespace twang
