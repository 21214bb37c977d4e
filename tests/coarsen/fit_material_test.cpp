// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/fit_material.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace twang {
namespace {

constexpr double kRoundOff = 1e-12;  // a handful of operations in double precision, relative

DampedSinusoid sinusoid(double f, double d, double sigma_f, double sigma_d, double covariance) {
  DampedSinusoid s;
  s.frequency_hz = f;
  s.decay_per_s = d;
  s.frequency_sigma_hz = sigma_f;
  s.decay_sigma_per_s = sigma_d;
  s.frequency_decay_covariance = covariance;
  return s;
}

TEST(DampedTarget, InvertsTheOscillatorWithoutMassDamping) {
  for (const double f : {0.5, 48.53, 900.0}) {
    for (const double d : {0.0, 0.3, 7.66, 200.0}) {
      const DampedTarget target = damped_target(sinusoid(f, d, 0, 0, 0));
      const FrequencyAndDecay back =
          frequency_and_decay(target.lambda_per_s2, 0.0, target.damping_stiffness_b_s);
      // 200 1/s at 0.5 Hz leaves f² as a difference of numbers 4e3 times larger.
      EXPECT_NEAR(back.frequency_hz, f, 1e-9 * f);
      EXPECT_NEAR(back.decay_per_s, d, kRoundOff * (1.0 + d));
    }
  }
}

TEST(DampedTarget, GivesTheDampingOfThePublishedRig) {
  // The paper's calibration rig: 48.53 Hz and 7.66 1/s read off its figure, b = 1.64e-4 s in its
  // table; the reading is good to 2 %.
  const DampedTarget target = damped_target(sinusoid(48.53, 7.66, 0, 0, 0));
  EXPECT_NEAR(target.damping_stiffness_b_s, 1.64e-4, 0.02 * 1.64e-4);
}

TEST(DampedTarget, SigmasAreThoseOfALargeSample) {
  const double f = 3.0;
  const double d = 8.0;  // damping ratio 0.4: every term of the gradients counts
  const double sigma_f = 0.01;
  const double sigma_d = 0.05;
  const double correlation = -0.6;
  const DampedTarget target =
      damped_target(sinusoid(f, d, sigma_f, sigma_d, correlation * sigma_f * sigma_d));

  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  constexpr int kDraws = 200000;
  double lambda_square = 0.0;
  double b_square = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double u = normal(generator);
    const double v =
        correlation * u + std::sqrt(1.0 - correlation * correlation) * normal(generator);
    const DampedTarget draw = damped_target(sinusoid(f + sigma_f * u, d + sigma_d * v, 0, 0, 0));
    lambda_square += std::pow(draw.lambda_per_s2 - target.lambda_per_s2, 2);
    b_square += std::pow(draw.damping_stiffness_b_s - target.damping_stiffness_b_s, 2);
  }
  // 1 / sqrt(2 draws) = 0.16 % is the sampling error; second-order terms are smaller still.
  EXPECT_NEAR(std::sqrt(lambda_square / kDraws) / target.lambda_sigma_per_s2, 1.0, 0.01);
  EXPECT_NEAR(std::sqrt(b_square / kDraws) / target.damping_stiffness_b_sigma_s, 1.0, 0.01);
}

TEST(DampedTarget, KeepsAnUnknownSigmaUnknown) {
  const DampedTarget target = damped_target(sinusoid(10, 1, kNaN, 0.1, 0));
  EXPECT_TRUE(std::isnan(target.lambda_sigma_per_s2));
  EXPECT_TRUE(std::isnan(target.damping_stiffness_b_sigma_s));
}

TEST(DampedTarget, RefusesWhatIsNoDecayingMotion) {
  EXPECT_THROW((void)damped_target(sinusoid(10, -1, 0, 0, 0)), InputError);
  EXPECT_THROW((void)damped_target(sinusoid(0, 0, 0, 0, 0)), InputError);
  EXPECT_THROW((void)damped_target(sinusoid(kNaN, 1, 0, 0, 0)), InputError);
}

TEST(FrequencyAndDecay, IsTheRootOfTheDampedOscillator) {
  const double lambda = 5000.0;
  const double a = 2.0;
  const double b = 1e-3;
  const FrequencyAndDecay motion = frequency_and_decay(lambda, a, b);
  // s = -d + i w solves s² + (a + b lambda) s + lambda = 0, real and imaginary part.
  const double w = kTwoPi * motion.frequency_hz;
  const double d = motion.decay_per_s;
  EXPECT_NEAR(d * d - w * w - (a + b * lambda) * d + lambda, 0.0, kRoundOff * lambda);
  EXPECT_NEAR(-2.0 * d * w + (a + b * lambda) * w, 0.0, kRoundOff * lambda);
}

TEST(FrequencyAndDecay, DoesNotSwingWhenOverdamped) {
  const FrequencyAndDecay motion = frequency_and_decay(100.0, 0.0, 0.5);
  EXPECT_EQ(motion.frequency_hz, 0.0);
  EXPECT_DOUBLE_EQ(motion.decay_per_s, 25.0);
}

TEST(RescaledModulus, BringsTheMeshToTheTarget) {
  // lambda of a mesh is proportional to E, so the mesh with the new modulus has the target's
  // lambda.
  const double per_pascal = 4.2e-5;
  const double modulus = rescaled_modulus(3.0, 92000.0, 3.0 * per_pascal);
  EXPECT_NEAR(modulus * per_pascal, 92000.0, kRoundOff * 92000.0);
}

TEST(FitRayleigh, RecoversBothParametersFromTwoModes) {
  const double a = 1.7;
  const double b = 2.3e-4;
  std::vector<DampedSinusoid> sinusoids;
  for (const double lambda : {9000.0, 400000.0}) {
    const FrequencyAndDecay motion = frequency_and_decay(lambda, a, b);
    sinusoids.push_back(sinusoid(motion.frequency_hz, motion.decay_per_s, kNaN, kNaN, 0));
  }
  const RayleighFit fit = fit_rayleigh(sinusoids);
  EXPECT_NEAR(fit.damping_mass_a_per_s, a, 1e-10);
  EXPECT_NEAR(fit.damping_stiffness_b_s, b, 1e-10 * b);
}

TEST(FitRayleigh, WeightsByTheDecaysSigma) {
  const double a = 1.7;
  const double b = 2.3e-4;
  std::vector<DampedSinusoid> sinusoids;
  for (const double lambda : {9000.0, 100000.0, 400000.0}) {
    const FrequencyAndDecay motion = frequency_and_decay(lambda, a, b);
    sinusoids.push_back(sinusoid(motion.frequency_hz, motion.decay_per_s, 0.0, 1e-3, 0));
  }
  sinusoids[1].decay_per_s += 5.0;  // wrong, and says so
  sinusoids[1].decay_sigma_per_s = 1e4;
  const RayleighFit fit = fit_rayleigh(sinusoids);
  // Its weight is 1e-7 of the others', squared in the fit.
  EXPECT_NEAR(fit.damping_mass_a_per_s, a, 1e-8);
  EXPECT_NEAR(fit.damping_stiffness_b_s, b, 1e-8 * b);
}

TEST(FitRayleigh, RefusesFewerThanTwoFrequencies) {
  EXPECT_THROW((void)fit_rayleigh({}), InputError);
  EXPECT_THROW((void)fit_rayleigh({sinusoid(10, 1, 0, 0, 0)}), InputError);
  EXPECT_THROW((void)fit_rayleigh({sinusoid(10, 1, 0, 0, 0), sinusoid(10, 1, 0, 0, 0)}),
               InputError);
}

TEST(ModulusBudget, EachPartIsItsOwnAndTheTotalTheirRootSumOfSquares) {
  DampedTarget target;
  target.lambda_per_s2 = 200.0;
  target.lambda_sigma_per_s2 = 2.0;
  Tolerance tolerance;
  tolerance.dimension_m = 1e-4;
  tolerance.density_rel = 0.03;
  tolerance.poissons_ratio = 0.02;
  tolerance.clock_rel = 0.001;
  ModulusSensitivities sensitivities;
  sensitivities.dimension_per_m = -1500.0;
  sensitivities.density = 0.8;
  sensitivities.poissons_ratio = -0.25;
  const UncertaintyBudget budget = modulus_budget(target, 0.004, 0.006, tolerance, sensitivities);
  EXPECT_DOUBLE_EQ(budget.statistical, 0.01);
  EXPECT_DOUBLE_EQ(budget.repeats, 0.006);
  EXPECT_DOUBLE_EQ(budget.mesh, 0.004);
  EXPECT_DOUBLE_EQ(budget.clock, 0.002);
  EXPECT_DOUBLE_EQ(budget.dimension, 0.15);
  EXPECT_DOUBLE_EQ(budget.density, 0.024);
  EXPECT_DOUBLE_EQ(budget.poissons_ratio, 0.005);
  const double sum_of_squares = 1e-4 + 3.6e-5 + 1.6e-5 + 4e-6 + 0.0225 + 5.76e-4 + 2.5e-5;
  EXPECT_NEAR(budget.total(), std::sqrt(sum_of_squares), kRoundOff);
}

}  // namespace
}  // namespace twang
