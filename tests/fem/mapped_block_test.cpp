// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/mapped_block.hpp"

#include "core/constants.hpp"
#include "tests/support/expect_refusal.hpp"

#include <gtest/gtest.h>

namespace twang {
namespace {

using Eigen::Vector3d;

/// A tube of radii 1 and 2 and of length 3.
MappedBlock tube(int around) {
  MappedBlock block;
  block.cells = {2, around, 2};
  block.map = [](const Vector3d& s) {
    const double angle = 2.0 * kPi * s.y();
    const double r = 1.0 + s.x();
    return Vector3d(r * std::cos(angle), r * std::sin(angle), 3.0 * s.z());
  };
  block.closed = {false, true, false};
  return block;
}

TEST(MappedBlock, ClosesARingAndApproachesItsVolume) {
  const double exact = 9.0 * kPi;
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20}) {
    const HexMesh mesh = mesh_block(tube(24), kind);
    EXPECT_EQ(mesh.num_elements(), 96);
    const int corners = 3 * 24 * 3;
    const int edges = 2 * 24 * 3 + 3 * 24 * 3 + 3 * 24 * 2;
    EXPECT_EQ(mesh.num_nodes(), kind == ElementKind::Hex8 ? corners : corners + edges);
    // hex8: chords, sin(15 deg) / 15 deg in the area; hex20: parabolas, of order four.
    const double chords = std::sin(kPi / 12.0) / (kPi / 12.0);
    EXPECT_NEAR(mesh.volume() / exact, kind == ElementKind::Hex8 ? chords : 1.0, 1e-4);
    const double of_kind = kind == ElementKind::Hex8 ? mesh.volume() / (exact * chords) : 1.0;
    EXPECT_NEAR(of_kind, 1.0, 1e-12);
    EXPECT_EQ(surface_faces(mesh).size(), 2U * 24U * 2U + 2U * 24U * 2U);
  }
  const double coarse = mesh_block(tube(12), ElementKind::Hex20).volume() / exact - 1.0;
  const double fine = mesh_block(tube(24), ElementKind::Hex20).volume() / exact - 1.0;
  EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.1);
}

TEST(MappedBlock, RefusesWhatIsNoBlock) {
  const auto refusal = [](const MappedBlock& block) {
    return test::refusal_of([&] { (void)mesh_block(block, ElementKind::Hex8); });
  };
  MappedBlock block = tube(2);
  EXPECT_TRUE(test::holds(refusal(block), "2 cells along axis 1, must have 3"));
  block = tube(8);
  block.cells[0] = 0;
  EXPECT_TRUE(test::holds(refusal(block), "0 cells along axis 0"));
  block = tube(8);
  block.map = [](const Vector3d& s) { return Vector3d(s.y(), s.x(), s.z()); };
  block.closed = {};
  EXPECT_TRUE(test::holds(refusal(block), "inside out"));
  block.map = {};
  EXPECT_TRUE(test::holds(refusal(block), "no map"));
}

}  // namespace
}  // namespace twang
