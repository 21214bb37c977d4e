// SPDX-License-Identifier: GPL-3.0-or-later
// What the numerical modulus is for: the L-shaped rig on its coarse mesh of 1.5 mm, one hex8
// through the leg, bends, swings and rings down as on the fine one.
#include "coarsen/fit_material.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/constants.hpp"
#include "core/trace.hpp"
#include "fem/static_solve.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "simulate/integrators.hpp"
#include "tests/coarsen/rigs_of_tests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace twang {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kModulus_pa = 1e9;
constexpr double kB_s = 1.6e-4;
constexpr double kDx_m = 1.5e-3;
const Vector3d kArmEnd_m(9e-3, 12e-3, 27e-3);
const Vector3d kPull_n(0.0, 0.0, -0.1);       // turns the arm by a few mrad
const Vector3d kTip_m(80e-3, 10e-3, 4e-3);    // of a beam, and its size
const Vector3d kSkewPull_n(0.0, 0.02, -0.1);  // bends both ways and twists

const MeshRung& fine() {
  static const MeshRung kRung = compute_rung(test::l_rig(), kDx_m, ElementKind::Hex20, 6);
  return kRung;
}
const MeshRung& coarse() {
  static const MeshRung kRung = compute_rung(test::l_rig(), kDx_m, ElementKind::Hex8, 6);
  return kRung;
}

/// E_n of `rung` for a part of kModulus_pa on `truth`.
double numerical_modulus(const MeshRung& rung, const MeshRung& truth) {
  return rescaled_modulus(kModulus_pa, truth.modes.lambda_per_s2(0), rung.modes.lambda_per_s2(0));
}

ElasticBody body_of(const MeshRung& rung, double modulus_pa) {
  return ElasticBody(rung.mesh, {{modulus_pa, 0.45, 1205.0, kB_s, 0.0}}, ConstitutiveModel::Linear);
}

VectorXd pulled(const MeshRung& rung, const ElasticBody& body) {
  StaticLoad load;
  load.force = nodal_force(rung.mesh, locate(rung.mesh, kArmEnd_m), kPull_n);
  const StaticResult result = solve_static(body, rung.held_nodes, load);
  EXPECT_TRUE(result.usable()) << result.message;
  return result.u;
}

double deflection(const MeshRung& rung, double modulus_pa) {
  const VectorXd u = pulled(rung, body_of(rung, modulus_pa));
  return interpolate(locate(rung.mesh, kArmEnd_m), u).z();
}

TEST(CoarseMesh, BendsUnderALoadAsTheFineOneOnlyAtTheNumericalModulus) {
  const double truth = deflection(fine(), kModulus_pa);
  EXPECT_LT(truth, 0.0);
  // The load bends the leg as the first mode does, whose frequency is matched; the rest of the
  // deflection is a few per cent.
  const double numerical = deflection(coarse(), numerical_modulus(coarse(), fine()));
  // Fig. 8: at the true modulus the coarse mesh is as much too stiff as its eigenvalue.
  const double at_true = deflection(coarse(), kModulus_pa);
  std::printf(
      "deflection %.3f mm; coarse: %.3f mm at E_n (%+.1f %%), %.3f mm at E (%.2f times too "
      "stiff)\n",
      1e3 * truth,
      1e3 * numerical,
      100.0 * (numerical / truth - 1.0),
      1e3 * at_true,
      truth / at_true);
  EXPECT_NEAR(numerical / truth, 1.0, 0.03);
  EXPECT_NEAR(truth / at_true, 2.5, 0.1);
}

/// The strongest sinusoid of the arm's end after the pull is let go.
DampedSinusoid ring_down(const MeshRung& rung, double modulus_pa) {
  const ElasticBody body = body_of(rung, modulus_pa);
  const double f = std::sqrt(modulus_pa * rung.modes.lambda_per_s2(0)) / kTwoPi;
  constexpr int kStepsInAPeriod = 48;
  constexpr int kPeriods = 6;
  NewmarkOptions options;
  options.step_s = 1.0 / (f * kStepsInAPeriod);
  NewmarkIntegrator integrator(body, rung.held_nodes, options);
  BodyState state;
  state.u = pulled(rung, body);
  state.v = VectorXd::Zero(state.u.size());
  const MeshPoint end = locate(rung.mesh, kArmEnd_m);
  Trace trace;
  Channel channel;
  channel.name = "end_mm";
  const RunSummary summary =
      run(integrator, state, options.step_s, kPeriods / f, [&](const BodyState& now) {
        trace.time_s.push_back(now.time_s);
        channel.values.push_back(1e3 * interpolate(end, now.u).z());
      });
  EXPECT_TRUE(summary.usable()) << summary.message;
  trace.channels.push_back(channel);
  InversionOptions inversion;
  inversion.start_s = 0.5 / f;  // what rings higher is gone
  const InversionResult found = invert_harmonics(trace, {"end_mm"}, inversion);
  EXPECT_TRUE(found.usable()) << found.message;
  return found.modes.empty() ? DampedSinusoid{} : found.modes.front();
}

TEST(CoarseMesh, OverDampsAtTheTrueModulusAndRingsDownRightAtTheNumericalOne) {
  const FrequencyAndDecay truth =
      frequency_and_decay(kModulus_pa * fine().modes.lambda_per_s2(0), 0.0, kB_s);
  const DampedSinusoid right = ring_down(coarse(), numerical_modulus(coarse(), fine()));
  // Steps of a 48th of a period make it longer by 0.14 %, and the decay weaker by 0.4 %.
  EXPECT_NEAR(right.frequency_hz / truth.frequency_hz, 1.0, 0.003);
  EXPECT_NEAR(right.decay_per_s / truth.decay_per_s, 1.0, 0.01);

  const DampedSinusoid wrong = ring_down(coarse(), kModulus_pa);
  std::printf("decay over truth: %.3f at E_n, %.3f at E; frequency at E_n %.4f\n",
              right.decay_per_s / truth.decay_per_s,
              wrong.decay_per_s / truth.decay_per_s,
              right.frequency_hz / truth.frequency_hz);
  const double stiffer = coarse().modes.lambda_per_s2(0) / fine().modes.lambda_per_s2(0);
  EXPECT_NEAR(wrong.decay_per_s / truth.decay_per_s, stiffer, 0.01 * stiffer);
  EXPECT_GT(wrong.decay_per_s, 2.4 * truth.decay_per_s);
}

/// A corner of a beam's tip after a pull on it is let go, by the mesh's modes at its E_n:
/// sum_i (phi_i . f / lambda_i) phi_i exp(-d_i t) (cos w_i t + d_i / w_i sin w_i t).
Eigen::MatrixXd modal_motion(const MeshRung& rung, double modulus_pa, const VectorXd& times_s) {
  const MeshPoint corner = locate(rung.mesh, kTip_m);
  const VectorXd force = nodal_force(rung.mesh, corner, kSkewPull_n);
  Eigen::MatrixXd motion = Eigen::MatrixXd::Zero(times_s.size(), 3);
  for (int i = 0; i < rung.modes.count(); ++i) {
    const VectorXd shape = rung.modes.shapes.col(i);
    const double lambda = modulus_pa * rung.modes.lambda_per_s2(i);
    const FrequencyAndDecay mode = frequency_and_decay(lambda, 0.0, kB_s);
    if (mode.frequency_hz == 0.0) continue;  // overdamped: gone at once
    const double w = kTwoPi * mode.frequency_hz;
    const double d = mode.decay_per_s;
    const VectorXd swing = (-d * times_s.array()).exp() *
                           ((w * times_s.array()).cos() + d / w * (w * times_s.array()).sin());
    motion += swing * (shape.dot(force) / lambda * interpolate(corner, shape)).transpose();
  }
  return motion;
}

TEST(ModeCriteria, OfFourAndOfTenModesChooseMeshesThatMoveAlike) {
  const Rig rig = test::beam(kTip_m, 0.4, 1200.0);
  LadderOptions options;
  options.max_dofs = 60000;
  options.num_frequencies = 16;
  MeshLadder ladder = build_mesh_ladder(rig, options);
  const auto motion_of = [&](int num_modes, const VectorXd& times_s) {
    options.num_modes = num_modes;
    ladder = choose_again(rig, std::move(ladder), options);
    EXPECT_TRUE(ladder.chosen().passes) << ladder.choice;
    return modal_motion(ladder.coarse, kModulus_pa / ladder.identified_over_numerical(), times_s);
  };
  const double f = std::sqrt(kModulus_pa * ladder.limit.lambda_per_s2) / kTwoPi;
  const VectorXd times_s = VectorXd::LinSpaced(4000, 0.0, 10.0 / f);
  const Eigen::MatrixXd of_four = motion_of(4, times_s);
  const double coarsest = ladder.coarse.mesh.requested_dx_m;
  const Eigen::MatrixXd of_ten = motion_of(10, times_s);
  ASSERT_LT(ladder.coarse.mesh.requested_dx_m, coarsest);  // or there is nothing to compare
  // Fig. 11 shows no difference; the overtones of the coarser mesh are off, and a few per cent of
  // the motion.
  const double peak = of_ten.rowwise().norm().maxCoeff();
  const double rms = (of_four - of_ten).norm() / std::sqrt(static_cast<double>(times_s.size()));
  std::printf("dx %.3g and %.3g mm for four and ten modes: motion %.2f %% rms of the peak apart\n",
              1e3 * coarsest,
              1e3 * ladder.coarse.mesh.requested_dx_m,
              100.0 * rms / peak);
  EXPECT_LT(rms, 0.02 * peak);
  EXPECT_GT(rms, 0.0);
}

}  // namespace
}  // namespace twang
