// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/mesh_ladder.hpp"

#include "coarsen/detail/ladder_steps.hpp"
#include "coarsen/detail/mesh_rung.hpp"
#include "core/error.hpp"
#include "tests/coarsen/rigs_of_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace twang {
namespace {

using test::mm;
using test::short_beam;
using test::small_ladder;

TEST(LadderOptions, DefaultsPass) { EXPECT_NO_THROW(LadderOptions{}.check()); }

TEST(LadderOptions, EachBoundIsRefused) {
  const std::vector<std::function<void(LadderOptions&)>> wrong = {
      [](LadderOptions& o) { o.start_dx_m = 0.0; },
      [](LadderOptions& o) { o.coarse_dx_m = -1e-3; },
      [](LadderOptions& o) { o.convergent_change = 0.0; },
      [](LadderOptions& o) { o.accurate_change = 1.0; },
      [](LadderOptions& o) { o.shape_tolerance = -0.05; },
      [](LadderOptions& o) { o.num_modes = 0; },
      [](LadderOptions& o) { o.num_frequencies = 0; },
      [](LadderOptions& o) { o.max_dofs = 0; },
      [](LadderOptions& o) { o.enhanced_growth = -1.0; },
      [](LadderOptions& o) { o.coarse_element = ElementKind::Hex20; }};
  for (const auto& spoil : wrong) {
    LadderOptions options;
    spoil(options);
    EXPECT_THROW(options.check(), InputError);
  }
}

TEST(MeshLadder, RefusesARigThatLeavesNothingToIdentify) {
  Rig without_part = short_beam();
  without_part.parts.clear();
  EXPECT_THROW((void)build_mesh_ladder(without_part), InputError);

  Rig without_clamp = short_beam();
  without_clamp.clamps.clear();
  EXPECT_THROW((void)build_mesh_ladder(without_clamp), InputError);

  Rig of_two_materials = short_beam();
  RigMaterial other = of_two_materials.materials.front();
  other.name = "other";
  of_two_materials.materials.push_back(other);
  of_two_materials.parts.push_back({"other", Box{mm(30, 0, 0), mm(40, 10, 5)}});
  EXPECT_THROW((void)build_mesh_ladder(of_two_materials), InputError);
}

TEST(CountDofs, EqualsTheMeshThatIsBuilt) {
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20}) {
    EXPECT_EQ(count_dofs(short_beam(), 2.5e-3, kind),
              mesh_part(short_beam(), 2.5e-3, kind).num_dofs());
    EXPECT_EQ(count_dofs(test::l_rig(), 1.5e-3, kind),
              mesh_part(test::l_rig(), 1.5e-3, kind).num_dofs());
  }
}

TEST(StartingDx, IsTheSmallestEdgeOfTheSolids) {
  std::vector<std::string> notes;
  EXPECT_DOUBLE_EQ(starting_dx(short_beam(), {}, notes), 5e-3);
  EXPECT_NEAR(starting_dx(test::l_rig(), {}, notes), 1.5e-3, 1e-15);  // a difference of coordinates
  Rig with_post = short_beam();
  with_post.parts.push_back({"part", Cylinder{mm(35, 5, 5), mm(35, 5, 25), 2e-3}});
  EXPECT_DOUBLE_EQ(starting_dx(with_post, {}, notes), 4e-3);
  EXPECT_TRUE(notes.empty());
}

TEST(StartingDx, IsHalvedUntilNoSolidSlipsThroughTheCells) {
  // A web of 1 mm whose middle falls on a face of 1 mm cells holds none of their centres but those
  // of its lower face; moved by a hundredth, it holds none.
  Rig rig = test::rig_of_boxes({{mm(0, 0, 0), mm(20, 10, 2)},
                                {mm(9.51, 0, 2), mm(10.49, 10, 12)},
                                {mm(0, 0, 12), mm(20, 10, 14)}},
                               {mm(0, 0, 0), mm(20, 10, 0)},
                               0.3,
                               1000.0);
  std::vector<std::string> notes;
  EXPECT_LT(starting_dx(rig, {}, notes), 0.98e-3);
}

TEST(StartingDx, IsDoubledWhereTheMeshWouldBeTooLargeAndSaysSo) {
  std::vector<std::string> notes;
  LadderOptions options;
  options.start_dx_m = 1.25e-3;
  options.max_dofs = 3000;
  EXPECT_DOUBLE_EQ(starting_dx(short_beam(), options, notes), 2.5e-3);  // 2607 unknowns
  EXPECT_EQ(notes.size(), 1U);
  options.max_dofs = 10;
  EXPECT_THROW((void)starting_dx(short_beam(), options, notes), InputError);
}

TEST(MeshLadder, HalvesFromRungToRungAndFillsEveryPart) {
  const MeshLadder ladder = build_mesh_ladder(short_beam(), small_ladder());
  ASSERT_GE(ladder.reference.size(), 2U);
  for (std::size_t i = 1; i < ladder.reference.size(); ++i) {
    const MeshRung& before = ladder.reference[i - 1];
    const MeshRung& rung = ladder.reference[i];
    const bool goes_on = rung.mesh.kind != before.mesh.kind;
    EXPECT_DOUBLE_EQ(rung.mesh.requested_dx_m, before.mesh.requested_dx_m / (goes_on ? 1.0 : 2.0));
    if (goes_on) continue;
    EXPECT_LT(rung.modes.lambda_per_s2(0),
              before.modes.lambda_per_s2(0));  // a conforming mesh is too stiff
  }
  EXPECT_EQ(ladder.reference.front().mesh.kind, ElementKind::Hex20);
  EXPECT_LT(ladder.limit.lambda_per_s2, ladder.reference.back().modes.lambda_per_s2(0));
  EXPECT_GT(ladder.limit.relative_sigma, 0.0);
  ASSERT_TRUE(ladder.accurate_rung.has_value());
  EXPECT_EQ(ladder.coarse.mesh.kind, ElementKind::Hex8);
  EXPECT_FALSE(ladder.choice.empty());
  ASSERT_FALSE(ladder.candidates.empty());
  for (std::size_t i = 0; i < ladder.candidates.size(); ++i) {
    const CoarseCandidate& candidate = ladder.candidates[i];
    if (i > 0) {
      EXPECT_DOUBLE_EQ(candidate.dx_m, 2.0 * ladder.candidates[i - 1].dx_m);
      EXPECT_GT(candidate.natural_frequency_hz(0),
                ladder.candidates[i - 1].natural_frequency_hz(0));  // coarser is stiffer
    }
    EXPECT_EQ(candidate.passes, candidate.comparison.max_difference <= 0.05);
    EXPECT_GT(candidate.mean_frequency_error_before, 0.0);
  }
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

TEST(StartingDx, IsHalvedUntilBordersOfMaterialsFallOnCellFaces) {
  std::vector<std::string> notes;
  EXPECT_DOUBLE_EQ(starting_dx(two_halves(25), {}, notes), 5e-3);
  EXPECT_DOUBLE_EQ(starting_dx(two_halves(22.5), {}, notes), 2.5e-3);
  EXPECT_TRUE(notes.empty());
  LadderOptions options;
  options.max_dofs = 20000;
  EXPECT_DOUBLE_EQ(starting_dx(two_halves(20.777), options, notes), 5e-3);
  EXPECT_EQ(notes.size(), 1U);
}

TEST(MeshLadder, TakesTheCoarsestMeshThatKeepsTheShapes) {
  const MeshLadder ladder = build_mesh_ladder(short_beam(), small_ladder());
  double coarsest = 0.0;
  for (const CoarseCandidate& candidate : ladder.candidates) {
    if (candidate.passes) coarsest = std::max(coarsest, candidate.dx_m);
  }
  EXPECT_DOUBLE_EQ(ladder.coarse.mesh.requested_dx_m, coarsest);

  LadderOptions strict = small_ladder();
  strict.shape_tolerance = 1e-6;
  const MeshLadder none = build_mesh_ladder(short_beam(), strict);
  EXPECT_FALSE(none.candidates.front().passes);
  EXPECT_DOUBLE_EQ(none.coarse.mesh.requested_dx_m, none.candidates.front().dx_m);
  EXPECT_GT(none.notes.size(), ladder.notes.size());
}

TEST(MeshLadder, TheWantedCoarseMeshOverrulesTheChoice) {
  LadderOptions options = small_ladder();
  options.coarse_dx_m = 4e-3;
  options.shape_tolerance = 1e-6;
  const MeshLadder ladder = build_mesh_ladder(short_beam(), options);
  ASSERT_EQ(ladder.candidates.size(), 1U);
  EXPECT_FALSE(ladder.candidates.front().passes);
  EXPECT_DOUBLE_EQ(ladder.coarse.mesh.requested_dx_m, 4e-3);
}

TEST(MeshLadder, TheStatedModulusTakesNoPartAndIsMentioned) {
  const MeshLadder plain = build_mesh_ladder(short_beam(), small_ladder());
  Rig stated = short_beam();
  stated.materials.front().youngs_modulus_pa = 2e9;
  const MeshLadder ladder = build_mesh_ladder(stated, small_ladder());
  EXPECT_EQ(ladder.limit.lambda_per_s2, plain.limit.lambda_per_s2);
  EXPECT_EQ(ladder.notes.size(), plain.notes.size() + 1);
}

TEST(MeshRung, AWeightLowersTheEigenvalues) {
  const Rig rig = test::beam(mm(80, 10, 4), 0.0, 1000.0);
  Rig weighted = rig;
  weighted.masses.push_back({mm(80, 5, 2), 3.2e-3});
  const auto lambda_of = [](const Rig& r) {
    return compute_rung(r, 4e-3, ElementKind::Hex20, 1, {}).modes.lambda_per_s2(0);
  };
  // Of a slender beam 3 / 1.8751^4 = 0.2427 takes part at the tip, and with a weight as heavy as
  // itself its stiffness is 3 E I / L^3: Rayleigh's quotient, good to 1 %.
  EXPECT_NEAR(lambda_of(weighted) / lambda_of(rig), 0.2427 / (1.0 + 0.2357), 0.01 * 0.196);
}

TEST(MeshLadder, AStopAskedForComesThrough) {
  LadderOptions options = small_ladder();
  int calls = 0;
  options.progress = [&](const Progress& progress) {
    EXPECT_FALSE(progress.stage.empty());
    return ++calls < 3;
  };
  EXPECT_THROW((void)build_mesh_ladder(short_beam(), options), Cancelled);
  EXPECT_EQ(calls, 3);
}

}  // namespace
}  // namespace twang
