// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/thinnest_wall.hpp"

#include "rigs/generators/paper_shapes.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/rigs.hpp"
#include "tests/support/surfaces.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

namespace twang {
namespace {

double wall_of(const SurfaceMesh& surface) {
  const test::TemporaryFolder folder;
  SurfaceFile file;
  file.file = folder / "part.stl";
  write_stl(file.file, surface);
  Rig rig = test::make_rig({});
  rig.parts.push_back({"part", file});
  return thinnest_wall_m(rig);
}

TEST(ThinnestWall, IsTheSmallestEdgeOfBoxesAndCylinders) {
  EXPECT_NEAR(thinnest_wall_m(test::l_rig()), 1.5e-3, 1e-15);
  Rig rig = test::beam_rig();
  rig.parts.push_back({"part", Cylinder{{0, 0, 0}, {0.001, 0, 0}, 0.004}});
  EXPECT_NEAR(thinnest_wall_m(rig), 1e-3, 1e-15);
  rig.parts.back().shape = Cylinder{{0, 0, 0}, {0.1, 0, 0}, 0.0007};
  EXPECT_NEAR(thinnest_wall_m(rig), 1.4e-3, 1e-15);
  EXPECT_TRUE(test::holds(test::refusal_of([] { (void)thinnest_wall_m(test::make_rig({})); }),
                          "has no [[part]]"));
}

TEST(ThinnestWall, FindsALegOfASurfaceAlongAnyAxis) {
  // 1e-9 m: single precision of the file
  SurfaceMesh surface = jumper();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(wall_of(surface), 1.5e-3, 1e-9) << axis;
    const Eigen::Matrix3Xd turned = surface.vertices;
    for (int i = 0; i < 3; ++i) surface.vertices.row(i) = turned.row((i + 1) % 3);
  }
}

TEST(ThinnestWall, OfABallIsTheChordThatTwoInAHundredLinesDoNotReach) {
  // Chords at the distance s from the middle are 2 sqrt(1 - s²) long; beyond s² = 0.98 are 2 %.
  const double expected = 2.0 * 0.01 * std::sqrt(0.02);
  // 3 %: two hundred lines across, a ball of eighty latitudes
  EXPECT_NEAR(wall_of(test::sphere({0, 0, 0}, 0.01, 80)) / expected, 1.0, 0.03);
}

TEST(ThinnestWall, CountsBodiesThatOverlapAsOne) {
  const SurfaceMesh one = test::box_surface(test::box_mm({0, 0, 0}, {10, 10, 10}));
  const SurfaceMesh two = test::box_surface(test::box_mm({8, 0, 0}, {18, 10, 10}));
  EXPECT_NEAR(wall_of(test::together({one, two})), 1e-2, 1e-8);
}

}  // namespace
}  // namespace twang
