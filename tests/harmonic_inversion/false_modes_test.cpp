// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/constants.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/synthesize.hpp"
#include "tests/harmonic_inversion/found_modes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace twang {
namespace {

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

}  // namespace
}  // namespace twang
