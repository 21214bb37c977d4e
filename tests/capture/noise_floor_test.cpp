// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/noise_floor.hpp"

#include "core/constants.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace twang::test {
namespace {

constexpr double kNoise = 0.03;
constexpr int kFrames = 300;

double floor_of(const std::function<Eigen::Vector2d(int)>& path) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, kNoise);
  std::vector<Eigen::Vector2d> positions;
  for (int n = 0; n < kFrames; ++n) {
    positions.push_back(path(n) + Eigen::Vector2d(noise(random), noise(random)));
  }
  // The stated sigma is half the truth: the floor is to find that out.
  return detail::scatter_while_still(positions, std::vector<double>(kFrames, 0.5 * kNoise));
}

Eigen::Vector2d plucked(int n, int release) {
  const double t = std::max(0, n - release);
  return {0.0, 8.0 * std::exp(-t / 25.0) * std::cos(0.9 * t)};
}

// Some ten to fifty stretches of 20 degrees of freedom: 10 % of one sigma at most.
constexpr double kWithin = 0.15 * kNoise;

TEST(NoiseFloor, IsTheScatterBeforeTheRelease) {
  EXPECT_NEAR(floor_of([](int n) { return plucked(n, 80); }), kNoise, kWithin);
}

TEST(NoiseFloor, IsTheScatterOnceAllHasSettled) {
  EXPECT_NEAR(floor_of([](int n) { return plucked(n, 0); }), kNoise, kWithin);
}

TEST(NoiseFloor, SlowDriftDoesNotCount) {
  EXPECT_NEAR(
      floor_of([](int n) { return Eigen::Vector2d(0.02 * n, -0.01 * n); }), kNoise, kWithin);
}

TEST(NoiseFloor, IsNoNumberWhileTheMarkerNeverRests) {
  EXPECT_TRUE(
      std::isnan(floor_of([](int n) { return Eigen::Vector2d(0.0, 5.0 * std::cos(0.3 * n)); })));
  EXPECT_TRUE(std::isnan(floor_of([](int) { return Eigen::Vector2d::Constant(kNaN); })));
}

}  // namespace
}  // namespace twang::test
