// SPDX-License-Identifier: GPL-3.0-or-later
// Plant and walker on the coarsest mesh that keeps four of their shapes, beside references that a
// test can afford; bench/coarsened_modes goes further.
#include "coarsen/mesh_ladder.hpp"
#include "rigs/load_rig.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

namespace twang {
namespace {

struct Shape {
  const char* rig;
  double coarse_dx_m;  ///< of the mesh that is to be chosen
  long max_dofs;
  double most_after;  ///< mean frequency error that is left [-]
};
void PrintTo(const Shape& shape, std::ostream* out) { *out << shape.rig; }

class PaperShape : public testing::TestWithParam<Shape> {};

void print(const CoarseCandidate& candidate) {
  fmt::print(
      "{} at {:.4g} mm: shapes to {:.1f} %, mean error of ten frequencies {:.1f} % -> {:.1f} %\n",
      to_string(candidate.element),
      1e3 * candidate.dx_m,
      100.0 * candidate.comparison.max_difference,
      100.0 * candidate.mean_frequency_error_before,
      100.0 * candidate.mean_frequency_error_after);
}

TEST_P(PaperShape, KeepsFourShapesAndTenFrequenciesOnTheMeshThatIsChosen) {
  const Shape& shape = GetParam();
  RigNeeds needs;
  needs.part = true;
  needs.clamp = true;
  const Rig rig = load_rig(std::string(TWANG_SOURCE_DIR) + "/rigs/" + shape.rig, needs);
  LadderOptions options;
  options.max_dofs = shape.max_dofs;
  options.enhanced_growth = 0.0;  // hex20 alone is the reference
  options.beside = true;
  const MeshLadder ladder = build_mesh_ladder(rig, options);
  EXPECT_EQ(ladder.reference.back().mesh.kind, ElementKind::Hex20);

  const CoarseCandidate& hex8 = ladder.chosen();
  print(hex8);
  EXPECT_EQ(hex8.element, ElementKind::Hex8);
  EXPECT_NEAR(hex8.dx_m, shape.coarse_dx_m, 1e-8);  // single precision of the surface
  EXPECT_TRUE(hex8.passes) << ladder.choice;
  ASSERT_GE(hex8.natural_frequency_hz.size(), 10);
  // Thin legs and leaves bend too stiffly, all alike: the authors' shapes have 27.1 % and 2.4 %.
  EXPECT_GT(hex8.mean_frequency_error_before, 0.1);
  EXPECT_LT(hex8.mean_frequency_error_after, shape.most_after);

  // hex8e hardly needs a rescale.
  ASSERT_TRUE(ladder.beside.has_value());
  print(*ladder.beside);
  EXPECT_LE(ladder.beside->comparison.max_difference, options.shape_tolerance);
  EXPECT_LT(ladder.beside->mean_frequency_error_before, 0.05);
}

// The bounds leave a half more than what is measured, 2.2 % and 1.9 %, of which most is due to two
// modes that twist more than they bend.
INSTANTIATE_TEST_SUITE_P(OfThinLeavesAndOfThinLegs,
                         PaperShape,
                         testing::Values(Shape{"plant.toml", 0.6e-3, 110000, 0.033},
                                         Shape{"walker.toml", 1.5e-3, 40000, 0.029}));

}  // namespace
}  // namespace twang
