// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/constants.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/synthesize.hpp"
#include "tests/harmonic_inversion/found_modes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace twang {
namespace {

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

// 60 Hz with a damping ratio of 0.4, of which four samples stand above noise at 30 dB.
const double kLoneDecay_per_s = kTwoPi * 60.0 * 0.4 / std::sqrt(1.0 - 0.4 * 0.4);

InversionResult inverted_draw(unsigned seed, double phase_rad) {
  SynthesisOptions options;
  options.noise_sigma = std::pow(10.0, -30.0 / 20.0);
  options.seed = seed;
  return invert_harmonics(synthesize_sinusoids({{60.0, kLoneDecay_per_s, 1.0, phase_rad}}, options),
                          {"y"});
}

TEST(InvertHarmonics, FindsALoneModeOfFourSamplesWhoseAmplitudeFollowsItsDecay) {
  // Draws in which least squares has its one minimum at twice the true decay, with a sigma of two
  // thirds of that: the amplitude at the first sample is uncertain then, the mode is not.
  for (const auto& [seed, phase_rad] : {std::pair{987U, 2.938}, {1638U, -2.696}}) {
    const InversionResult result = inverted_draw(seed, phase_rad);
    ASSERT_EQ(result.modes.size(), 1U) << result.message;
    const DampedSinusoid& mode = result.modes.front();
    const SinusoidInChannel& part = mode.channels.front();
    EXPECT_LT(part.amplitude, 3.0 * part.amplitude_sigma) << "the case that is meant";
    EXPECT_NEAR(mode.frequency_hz, 60.0, 3.0 * mode.frequency_sigma_hz);
    EXPECT_NEAR(mode.decay_per_s, kLoneDecay_per_s, 3.0 * mode.decay_sigma_per_s);
  }
}

TEST(InvertHarmonics, FindsALoneModeWhereTwoOutliersWouldStandForIt) {
  // The first and the third sample are far off a record that is otherwise noise; and a mode whose
  // damping ratio of least squares, 0.80, is above what oscillates, but by no more than chance.
  for (const auto& [seed, phase_rad] : {std::pair{29176U, -1.557}, {26181U, -0.593}}) {
    const InversionResult result = inverted_draw(seed, phase_rad);
    ASSERT_EQ(result.modes.size(), 1U) << result.message;
    EXPECT_NEAR(result.modes[0].frequency_hz, 60.0, 3.5 * result.modes[0].frequency_sigma_hz);
    EXPECT_NEAR(
        result.modes[0].decay_per_s, kLoneDecay_per_s, 3.5 * result.modes[0].decay_sigma_per_s);
    EXPECT_EQ(result.weights[0].num_left_out, 0);
  }
}

TEST(InvertHarmonics, MakesNoModeOfTwoBadFramesInNoise) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    SynthesisOptions options;
    options.noise_sigma = 1.0;
    options.seed = seed;
    Trace trace = synthesize_sinusoids({}, options);
    trace.channels[0].values[100 + seed] += 30.0;
    trace.channels[0].values[200] -= 20.0;
    EXPECT_TRUE(invert_harmonics(trace, {"y"}).modes.empty()) << seed;
  }
}

}  // namespace
}  // namespace twang
