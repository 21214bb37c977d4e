// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/refine_material.hpp"

#include "calibrate/detail/judge_refinement.hpp"
#include "calibrate/simulated_release.hpp"
#include "core/error.hpp"
#include "tests/calibrate/small_l_rig.hpp"
#include "tests/support/expect_refusal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>
#include <string>

namespace twang {
namespace {

using test::holds;
using test::kCell_m;
using test::linear_estimate;
using test::quick;
using test::refusal_of;
using test::small_l_rig;
using test::SwingingRig;

constexpr double kTrueModulus = 1e8;
constexpr double kTrueDamping_s = 4e-4;

constexpr double kTraceNoise = 2e-4;

/// The rig let go from its release, seen at 240 frames a second with some noise [rad].
Trace plucked(const Rig& rig, const MeshRung& rung, double duration_s) {
  const ElasticMaterial material = {kTrueModulus,
                                    rig.materials.front().poissons_ratio,
                                    rig.materials.front().density_kg_m3,
                                    kTrueDamping_s};
  std::vector<int> all(static_cast<std::size_t>(rung.mesh.num_nodes()));
  std::iota(all.begin(), all.end(), 0);
  SimulatedReleaseOptions options;
  options.duration_s = duration_s;
  options.frequency_hz = rung.modes.natural_frequency_hz(0) * std::sqrt(kTrueModulus);
  options.steps_per_period = 150.0;
  const RecordedMotion motion =
      simulate_release(rig, rung.mesh, rung.held_nodes, material, all, options);
  const SimulatedObservable observable(rig, rung);
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  Trace trace;
  trace.channels.push_back({"observable_rad", {}});
  for (int n = 0; n / 240.0 < duration_s; ++n) {
    trace.time_s.push_back(n / 240.0);
    trace.channels[0].values.push_back(observable.evaluate(motion.displacement(n / 240.0)) +
                                       kTraceNoise * normal(generator));
  }
  return trace;
}

TEST(RefineMaterial, TakesOutWhatALargeDeflectionDoesToTheLinearEstimate) {
  const Rig rig = small_l_rig();
  const MeshRung rung = compute_rung(rig, kCell_m, ElementKind::Hex8, 4);
  const Trace trace = plucked(rig, rung, 0.4);
  ASSERT_GT(std::abs(trace.channels[0].values[0]), 0.3);
  InversionOptions window;
  window.start_s = 0.0;
  const InversionResult inversion = invert_harmonics(trace, {"observable_rad"}, window);
  ASSERT_TRUE(inversion.usable());
  const Material linear = linear_estimate(rig, rung, inversion);
  const double linear_modulus = linear.youngs_modulus_numerical_pa / kTrueModulus - 1.0;
  const double linear_damping = linear.damping_stiffness_b_s / kTrueDamping_s - 1.0;

  const RefinedMaterial refined =
      refine_material(rig, rung, linear, {{&trace, "observable_rad", &inversion}});
  ASSERT_TRUE(refined.usable()) << refined.message;
  const double modulus = refined.youngs_modulus_numerical_pa / kTrueModulus - 1.0;
  const double damping = refined.damping_stiffness_b_s / kTrueDamping_s - 1.0;
  // The pluck bends far: the linear estimate is off by many of its own sigmas, 0.5 and 2.5 %.
  EXPECT_GT(std::abs(linear_modulus), 3e-3);
  EXPECT_GT(std::abs(linear_damping), 1.5e-2);
  // What overtones leave behind the settling, and the noise: sigmas are below a third of it.
  EXPECT_LT(std::abs(modulus), 1.5e-3);
  EXPECT_LT(std::abs(damping), 4e-3);
  EXPECT_LT(refined.modulus_sigma_rel, 5e-4);
  EXPECT_LT(refined.damping_sigma_rel, 4e-3);
  EXPECT_LT(refined.change.residual_rel, 2e-3);
  EXPECT_GT(refined.change.linear_residual_rel, 2.0 * refined.change.residual_rel);
  EXPECT_DOUBLE_EQ(refined.youngs_modulus_numerical_pa,
                   linear.youngs_modulus_numerical_pa * (1.0 + refined.change.modulus_change_rel));
}

TEST(RefineMaterial, KeepsTheLinearEstimateWhereNothingIsLeftToFollow) {
  Rig rig = small_l_rig();
  const MeshRung rung = compute_rung(rig, kCell_m, ElementKind::Hex8, 2);
  const auto refined = [&](const SwingingRig& seen) {
    return refine_material(rig,
                           rung,
                           linear_estimate(rig, rung, seen.inversion),
                           {{&seen.trace, "observable_rad", &seen.inversion}});
  };
  const SwingingRig seen(0.5);
  ASSERT_TRUE(seen.inversion.usable());
  SwingingRig brief = seen;
  brief.inversion.time_end_s = 0.08;  // 1.6 periods, of which the first is left to settle
  EXPECT_FALSE(refined(brief).usable());
  EXPECT_TRUE(holds(refined(brief).message, "0.60 of a period"));
  brief.inversion.time_end_s = brief.inversion.time_origin_s;
  EXPECT_TRUE(holds(refined(brief).message, "0.00 of a period"));
  SwingingRig lost = seen;
  for (double& value : lost.trace.channels[0].values) value = kNaN;
  EXPECT_FALSE(refined(lost).usable());
  EXPECT_TRUE(holds(refined(lost).message, "0 samples"));
  rig.observable.reset();
  EXPECT_TRUE(
      holds(refusal_of([&] { static_cast<void>(refined(seen)); }), "[observable] is missing"));
}

TEST(RefineMaterial, KeepsTheLinearEstimateWhereTheModeHardlyMovesTheObservable) {
  Rig rig = small_l_rig();
  // Across the plane in which the rig is symmetric and swings.
  rig.observable->kind = ObservableKind::Displacement;
  rig.observable->markers = {"left"};
  rig.observable->direction = {0.0, 1.0, 0.0};
  const MeshRung rung = compute_rung(rig, kCell_m, ElementKind::Hex8, 2);
  SwingingRig seen(0.5);
  seen.trace.channels[0].name = "observable_mm";
  const RefinedMaterial refined =
      refine_material(rig,
                      rung,
                      linear_estimate(rig, rung, seen.inversion),
                      {{&seen.trace, "observable_mm", &seen.inversion}});
  EXPECT_FALSE(refined.usable());
  EXPECT_EQ(refined.simulations, 0);
  EXPECT_TRUE(holds(refined.message, "moves the observable by only"));
}

TEST(RefineMaterial, KeepsTheLinearEstimateOfASmallMotion) {
  const Rig rig = small_l_rig();
  const MeshRung rung = compute_rung(rig, kCell_m, ElementKind::Hex8, 2);
  SwingingRig seen(0.5);
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  for (double& value : seen.trace.channels[0].values)
    value = 0.01 * value + 5e-6 * normal(generator);
  InversionOptions window;
  window.start_s = 0.0;
  seen.inversion = invert_harmonics(seen.trace, {"observable_rad"}, window);
  const RefinedMaterial refined =
      refine_material(rig,
                      rung,
                      linear_estimate(rig, rung, seen.inversion),
                      {{&seen.trace, "observable_rad", &seen.inversion}},
                      0,
                      quick());
  EXPECT_TRUE(refined.agrees) << refined.message;
  EXPECT_FALSE(refined.usable());
  EXPECT_TRUE(holds(refined.message, "The linear estimate was kept"));
  // The noise of half a per cent lets E be known to a few 1e-4; the sinusoid is what a small motion
  // is, but for the little that the settled overtones leave.
  EXPECT_LT(std::abs(refined.change.modulus_change_rel), 1e-3);
  EXPECT_LT(refined.change.residual_rel, 0.01);
}

TEST(RefineMaterial, NoiseThatLastsMakesSigmasWider) {
  const Rig rig = small_l_rig();
  const MeshRung rung = compute_rung(rig, kCell_m, ElementKind::Hex8, 2);
  RefineMaterialOptions options;
  options.steps_per_period = 20.0;
  options.periods = 6.0;
  const auto modulus_sigma = [&](double lasting) {
    SwingingRig seen(0.5);
    std::mt19937 generator(5);
    std::normal_distribution<double> normal;
    double noise = normal(generator);
    for (double& value : seen.trace.channels[0].values) {
      value = 0.01 * value + 5e-6 * noise;
      noise = lasting * noise + std::sqrt(1.0 - lasting * lasting) * normal(generator);
    }
    return refine_material(rig,
                           rung,
                           linear_estimate(rig, rung, seen.inversion),
                           {{&seen.trace, "observable_rad", &seen.inversion}},
                           0,
                           options)
        .change.modulus_sigma_rel;
  };
  // (1 + 0.8) / (1 - 0.8) = 9 times the variance, were 0.8 found exactly
  EXPECT_NEAR(modulus_sigma(0.8) / modulus_sigma(0.0), 3.0, 0.4);
}

TEST(RefineMaterial, KeepsTheLinearEstimateWhereTheFitGoesAstray) {
  const Rig rig = small_l_rig();
  const MeshRung rung = compute_rung(rig, kCell_m, ElementKind::Hex8, 2);
  const SwingingRig seen(0.5);
  Material wrong = linear_estimate(rig, rung, seen.inversion);
  wrong.youngs_modulus_numerical_pa *= 2.0;  // two periods and more out of step at the end
  const RefinedMaterial refined = refine_material(
      rig, rung, wrong, {{&seen.trace, "observable_rad", &seen.inversion}}, 0, quick());
  EXPECT_FALSE(refined.usable());
  EXPECT_FALSE(refined.agrees);
  EXPECT_TRUE(holds(refined.message, "The linear estimate was kept"));
}

TEST(JudgedRefinement, SaysByHowMuchTheHalvesOfARecordingDiffer) {
  std::mt19937 generator(9);
  std::normal_distribution<double> normal;
  const Eigen::MatrixXd columns =
      Eigen::MatrixXd::NullaryExpr(80, 4, [&] { return normal(generator); });
  const Eigen::Vector4d step(0.02, 0.05, 0.01, -0.01);
  Eigen::VectorXd left = columns * step;
  left.head(40).setZero();
  const Eigen::Array2d apart = detail::variance_between_halves(columns, left, 0.0);
  // half of what ln E_n, and ln b = p1 - p0 / 2, are apart; round-off
  EXPECT_NEAR(std::sqrt(apart[0]), 0.01, 1e-12);
  EXPECT_NEAR(std::sqrt(apart[1]), 0.02, 1e-12);
  // Both halves alike, or apart by no more than noise would make them.
  EXPECT_LT(detail::variance_between_halves(columns, columns * step, 0.0).maxCoeff(), 1e-24);
  EXPECT_EQ(detail::variance_between_halves(columns, left, 1.0).maxCoeff(), 0.0);
}

TEST(JudgedRefinement, IsWorthNothingWhereSigmasExplodeOrMuchIsLeft) {
  detail::RefinementFit fit;
  fit.change = {0.01, 0.05};
  fit.covariance = Eigen::Vector2d(1e-6, 1e-4).asDiagonal();
  fit.residual_rel = 0.01;
  fit.linear_residual_rel = 0.03;
  EXPECT_EQ(detail::fault_of(fit), "");
  EXPECT_EQ(detail::agreement_of(fit), "");
  detail::RefinementFit vague = fit;
  vague.covariance(1, 1) = 0.36;
  EXPECT_TRUE(holds(detail::fault_of(vague), "b to 60 %"));
  vague.covariance.setConstant(kNaN);
  EXPECT_FALSE(detail::fault_of(vague).empty());
  detail::RefinementFit left = fit;
  left.residual_rel = 0.2;
  EXPECT_TRUE(holds(detail::fault_of(left), "20 % of the amplitude"));
  detail::RefinementFit no_better = fit;
  no_better.linear_residual_rel = fit.residual_rel;
  EXPECT_FALSE(detail::agreement_of(no_better).empty());
  detail::RefinementFit same = fit;
  same.change = {1e-3, 1e-2};  // one sigma each
  EXPECT_FALSE(detail::agreement_of(same).empty());
}

TEST(RefineMaterial, StopsWhenAsked) {
  const Rig rig = small_l_rig();
  const MeshRung rung = compute_rung(rig, kCell_m, ElementKind::Hex8, 2);
  const SwingingRig seen(0.5);
  RefineMaterialOptions options;
  int asked = 0;
  options.progress = [&](const Progress&) { return ++asked < 900; };  // in the second simulation
  EXPECT_THROW(static_cast<void>(refine_material(rig,
                                                 rung,
                                                 linear_estimate(rig, rung, seen.inversion),
                                                 {{&seen.trace, "observable_rad", &seen.inversion}},
                                                 0,
                                                 options)),
               Cancelled);
}

}  // namespace
}  // namespace twang
