// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/strongest_sinusoid.hpp"

#include "core/constants.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace twang {
namespace {

constexpr double kRate_hz = 240.0;
constexpr double kFrequency_hz = 20.0;
constexpr double kDecay_per_s = 3.0;

SampleSeries sampled(int count, const std::function<double(double)>& y) {
  SampleSeries samples;
  samples.time_s = Eigen::VectorXd::LinSpaced(count, 0.0, (count - 1) / kRate_hz);
  samples.value = samples.time_s.unaryExpr(y);
  return samples;
}

double damped(double t, double frequency_hz, double decay_per_s) {
  return std::exp(-decay_per_s * t) * std::sin(kTwoPi * frequency_hz * t + 0.4);
}

DampedSinusoid mode(double frequency_hz, double decay_per_s) {
  DampedSinusoid mode;
  mode.frequency_hz = frequency_hz;
  mode.decay_per_s = decay_per_s;
  return mode;
}

TEST(StrongestSinusoid, IsFoundBesideAnOvertoneAndAnOffset) {
  const SampleSeries samples = sampled(120, [](double t) {
    return 0.7 + damped(t, kFrequency_hz, kDecay_per_s) + 0.3 * damped(t, 71.0, 9.0);
  });
  const auto found = fit_strongest_sinusoid(samples, {mode(20.3, 2.7), mode(71.0, 9.0)});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->frequency_hz, kFrequency_hz, 1e-5 * kFrequency_hz);
  EXPECT_NEAR(found->decay_per_s, kDecay_per_s, 1e-4 * kDecay_per_s);
}

TEST(StrongestSinusoid, OfALargeMotionIsTheSameFromWhicheverCompanionsItWasKnownBy) {
  // a frequency that rises by 2 % as the amplitude falls
  const SampleSeries samples = sampled(120, [](double t) {
    const double turns = kFrequency_hz * (t + 0.02 / kDecay_per_s * std::exp(-kDecay_per_s * t));
    return std::exp(-kDecay_per_s * t) * std::cos(kTwoPi * turns);
  });
  const auto by_one = fit_strongest_sinusoid(samples, {mode(19.9, 3.1)});
  const auto by_two = fit_strongest_sinusoid(samples, {mode(19.7, 2.5), mode(20.4, 4.0)});
  ASSERT_TRUE(by_one && by_two);
  EXPECT_NEAR(by_two->frequency_hz, by_one->frequency_hz, 1e-9 * kFrequency_hz);
  EXPECT_NEAR(by_two->decay_per_s, by_one->decay_per_s, 1e-7 * kDecay_per_s);
  EXPECT_GT(std::abs(by_one->frequency_hz - kFrequency_hz), 0.01);  // an average it is
}

TEST(StrongestSinusoid, IsNothingWhereTheSamplesAreTooFew) {
  const SampleSeries samples =
      sampled(9, [](double t) { return damped(t, kFrequency_hz, kDecay_per_s); });
  EXPECT_FALSE(fit_strongest_sinusoid(samples, {mode(kFrequency_hz, kDecay_per_s)}));
  EXPECT_FALSE(fit_strongest_sinusoid(samples, {}));
}

}  // namespace
}  // namespace twang
