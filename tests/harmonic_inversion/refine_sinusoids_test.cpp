// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/refine_sinusoids.hpp"

#include "core/constants.hpp"
#include "core/dense_algebra.hpp"
#include "core/error.hpp"
#include "harmonic_inversion/mode_criteria.hpp"
#include "harmonic_inversion/projected_fit.hpp"

#include <Eigen/Core>
#include <Eigen/QR>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace twang {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

const std::vector<DampedPole> kPairOfPoles = {{11.0, 2.0}, {17.0, 5.0}};

/// Two sinusoids on uneven stamps, with offset, drift and noise.
SampleSeries uneven(double sigma, std::uint32_t seed = 7) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0.7, 1.3);
  SampleSeries out{"y", VectorXd(300), VectorXd(300)};
  double t = 0.0;
  for (Eigen::Index i = 0; i < 300; ++i) {
    out.time_s(i) = t;
    out.value(i) = 0.4 - 0.2 * t + std::exp(-2.0 * t) * std::cos(kTwoPi * 11.0 * t) +
                   0.3 * std::exp(-5.0 * t) * std::sin(kTwoPi * 17.0 * t) +
                   sigma * normal(generator);
    t += uniform(generator) / 240.0;
  }
  return out;
}

/// Residual of the linear fit at given poles, by Householder reflections.
VectorXd projected_residual(const SampleSeries& s, const VectorXd& weights, const VectorXd& p) {
  MatrixXd basis(s.value.size(), 2 + p.size());
  basis.col(0).setOnes();
  basis.col(1) = s.time_s;
  for (Eigen::Index k = 0; k < p.size(); k += 2) {
    const auto envelope = (-p(k + 1) * s.time_s).array().exp();
    basis.col(2 + k) = envelope * (kTwoPi * p(k) * s.time_s).array().cos();
    basis.col(3 + k) = envelope * (kTwoPi * p(k) * s.time_s).array().sin();
  }
  basis = weights.asDiagonal() * basis;
  const VectorXd y = weights.cwiseProduct(s.value);
  return y - basis * basis.householderQr().solve(y);
}

TEST(ProjectedFit, HasTheSumOfSquaresAndGradientOfTheProjectedResidual) {
  const SampleSeries series = uneven(0.05);
  VectorXd weights = VectorXd::LinSpaced(300, 0.5, 2.0);
  weights(10) = 0.0;
  // Off the minimum, where neither the residual nor the gradient is small.
  const std::vector<DampedPole> poles = {{11.2, 2.4}, {16.5, 4.0}};
  const ProjectedFit fit = fit_projected(series, weights, poles, true, true);
  VectorXd p(4);
  p << 11.2, 2.4, 16.5, 4.0;
  const double squares = projected_residual(series, weights, p).squaredNorm();
  EXPECT_NEAR(fit.sum_of_squares, squares, 1e-12 * squares);
  for (Eigen::Index i = 0; i < 4; ++i) {
    const double h = 1e-5;  // error h² / 6 times the third derivative: 1e-8 relative
    VectorXd up = p;
    VectorXd down = p;
    up(i) += h;
    down(i) -= h;
    const double slope = (projected_residual(series, weights, up).squaredNorm() -
                          projected_residual(series, weights, down).squaredNorm()) /
                         (2.0 * h);
    EXPECT_NEAR(2.0 * fit.gradient(i), slope, 1e-6 * std::abs(slope)) << i;
  }
}

TEST(RefineSinusoids, ReachesTheTruthOnUnevenStamps) {
  RefineOptions options;
  options.fit_drift = true;
  const SinusoidFit fit = refine_sinusoids({uneven(0.0)}, {{11.3, 1.0}, {16.6, 8.0}}, options);
  EXPECT_EQ(fit.termination, Termination::Converged);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(fit.poles[k].frequency_hz,
                kPairOfPoles[k].frequency_hz,
                1e-10 * kPairOfPoles[k].frequency_hz);
    EXPECT_NEAR(
        fit.poles[k].decay_per_s, kPairOfPoles[k].decay_per_s, 1e-10 * kPairOfPoles[k].decay_per_s);
  }
  EXPECT_NEAR(fit.channels[0].offset, 0.4, 1e-12);
  EXPECT_NEAR(fit.channels[0].drift_per_s, -0.2, 1e-12);
  EXPECT_NEAR(fit.channels[0].cosine(0), 1.0, 1e-12);
  EXPECT_NEAR(fit.channels[0].sine(1), 0.3, 1e-12);
}

TEST(RefineSinusoids, CovarianceIsTheInverseOfTheFullNormalMatrix) {
  const SampleSeries series = uneven(0.01);
  RefineOptions options;
  options.fit_drift = true;
  const SinusoidFit fit = refine_sinusoids({series}, kPairOfPoles, options);
  // All ten parameters in one Jacobian: offset, drift, (cosine, sine) x 2, (f, d) x 2.
  const Eigen::ArrayXd t = series.time_s.array();
  MatrixXd jacobian(300, 10);
  jacobian.col(0).setOnes();
  jacobian.col(1) = t;
  for (Eigen::Index k = 0; k < 2; ++k) {
    const DampedPole& pole = fit.poles[static_cast<std::size_t>(k)];
    const double a = fit.channels[0].cosine(k);
    const double b = fit.channels[0].sine(k);
    const Eigen::ArrayXd c = (-pole.decay_per_s * t).exp() * (kTwoPi * pole.frequency_hz * t).cos();
    const Eigen::ArrayXd s = (-pole.decay_per_s * t).exp() * (kTwoPi * pole.frequency_hz * t).sin();
    jacobian.col(2 + 2 * k) = c;
    jacobian.col(3 + 2 * k) = s;
    jacobian.col(6 + 2 * k) = kTwoPi * t * (b * c - a * s);
    jacobian.col(7 + 2 * k) = -t * (a * c + b * s);
  }
  const MatrixXd full =
      solve_symmetric(jacobian.transpose() * jacobian, MatrixXd::Identity(10, 10));
  // 1e-9: condition of the normal matrix, about 1e5, times 1e-16, with room.
  EXPECT_TRUE(fit.pole_covariance.isApprox(full.bottomRightCorner(4, 4), 1e-9));
  EXPECT_TRUE(fit.channels[0].covariance.isApprox(full.topLeftCorner(6, 6), 1e-9));
  EXPECT_EQ(fit.num_parameters, 10);
  EXPECT_NEAR(fit.variance(), 1e-4, 0.3e-4);  // 290 degrees of freedom scatter by 8 %
}

TEST(RefineSinusoids, KeepsADecayThatIsFixed) {
  RefineOptions options;
  options.fit_drift = true;
  options.fixed_decays = {false, true};
  const SinusoidFit fit = refine_sinusoids({uneven(0.0)}, {{11.1, 1.5}, {17.0, 4.0}}, options);
  EXPECT_EQ(fit.poles[1].decay_per_s, 4.0);
  EXPECT_NE(fit.poles[0].decay_per_s, 1.5);
  EXPECT_EQ(fit.pole_covariance(3, 3), 0.0);
  EXPECT_EQ(fit.num_parameters, 9);
}

TEST(RefineSinusoids, RefusesWhatDoesNotFitTogether) {
  const SampleSeries series = uneven(0.0);
  RefineOptions options;
  EXPECT_THROW(static_cast<void>(refine_sinusoids({}, kPairOfPoles)), InputError);
  options.weights = {VectorXd::Ones(300), VectorXd::Ones(300)};
  EXPECT_THROW(static_cast<void>(refine_sinusoids({series}, kPairOfPoles, options)), InputError);
  options = {};
  options.fixed_decays = {true};
  EXPECT_THROW(static_cast<void>(refine_sinusoids({series}, kPairOfPoles, options)), InputError);
  options = {};
  options.max_iterations = 0;
  EXPECT_THROW(options.check(), InputError);
  options = {};
  options.relative_step = 1.0;
  EXPECT_THROW(options.check(), InputError);
  options = {};
  options.max_frequency_hz = 0.0;
  EXPECT_THROW(options.check(), InputError);
}

TEST(LogChanceOfGain, IsTheShareOfWhiteNoiseThatTwoColumnsExplain) {
  // For two columns and m degrees of freedom left: P(after / before < r) = r^(m / 2).
  EXPECT_NEAR(log_chance_of_gain(10.0, 9.0, 40, 2), 20.0 * std::log(0.9), 1e-12);
  EXPECT_EQ(log_chance_of_gain(10.0, 10.0, 40, 2), 0.0);
  // For four: r^(m/2) (1 + m/2 (1 - r)); and by drawing: chi-square ratios.
  const double expected = 20.0 * std::log(0.8) + std::log(1.0 + 20.0 * 0.2);
  EXPECT_NEAR(log_chance_of_gain(10.0, 8.0, 40, 4), expected, 1e-12);
  std::mt19937 generator(11);
  std::chi_squared_distribution<double> explained(4.0);
  std::chi_squared_distribution<double> left(40.0);
  int below = 0;
  for (int i = 0; i < 20000; ++i) {
    const double rest = left(generator);
    below += rest / (rest + explained(generator)) < 0.8 ? 1 : 0;
  }
  const double share = std::exp(expected);
  EXPECT_NEAR(below / 20000.0, share, 4.0 * std::sqrt(share / 20000.0));
}

TEST(IsolatedOutliers, AreSamplesAloneNotRuns) {
  std::mt19937 generator(2);
  std::normal_distribution<double> normal;
  VectorXd residual(400);
  for (Eigen::Index i = 0; i < 400; ++i) residual(i) = normal(generator);
  residual(50) = 30.0;
  residual(200) = 25.0;
  residual(201) = 26.0;
  const std::vector<bool> found = find_isolated_outliers(residual);
  EXPECT_TRUE(found[50]);
  EXPECT_FALSE(found[200]);
  EXPECT_FALSE(found[201]);
  EXPECT_EQ(std::count(found.begin(), found.end(), true), 1);
}

}  // namespace
}  // namespace twang
