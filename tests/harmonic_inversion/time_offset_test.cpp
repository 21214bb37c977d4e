// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/constants.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "tests/harmonic_inversion/found_modes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

constexpr double kReadout_s = 4e-3;
constexpr double kAmplitude = 5.0;
constexpr double kRise = 0.03;  // of the picture's height, per unit of the swing
constexpr double kFrequency_hz = 31.0;
constexpr double kDecay_per_s = 3.0;

double truth(double time_s) {
  return kAmplitude * std::exp(-kDecay_per_s * time_s) * std::cos(kTwoPi * kFrequency_hz * time_s);
}

/// A marker that swings over three tenths of the picture's height, read by rows.
Trace rolled(const std::string& column) {
  Trace trace;
  Channel value{column, {}};
  Channel offset{
      column.rfind("observable", 0) == 0 ? "observable.time_offset_s" : "tip.time_offset_s", {}};
  for (int n = 0; n < 360; ++n) {
    const double time_s = n / kRate_hz;
    double offset_s = 0.0;
    for (int i = 0; i < 60; ++i) offset_s = kReadout_s * (0.5 + kRise * truth(time_s + offset_s));
    trace.time_s.push_back(time_s);
    value.values.push_back(truth(time_s + offset_s));
    offset.values.push_back(offset_s);
  }
  trace.channels = {value, offset};
  return trace;
}

TEST(TimeOffset, OfARollingShutterIsTakenIntoFrequencyDecayAndPhase) {
  for (const char* column : {"observable_mm", "tip.z_mm"}) {
    const Trace trace = rolled(column);
    InversionOptions options;
    options.start_s = 0.0;
    const InversionResult result = invert_harmonics(trace, {column}, options);
    ASSERT_EQ(result.modes.size(), 1U) << result.message;
    // Exact samples at exact times: round-off of the fit.
    EXPECT_NEAR(result.modes[0].frequency_hz, kFrequency_hz, 1e-7);
    EXPECT_NEAR(result.modes[0].decay_per_s, kDecay_per_s, 1e-6);
    EXPECT_NEAR(result.modes[0].channels[0].phase_rad, kPi / 2.0, 1e-6);
    EXPECT_EQ(result.time_origin_s, 0.0);  // the frame's: rows' times enter the fit, not its origin
    EXPECT_EQ(result.time_end_s, trace.time_s.back());
  }
}

TEST(TimeOffset, LeftOutOfAccountItBiases) {
  Trace trace = rolled("observable_mm");
  trace.channels.pop_back();
  InversionOptions options;
  options.start_s = 0.0;
  const InversionResult result = invert_harmonics(trace, {"observable_mm"}, options);
  ASSERT_TRUE(result.usable());
  ASSERT_GE(result.modes.size(), 2U);
  // x(t + r (1/2 + k x)) = x(t + r/2) + r k x x' + ...: a phase, and an overtone the part does not
  // have. What is neglected is another factor 2 pi f r k x = 0.12 at first, and decays.
  const double omega = kTwoPi * kFrequency_hz;
  EXPECT_NEAR(result.modes[0].channels[0].phase_rad, kPi / 2.0 + 0.5 * omega * kReadout_s, 5e-3);
  EXPECT_NEAR(result.modes[1].frequency_hz, 2.0 * kFrequency_hz, 0.1);
  const double overtone = 0.5 * omega * kReadout_s * kRise * kAmplitude * kAmplitude;
  EXPECT_NEAR(result.modes[1].channels[0].amplitude, overtone, 0.05 * overtone);
}

}  // namespace
}  // namespace twang
