// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/inversion_draws.hpp"
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

namespace twang::bench {
namespace {

constexpr int kDraws = 250;
constexpr std::uint32_t kSeed = 100000;  // not the draws of the benchmark

void expect_efficient_and_honest(const Spread& spread, double best) {
  // The benchmark's bounds, 1.1, 65 to 72 % and 93.5 to 97 %, each widened by three times the
  // scatter of 250 draws: 4.5 %, 2.9 % and 1.3 %.
  const double n = kDraws;
  EXPECT_LT(spread.rmse_over_bound, 1.1 * (1.0 + 3.0 / std::sqrt(2.0 * n)));
  EXPECT_GT(spread.rmse_over_bound, 1.0 - 3.0 / std::sqrt(2.0 * n));
  const double scatter_of_one = 3.0 * std::sqrt(0.683 * 0.317 / n);
  EXPECT_GT(spread.within_one, 0.65 - scatter_of_one);
  EXPECT_LT(spread.within_one, 0.72 + scatter_of_one);
  const double scatter_of_two = 3.0 * std::sqrt(0.954 * 0.046 / n);
  EXPECT_GT(spread.within_two, 0.935 - scatter_of_two);
  // On the same draws, so without that scatter: in 2 % of them a drift is fitted, too, or a sample
  // counts less.
  EXPECT_LT(spread.rmse_over_bound, 1.01 * best);
}

class MonteCarlo : public testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(MonteCarlo, IsEfficientAndHonestAtThirtyDecibels) {
  const auto [frequency_hz, damping_ratio] = GetParam();
  const DrawStatistics s = draw_sinusoids({frequency_hz, damping_ratio, 30.0}, kDraws, kSeed);
  EXPECT_EQ(s.missed, 0);
  expect_efficient_and_honest(s.frequency, s.best_frequency);
  expect_efficient_and_honest(s.decay, s.best_decay);
}

INSTANTIATE_TEST_SUITE_P(FrequenciesAndDampingRatios,
                         MonteCarlo,
                         testing::Combine(testing::Values(20.0, 60.0),
                                          testing::Values(0.005, 0.1, 0.4)));

TEST(MonteCarloRecords, OfNoiseHaveNoModeAndOfTwentySigmaAlways) {
  // Refused but for 3 in 1000: of 250, more than 3 have a chance of 1 in 100.
  EXPECT_LE(count_false_alarms(kDraws, kSeed), 3);
  EXPECT_EQ(count_detections(kDraws, kSeed), kDraws);
}

}  // namespace
}  // namespace twang::bench
