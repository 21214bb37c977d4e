// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/observable.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace twang {
namespace {

using Eigen::Vector3d;
using Positions = std::vector<Vector3d>;

Rig displacement_rig() {
  Rig rig;
  rig.observable = {ObservableKind::Displacement, {"tip"}, {1.0, -2.0, 2.0}};
  return rig;
}

/// Seen along +y with x to the right and z up, unless the camera says otherwise.
Rig angle_rig() {
  Rig rig;
  rig.observable = {ObservableKind::Angle, {"a", "b"}, Vector3d::Zero()};
  rig.camera = Camera{};
  return rig;
}

/// Two points of a slanted line, off the image plane too.
const Positions kRest = {{0.012, 0.001, 0.023}, {0.042, -0.002, 0.031}};

Positions turned(const Positions& points, const Vector3d& axis, double angle) {
  const Eigen::AngleAxisd rotation(angle, axis.normalized());
  Positions result;
  for (const Vector3d& point : points) result.emplace_back(rotation * point);
  return result;
}

/// Central differences of the observable.
Eigen::Matrix3Xd gradient_by_differences(const Rig& rig,
                                         const Positions& positions,
                                         const Positions& rest) {
  constexpr double kStep_m = 1e-6;
  Eigen::Matrix3Xd gradient(3, static_cast<Eigen::Index>(positions.size()));
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      Positions plus = positions;
      Positions minus = positions;
      plus[i](axis) += kStep_m;
      minus[i](axis) -= kStep_m;
      gradient(axis, static_cast<Eigen::Index>(i)) =
          (evaluate_observable(rig, plus, rest) - evaluate_observable(rig, minus, rest)) /
          (2 * kStep_m);
    }
  }
  return gradient;
}

TEST(Observable, DisplacementIsTheComponentAlongTheDirection) {
  const Positions rest = {{0.1, 0.2, 0.3}};
  const Positions now = {{0.103, 0.2, 0.306}};
  // (0.003, 0, 0.006) . (1, -2, 2) / 3; 1e-16 m is rounding.
  EXPECT_NEAR(evaluate_observable(displacement_rig(), now, rest), 0.005, 1e-16);
  EXPECT_EQ(evaluate_observable(displacement_rig(), rest, rest), 0.0);
}

TEST(Observable, AngleIsPositiveAnticlockwiseAsSeenInTheImage) {
  // z is up and x right in the image: from x towards z is anticlockwise, about -y in the rig frame.
  for (const double angle : {-3.0, -0.5, 0.01, 1.0, 3.1}) {
    const Positions now = turned(kRest, -Vector3d::UnitY(), angle);
    EXPECT_NEAR(evaluate_observable(angle_rig(), now, kRest), angle, 1e-14) << angle;
  }
}

TEST(Observable, AngleChangesSignWhenTheCameraLooksFromBehind) {
  Rig behind = angle_rig();
  behind.camera->image_right = -Vector3d::UnitX();
  const Positions now = turned(kRest, -Vector3d::UnitY(), 0.3);
  EXPECT_NEAR(evaluate_observable(behind, now, kRest), -0.3, 1e-14);
}

TEST(Observable, AngleIgnoresMotionTowardsTheCameraAndTranslation) {
  Positions now = kRest;
  now[0] += Vector3d(0.004, 0.010, -0.003);
  now[1] += Vector3d(0.004, -0.020, -0.003);
  EXPECT_NEAR(evaluate_observable(angle_rig(), now, kRest), 0.0, 1e-15);
}

TEST(Observable, AngleOfHalfATurnIsPlusPi) {
  const Positions rest = {{0, 0, 0}, {1, 0, 0}};
  EXPECT_EQ(evaluate_observable(angle_rig(), {{0, 0, 0}, {-1, 0, 0.0}}, rest), kPi);
  EXPECT_EQ(evaluate_observable(angle_rig(), {{0, 0, 0}, {-1, 0, -0.0}}, rest), kPi);
}

TEST(Observable, UsesDefaultAxesWithoutACamera) {
  Rig rig = angle_rig();
  const Positions now = turned(kRest, -Vector3d::UnitY(), 0.2);
  const double with_camera = evaluate_observable(rig, now, kRest);
  rig.camera.reset();
  EXPECT_EQ(evaluate_observable(rig, now, kRest), with_camera);
}

TEST(ObservableGradient, OfADisplacementEqualsCentralDifferences) {
  const Positions rest = {{0.1, 0.2, 0.3}};
  const Positions now = {{0.11, 0.18, 0.33}};
  const Rig rig = displacement_rig();
  const auto gradient = observable_gradient(rig, now);
  // Linear: the differences err by rounding alone, 1e-16 m / 1e-6 m.
  EXPECT_LT((gradient - gradient_by_differences(rig, now, rest)).norm(), 1e-9);
  EXPECT_NEAR(gradient.norm(), 1.0, 1e-15);
}

TEST(ObservableGradient, OfAnAngleEqualsCentralDifferencesAtDisplacedPoints) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-0.01, 0.01);
  for (int trial = 0; trial < 20; ++trial) {
    Rig rig = angle_rig();
    const Eigen::Quaterniond pose(
        Eigen::AngleAxisd(100.0 * shift(random), Vector3d(1, 2, -1).normalized()));
    rig.camera->image_right = pose * rig.camera->image_right;
    rig.camera->image_down = pose * rig.camera->image_down;
    Positions now = kRest;
    for (Vector3d& point : now) point += Vector3d(shift(random), shift(random), shift(random));
    const auto gradient = observable_gradient(rig, now);
    // Step 1e-6 m over a line of about 0.02 m: truncation (h/L)² = 3e-9 of a gradient of 1/L.
    EXPECT_LT((gradient - gradient_by_differences(rig, now, kRest)).norm(), 1e-7 * gradient.norm());
    EXPECT_GT(gradient.norm(), 10.0) << "a gradient that is nearly zero proves nothing";
  }
}

TEST(Observable, RefusesWrongSizesAndARigWithout) {
  EXPECT_THROW((void)evaluate_observable(Rig{}, kRest, kRest), InputError);
  EXPECT_THROW((void)observable_gradient(Rig{}, kRest), InputError);
  EXPECT_THROW((void)evaluate_observable(displacement_rig(), kRest, kRest), InputError);
  EXPECT_THROW((void)evaluate_observable(angle_rig(), kRest, {kRest[0]}), InputError);
  EXPECT_THROW((void)observable_gradient(angle_rig(), {kRest[0]}), InputError);
}

TEST(Observable, NamesItsColumnAndUnit) {
  EXPECT_EQ(observable_column(ObservableKind::Displacement), "observable_mm");
  EXPECT_EQ(observable_column(ObservableKind::Angle), "observable_rad");
  EXPECT_EQ(observable_unit(ObservableKind::Displacement), "mm");
  EXPECT_EQ(observable_unit(ObservableKind::Angle), "rad");
}

TEST(Unwrap, RestoresASmoothTurnThroughManyTurnsAndGaps) {
  std::vector<double> truth;
  std::vector<double> wrapped;
  for (int i = 0; i < 200; ++i) {
    truth.push_back(0.5 + 20.0 * std::sin(0.05 * i));
    wrapped.push_back(std::remainder(truth.back(), kTwoPi));
    if (i % 7 == 3) wrapped.back() = kNaN;
  }
  unwrap(wrapped);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (i % 7 == 3) {
      EXPECT_TRUE(std::isnan(wrapped[i]));
    } else {
      EXPECT_NEAR(wrapped[i], truth[i], 1e-13) << i;
    }
  }
}

TEST(Unwrap, LeavesSmallAnglesAndAnEmptySequenceAlone) {
  std::vector<double> small = {kNaN, 0.1, -3.0, 0.1};
  unwrap(small);
  EXPECT_EQ(small[1], 0.1);
  EXPECT_EQ(small[2], -3.0);
  EXPECT_EQ(small[3], 0.1);
  std::vector<double> none;
  unwrap(none);
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace twang
