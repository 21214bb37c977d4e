// SPDX-License-Identifier: GPL-3.0-or-later
// Order of convergence of the frequencies of slender beams, and where they converge to. Slices one
// cell deep, held across, with nu = 0: a beam in plane stress at a fraction of the cost.
#include "core/constants.hpp"
#include "fem/eigenmodes.hpp"
#include "tests/support/rigs.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>
#include <unsupported/Eigen/MatrixFunctions>

#include <cmath>

namespace twang {
namespace {

constexpr double kLength = 20.0;  // of a beam one unit thick, E = 1, rho = 1
enum class Support { Cantilever, ClampedClamped, Simple };

bool is_held(Support support, const Eigen::Vector3d& x, int axis) {
  const bool at_start = x.x() < 1e-9;
  const bool at_end = x.x() > kLength - 1e-9;
  if (axis == 1) return true;
  if (support == Support::Simple) {
    // z on both ends; x once, on the middle line of the start.
    const bool pin = at_start && std::abs(x.z() - 0.5) < 1e-9;
    return axis == 2 ? at_start || at_end : pin;
  }
  return at_start || (at_end && support == Support::ClampedClamped);
}

constexpr int kNumModes = 3;  // in bending; the first of the bar's own along it is higher

Eigen::Array3d frequencies(Support support, ElementKind kind, int cells_across) {
  const double dx = 1.0 / cells_across;
  const HexMesh mesh = mesh_part(test::make_rig({Box{{0, 0, 0}, {kLength, dx, 1}}}), dx, kind);
  std::vector<int> held;
  for (int n = 0; n < mesh.num_nodes(); ++n) {
    for (int axis = 0; axis < 3; ++axis) {
      if (is_held(support, mesh.nodes.col(n), axis)) held.push_back(3 * n + axis);
    }
  }
  const ElasticBody body(mesh, {test::elastic(1.0, 0.0, 1.0)});
  EigenmodeOptions options;
  options.count = kNumModes;
  const Eigenmodes modes =
      compute_eigenmodes(body, FreeDofs::from_held_dofs(mesh.num_nodes(), held), options);
  EXPECT_TRUE(modes.usable()) << modes.message;
  return {
      modes.natural_frequency_hz(0), modes.natural_frequency_hz(1), modes.natural_frequency_hz(2)};
}

struct Convergence {
  Eigen::Array3d order;     ///< of each mode
  Eigen::Array3d limit_hz;  ///< by Richardson with that order
};

Convergence converge(Support support, ElementKind kind, int coarsest) {
  const Eigen::Array3d coarse = frequencies(support, kind, coarsest);
  const Eigen::Array3d middle = frequencies(support, kind, 2 * coarsest);
  const Eigen::Array3d fine = frequencies(support, kind, 4 * coarsest);
  const Eigen::Array3d ratio = (coarse - middle) / (middle - fine);
  return {ratio.log() / std::log(2.0), fine + (fine - middle) / (ratio - 1.0)};
}

/// Whether a Timoshenko beam's frequency function changes sign; zero at a natural frequency. State
/// (w, psi, M, V), rectangle of unit thickness and width, E = rho = 1, G = 1/2, kappa = 5/6.
double timoshenko_determinant(Support support, double omega) {
  const double I = 1.0 / 12.0;
  const double shear = 5.0 / 6.0 * 0.5;
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  A(0, 1) = 1.0;
  A(0, 3) = 1.0 / shear;
  A(1, 2) = 1.0 / I;
  A(2, 1) = -I * omega * omega;
  A(2, 3) = -1.0;
  A(3, 0) = -omega * omega;
  const Eigen::Matrix4d end_from_start = (kLength * A).exp();
  if (support == Support::Simple) {  // w = M = 0 at both ends, psi and V free
    return end_from_start(0, 1) * end_from_start(2, 3) -
           end_from_start(0, 3) * end_from_start(2, 1);
  }
  if (support == Support::Cantilever) return end_from_start.block<2, 2>(2, 2).determinant();
  return end_from_start.block<2, 2>(0, 2).determinant();
}

/// The first natural frequencies by stepping to the changes of sign, then bisection.
Eigen::Array3d timoshenko_frequencies(Support support) {
  Eigen::Array3d found;
  double low = 1e-4;
  for (int k = 0; k < kNumModes; ++k) {
    const double start = timoshenko_determinant(support, low);
    while (timoshenko_determinant(support, 1.02 * low) * start > 0.0) low *= 1.02;
    double high = 1.02 * low;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (timoshenko_determinant(support, middle) * start > 0.0 ? low : high) = middle;
    }
    found[k] = low / kTwoPi;
    low = 1.001 * high;
  }
  return found;
}

/// beta L of an Euler-Bernoulli beam.
Eigen::Array3d euler_bernoulli(Support support) {
  if (support == Support::Cantilever) return {1.875104, 4.694091, 7.854757};
  if (support == Support::ClampedClamped) return {4.730041, 7.853205, 10.995608};
  return {kPi, 2.0 * kPi, 3.0 * kPi};
}

void expect_limit(const Convergence& found, Support support) {
  const Eigen::Array3d expected = timoshenko_frequencies(support);
  for (int k = 0; k < kNumModes; ++k) {
    EXPECT_NEAR(found.limit_hz[k] / expected[k], 1.0, 5e-3) << "mode " << k + 1;
  }
}

TEST(BeamConvergence, Hex8IsOfOrderTwo) {
  for (const Support support : {Support::Cantilever, Support::ClampedClamped}) {
    const Convergence found = converge(support, ElementKind::Hex8, 4);
    for (int k = 0; k < kNumModes; ++k) EXPECT_NEAR(found.order[k], 2.0, 0.1) << "mode " << k + 1;
    expect_limit(found, support);
  }
}

TEST(BeamConvergence, Hex20IsOfOrderFourWhereTheSolutionIsSmooth) {
  const Convergence found = converge(Support::Simple, ElementKind::Hex20, 2);
  for (int k = 0; k < kNumModes; ++k) EXPECT_NEAR(found.order[k], 4.0, 0.1) << "mode " << k + 1;
  expect_limit(found, Support::Simple);
}

TEST(BeamConvergence, Hex20AtClampsIsHeldBackByTheCornersAlone) {
  // Stress is singular in the corners of a clamp (which also hinders the warping of the section),
  // which takes some of the order; hex8 is too coarse to see it.
  for (const Support support : {Support::Cantilever, Support::ClampedClamped}) {
    const Convergence found = converge(support, ElementKind::Hex20, 2);
    for (int k = 0; k < kNumModes; ++k) {
      EXPECT_GT(found.order[k], 3.5) << "mode " << k + 1;
      EXPECT_LT(found.order[k], 4.1) << "mode " << k + 1;
    }
    expect_limit(found, support);
  }
}

TEST(BeamConvergence, BothElementsHaveOneLimit) {
  const Convergence hex8 = converge(Support::ClampedClamped, ElementKind::Hex8, 4);
  const Convergence hex20 = converge(Support::ClampedClamped, ElementKind::Hex20, 2);
  // What Richardson leaves of hex8's last step of 0.3 %.
  for (int k = 0; k < kNumModes; ++k) {
    EXPECT_NEAR(hex8.limit_hz[k] / hex20.limit_hz[k], 1.0, 3e-4) << "mode " << k + 1;
  }
}

TEST(TimoshenkoBeam, TendsToEulerBernoulli) {
  // The check's own check: 20 times as long as thick, shear and rotary inertia take 0.2 to 1.4 % of
  // the first mode, and of the others more as the square of beta.
  const double scale = std::sqrt(1.0 / 12.0) / (kTwoPi * kLength * kLength);
  for (const Support support : {Support::Cantilever, Support::ClampedClamped, Support::Simple}) {
    const Eigen::Array3d beta = euler_bernoulli(support);
    const Eigen::Array3d found = timoshenko_frequencies(support) / (beta.square() * scale);
    for (int k = 0; k < kNumModes; ++k) {
      EXPECT_LT(found[k], 1.0);
      EXPECT_GT(found[k], 1.0 - 1e-3 * beta[k] * beta[k]) << "mode " << k + 1;
    }
  }
}

}  // namespace
}  // namespace twang
