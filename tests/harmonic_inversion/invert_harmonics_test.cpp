// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/invert_harmonics.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/synthesize.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace twang {
namespace {

const std::vector<SinusoidTruth> kThree = {
    {17.3, 1.9, 1.0, 0.4}, {44.1, 6.3, 0.3, -2.0}, {91.7, 12.5, 0.05, 1.1}};

const DampedSinusoid* nearest(const InversionResult& result, double frequency_hz) {
  const auto it =
      std::min_element(result.modes.begin(), result.modes.end(), [&](const auto& a, const auto& b) {
        return std::abs(a.frequency_hz - frequency_hz) < std::abs(b.frequency_hz - frequency_hz);
      });
  return it == result.modes.end() ? nullptr : &*it;
}

std::string listing(const InversionResult& result) {
  std::string out = result.message + "\n" + result.method + "\n";
  for (const auto& m : result.modes) {
    out += "  mode " + std::to_string(m.frequency_hz) + " Hz " + std::to_string(m.decay_per_s) +
           " 1/s\n";
  }
  for (const auto& m : result.rejected) {
    out += "  rejected " + std::to_string(m.frequency_hz) + " Hz: " + m.reason + "\n";
  }
  return out;
}

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

class HeavyDamping : public testing::TestWithParam<double> {};

TEST_P(HeavyDamping, IsFoundUnderTwoVisiblePeriods) {
  const double zeta = GetParam();
  const double omega0 = kTwoPi * 12.0;
  const SinusoidTruth truth{12.0 * std::sqrt(1.0 - zeta * zeta), zeta * omega0, 1.0, 1.3};
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    SynthesisOptions options;
    options.noise_sigma = 0.01;
    options.duration_s = 1.0;
    options.offset = 0.7;
    options.seed = seed;
    const InversionResult result = invert_harmonics(synthesize_sinusoids({truth}, options), {"y"});
    ASSERT_EQ(result.modes.size(), 1U) << "zeta " << zeta << "\n" << listing(result);
    const DampedSinusoid& mode = result.modes.front();
    // Four sigma of either: 5 seeds and 5 damping ratios leave a chance of 1 in 300.
    EXPECT_NEAR(mode.frequency_hz, truth.frequency_hz, 4.0 * mode.frequency_sigma_hz);
    EXPECT_NEAR(mode.decay_per_s, truth.decay_per_s, 4.0 * mode.decay_sigma_per_s);
    EXPECT_LT(mode.decay_sigma_per_s, 0.1 * truth.decay_per_s);
  }
}

INSTANTIATE_TEST_SUITE_P(DampingRatios, HeavyDamping, testing::Values(0.2, 0.3, 0.4, 0.5, 0.6));

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

TEST(InvertHarmonics, MakesNoModeOfAConstantOrAStraightLine) {
  Trace trace;
  trace.channels = {{"constant", {}}, {"line", {}}};
  for (int i = 0; i < 300; ++i) {
    trace.time_s.push_back(i / 240.0);
    trace.channels[0].values.push_back(0.1);
    trace.channels[1].values.push_back(0.1 + 0.3 * i);
  }
  for (const char* name : {"constant", "line"}) {
    const InversionResult result = invert_harmonics(trace, {name});
    EXPECT_TRUE(result.modes.empty()) << name << "\n" << listing(result);
    EXPECT_FALSE(result.usable());
    EXPECT_NE(result.message.find("no mode"), std::string::npos);
  }
}

TEST(InvertHarmonics, MakesNoModeOfASlowlyBendingBaseline) {
  SynthesisOptions options;
  options.noise_sigma = 0.002;
  Trace trace = synthesize_sinusoids({{20.0, 3.0, 1.0, 0.8}}, options);
  for (std::size_t i = 0; i < trace.num_samples(); ++i) {
    const double t = trace.time_s[i];
    trace.channels[0].values[i] += 0.05 * std::exp(-t / 0.7) + 0.02 * t * t;
  }
  const InversionResult result = invert_harmonics(trace, {"y"});
  ASSERT_EQ(result.modes.size(), 1U) << listing(result);
  EXPECT_NEAR(result.modes.front().frequency_hz, 20.0, 0.01);
}

/// One mode, 3 % softer and 10 % more damped at full amplitude than at small, as rubber is.
InversionResult invert_rubber(double noise_sigma) {
  SynthesisOptions options;
  options.noise_sigma = noise_sigma;
  Trace trace = synthesize_sinusoids({}, options);
  double amplitude = 1.0;
  double phase = 0.5;
  for (double& y : trace.channels[0].values) {
    y += amplitude * std::sin(phase);
    phase += kTwoPi * 20.0 * (1.0 - 0.03 * amplitude) / 240.0;
    amplitude *= std::exp(-4.0 * (1.0 + 0.1 * amplitude) / 240.0);
  }
  return invert_harmonics(trace, {"y"});
}

TEST(InvertHarmonics, MakesOneModeOfOneThatChangesWithAmplitude) {
  const InversionResult result = invert_rubber(0.02);
  ASSERT_EQ(result.modes.size(), 1U) << listing(result);
  EXPECT_NEAR(result.modes[0].frequency_hz, 19.7, 0.3);  // between 19.4 and 20
  EXPECT_NEAR(result.modes[0].decay_per_s, 4.2, 0.3);    // between 4.0 and 4.4
  EXPECT_FALSE(result.rejected.empty());
}

TEST(InvertHarmonics, SaysThatOverlappingModesMayBeOne) {
  // Without noise the change with amplitude is a series of poles with once, twice ... the decay.
  const InversionResult result = invert_rubber(1e-4);
  ASSERT_GT(result.modes.size(), 1U) << listing(result);
  EXPECT_NEAR(result.modes[0].frequency_hz, 20.0, 0.02);  // the limit of small amplitude
  EXPECT_NEAR(result.modes[0].decay_per_s, 4.0, 0.1);
  EXPECT_TRUE(std::any_of(result.notes.begin(), result.notes.end(), [](const std::string& note) {
    return note.find("overlap") != std::string::npos;
  }));
}

TEST(InvertHarmonics, CallsGrowthNoMode) {
  for (const double growth : {1.5, 6.0, 40.0}) {
    SynthesisOptions options;
    options.noise_sigma = 0.001;
    const InversionResult result =
        invert_harmonics(synthesize_sinusoids({{20.0, -growth, 1.0, 0.8}}, options), {"y"});
    EXPECT_TRUE(result.modes.empty()) << "growth " << growth << "\n" << listing(result);
    EXPECT_FALSE(result.rejected.empty());
    EXPECT_FALSE(result.notes.empty());
  }
  Trace trace;
  trace.channels = {{"y", {}}};
  for (int i = 0; i < 400; ++i) {
    trace.time_s.push_back(i / 240.0);
    trace.channels[0].values.push_back(std::exp(0.5 * i));  // to 1e86
  }
  EXPECT_TRUE(invert_harmonics(trace, {"y"}).modes.empty());
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

TEST(InvertHarmonics, SharesPolesBetweenChannels) {
  SynthesisOptions options;
  options.noise_sigma = 0.02;
  options.channel = "a";
  Trace trace = synthesize_sinusoids({{20.0, 3.0, 1.0, 0.8}, {47.0, 5.0, 0.2, 0.0}}, options);
  options.channel = "b";
  options.seed = 2;
  options.noise_sigma = 0.05;
  const Trace other =
      synthesize_sinusoids({{20.0, 3.0, 0.4, -1.0}, {47.0, 5.0, 0.9, 2.0}}, options);
  trace.channels.push_back(other.channels[0]);
  const InversionResult joint = invert_harmonics(trace, {"a", "b"});
  ASSERT_EQ(joint.modes.size(), 2U) << listing(joint);
  EXPECT_EQ(joint.channel_names, (std::vector<std::string>{"a", "b"}));
  const DampedSinusoid* low = nearest(joint, 20.0);
  EXPECT_NEAR(low->frequency_hz, 20.0, 4.0 * low->frequency_sigma_hz);
  EXPECT_NEAR(low->channels[1].amplitude, 0.4, 4.0 * low->channels[1].amplitude_sigma);
  EXPECT_NEAR(low->channels[1].phase_rad, -1.0, 4.0 * low->channels[1].phase_sigma_rad);
  // Joint order is by root sum of squares: 1.08 at 20 Hz over 0.92 at 47 Hz.
  EXPECT_EQ(low, &joint.modes[0]);
  // sqrt(0.02² + 0.05²), to 4 % of 480 samples' scatter, twice.
  EXPECT_NEAR(joint.residual_rms, std::hypot(0.02, 0.05), 0.08 * std::hypot(0.02, 0.05));
  const InversionResult alone = invert_harmonics(trace, {"b"});
  const DampedSinusoid* weak = nearest(alone, 20.0);
  ASSERT_NE(weak, nullptr);
  EXPECT_LT(low->decay_sigma_per_s, 0.5 * weak->decay_sigma_per_s);
}

TEST(InvertHarmonics, SharesPolesBetweenRepeatsWithTheirOwnTimes) {
  SynthesisOptions options;
  options.noise_sigma = 0.02;
  Trace first = synthesize_sinusoids({{20.0, 3.0, 1.0, 0.8}}, options);
  options.seed = 5;
  options.rate_hz = 200.0;
  options.duration_s = 1.5;
  Trace second = synthesize_sinusoids({{20.0, 3.0, 0.5, -0.5}}, options);
  for (double& t : second.time_s) t += 4.0;
  const InversionResult result = invert_repeats({first, second}, {"y"});
  ASSERT_EQ(result.modes.size(), 1U) << listing(result);
  const DampedSinusoid& mode = result.modes[0];
  ASSERT_EQ(mode.channels.size(), 2U);
  EXPECT_EQ(mode.channels[0].channel, "1:y");
  EXPECT_NEAR(mode.frequency_hz, 20.0, 4.0 * mode.frequency_sigma_hz);
  EXPECT_NEAR(mode.channels[1].amplitude, 0.5, 4.0 * mode.channels[1].amplitude_sigma);
  EXPECT_NEAR(mode.channels[1].phase_rad, -0.5, 4.0 * mode.channels[1].phase_sigma_rad);
  EXPECT_DOUBLE_EQ(result.channel_origins_s[1], 4.0);
  EXPECT_NEAR(result.evaluate(1, 4.0), 0.5 * std::sin(-0.5), 0.05);
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

TEST(InvertHarmonics, FindsALoneModeOfFourSamplesWhoseAmplitudeFollowsItsDecay) {
  // Draws in which least squares has its one minimum at twice the true decay, with a sigma of two
  // thirds of that: the amplitude at the first sample is uncertain then, the mode is not.
  for (const auto& [seed, phase_rad] : {std::pair{987U, 2.938}, {1638U, -2.696}}) {
    const double decay = kTwoPi * 60.0 * 0.4 / std::sqrt(1.0 - 0.16);
    SynthesisOptions options;
    options.noise_sigma = std::pow(10.0, -30.0 / 20.0);
    options.seed = seed;
    const InversionResult result =
        invert_harmonics(synthesize_sinusoids({{60.0, decay, 1.0, phase_rad}}, options), {"y"});
    ASSERT_EQ(result.modes.size(), 1U) << result.message;
    const DampedSinusoid& mode = result.modes.front();
    const SinusoidInChannel& part = mode.channels.front();
    EXPECT_LT(part.amplitude, 3.0 * part.amplitude_sigma) << "the case that is meant";
    EXPECT_NEAR(mode.frequency_hz, 60.0, 3.0 * mode.frequency_sigma_hz);
    EXPECT_NEAR(mode.decay_per_s, decay, 3.0 * mode.decay_sigma_per_s);
  }
}

}  // namespace
}  // namespace twang
