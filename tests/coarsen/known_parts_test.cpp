// SPDX-License-Identifier: GPL-3.0-or-later
// Ladders of parts whose limits are known: beams by formula, a strip by CalculiX. An L-shaped rig
// is with the samples, a beam next to incompressibility with the calibration of its recordings:
// they need the same ladders.
#include "coarsen/fit_material.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/constants.hpp"
#include "tests/coarsen/rigs_of_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace twang {
namespace {

using test::mm;

double limit_frequency_hz(const MeshLadder& ladder, double youngs_modulus_pa) {
  return std::sqrt(ladder.limit.lambda_per_s2 * youngs_modulus_pa) / kTwoPi;
}

TEST(StripLadder, EndsAtTheBeamFormula) {
  const double L = 80e-3;
  const double h = 2e-3;
  const MeshLadder ladder = build_mesh_ladder(test::beam({L, 10e-3, h}, 0.0, 1000.0));
  EXPECT_TRUE(ladder.convergent);
  const double beta = 1.875104068711961 / L;
  const double lambda = std::pow(beta, 4) * h * h / (12.0 * 1000.0);
  // 0.5 % in frequency, 1 % in lambda: shear and rotation take 0.1 % of a strip 40 times longer
  // than thick.
  EXPECT_NEAR(ladder.limit.lambda_per_s2 / lambda, 1.0, 0.01);
}

TEST(StripLadder, EndsAtThePeersFinestMesh) {
  // CalculiX, C3D20 at 2/3 mm: 42.6022 Hz with E = 2 GPa.
  const MeshLadder ladder = build_mesh_ladder(test::beam(mm(100, 10, 2), 0.45, 1180.0));
  EXPECT_NEAR(limit_frequency_hz(ladder, 2e9), 42.6022, 0.005 * 42.6022);
  // The stated uncertainty covers the distance: the peer's mesh is itself 0.1 % too stiff.
  EXPECT_NEAR(ladder.limit.lambda_per_s2 * 2e9 / std::pow(kTwoPi * 42.6022, 2),
              1.0,
              3.0 * ladder.limit.relative_sigma + 0.002);
  const double fundamental =
      ladder.reference.front().modes.natural_frequency_hz(0) * std::sqrt(2e9);
  EXPECT_NEAR(fundamental, 42.8274, 1e-3 * 42.8274);  // C3D20 at 2 mm
}

TEST(SquareBeamLadder, TurnedPairsOfBendingModesAgree) {
  // Both bending modes of a square section have one frequency; their directions are the mesh's
  // whim.
  const Rig rig = test::beam(mm(100, 10, 10), 0.3, 1000.0);
  const MeshLadder ladder = build_mesh_ladder(rig);
  const Eigen::VectorXd& lambda = ladder.reference.back().modes.lambda_per_s2;
  EXPECT_NEAR(lambda(1) / lambda(0), 1.0, 1e-6);
  ASSERT_FALSE(ladder.candidates.empty());
  EXPECT_TRUE(ladder.candidates.front().passes);
  EXPECT_LT(ladder.candidates.front().comparison.max_difference, 0.05);
}

}  // namespace
}  // namespace twang
