// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/damped_sinusoid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace twang {
namespace {

TEST(DampedSinusoid, IsTheMotionOfItsOscillator) {
  // An oscillator of natural frequency 10 Hz and damping ratio 0.6 rings at 8 Hz and decays with
  // 0.6 * 2 pi * 10 Hz.
  DampedSinusoid mode;
  mode.frequency_hz = 8.0;
  mode.decay_per_s = 0.6 * kTwoPi * 10.0;
  // 1e-13, 1e-9: rounding of (2 pi 10)² and its root.
  EXPECT_NEAR(mode.natural_frequency_hz(), 10.0, 1e-13);
  EXPECT_NEAR(mode.damping_ratio(), 0.6, 1e-15);
  EXPECT_NEAR(mode.lambda_per_s2(), (kTwoPi * 10.0) * (kTwoPi * 10.0), 1e-9);
}

TEST(DampedSinusoid, WithoutDampingRingsAtItsNaturalFrequency) {
  DampedSinusoid mode;
  mode.frequency_hz = 48.5;
  EXPECT_DOUBLE_EQ(mode.natural_frequency_hz(), 48.5);
  EXPECT_EQ(mode.damping_ratio(), 0.0);
}

TEST(DampedSinusoid, SigmasOfWhatFollowsFromFAndDAreThoseOfTheFirstOrder) {
  DampedSinusoid mode;
  mode.frequency_hz = 48.0;
  mode.decay_per_s = 60.0;
  mode.frequency_sigma_hz = 0.02;
  mode.decay_sigma_per_s = 0.15;
  mode.frequency_decay_covariance = -0.6 * 0.02 * 0.15;
  using Quantity = double (DampedSinusoid::*)() const;
  const std::pair<Quantity, Quantity> pairs[] = {
      {&DampedSinusoid::lambda_per_s2, &DampedSinusoid::lambda_sigma_per_s2},
      {&DampedSinusoid::natural_frequency_hz, &DampedSinusoid::natural_frequency_sigma_hz},
      {&DampedSinusoid::damping_ratio, &DampedSinusoid::damping_ratio_sigma},
      {&DampedSinusoid::damping_stiffness_b_s, &DampedSinusoid::damping_stiffness_b_sigma_s}};
  for (const auto& [quantity, sigma] : pairs) {
    const auto at = [&, of = quantity](double f, double d) {
      DampedSinusoid other = mode;
      other.frequency_hz = f;
      other.decay_per_s = d;
      return (other.*of)();
    };
    // Central differences; 1e-6 of f and d leaves seven digits.
    const double by_f = (at(48.0 + 48e-6, 60.0) - at(48.0 - 48e-6, 60.0)) / 96e-6;
    const double by_d = (at(48.0, 60.0 + 60e-6) - at(48.0, 60.0 - 60e-6)) / 120e-6;
    const double variance = std::pow(by_f * 0.02, 2) + std::pow(by_d * 0.15, 2) +
                            2.0 * by_f * by_d * mode.frequency_decay_covariance;
    EXPECT_NEAR((mode.*sigma)() / std::sqrt(variance), 1.0, 1e-6);
  }
  // b = 2 d / lambda, as everywhere.
  EXPECT_DOUBLE_EQ(mode.damping_stiffness_b_s(), 120.0 / mode.lambda_per_s2());
  mode.decay_sigma_per_s = kNaN;
  EXPECT_TRUE(std::isnan(mode.damping_ratio_sigma()));
}

}  // namespace
}  // namespace twang
