// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/surface_distance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace twang {
namespace {

using Eigen::Vector3d;

/// A square sheet of n x n squares in z = 0, side 1.
struct Sheet {
  Eigen::Matrix3Xd vertices;
  std::vector<Triangle> triangles;
};
Sheet make_sheet(int n) {
  Sheet sheet;
  sheet.vertices.resize(3, (n + 1) * (n + 1));
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      sheet.vertices.col(j * (n + 1) + i) = Vector3d(i, j, 0) / n;
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i;
      sheet.triangles.push_back({a, a + 1, a + n + 2});
      sheet.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  }
  return sheet;
}

TEST(ClosestPointOfTriangle, IsNoFartherThanAnyOfManyPointsOfIt) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto random_point = [&] {
    return Vector3d(uniform(generator), uniform(generator), uniform(generator));
  };
  for (int trial = 0; trial < 200; ++trial) {
    const Vector3d p = random_point();
    const Vector3d a = random_point();
    const Vector3d b = random_point();
    const Vector3d c = random_point();
    double sampled = std::numeric_limits<double>::infinity();
    constexpr int kSteps = 60;
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; i + j <= kSteps; ++j) {
        const Vector3d q = a + (b - a) * i / kSteps + (c - a) * j / kSteps;
        sampled = std::min(sampled, (q - p).norm());
      }
    }
    const double found = (closest_point_of_triangle(p, a, b, c) - p).norm();
    EXPECT_LE(found, sampled + 1e-12);
    // Sides are at most 3.5 long: no point is farther than a grid step from a sampled one.
    EXPECT_GE(found, sampled - 3.5 / kSteps);
  }
}

TEST(HausdorffDistance, IsTheShiftAcrossAPlane) {
  const Sheet sheet = make_sheet(8);
  Eigen::Matrix3Xd shifted = sheet.vertices;
  shifted.row(2).array() += 0.25;
  EXPECT_NEAR(hausdorff_distance(sheet.vertices, shifted, sheet.triangles), 0.25, 1e-12);
}

TEST(HausdorffDistance, DoesNotSeeSlidingAlongTheSurface) {
  const Sheet sheet = make_sheet(8);
  Eigen::Matrix3Xd slid = sheet.vertices;
  for (Eigen::Index i = 0; i < slid.cols(); ++i) {
    const double x = slid(0, i);
    slid(0, i) += 0.2 * x * (1.0 - x);  // the outline stays
  }
  EXPECT_NEAR(hausdorff_distance(sheet.vertices, slid, sheet.triangles), 0.0, 1e-12);
  EXPECT_GT((slid - sheet.vertices).colwise().norm().maxCoeff(), 0.04);
}

TEST(HausdorffDistance, LooksBothWays) {
  const Sheet sheet = make_sheet(8);
  Eigen::Matrix3Xd shrunk = sheet.vertices;
  shrunk.row(0) *= 0.5;  // each of its points lies on the sheet, but not the other way round
  EXPECT_NEAR(hausdorff_distance(sheet.vertices, shrunk, sheet.triangles), 0.5, 1e-12);
  EXPECT_NEAR(hausdorff_distance(shrunk, sheet.vertices, sheet.triangles), 0.5, 1e-12);
}

TEST(HausdorffDistance, EqualsTheSearchOfAllTriangles) {
  const Sheet sheet = make_sheet(9);
  std::mt19937 generator(11);
  std::normal_distribution<double> normal(0.0, 0.1);
  Eigen::Matrix3Xd first = sheet.vertices;
  Eigen::Matrix3Xd second = sheet.vertices;
  for (Eigen::Index i = 0; i < first.size(); ++i) first.data()[i] += normal(generator);
  for (Eigen::Index i = 0; i < second.size(); ++i) second.data()[i] += normal(generator);

  const auto directed = [&](const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
    double largest = 0.0;
    for (Eigen::Index i = 0; i < from.cols(); ++i) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const Triangle& t : sheet.triangles) {
        const Vector3d q =
            closest_point_of_triangle(from.col(i), to.col(t[0]), to.col(t[1]), to.col(t[2]));
        nearest = std::min(nearest, (q - from.col(i)).norm());
      }
      largest = std::max(largest, nearest);
    }
    return largest;
  };
  EXPECT_DOUBLE_EQ(hausdorff_distance(first, second, sheet.triangles),
                   std::max(directed(first, second), directed(second, first)));
}

}  // namespace
}  // namespace twang
