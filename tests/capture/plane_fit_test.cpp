// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/constants.hpp"
#include "core/error.hpp"
#include "tests/capture/slanted_plane.hpp"
#include "tests/support/expect_refusal.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace twang::test {
namespace {

TEST(Homography, IsRecoveredFromFourPoints) {
  const PointPairs pairs = pairs_of(px_from_plane(), kBench_m);
  const Homography found = fit_homography(pairs);
  for (const Eigen::Vector2d& other : {Eigen::Vector2d(0.04, 0.0), {0.1, -0.05}}) {
    // Round-off of the decomposition.
    EXPECT_LT((map_point(found, other) - map_point(px_from_plane(), other)).norm(), 1e-8);
  }
}

TEST(Homography, MinimisesTheDistancesOfManyPoints) {
  Points points = kBench_m;
  for (int i = 0; i < 5; ++i) points.emplace_back(0.02 * i, 0.01 * (i % 3) - 0.01);
  PointPairs pairs = pairs_of(px_from_plane(), points);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 0.3);
  for (auto& point : pairs.to) point += Eigen::Vector2d(noise(random), noise(random));
  const auto cost = [&](const Homography& map) {
    double square = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      square += (map_point(map, pairs.from[i]) - pairs.to[i]).squaredNorm();
    }
    return square;
  };
  const Homography best = fit_homography(pairs);
  // The least squares: any small change of any of the eight entries costs.
  for (int k = 0; k < 8; ++k) {
    for (const double sign : {1.0, -1.0}) {
      Homography other = best;
      other(k / 3, k % 3) += sign * 1e-4 * std::max(1.0, std::abs(best(k / 3, k % 3)));
      EXPECT_GT(cost(other), cost(best)) << k;
    }
  }
}

TEST(Homography, RefusesPointsOnALine) {
  PointPairs pairs;
  for (int i = 0; i < 5; ++i) {
    pairs.from.emplace_back(0.01 * i, 0.02 * i);
    pairs.to.emplace_back(10.0 * i, 20.0 * i);
  }
  EXPECT_TRUE(holds(refusal_of([&] { static_cast<void>(fit_homography(pairs)); }), "on a line"));
}

TEST(Homography, JacobianIsTheDerivative) {
  const Eigen::Vector2d at(0.03, -0.01);
  const double step = 1e-6;
  const Eigen::Matrix2d jacobian = map_jacobian(px_from_plane(), at);
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2d way = step * Eigen::Vector2d::Unit(k);
    const Eigen::Vector2d slope =
        (map_point(px_from_plane(), at + way) - map_point(px_from_plane(), at - way)) / (2 * step);
    EXPECT_LT((slope - jacobian.col(k)).norm(), 1e-5 * jacobian.norm());  // central differences
  }
}

TEST(Similarity, IsRecoveredAndNeverReflects) {
  Homography map = Homography::Identity();
  map.topLeftCorner<2, 2>() = 6000.0 * Eigen::Rotation2Dd(0.2).toRotationMatrix();
  map.topRightCorner<2, 1>() << 100.0, 50.0;
  const Homography found = fit_similarity_map(pairs_of(map, {kBench_m[0], kBench_m[2]}));
  EXPECT_LT((found - map).norm(), 1e-9 * map.norm());
  const PointPairs mirrored{kBench_m, {{7, -22}, {-87, -25}, {-82, 21}, {9, 19}}};
  EXPECT_GT((fit_similarity_map(mirrored).topLeftCorner<2, 2>().determinant()), 0.0);
}

}  // namespace
}  // namespace twang::test
