// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/lack_of_fit.hpp"

#include "core/constants.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace twang::test {
namespace {

constexpr double kFrequency_hz = 40.0;
constexpr double kDecay_per_s = 8.0;
constexpr double kAmplitude_mm = 5.0;

Rig rig_with(ObservableKind kind) {
  Rig rig;
  rig.markers.resize(2);
  rig.markers[0].id += 'a';
  rig.markers[1].id += 'b';
  rig.markers[0].position = {10e-3, 0.0, 0.0};
  rig.markers[1].position = {40e-3, 0.0, 0.0};
  ObservableDefinition& observable = rig.observable.emplace();
  observable.kind = kind;
  if (kind == ObservableKind::Angle) observable.markers.push_back(rig.markers[0].id);
  observable.markers.push_back(rig.markers[1].id);
  observable.direction = Eigen::Vector3d::UnitZ();
  return rig;
}

/// A vibration whose envelope is too small by `shrunk_mm` as long as it is larger than that.
Trace vibration(double shrunk_mm, double noise_mm) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, noise_mm);
  Trace trace;
  Channel observable{"observable_mm", {}};
  Channel sigma{"b.sigma_mm", {}};
  for (int n = 0; n < 240; ++n) {
    const double t = n / 240.0;
    const double envelope = std::max(0.0, kAmplitude_mm * std::exp(-kDecay_per_s * t) - shrunk_mm);
    trace.time_s.push_back(t);
    observable.values.push_back(envelope * std::sin(kTwoPi * kFrequency_hz * t) + noise(random));
    sigma.values.push_back(noise_mm);
  }
  trace.channels = {observable, sigma};
  return trace;
}

InversionResult invert(const Trace& trace) {
  InversionOptions options;
  options.start_s = 0.0;
  options.max_modes = 1;
  return invert_harmonics(trace, {"observable_mm"}, options);
}

TEST(LackOfFit, CoversAnEnvelopeThatIsOff) {
  const Trace trace = vibration(0.05, 1e-4);
  const InversionResult inversion = invert(trace);
  ASSERT_TRUE(inversion.usable());
  const DampedSinusoid& mode = inversion.modes.front();
  const double error = std::abs(mode.decay_per_s - kDecay_per_s);
  EXPECT_GT(error, 3.0 * mode.decay_sigma_per_s);  // the fit itself knows nothing of it
  const LackOfFit lack = lack_of_fit(rig_with(ObservableKind::Displacement), trace, inversion);
  // An order of magnitude is what it promises: within one sigma and a half, and not ten times.
  EXPECT_GT(lack.decay_spread_per_s, error / 1.5);
  EXPECT_LT(lack.decay_spread_per_s, 10.0 * error);
  EXPECT_DOUBLE_EQ(lack.frequency_spread_hz, lack.decay_spread_per_s / kTwoPi);
}

TEST(LackOfFit, IsSmallWhereTheSigmasExplainTheResidual) {
  const Trace trace = vibration(0.0, 0.05);
  const InversionResult inversion = invert(trace);
  ASSERT_TRUE(inversion.usable());
  const LackOfFit lack = lack_of_fit(rig_with(ObservableKind::Displacement), trace, inversion);
  // 240 samples know their scatter to 5 %: a third of it may seem to be unexplained.
  EXPECT_LT(lack.decay_spread_per_s, 4.0 * 0.33 * 0.05 / kAmplitude_mm * kDecay_per_s);
}

TEST(LackOfFit, OfAnAngleTakesBothMarkersOverTheirDistance) {
  Trace trace;
  trace.time_s = {0.0, 1.0};
  trace.channels = {{"a.sigma_mm", {0.03, 0.03}}, {"b.sigma_mm", {0.04, kNaN}}};
  InversionResult inversion = invert(vibration(0.0, 1e-3));
  inversion.time_origin_s = 0.0;
  inversion.time_end_s = 1.0;
  inversion.modes.resize(1);
  inversion.modes[0].decay_per_s = 6.0;
  inversion.modes[0].channels = {{"observable_rad", 0.1, 0.0}};
  const double sigma = 0.05 / 30.0;
  inversion.residual_rms = 1.25 * sigma;
  const LackOfFit lack = lack_of_fit(rig_with(ObservableKind::Angle), trace, inversion);
  EXPECT_NEAR(lack.decay_spread_per_s, 4.0 * 0.75 * sigma / 0.1 * 6.0, 1e-12);
}

TEST(LackOfFit, IsUnknownWithoutSigmas) {
  Trace trace = vibration(0.05, 1e-4);
  const InversionResult inversion = invert(trace);
  trace.channels.pop_back();
  EXPECT_EQ(
      lack_of_fit(rig_with(ObservableKind::Displacement), trace, inversion).decay_spread_per_s,
      0.0);
}

}  // namespace
}  // namespace twang::test
