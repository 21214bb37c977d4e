// SPDX-License-Identifier: GPL-3.0-or-later
// Which element, which materials: what the choice among the meshes of a ladder depends on.
#include "coarsen/mesh_ladder.hpp"
#include "core/error.hpp"
#include "tests/coarsen/rigs_of_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace twang {
namespace {

using test::mm;
using test::short_beam;
using test::small_ladder;

TEST(MeshLadder, EnhancedHexahedraGoOnWhereHex20EndsBeforeItIsConvergent) {
  LadderOptions options = small_ladder();
  options.convergent_change = 1e-3;  // out of reach
  options.enhanced_growth = 0.0;
  const MeshLadder ended = build_mesh_ladder(short_beam(), options);
  for (const MeshRung& rung : ended.reference) EXPECT_EQ(rung.mesh.kind, ElementKind::Hex20);
  EXPECT_FALSE(ended.convergent);

  options.enhanced_growth = 4.0;
  const MeshLadder ladder = build_mesh_ladder(short_beam(), options);
  ASSERT_GE(ladder.reference.size(), ended.reference.size() + 2);
  const MeshRung& last_hex20 = ended.reference.back();
  const MeshRung& first_enhanced = ladder.reference[ended.reference.size()];
  EXPECT_EQ(first_enhanced.mesh.kind, ElementKind::Hex8e);
  EXPECT_EQ(first_enhanced.mesh.requested_dx_m, last_hex20.mesh.requested_dx_m);
  EXPECT_LE(ladder.reference.back().mesh.num_dofs(), 4 * options.max_dofs);
  EXPECT_LT(ladder.reference.back().mesh.requested_dx_m, last_hex20.mesh.requested_dx_m);
  // Both say the same within what they say is uncertain, one sigma each.
  EXPECT_LT(std::abs(ladder.limit.lambda_per_s2 / ended.limit.lambda_per_s2 - 1.0),
            2.0 * (ladder.limit.relative_sigma + ended.limit.relative_sigma));
  EXPECT_LE(ladder.limit.relative_sigma, ended.limit.relative_sigma);
}

TEST(MeshLadder, TheCoarseElementIsTheOneAskedFor) {
  LadderOptions options = small_ladder();
  options.beside = true;
  const MeshLadder plain = build_mesh_ladder(short_beam(), options);
  EXPECT_EQ(plain.coarse.mesh.kind, ElementKind::Hex8);
  ASSERT_TRUE(plain.beside.has_value());
  EXPECT_EQ(plain.beside->element, ElementKind::Hex8e);
  EXPECT_EQ(plain.beside->num_elements, plain.chosen().num_elements);

  options.coarse_element = ElementKind::Hex8e;
  options.beside = false;
  const MeshLadder enhanced = choose_again(short_beam(), plain, options);
  EXPECT_EQ(enhanced.coarse.mesh.kind, ElementKind::Hex8e);
  EXPECT_EQ(enhanced.chosen().element, ElementKind::Hex8e);
  EXPECT_FALSE(enhanced.beside.has_value());
  EXPECT_EQ(enhanced.limit.lambda_per_s2, plain.limit.lambda_per_s2);
  // Without the stiffening of hex8 in bending, E_n is all but E.
  EXPECT_LT(std::abs(enhanced.identified_over_numerical() - 1.0),
            0.25 * std::abs(plain.identified_over_numerical() - 1.0));
  // Chosen anew as at first: nothing is left of the choice before.
  const MeshLadder again = choose_again(short_beam(), enhanced, small_ladder());
  EXPECT_EQ(again.choice, plain.choice);
  EXPECT_EQ(again.notes, plain.notes);
  EXPECT_EQ(again.candidates.size(), plain.candidates.size());
}

/// A beam of a stiff and a soft half whose border lies at `border_mm`.
Rig two_halves(double border_mm) {
  Rig rig = short_beam();
  RigMaterial soft = rig.materials.front();
  soft.name = "soft";
  rig.materials.front().youngs_modulus_pa = 2e9;
  soft.youngs_modulus_pa = 5e8;
  rig.materials.push_back(soft);
  rig.parts.push_back({"soft", Box{mm(border_mm, 0, 0), mm(40, 10, 5)}});
  return rig;
}

TEST(MeshLadder, OfSeveralMaterialsBelongsToTheModuliStated) {
  const MeshLadder ladder = build_mesh_ladder(two_halves(20), small_ladder());
  EXPECT_TRUE(ladder.stated_moduli);
  EXPECT_FALSE(build_mesh_ladder(short_beam(), small_ladder()).stated_moduli);
  Rig all_stiff = two_halves(20);
  all_stiff.materials.back().youngs_modulus_pa = 2e9;
  Rig alone = short_beam();
  alone.materials.front().youngs_modulus_pa = 2e9;
  // The same body, once at its modulus and once at 1 Pa; round-off.
  EXPECT_NEAR(build_mesh_ladder(all_stiff, small_ladder()).limit.lambda_per_s2 /
                  build_mesh_ladder(alone, small_ladder()).limit.lambda_per_s2,
              2e9,
              2e9 * 1e-8);
  Rig unstated = two_halves(20);
  unstated.materials.back().youngs_modulus_pa.reset();
  try {
    (void)build_mesh_ladder(unstated, small_ladder());
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("\"soft\" states no youngs_modulus_pa"),
              std::string::npos)
        << error.what();
  }
}

TEST(MeshLadder, CoarseningEndsWhereACellWouldHoldTwoMaterials) {
  LadderOptions lenient = small_ladder();
  lenient.shape_tolerance = 0.9;  // shapes do not stop it
  // Cells of 2.5 and 5 mm fit a border at 25 mm; 10 mm ones do not.
  const MeshLadder ladder = build_mesh_ladder(two_halves(25), lenient);
  EXPECT_NEAR(ladder.coarse.mesh.requested_dx_m, 5e-3, 1e-15);
  EXPECT_EQ(ladder.chosen().num_mixed_cells, 0);
  EXPECT_GT(ladder.candidates.back().num_mixed_cells, 0);
  EXPECT_FALSE(ladder.candidates.back().passes);
  const auto says = [](const MeshLadder& of, const char* words) {
    return std::any_of(of.notes.begin(), of.notes.end(), [&](const std::string& note) {
      return note.find(words) != std::string::npos;
    });
  };
  EXPECT_TRUE(says(ladder, "coarsening ends at 5 mm")) << ladder.notes.size();
  // One material has no borders.
  Rig one = two_halves(25);
  one.parts.back().material = one.parts.front().material;
  const MeshLadder coarser = build_mesh_ladder(one, lenient);
  EXPECT_GT(coarser.coarse.mesh.requested_dx_m, 5.1e-3);
  EXPECT_FALSE(says(coarser, "coarsening ends"));
  // A border that no cells fit is said.
  const MeshLadder crooked = build_mesh_ladder(two_halves(20.777), lenient);
  EXPECT_GT(crooked.chosen().num_mixed_cells, 0);
  EXPECT_TRUE(says(crooked, "hold more than one material"));
}

TEST(MeshLadder, StairsLeaveTheLastChangeUncertain) {
  // A cylinder along x: no cell size fits it, and each halving changes its stairs.
  Rig rig = short_beam();
  rig.parts = {{"part", Cylinder{mm(0, 0, 0), mm(40, 0, 0), 4e-3}}};
  rig.clamps = {{mm(0, -4, -4), mm(0, 4, 4)}};
  LadderOptions options = small_ladder();
  options.start_dx_m = 2e-3;
  const MeshLadder ladder = build_mesh_ladder(rig, options);
  ASSERT_GE(ladder.reference.size(), 2U);
  const std::size_t n = ladder.reference.size();
  ASSERT_EQ(ladder.reference[n - 2].mesh.kind, ladder.reference[n - 1].mesh.kind);
  const double change = std::abs(ladder.reference[n - 2].modes.lambda_per_s2(0) /
                                     ladder.reference[n - 1].modes.lambda_per_s2(0) -
                                 1.0);
  EXPECT_GE(ladder.limit.relative_sigma, change);
}

}  // namespace
}  // namespace twang
