// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/release.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/synthesize.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace twang {
namespace {

FreeMotion motion_of_first(const Trace& trace) {
  return find_free_motion(
      trace, {trace.channels[0].name}, trace.time_s.front(), trace.time_s.back());
}

/// A quarter turn of the sine: released at rest from its largest deflection.
SinusoidTruth let_go(double frequency_hz, double decay_per_s) {
  return {frequency_hz, decay_per_s, 5.0, 0.5 * kPi};
}

class HeldThenReleased : public testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(HeldThenReleased, IsFoundAndInvertedWithoutBias) {
  const auto [frequency_hz, noise] = GetParam();
  SynthesisOptions options;
  options.held_s = 0.1;
  options.noise_sigma = noise;
  options.offset = 2.0;
  const Trace trace = synthesize_sinusoids({let_go(frequency_hz, 4.0)}, options);
  const FreeMotion motion = motion_of_first(trace);
  ASSERT_TRUE(motion.release_s.has_value());
  const double quarter = 0.25 / frequency_hz;
  EXPECT_NEAR(*motion.release_s, 0.1, 0.5 * quarter + 2.0 / 240.0);
  EXPECT_GE(motion.start_s, 0.1);
  EXPECT_LE(motion.start_s, 0.1 + 2.0 * quarter + 2.0 / 240.0);
  EXPECT_FALSE(motion.ends_early);
  const InversionResult result = invert_harmonics(trace, {"y"});
  ASSERT_EQ(result.modes.size(), 1U) << result.message;
  EXPECT_EQ(result.release_s, motion.release_s);
  // Four of the stated sigmas; the held samples, were they taken in, would shift d by 0.1 and more.
  EXPECT_NEAR(result.modes[0].frequency_hz, frequency_hz, 4.0 * result.modes[0].frequency_sigma_hz);
  EXPECT_NEAR(result.modes[0].decay_per_s, 4.0, 4.0 * result.modes[0].decay_sigma_per_s);
}

INSTANTIATE_TEST_SUITE_P(FrequenciesAndNoise,
                         HeldThenReleased,
                         testing::Combine(testing::Values(6.0, 20.0, 47.0),
                                          testing::Values(0.001, 0.02, 0.1)));

TEST(FreeMotion, BeginsWithARecordThatMovesFreelyFromTheFirstSample) {
  for (const double phase : {0.0, 0.5, 1.5708, 3.0, -1.0}) {
    for (const double frequency_hz : {3.0, 20.0, 60.0}) {
      SynthesisOptions options;
      options.noise_sigma = 0.001;
      const FreeMotion motion =
          motion_of_first(synthesize_sinusoids({{frequency_hz, 4.0, 1.0, phase}}, options));
      EXPECT_FALSE(motion.release_s.has_value()) << frequency_hz << " Hz, phase " << phase;
      EXPECT_EQ(motion.start_s, 0.0);
      EXPECT_EQ(motion.end_s, 2.0);
    }
  }
}

TEST(FreeMotion, BeginsAtTheReleaseThoughTwoModesAreExcited) {
  SynthesisOptions options;
  options.held_s = 0.15;
  options.noise_sigma = 0.01;
  const Trace trace =
      synthesize_sinusoids({let_go(20.0, 4.0), {71.0, 9.0, 1.0, 0.5 * kPi}}, options);
  const FreeMotion motion = motion_of_first(trace);
  ASSERT_TRUE(motion.release_s.has_value());
  EXPECT_NEAR(*motion.release_s, 0.15, 2.0 / 240.0);
  const InversionResult result = invert_harmonics(trace, {"y"});
  ASSERT_EQ(result.modes.size(), 2U);
  EXPECT_NEAR(result.modes[0].decay_per_s, 4.0, 4.0 * result.modes[0].decay_sigma_per_s);
}

/// Rest, a slow pull of a second, release at 1.5 s; and the same again from 3.5 s on.
Trace pulled_twice() {
  SynthesisOptions options;
  options.duration_s = 7.0;
  options.noise_sigma = 0.01;
  Trace trace = synthesize_sinusoids({}, options);
  for (std::size_t i = 0; i < trace.num_samples(); ++i) {
    const double t = std::fmod(trace.time_s[i], 3.5);
    double& y = trace.channels[0].values[i];
    if (t >= 0.5 && t < 1.5) y += 5.0 * (t - 0.5);
    if (t >= 1.5) y += 5.0 * std::exp(-5.0 * (t - 1.5)) * std::cos(kTwoPi * 12.0 * (t - 1.5));
  }
  return trace;
}

TEST(FreeMotion, EndsBeforeTheNextPull) {
  const FreeMotion motion = motion_of_first(pulled_twice());
  ASSERT_TRUE(motion.release_s.has_value());
  EXPECT_NEAR(*motion.release_s, 1.5, 3.0 / 240.0);
  EXPECT_TRUE(motion.ends_early);
  EXPECT_GT(motion.end_s, 3.0);
  EXPECT_LE(motion.end_s, 4.03);  // the pull begins at 4.0 s and has moved by 0.15 of 5 then
  EXPECT_FALSE(motion.note.empty());
}

TEST(FreeMotion, GivenAStartBeforeASecondReleaseBeginsAfterIt) {
  InversionOptions options;
  options.start_s = 4.2;  // in the second pull
  const InversionResult result = invert_harmonics(pulled_twice(), {"y"}, options);
  ASSERT_TRUE(result.release_s.has_value());
  EXPECT_NEAR(*result.release_s, 5.0, 3.0 / 240.0);
  ASSERT_EQ(result.modes.size(), 1U);
  EXPECT_NEAR(result.modes[0].frequency_hz, 12.0, 4.0 * result.modes[0].frequency_sigma_hz);
  EXPECT_NEAR(result.modes[0].decay_per_s, 5.0, 4.0 * result.modes[0].decay_sigma_per_s);
  options.start_s = 1.7;  // in free motion: taken as given
  const InversionResult inside = invert_harmonics(pulled_twice(), {"y"}, options);
  EXPECT_NEAR(inside.time_origin_s, 1.7, 0.5 / 240.0);
  EXPECT_LT(inside.time_end_s, 4.03);
}

TEST(FreeMotion, EndsWhereTheNextPullBeginsThoughTheEndGivenIsLater) {
  for (const std::optional<double> start_s : {std::optional<double>(), std::optional(1.7)}) {
    for (const double end_s : {4.3, 4.6, 4.95}) {  // in the pull, which begins at 4.0 s
      InversionOptions options;
      options.start_s = start_s;
      options.end_s = end_s;
      const InversionResult result = invert_harmonics(pulled_twice(), {"y"}, options);
      EXPECT_GT(result.time_end_s, 3.0) << end_s;
      EXPECT_LE(result.time_end_s, 4.03) << end_s;
      ASSERT_EQ(result.modes.size(), 1U) << end_s << ": " << result.message;
      EXPECT_NEAR(result.modes[0].frequency_hz, 12.0, 4.0 * result.modes[0].frequency_sigma_hz);
      EXPECT_NEAR(result.modes[0].decay_per_s, 5.0, 4.0 * result.modes[0].decay_sigma_per_s);
      ASSERT_EQ(result.remarks.size(), 1U);
      EXPECT_NE(result.remarks[0].find(start_s ? "where the next pull begins" : "before the next"),
                std::string::npos)
          << result.remarks[0];
    }
  }
}

TEST(FreeMotion, EndsBeforeAPullInWhichTheRecordEnds) {
  Trace trace = pulled_twice();
  const auto kept = std::lower_bound(trace.time_s.begin(), trace.time_s.end(), 4.95);
  const auto count = static_cast<std::size_t>(kept - trace.time_s.begin());
  trace.time_s.resize(count);
  trace.channels[0].values.resize(count);
  const FreeMotion motion = motion_of_first(trace);
  EXPECT_TRUE(motion.ends_early);
  EXPECT_GT(motion.end_s, 3.0);
  EXPECT_LE(motion.end_s, 4.03);
}

TEST(FreeMotion, IsNotCutByADrift) {
  SynthesisOptions options;
  options.held_s = 0.5;
  options.duration_s = 5.0;
  options.noise_sigma = 0.01;
  options.drift_per_s = 0.4;  // by two amplitudes in all
  const FreeMotion motion = motion_of_first(synthesize_sinusoids({{12.0, 3.0, 1.0, 1.5}}, options));
  EXPECT_FALSE(motion.ends_early) << motion.note;
}

TEST(FreeMotion, TakesAnEndBeforeTheNextPullAsGiven) {
  InversionOptions options;
  options.end_s = 2.6;
  EXPECT_NEAR(invert_harmonics(pulled_twice(), {"y"}, options).time_end_s, 2.6, 0.5 / 240.0);
}

TEST(FreeMotion, PassesOverGlitchesWhileHeld) {
  SynthesisOptions options;
  options.held_s = 0.3;
  options.noise_sigma = 0.01;
  Trace trace = synthesize_sinusoids({let_go(15.0, 4.0)}, options);
  trace.channels[0].values[20] += 4.0;
  trace.channels[0].values[45] -= 3.0;
  const FreeMotion motion = motion_of_first(trace);
  ASSERT_TRUE(motion.release_s.has_value());
  EXPECT_NEAR(*motion.release_s, 0.3, 4.0 / 240.0);
}

TEST(FreeMotion, SeesNoReleaseInAConstantOrAStep) {
  Trace trace;
  trace.channels = {{"y", {}}};
  for (int i = 0; i < 200; ++i) {
    trace.time_s.push_back(i / 240.0);
    trace.channels[0].values.push_back(1.0);
  }
  EXPECT_FALSE(motion_of_first(trace).release_s.has_value());
  for (std::size_t i = 100; i < 200; ++i) trace.channels[0].values[i] = 2.0;
  EXPECT_FALSE(motion_of_first(trace).release_s.has_value());
}

}  // namespace
}  // namespace twang
