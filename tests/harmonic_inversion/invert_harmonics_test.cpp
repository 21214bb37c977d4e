// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/invert_harmonics.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/synthesize.hpp"
#include "tests/harmonic_inversion/found_modes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace twang {
namespace {

const std::vector<SinusoidTruth> kThree = {
    {17.3, 1.9, 1.0, 0.4}, {44.1, 6.3, 0.3, -2.0}, {91.7, 12.5, 0.05, 1.1}};

TEST(InvertHarmonics, RecoversThreeNoiseFreeSinusoidsToNineDigits) {
  SynthesisOptions options;
  const InversionResult result = invert_harmonics(synthesize_sinusoids(kThree, options), {"y"});
  ASSERT_EQ(result.modes.size(), 3U) << listing(result);
  for (std::size_t k = 0; k < 3; ++k) {
    // 1e-9: round-off of doubles in the samples, 1e-16, over the smallest amplitude, times the
    // condition of the fit; a hundredfold margin.
    EXPECT_NEAR(
        result.modes[k].frequency_hz, kThree[k].frequency_hz, 1e-9 * kThree[k].frequency_hz);
    EXPECT_NEAR(result.modes[k].decay_per_s, kThree[k].decay_per_s, 1e-9 * kThree[k].decay_per_s);
    EXPECT_NEAR(result.modes[k].channels[0].amplitude, kThree[k].amplitude, 1e-9);
    EXPECT_NEAR(result.modes[k].channels[0].phase_rad, kThree[k].phase_rad, 1e-8);
  }
  EXPECT_EQ(result.time_origin_s, 0.0);
  EXPECT_EQ(result.termination, Termination::Converged);
}

TEST(InvertHarmonics, DoesNotDependOnUnitsOrOnTheTimeOfTheFirstSample) {
  SynthesisOptions options;
  options.noise_sigma = 0.001;
  Trace trace = synthesize_sinusoids(kThree, options);
  const InversionResult first = invert_harmonics(trace, {"y"});
  for (double& t : trace.time_s) t += 37.0;
  for (double& y : trace.channels[0].values) y *= 1e-6;
  const InversionResult second = invert_harmonics(trace, {"y"});
  ASSERT_EQ(first.modes.size(), 3U) << listing(first);
  ASSERT_EQ(second.modes.size(), 3U) << listing(second);
  for (std::size_t k = 0; k < 3; ++k) {
    // 1e-8: stamps near 37 s carry 7e-15 s of round-off; the optimizer stops at 1e-14 of the cost,
    // which is 1e-7 of a sigma of about 1e-3 of the value or better.
    EXPECT_NEAR(first.modes[k].frequency_hz,
                second.modes[k].frequency_hz,
                1e-8 * first.modes[k].frequency_hz);
    EXPECT_NEAR(
        first.modes[k].decay_per_s, second.modes[k].decay_per_s, 1e-6 * first.modes[k].decay_per_s);
    EXPECT_NEAR(first.modes[k].channels[0].amplitude * 1e-6,
                second.modes[k].channels[0].amplitude,
                1e-6 * second.modes[k].channels[0].amplitude);
  }
  EXPECT_DOUBLE_EQ(second.time_origin_s, 37.0);
}

TEST(InvertHarmonics, SeparatesTwoModes1Point3HzApart) {
  SynthesisOptions options;
  options.noise_sigma = std::pow(10.0, -50.0 / 20.0);
  const InversionResult result = invert_harmonics(
      synthesize_sinusoids({{30.0, 8.0, 1.0, 0.3}, {31.3, 9.0, 1.0, 1.2}}, options), {"y"});
  ASSERT_EQ(result.modes.size(), 2U) << listing(result);
  const DampedSinusoid* a = nearest(result, 30.0);
  const DampedSinusoid* b = nearest(result, 31.3);
  ASSERT_NE(a, b);
  // Five of the stated sigmas: the seed is fixed, and the sigmas are tested elsewhere.
  EXPECT_NEAR(a->frequency_hz, 30.0, 5.0 * a->frequency_sigma_hz);
  EXPECT_NEAR(b->frequency_hz, 31.3, 5.0 * b->frequency_sigma_hz);
  EXPECT_NEAR(a->decay_per_s, 8.0, 5.0 * a->decay_sigma_per_s);
  EXPECT_NEAR(b->decay_per_s, 9.0, 5.0 * b->decay_sigma_per_s);
  EXPECT_LT(a->frequency_sigma_hz, 0.2);
}

TEST(InvertHarmonics, IsNotBiasedByOffsetDriftGapsAndJitter) {
  int outside = 0;
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    SynthesisOptions options;
    options.noise_sigma = 0.01;
    options.offset = -3.0;
    options.drift_per_s = 0.4;
    options.jitter_s = 0.8e-3;
    options.missing_part = 0.15;
    options.seed = seed;
    const InversionResult result =
        invert_harmonics(synthesize_sinusoids({{20.0, 3.0, 1.0, 0.8}}, options), {"y"});
    ASSERT_EQ(result.modes.size(), 1U) << listing(result);
    const DampedSinusoid& mode = result.modes.front();
    outside += std::abs(mode.frequency_hz - 20.0) > 2.0 * mode.frequency_sigma_hz ? 1 : 0;
    outside += std::abs(mode.decay_per_s - 3.0) > 2.0 * mode.decay_sigma_per_s ? 1 : 0;
    EXPECT_NEAR(result.drifts_per_s.front(), 0.4, 0.01);  // sigma 0.01 / (0.58 s sqrt(400)) = 8e-4
    EXPECT_NEAR(result.offsets.front(), -3.0, 0.01);
  }
  EXPECT_LE(outside, 4);  // of 20, with 1 expected: 5 or more have a chance of 0.3 %
}

TEST(InvertHarmonics, LeavesWildSamplesOut) {
  SynthesisOptions options;
  options.noise_sigma = 0.01;
  Trace trace = synthesize_sinusoids({{20.0, 3.0, 1.0, 0.8}}, options);
  for (const std::size_t i : {50U, 123U, 300U}) trace.channels[0].values[i] += 5.0;
  const InversionResult result = invert_harmonics(trace, {"y"});
  ASSERT_EQ(result.modes.size(), 1U) << listing(result);
  const DampedSinusoid& mode = result.modes.front();
  EXPECT_NEAR(mode.frequency_hz, 20.0, 3.0 * mode.frequency_sigma_hz);
  EXPECT_NEAR(mode.decay_per_s, 3.0, 3.0 * mode.decay_sigma_per_s);
  EXPECT_LT(mode.decay_sigma_per_s, 0.05);  // without the wild samples; with them it would be 0.5
  ASSERT_EQ(result.notes.size(), 1U);
  EXPECT_NE(result.notes[0].find("3 samples far off the model took no part"), std::string::npos)
      << result.notes[0];
  EXPECT_EQ(result.num_samples, 478);
}

TEST(InvertHarmonics, AlwaysFindsAModeOfTwentySigma) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    SynthesisOptions options;
    options.noise_sigma = 0.05;
    options.seed = seed;
    const double omega0 = kTwoPi * 25.0;
    const InversionResult result =
        invert_harmonics(synthesize_sinusoids({{25.0, 0.05 * omega0, 1.0, 2.0}}, options), {"y"});
    ASSERT_GE(result.modes.size(), 1U) << "seed " << seed << "\n" << listing(result);
    // 0.5 Hz: ten times the Cramer-Rao bound at 20 sigma.
    EXPECT_NEAR(result.modes.front().frequency_hz, 25.0, 0.5);
  }
}

TEST(InvertHarmonics, GivesASteadyToneADecayOfZeroWithinItsSigma) {
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    SynthesisOptions options;
    options.noise_sigma = 0.02;
    options.seed = seed;
    const InversionResult result =
        invert_harmonics(synthesize_sinusoids({{33.0, 0.0, 1.0, 0.8}}, options), {"y"});
    ASSERT_EQ(result.modes.size(), 1U) << listing(result);
    EXPECT_GE(result.modes[0].decay_per_s, 0.0);
    EXPECT_LE(result.modes[0].decay_per_s, 4.0 * result.modes[0].decay_sigma_per_s);
    EXPECT_GT(result.modes[0].decay_sigma_per_s, 0.0);
  }
}

TEST(InvertHarmonics, NamesTheTwinOfAModeNearNyquist) {
  SynthesisOptions options;
  options.noise_sigma = 0.01;
  const InversionResult result =
      invert_harmonics(synthesize_sinusoids({{104.0, 3.0, 1.0, 0.8}}, options), {"y"});
  ASSERT_EQ(result.modes.size(), 1U) << listing(result);
  ASSERT_EQ(result.notes.size(), 1U);
  EXPECT_NE(result.notes[0].find("136 Hz"), std::string::npos) << result.notes[0];
}

TEST(InvertHarmonics, EvaluatesItsModelAndItsRate) {
  const InversionResult result = invert_harmonics(synthesize_sinusoids(kThree), {"y"});
  const Trace trace = synthesize_sinusoids(kThree);
  for (const std::size_t i : {0U, 17U, 300U}) {
    EXPECT_NEAR(result.evaluate(0, trace.time_s[i]), trace.channels[0].values[i], 1e-9);
  }
  const double h = 1e-5;
  const double slope = (result.evaluate(0, 0.1 + h) - result.evaluate(0, 0.1 - h)) / (2.0 * h);
  EXPECT_NEAR(result.evaluate_rate(0, 0.1), slope, 1e-4 * std::abs(slope));  // h² w² / 6 = 1e-6
}

TEST(InvertHarmonics, KeepsTheStrongestWhenAskedForFewer) {
  SynthesisOptions options;
  options.noise_sigma = 1e-4;
  InversionOptions inversion;
  inversion.max_modes = 2;
  const InversionResult result =
      invert_harmonics(synthesize_sinusoids(kThree, options), {"y"}, inversion);
  ASSERT_EQ(result.modes.size(), 2U);
  EXPECT_NEAR(result.modes[0].frequency_hz, 17.3, 1e-3);
  EXPECT_NEAR(result.modes[1].frequency_hz, 44.1, 1e-2);
  ASSERT_EQ(result.rejected.size(), 1U);
  EXPECT_NEAR(result.rejected[0].frequency_hz, 91.7, 0.1);
  // The third mode, amplitude 0.05, stands in the residual: 0.05 / sqrt(2 * 2 * 12.5 * 2).
  EXPECT_NEAR(result.residual_rms, 0.05 / std::sqrt(100.0), 1e-3);
}

TEST(InvertHarmonics, LooksOnlyInsideTheBandAndTheWindow) {
  InversionOptions inversion;
  inversion.band_hz = Band{30.0, 60.0};
  const InversionResult result = invert_harmonics(synthesize_sinusoids(kThree), {"y"}, inversion);
  for (const DampedSinusoid& mode : result.modes) {
    EXPECT_GE(mode.frequency_hz, 30.0);
    EXPECT_LE(mode.frequency_hz, 60.0);
  }
  ASSERT_NE(nearest(result, 44.1), nullptr) << listing(result);
  EXPECT_NEAR(nearest(result, 44.1)->frequency_hz, 44.1, 1e-6);
  inversion = {};
  inversion.start_s = 0.5;
  inversion.end_s = 1.5;
  const InversionResult cut = invert_harmonics(synthesize_sinusoids(kThree), {"y"}, inversion);
  EXPECT_GE(cut.time_origin_s, 0.5);
  EXPECT_LT(cut.time_origin_s, 0.5 + 1.0 / 240.0);
  EXPECT_LE(cut.time_end_s, 1.5);
  EXPECT_NEAR(cut.modes.at(0).channels[0].amplitude, std::exp(-1.9 * cut.time_origin_s), 1e-8);
}

TEST(InvertHarmonics, StopsWhenTheCallbackAsksForIt) {
  InversionOptions options;
  options.progress = [](const Progress&) { return false; };
  EXPECT_THROW(static_cast<void>(invert_harmonics(synthesize_sinusoids(kThree), {"y"}, options)),
               Cancelled);
}

}  // namespace
}  // namespace twang
