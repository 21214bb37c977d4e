// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/damped_sinusoid.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace twang
