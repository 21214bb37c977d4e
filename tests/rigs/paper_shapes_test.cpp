// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/generators/paper_shapes.hpp"

#include "core/atomic_file.hpp"
#include "core/constants.hpp"
#include "rigs/closed_surface.hpp"
#include "rigs/load_rig.hpp"
#include "rigs/solid_shapes.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

namespace twang {
namespace {

const std::filesystem::path kRigs = std::filesystem::path(TWANG_SOURCE_DIR) / "rigs";

Eigen::Matrix2Xd outline(std::initializer_list<Eigen::Vector2d> corners) {
  Eigen::Matrix2Xd result(2, static_cast<Eigen::Index>(corners.size()));
  Eigen::Index i = 0;
  for (const Eigen::Vector2d& corner : corners) result.col(i++) = corner;
  return result;
}

TEST(Extrude, EnclosesAreaTimesDepthAndFacesOutwards) {
  // A U whose corners cannot all be cut off from the first one: area 9 - 1 * 2.
  const SurfaceMesh u =
      extrude(outline({{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}}), -0.5, 1.5);
  const ClosedSurface closed = close_surface(u, "u");
  EXPECT_TRUE(closed.notes.empty());
  EXPECT_NEAR(closed.volume_m3, 14.0, 1e-13);  // round-off
  EXPECT_EQ(closed.num_shells, 1);
}

TEST(Extrude, RefusesWhatIsNoOutline) {
  const auto refusal = [](const Eigen::Matrix2Xd& corners) {
    return test::refusal_of([&] { (void)extrude(corners, 0.0, 1.0); });
  };
  EXPECT_TRUE(test::holds(refusal(outline({{0, 0}, {1, 0}})), "three corners"));
  EXPECT_TRUE(test::holds(refusal(outline({{0, 0}, {0, 1}, {1, 1}, {1, 0}})), "clockwise"));
}

TEST(SolidShapes, EncloseTheirClosedForms) {
  constexpr int kSides = 64;
  // area of a regular polygon of 64 sides over that of its circle
  const double chords = kSides * std::sin(2.0 * kPi / kSides) / (2.0 * kPi);
  const double cone = kPi / 3.0 * 2.0 * (9.0 + 3.0 + 1.0) * chords;
  EXPECT_NEAR(close_surface(revolve(outline({{3, 0}, {1, 2}}), kSides), "cone").volume_m3 / cone,
              1.0,
              1e-12);
  Eigen::Matrix3Xd path(3, 3);
  path << 0, 1, 2, 0, 2, 4, 0, 2, 4;
  const Eigen::Vector3d radii(0.5, 0.5, 0.5);
  const ClosedSurface tube = close_surface(sweep(path, radii, kSides), "tube");
  EXPECT_NEAR(tube.volume_m3 / (kPi * 0.25 * 6.0 * chords), 1.0, 1e-12);
  EXPECT_TRUE(tube.notes.empty());
  const Eigen::Vector3d widths(1, 1, 1);
  const ClosedSurface strip = close_surface(ribbon(path, widths, 0.1), "strip");
  EXPECT_NEAR(strip.volume_m3 / 0.6, 1.0, 1e-12);
  EXPECT_TRUE(strip.notes.empty());
}

TEST(PaperShapes, AreClosedFaceOutwardsAndHaveTheirVolumes) {
  for (const auto& [name, surface] : paper_shapes()) {
    const ClosedSurface closed = close_surface(surface, name);
    EXPECT_TRUE(closed.notes.empty()) << name;
    EXPECT_GT(closed.volume_m3, 0.0) << name;
  }
  const double voxel = std::pow(1.5e-3, 3);
  EXPECT_NEAR(enclosed_volume(jumper()) / voxel, 5408.0, 1e-6);  // the paper's table: 5.4 K
  EXPECT_NEAR(enclosed_volume(plant_stem()) + enclosed_volume(plant_leaves()), 1e-6, 0.15e-6);
}

TEST(PaperShapes, AreTheFilesThatTheRigsLoad) {
  const test::TemporaryFolder folder;
  for (const auto& [name, surface] : paper_shapes()) {
    write_stl(folder / name, surface);
    const SurfaceMesh written = read_surface({folder / name, 1e-3, Eigen::Vector3d::Zero(), {}});
    const SurfaceMesh shipped =
        read_surface({kRigs / "shapes" / name, 1e-3, Eigen::Vector3d::Zero(), {}});
    ASSERT_EQ(written.vertices.cols(), shipped.vertices.cols()) << name;
    // 1e-8 m: sines of another library, rounded to single precision
    EXPECT_LT((written.vertices - shipped.vertices).lpNorm<Eigen::Infinity>(), 1e-8) << name;
  }
}

TEST(PaperShapes, MakeRigsThatLoad) {
  for (const char* name : {"jumper", "flipper", "catapult", "plant", "flamingo", "walker"}) {
    const Rig rig = load_rig(kRigs / (std::string(name) + ".toml"), {.part = true});
    EXPECT_EQ(rig.name, name);
    const Box box = rig.bounding_box();
    EXPECT_GT((box.max - box.min).minCoeff(), 0.015) << name;
    EXPECT_LT((box.max - box.min).maxCoeff(), 0.12) << name;
  }
}

}  // namespace
}  // namespace twang
