// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/matrix_pencil.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/synthesize.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace twang {
namespace {

EvenSeries decaying(double sigma) {
  // 40 samples, damping ratio 0.4: one visible period.
  EvenSeries out{1.0 / 240.0, Eigen::VectorXd(40)};
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  for (Eigen::Index i = 0; i < 40; ++i) {
    const double t = static_cast<double>(i) / 240.0;
    out.value(i) =
        std::exp(-33.0 * t) * std::sin(kTwoPi * 12.0 * t + 1.0) + sigma * normal(generator);
  }
  return out;
}

TEST(MatrixPencil, IsExactWithoutNoise) {
  const auto found = matrix_pencil(decaying(0.0), 2);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].pole.frequency_hz, 12.0, 1e-9);  // round-off of a 27 x 14 matrix
  EXPECT_NEAR(found[0].pole.decay_per_s, 33.0, 1e-8);
}

TEST(MatrixPencil, FindsAHeavilyDampedPoleInAFewNoisySamples) {
  const auto found = matrix_pencil(decaying(0.01), 2);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].pole.frequency_hz, 12.0, 0.6);  // 5 %: a start for the refinement
  EXPECT_NEAR(found[0].pole.decay_per_s, 33.0, 4.0);
}

TEST(MatrixPencil, FindsTheOrderOfASignalItself) {
  EXPECT_EQ(matrix_pencil(decaying(0.0), 0).size(), 1U);
  EXPECT_EQ(matrix_pencil(decaying(0.001), 0).size(), 1U);
}

TEST(MatrixPencil, GivesNothingForAnOrderTheSamplesCannotCarry) {
  EXPECT_TRUE(matrix_pencil(decaying(0.0), 14).empty());
  EXPECT_TRUE(matrix_pencil({0.1, Eigen::VectorXd::Ones(5)}, 2).empty());
  EXPECT_TRUE(matrix_pencil({0.1, Eigen::VectorXd::Zero(60)}, 2).empty());
}

}  // namespace
}  // namespace twang
