// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/even_record.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/weighted_data.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <tuple>
#include <vector>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index kSamples = 5000;  // no multiple of a block

SampleSeries noisy_series(double start_s) {
  SampleSeries out{"y", VectorXd(kSamples), VectorXd(kSamples)};
  std::mt19937 generator(4);
  std::normal_distribution<double> normal(0.0, 0.05);
  for (Index i = 0; i < kSamples; ++i) {
    const double t = start_s + 1e-3 * static_cast<double>(i);
    out.time_s(i) = t;
    out.value(i) = 0.3 + std::exp(-0.7 * t) * std::sin(kTwoPi * 31.0 * t) +
                   0.5 * std::exp(-1.1 * t) * std::cos(kTwoPi * 31.9 * t) + normal(generator);
  }
  return out;
}

/// Close to the truth, a steady one and a growing one beside.
const std::vector<DampedPole> kPoles = {{31.01, 0.65}, {31.88, 1.2}, {77.0, 0.0}, {100.0, -0.4}};

void expect_same(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  ASSERT_EQ(a.rows(), b.rows());
  ASSERT_EQ(a.cols(), b.cols());
  // Sums of 5000 terms in another order: 1e-13, times the condition of the columns, below 1e3.
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-9 * b.cwiseAbs().maxCoeff());
}

class EvenFit : public testing::TestWithParam<std::tuple<double, bool>> {};

TEST_P(EvenFit, EqualsTheFitOfAllSamples) {
  const auto [start_s, fit_drift] = GetParam();
  const SampleSeries series = noisy_series(start_s);
  VectorXd weights = VectorXd::Constant(kSamples, 2.5);
  weights(17) = weights(4321) = 0.0;
  const auto even = EvenRecord::from(series, weights);
  ASSERT_TRUE(even);
  const auto quick = even->fit_projected(kPoles, fit_drift, true);
  ASSERT_TRUE(quick);
  weights(100) *= 1.0 + 1e-14;  // weights that differ take the plain way
  ASSERT_FALSE(EvenRecord::from(series, weights));
  const ProjectedFit plain = fit_projected(series, weights, kPoles, fit_drift, true);
  expect_same(quick->coefficients, plain.coefficients);
  expect_same(quick->triangle, plain.triangle);
  expect_same(quick->inside, plain.inside);
  expect_same(quick->normal, plain.normal);
  expect_same(quick->gradient, plain.gradient);
  EXPECT_NEAR(quick->sum_of_squares, plain.sum_of_squares, 1e-11 * plain.sum_of_squares);
}

INSTANTIATE_TEST_SUITE_P(StartsAndDrifts,
                         EvenFit,
                         testing::Combine(testing::Values(0.0, 0.37), testing::Bool()));

TEST(EvenRecord, IsNoneOfAShortOrUnevenSeries) {
  SampleSeries series = noisy_series(0.0);
  EXPECT_TRUE(EvenRecord::from(series, {}));
  series.time_s(2000) += 1e-8;  // a hundred thousandth of a step
  EXPECT_FALSE(EvenRecord::from(series, {}));
  series = noisy_series(0.0);
  series.time_s.conservativeResize(1000);
  series.value.conservativeResize(1000);
  EXPECT_FALSE(EvenRecord::from(series, {}));
}

TEST(EvenRecord, LeavesAnExactFitToThePlainWay) {
  SampleSeries series = noisy_series(0.0);
  for (Index i = 0; i < kSamples; ++i) series.value(i) = std::sin(kTwoPi * 31.0 * series.time_s(i));
  EXPECT_FALSE(EvenRecord::from(series, {})->fit_projected({{31.0, 0.0}}, true, true));
}

TEST(WeightedData, ChecksMomentsOnceAgainstAllSamples) {
  const SampleSeries series = noisy_series(0.0);
  const double step = (series.time_s(kSamples - 1) - series.time_s(0)) / (kSamples - 1);
  const std::vector<SampleSeries> all = {series};
  const WeightedData data(all, step);
  ASSERT_NE(data.trial_options().records.at(0), nullptr);
  SinusoidFit fit = refine_sinusoids(data.series(), {}, data.final_options());
  fit.channels[0].residual = data.residual(fit, 0);
  // Sums of some thousand squares: round-off.
  EXPECT_LT(data.moment_mismatch(fit, 0), 1e-9);
  // Coefficients that moments off by 1 % of the signal would give.
  fit.channels[0].sum_of_squares *= 1.02;
  EXPECT_NEAR(data.moment_mismatch(fit, 0), 0.02, 1e-6);
}

}  // namespace
}  // namespace twang
