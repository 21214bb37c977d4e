// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/rig.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace twang {
namespace {

using Eigen::Vector3d;

TEST(Box, DistanceIsZeroInsideAndEuclideanOutside) {
  const Box box = {{1, 2, 3}, {4, 6, 8}};
  EXPECT_EQ(box.distance({2, 3, 4}), 0.0);
  EXPECT_EQ(box.distance({4, 6, 8}), 0.0);
  EXPECT_EQ(box.distance({0, 3, 4}), 1.0);
  EXPECT_EQ(box.distance({2, 9, 12}), 5.0) << "3 beyond in y, 4 in z";
  EXPECT_EQ(box.distance({-1, 0, 2}), 3.0) << "2, 2 and 1 short of the corner";
}

TEST(Box, ContainsItsFacesAndTheMargin) {
  const Box plane = {{0, 0, 0}, {0, 10, 2}};
  EXPECT_TRUE(plane.contains({0, 10, 2}, 0.0));
  EXPECT_FALSE(plane.contains({0.1, 5, 1}, 0.0));
  EXPECT_TRUE(plane.contains({0.1, 5, 1}, 0.1));
  EXPECT_FALSE(plane.contains({0.1, 5, 1}, -0.1));
}

TEST(PartSolid, BoxHoldsItsLowerFaceAndNotItsUpper) {
  const PartSolid solid = {"m", Box{{0, 0, 0}, {1, 1, 1}}};
  EXPECT_TRUE(contains(solid, {0, 0, 0}));
  EXPECT_TRUE(contains(solid, {0.5, 0.5, 0.999}));
  EXPECT_FALSE(contains(solid, {0.5, 0.5, 1.0}));
  EXPECT_FALSE(contains(solid, {1.0, 0.5, 0.5}));
}

TEST(PartSolid, CylinderIsBoundedAlongAndAcrossASlantedAxis) {
  const Vector3d axis = Vector3d(1, 2, 2) / 3.0;
  const Vector3d across = Vector3d(2, 1, -2) / 3.0;
  const Vector3d from(5, 6, 7);
  const PartSolid solid = {"m", Cylinder{from, from + 4.0 * axis, 1.5}};
  EXPECT_TRUE(contains(solid, from + 0.01 * axis + 1.49 * across));
  EXPECT_TRUE(contains(solid, from + 3.99 * axis - 1.49 * across));
  EXPECT_FALSE(contains(solid, from - 0.01 * axis));
  EXPECT_FALSE(contains(solid, from + 4.01 * axis));
  EXPECT_FALSE(contains(solid, from + 2.0 * axis + 1.51 * across));
}

TEST(Rig, BoundingBoxIsTightAroundASlantedCylinder) {
  // A disc of normal n and radius r reaches r sqrt(1 - n_i²) along axis i.
  const Vector3d axis = Vector3d(0.6, 0.0, 0.8);
  Rig rig;
  rig.parts = {{"m", Cylinder{Vector3d::Zero(), 10.0 * axis, 1.0}},
               {"m", Box{{-0.5, -3, 1}, {1, 0, 2}}}};
  const Box box = rig.bounding_box();
  EXPECT_TRUE(box.min.isApprox(Vector3d(-0.8, -3.0, -0.6), 1e-14));
  EXPECT_TRUE(box.max.isApprox(Vector3d(6.8, 1.0, 8.6), 1e-14));
  EXPECT_THROW((void)Rig{}.bounding_box(), InputError);
}

}  // namespace
}  // namespace twang
