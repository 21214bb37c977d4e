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

double first_frequency(Support support, ElementKind kind, int cells_across) {
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
  options.count = 1;
  const Eigenmodes modes =
      compute_eigenmodes(body, FreeDofs::from_held_dofs(mesh.num_nodes(), held), options);
  EXPECT_TRUE(modes.usable()) << modes.message;
  return modes.natural_frequency_hz(0);
}

struct Convergence {
  double order = 0.0;
  double limit_hz = 0.0;  ///< by Richardson with that order
};

Convergence converge(Support support, ElementKind kind, int coarsest) {
  const double coarse = first_frequency(support, kind, coarsest);
  const double middle = first_frequency(support, kind, 2 * coarsest);
  const double fine = first_frequency(support, kind, 4 * coarsest);
  const double ratio = (coarse - middle) / (middle - fine);
  return {std::log2(ratio), fine + (fine - middle) / (ratio - 1.0)};
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

/// The first natural frequency by stepping to the first change of sign, then bisection.
double timoshenko_frequency(Support support) {
  double low = 1e-4;
  const double start = timoshenko_determinant(support, low);
  while (timoshenko_determinant(support, 1.02 * low) * start > 0.0) low *= 1.02;
  double high = 1.02 * low;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (timoshenko_determinant(support, middle) * start > 0.0 ? low : high) = middle;
  }
  return low / kTwoPi;
}

TEST(BeamConvergence, Hex8IsOfOrderTwo) {
  for (const Support support : {Support::Cantilever, Support::ClampedClamped}) {
    const Convergence found = converge(support, ElementKind::Hex8, 4);
    EXPECT_NEAR(found.order, 2.0, 0.1);
    EXPECT_NEAR(found.limit_hz / timoshenko_frequency(support), 1.0, 5e-3);
  }
}

TEST(BeamConvergence, Hex20IsOfOrderFourWhereTheSolutionIsSmooth) {
  const Convergence found = converge(Support::Simple, ElementKind::Hex20, 2);
  EXPECT_NEAR(found.order, 4.0, 0.1);
  EXPECT_NEAR(found.limit_hz / timoshenko_frequency(Support::Simple), 1.0, 5e-3);
}

TEST(BeamConvergence, Hex20AtClampsIsHeldBackByTheCornersAlone) {
  // Stress is singular in the corners of a clamp (which also hinders the warping of the section),
  // which takes some of the order; hex8 is too coarse to see it.
  for (const Support support : {Support::Cantilever, Support::ClampedClamped}) {
    const Convergence found = converge(support, ElementKind::Hex20, 2);
    EXPECT_GT(found.order, 3.5);
    EXPECT_LT(found.order, 4.1);
    EXPECT_NEAR(found.limit_hz / timoshenko_frequency(support), 1.0, 5e-3);
  }
}

TEST(BeamConvergence, BothElementsHaveOneLimit) {
  const Convergence hex8 = converge(Support::ClampedClamped, ElementKind::Hex8, 4);
  const Convergence hex20 = converge(Support::ClampedClamped, ElementKind::Hex20, 2);
  // What Richardson leaves of hex8's last step of 0.3 %.
  EXPECT_NEAR(hex8.limit_hz / hex20.limit_hz, 1.0, 3e-4);
}

TEST(TimoshenkoBeam, TendsToEulerBernoulli) {
  // The check's own check: 20 times as long as thick, shear and rotary inertia take 0.2 to 1.4 %.
  const double scale = std::sqrt(1.0 / 12.0) / (kTwoPi * kLength * kLength);
  EXPECT_NEAR(timoshenko_frequency(Support::Cantilever) / (1.875104 * 1.875104 * scale), 1.0, 3e-3);
  EXPECT_NEAR(
      timoshenko_frequency(Support::ClampedClamped) / (4.730041 * 4.730041 * scale), 1.0, 2e-2);
  EXPECT_NEAR(timoshenko_frequency(Support::Simple) / (kPi * kPi * scale), 1.0, 5e-3);
}

}  // namespace
}  // namespace twang
