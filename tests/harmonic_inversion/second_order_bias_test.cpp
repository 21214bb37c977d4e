// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/second_order_bias.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/synthesize.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// (offset, drift, a1, b1, a2, b2, f1, d1, f2, d2) of a fit of two modes with a drift.
VectorXd parameters_of(const SinusoidFit& fit) {
  const ChannelFit& c = fit.channels.front();
  VectorXd out(10);
  out << c.offset, c.drift_per_s, c.cosine(0), c.sine(0), c.cosine(1), c.sine(1),
      fit.poles[0].frequency_hz, fit.poles[0].decay_per_s, fit.poles[1].frequency_hz,
      fit.poles[1].decay_per_s;
  return out;
}

VectorXd model_at(const VectorXd& t, const VectorXd& theta) {
  VectorXd out = (theta(0) + theta(1) * t.array()).matrix();
  for (Index k = 0; k < 2; ++k) {
    const auto angle = kTwoPi * theta(6 + 2 * k) * t.array();
    out.array() += (-theta(7 + 2 * k) * t.array()).exp() *
                   (theta(2 + 2 * k) * angle.cos() + theta(3 + 2 * k) * angle.sin());
  }
  return out;
}

/// By central differences.
MatrixXd jacobian_at(const VectorXd& t, const VectorXd& theta) {
  MatrixXd out(t.size(), theta.size());
  for (Index i = 0; i < theta.size(); ++i) {
    const VectorXd step = 1e-5 * std::max(1.0, std::abs(theta(i))) * VectorXd::Unit(10, i);
    out.col(i) =
        (model_at(t, theta + step) - model_at(t, theta - step)) / (2.0 * step.cwiseAbs().sum());
  }
  return out;
}

/// Two overlapping modes on uneven stamps with a drift, samples of two weights, some of none.
struct Fitted {
  std::vector<SampleSeries> series{1};
  std::vector<VectorXd> weights{VectorXd::Ones(300)};
  RefineOptions options;
  SinusoidFit fit;

  explicit Fitted(double noise_sigma) {
    SynthesisOptions synthesis;
    synthesis.noise_sigma = noise_sigma;
    synthesis.jitter_s = 0.001;
    synthesis.duration_s = 299.0 / 240.0;
    synthesis.offset = 0.3;
    synthesis.drift_per_s = 0.1;
    const Trace trace =
        synthesize_sinusoids({{20.0, 6.0, 1.0, 0.8}, {23.0, 9.0, 0.7, -0.4}}, synthesis);
    series[0].time_s = VectorXd::Map(trace.time_s.data(), 300).array() - trace.time_s.front();
    series[0].value = VectorXd::Map(trace.channels[0].values.data(), 300);
    weights[0].tail(150).setConstant(0.5);
    weights[0].segment(40, 3).setZero();
    options.fit_drift = true;
    options.weights = weights;
    fit = refine_sinusoids(series, {{20.0, 6.0}, {23.0, 9.0}}, options);
  }

  [[nodiscard]] MatrixXd covariance() const {
    const MatrixXd j = weights[0].asDiagonal() * jacobian_at(series[0].time_s, parameters_of(fit));
    return (j.transpose() * j).inverse() * fit.variance();
  }
};

TEST(MeanExcess, IsThatOfTheModelAveragedOverItsCovariance) {
  const Fitted fitted(0.3);
  const VectorXd& t = fitted.series[0].time_s;
  const VectorXd theta = parameters_of(fitted.fit);
  // The mean of the model over theta +- each column of a root of the covariance has the same
  // second order; the columns are scaled down so that there is no other.
  const MatrixXd root = fitted.covariance().llt().matrixL();
  constexpr double kScale = 0.02;
  VectorXd expected = VectorXd::Zero(t.size());
  for (Index i = 0; i < root.cols(); ++i) {
    const VectorXd step = kScale * root.col(i);
    expected += (model_at(t, theta + step) - 2.0 * model_at(t, theta) + model_at(t, theta - step)) /
                (2.0 * kScale * kScale);
  }
  const VectorXd excess = mean_excess(fitted.series, fitted.fit).front();
  EXPECT_GT(excess.norm(), 1e-3);
  // Differences of the Jacobian to 1e-5, and what is left of the fourth order.
  EXPECT_LT((excess - expected).norm(), 1e-3 * expected.norm());
}

TEST(WithoutBias, MovesAllParametersByTheFormulaOfBox) {
  const Fitted fitted(0.1);
  const auto corrected = without_bias(fitted.series, fitted.fit, fitted.weights, fitted.options);
  ASSERT_TRUE(corrected.has_value());
  const VectorXd theta = parameters_of(fitted.fit);
  const MatrixXd j = fitted.weights[0].asDiagonal() * jacobian_at(fitted.series[0].time_s, theta);
  const VectorXd h = fitted.weights[0].cwiseProduct(mean_excess(fitted.series, fitted.fit).front());
  const VectorXd expected = (j.transpose() * j).ldlt().solve(j.transpose() * h);
  const VectorXd sigma = fitted.covariance().diagonal().cwiseSqrt();
  const VectorXd moved = (parameters_of(*corrected) - theta).cwiseQuotient(sigma);
  EXPECT_GT(moved.norm(), 0.01);
  // The refit knows of the curvature of the residual, too, a part of a tenth at this noise.
  EXPECT_LT((moved - expected.cwiseQuotient(sigma)).norm(), 0.1 * moved.norm());
  EXPECT_EQ(corrected->sum_of_squares, fitted.fit.sum_of_squares);
}

TEST(WithoutBias, LeavesAloneWhatIsExactAndWhatItCannotMend) {
  const Fitted exact(1e-6);
  EXPECT_FALSE(without_bias(exact.series, exact.fit, exact.weights, exact.options).has_value());
  // So uncertain that the curvature moves it by more than its sigma.
  Fitted lost(0.3);
  lost.fit.sum_of_squares *= 1e4;
  EXPECT_FALSE(without_bias(lost.series, lost.fit, lost.weights, lost.options).has_value());
}

}  // namespace
}  // namespace twang
