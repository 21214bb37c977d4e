// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/richardson.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace twang {
namespace {

/// lambda(dx) = limit + c dx^p on dx = 1, 1/2, 1/4, ...
std::vector<double> power_law(double limit, double c, double order, int count) {
  std::vector<double> lambdas;
  for (int i = 0; i < count; ++i) lambdas.push_back(limit + c * std::exp2(-order * i));
  return lambdas;
}

TEST(RichardsonLimit, RecoversLimitAndOrderOfAPowerLaw) {
  for (const double order : {1.0, 1.5, 2.0, 4.0, 5.9}) {
    const RichardsonLimit limit = richardson_limit(power_law(50.0, 7.0, order, 3));
    EXPECT_TRUE(limit.order_observed);
    EXPECT_NEAR(limit.order, order, 1e-9);  // a logarithm of differences
    EXPECT_NEAR(limit.lambda_per_s2, 50.0, 1e-9);
  }
}

TEST(RichardsonLimit, LooksOnlyAtTheLastThree) {
  std::vector<double> lambdas = power_law(50.0, 7.0, 2.0, 3);
  lambdas.insert(lambdas.begin(), 1000.0);
  EXPECT_NEAR(richardson_limit(lambdas).lambda_per_s2, 50.0, 1e-9);
}

TEST(RichardsonLimit, AssumesOrderTwoOfTwoMeshes) {
  const RichardsonLimit limit = richardson_limit(power_law(50.0, 7.0, 2.0, 2));
  EXPECT_FALSE(limit.order_observed);
  EXPECT_DOUBLE_EQ(limit.order, 2.0);
  EXPECT_NEAR(limit.lambda_per_s2, 50.0, 1e-12);
}

TEST(RichardsonLimit, TheSigmaOfAnAssumedOrderCoversTheOrdersThatSingularitiesMake) {
  // Corners make orders between 1 and 2 as likely as higher ones: the truth lies within two sigmas.
  for (const double order : {1.0, 1.3, 2.0, 4.0}) {
    const RichardsonLimit limit = richardson_limit(power_law(50.0, 1.0, order, 2));
    EXPECT_LE(std::abs(limit.lambda_per_s2 - 50.0),
              2.001 * limit.relative_sigma * limit.lambda_per_s2)
        << order;
  }
}

TEST(RichardsonLimit, DoesNotBelieveChangesThatDoNotShrink) {
  const RichardsonLimit growing = richardson_limit({50.0, 51.0, 53.0});
  EXPECT_FALSE(growing.order_observed);
  EXPECT_GE(growing.relative_sigma * growing.lambda_per_s2, 2.0);
  const RichardsonLimit swinging = richardson_limit({50.0, 52.0, 51.0});
  EXPECT_FALSE(swinging.order_observed);
}

TEST(RichardsonLimit, OneMeshIsItsOwnLimitWithAGenerousSigma) {
  const RichardsonLimit limit = richardson_limit({50.0});
  EXPECT_DOUBLE_EQ(limit.lambda_per_s2, 50.0);
  EXPECT_GE(limit.relative_sigma, 0.02);  // what hex20 errs by with one cell through a thin leg
  EXPECT_FALSE(limit.order_observed);
}

TEST(RichardsonLimit, EqualMeshesLeaveTheFloor) {
  const RichardsonLimit limit = richardson_limit({50.0, 50.0, 50.0});
  EXPECT_DOUBLE_EQ(limit.lambda_per_s2, 50.0);
  EXPECT_GT(limit.relative_sigma, 0.0);
  EXPECT_LT(limit.relative_sigma, 1e-3);
}

}  // namespace
}  // namespace twang
