// SPDX-License-Identifier: GPL-3.0-or-later
// Plant and walker on meshes that a test can afford; bench/coarsened_modes goes further.
#include "coarsen/mesh_ladder.hpp"
#include "rigs/load_rig.hpp"

#include <gtest/gtest.h>

#include <string>

namespace twang {
namespace {

struct Shape {
  const char* rig;
  double start_dx_m;
  double coarse_dx_m;
  long max_dofs;
};
void PrintTo(const Shape& shape, std::ostream* out) { *out << shape.rig; }

class PaperShape : public testing::TestWithParam<Shape> {};

TEST_P(PaperShape, TheRescaledModulusBringsTheFirstTenFrequenciesNearer) {
  const Shape& shape = GetParam();
  RigNeeds needs;
  needs.part = true;
  needs.clamp = true;
  const Rig rig = load_rig(std::string(TWANG_SOURCE_DIR) + "/rigs/" + shape.rig, needs);
  LadderOptions options;
  options.coarse_dx_m = shape.coarse_dx_m;
  options.start_dx_m = shape.start_dx_m;
  options.max_dofs = shape.max_dofs;
  options.enhanced_growth = 6.0;
  options.beside = true;
  const MeshLadder ladder = build_mesh_ladder(rig, options);
  // The reference has half the cell size and another element: hex20 would not have come so far.
  EXPECT_EQ(ladder.reference.back().mesh.kind, ElementKind::Hex8e);
  EXPECT_NEAR(ladder.reference.back().mesh.requested_dx_m, 0.5 * shape.coarse_dx_m, 1e-12);
  const CoarseCandidate& hex8 = ladder.chosen();
  ASSERT_EQ(hex8.element, ElementKind::Hex8);
  ASSERT_GE(hex8.natural_frequency_hz.size(), 10);
  RecordProperty("before", std::to_string(hex8.mean_frequency_error_before));
  RecordProperty("after", std::to_string(hex8.mean_frequency_error_after));
  EXPECT_LT(hex8.mean_frequency_error_after, hex8.mean_frequency_error_before);
  // hex8 bends too stiffly, hex8e hardly so: its frequencies are nearer without any rescale.
  ASSERT_TRUE(ladder.beside.has_value());
  EXPECT_LT(ladder.beside->mean_frequency_error_before, hex8.mean_frequency_error_before);
}

INSTANTIATE_TEST_SUITE_P(OfThinLeavesAndOfThickLegs,
                         PaperShape,
                         testing::Values(Shape{"plant.toml", 0.575e-3, 0.575e-3, 100000},
                                         Shape{"walker.toml", 3e-3, 1.5e-3, 40000}));

}  // namespace
}  // namespace twang
