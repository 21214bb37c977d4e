// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/robust_factors.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/synthesize.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd noise(Index count, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  VectorXd out(count);
  for (Index i = 0; i < count; ++i) out(i) = normal(generator);
  return out;
}

TEST(RobustFactors, LeaveNormalNoiseAloneAtAnyLength) {
  for (const auto& [count, records] : {std::pair<Index, int>{100, 400}, {5000, 60}, {200000, 10}}) {
    int touched = 0;
    for (int record = 0; record < records; ++record) {
      const VectorXd factors = robust_factors(noise(count, static_cast<std::uint32_t>(record)));
      touched += factors.minCoeff() < 1.0 ? 1 : 0;
    }
    EXPECT_LE(touched, records / 10) << count;  // the claim
  }
}

TEST(RobustFactors, FallFromOneAtTheLimitToZeroAtTwiceThat) {
  VectorXd residual = noise(201, 4);
  residual /= robust_factors(residual).sum() / 201.0;  // all 1: of no effect
  std::vector<double> size(201);
  for (Index i = 0; i < 201; ++i) size[static_cast<std::size_t>(i)] = std::abs(residual(i));
  std::nth_element(size.begin(), size.begin() + 100, size.end());
  residual *= 0.6744897501960817 / size[100];  // robust scatter 1
  const double limit = std::sqrt(2.0 * std::log(2010.0));
  // Between quieter neighbours, so that the scatter of all counts.
  residual.segment(80, 41) *= 0.5;
  const auto factor_at = [&](double z) {
    VectorXd changed = residual;
    changed(100) = z;
    return robust_factors(changed)(100);
  };
  // Halving a fifth of the residuals lowers their median by up to a tenth.
  EXPECT_EQ(factor_at(0.85 * limit), 1.0);
  EXPECT_EQ(factor_at(-2.0 * limit), 0.0);
  EXPECT_EQ(factor_at(30.0 * limit), 0.0);
  double last = 1.0;
  for (double z = 1.15 * limit; z < 1.7 * limit; z += 0.1) {
    EXPECT_LT(factor_at(z), last) << z;
    last = factor_at(z);
  }
  EXPECT_GT(last, 0.0);
}

TEST(RobustFactors, DropARunOfOutliersAndNothingElse) {
  VectorXd residual = noise(481, 5);
  residual.segment(200, 5).array() += 30.0;
  const VectorXd factors = robust_factors(residual);
  EXPECT_EQ(factors.segment(200, 5), VectorXd::Zero(5));
  EXPECT_EQ((factors.array() < 1.0).count(), 5);
}

TEST(RobustFactors, LeaveAModelThatIsWrongAlone) {
  // What a mode that softens leaves: a beginning forty times as large as the noise.
  VectorXd residual = noise(481, 6);
  for (Index i = 0; i < 481; ++i) {
    const double t = static_cast<double>(i) / 240.0;
    residual(i) += 40.0 * std::exp(-6.0 * t) * std::sin(kTwoPi * 20.0 * t);
  }
  EXPECT_EQ(robust_factors(residual), VectorXd::Ones(481));
  // And so many far off that there is no telling which are right.
  VectorXd many = noise(481, 7);
  for (Index i = 0; i < 481; i += 12) many(i) += 30.0;
  EXPECT_EQ(robust_factors(many), VectorXd::Ones(481));
}

TEST(RobustFactors, LeaveAModeThatIsGoneWithinSomeSamplesToTheModel) {
  SynthesisOptions options;
  options.noise_sigma = 0.002;
  const InversionResult result = invert_harmonics(
      synthesize_sinusoids({{20.0, 3.0, 1.0, 0.6}, {70.0, 40.0, 0.5, 1.2}}, options), {"y"});
  ASSERT_EQ(result.modes.size(), 2U);
  EXPECT_NEAR(result.modes[1].frequency_hz, 70.0, 4.0 * result.modes[1].frequency_sigma_hz);
  EXPECT_EQ(result.weights[0].num_left_out + result.weights[0].num_down_weighted, 0);
}

TEST(InvertHarmonics, IsNotMovedByAMarkerThatJumpsForSomeFrames) {
  SynthesisOptions options;
  options.noise_sigma = 0.01;
  Trace trace = synthesize_sinusoids({{20.0, 4.0, 1.0, 0.6}}, options);
  const InversionResult clean = invert_harmonics(trace, {"y"});
  for (std::size_t i = 180; i < 186; ++i) trace.channels[0].values[i] += 0.3;
  const InversionResult result = invert_harmonics(trace, {"y"});
  ASSERT_EQ(result.modes.size(), 1U);
  EXPECT_EQ(result.weights[0].num_left_out, 6);
  ASSERT_EQ(result.notes.size(), 1U);
  EXPECT_EQ(result.notes[0], "6 samples far off the model took no part in the fit.");
  // Six samples less of 481 move the estimate by about sqrt(6 / 481) = 0.11 of its sigma.
  EXPECT_NEAR(result.modes[0].frequency_hz,
              clean.modes[0].frequency_hz,
              0.4 * clean.modes[0].frequency_sigma_hz);
  EXPECT_NEAR(result.modes[0].decay_per_s,
              clean.modes[0].decay_per_s,
              0.4 * clean.modes[0].decay_sigma_per_s);
  EXPECT_NEAR(result.modes[0].decay_sigma_per_s / clean.modes[0].decay_sigma_per_s, 1.0, 0.05);
}

TEST(InvertHarmonics, SeesTheModeThatAMarkersJumpHasHidden) {
  SynthesisOptions options;
  options.noise_sigma = 0.001;
  Trace trace = synthesize_sinusoids({{20.0, 4.0, 1.0, 0.6}, {71.0, 5.0, 0.004, 0.3}}, options);
  for (std::size_t i = 180; i < 186; ++i) trace.channels[0].values[i] += 0.3;
  const InversionResult result = invert_harmonics(trace, {"y"});
  ASSERT_EQ(result.modes.size(), 2U);
  EXPECT_NEAR(result.modes[1].frequency_hz, 71.0, 4.0 * result.modes[1].frequency_sigma_hz);
}

}  // namespace
}  // namespace twang
