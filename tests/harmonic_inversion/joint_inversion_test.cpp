// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/synthesize.hpp"
#include "tests/harmonic_inversion/found_modes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace twang {
namespace {

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

}  // namespace
}  // namespace twang
