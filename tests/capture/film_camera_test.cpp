// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/film_camera.hpp"

#include <gtest/gtest.h>

namespace twang::test {
namespace {

using detail::FilmCamera;

/// A tilted and rolled view on a box, along +y with z up.
FilmCamera tilted_camera() {
  return FilmCamera(Camera{},
                    {{-30e-3, 0.0, -10e-3}, {50e-3, 8e-3, 25e-3}},
                    {.tilt_rad = 0.5, .roll_rad = -0.2, .margin_px = 5.0});
}

const Eigen::Vector3d kPoint(41e-3, 3e-3, -7e-3);

TEST(FilmCamera, JacobianIsTheDerivative) {
  const FilmCamera camera = tilted_camera();
  constexpr double kStep = 1e-6;  // [m]
  const Eigen::Vector3d right = kStep * Camera{}.image_right;
  const Eigen::Vector3d down = kStep * Camera{}.image_down;
  Eigen::Matrix2d differences;
  differences << camera.pixel_from_rig(kPoint + right) - camera.pixel_from_rig(kPoint - right),
      camera.pixel_from_rig(kPoint + down) - camera.pixel_from_rig(kPoint - down);
  differences /= 2.0 * kStep;
  // Central differences: rounding of 1e-13 px over 1e-6 m, on derivatives of 1e3 to 1e4 px/m.
  EXPECT_LT((camera.jacobian(kPoint) - differences).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_GT(std::abs(differences(0, 1)), 10.0);  // no entry is idle
}

TEST(FilmCamera, PlaneFromPixelUndoesTheView) {
  const FilmCamera camera = tilted_camera();
  const Eigen::Vector2d a = camera.plane_from_pixel(camera.pixel_from_rig(kPoint));
  const Eigen::Vector2d b = camera.plane_from_pixel(camera.pixel_from_rig({0.0, 0.0, 0.0}));
  EXPECT_NEAR(a.x() - b.x(), kPoint.x(), 1e-12);   // rounding
  EXPECT_NEAR(a.y() - b.y(), -kPoint.z(), 1e-12);  // down is -z
}

TEST(FilmCamera, IgnoresDepthAlongTheLineOfSight) {
  const FilmCamera camera = tilted_camera();
  const Eigen::Vector3d behind = kPoint + Eigen::Vector3d(0.0, 20e-3, 0.0);
  EXPECT_LT((camera.pixel_from_rig(behind) - camera.pixel_from_rig(kPoint)).norm(), 1e-12);
}

}  // namespace
}  // namespace twang::test
