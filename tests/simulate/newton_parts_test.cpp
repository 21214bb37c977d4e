// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dense_algebra.hpp"
#include "simulate/detail/damped_body.hpp"
#include "simulate/detail/minimal_residual.hpp"
#include "simulate/detail/nodal_rotations.hpp"
#include "simulate/detail/stale_factor.hpp"
#include "tests/simulate/box_body.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace twang {
namespace {

using detail::DampedBody;

Eigen::VectorXd noise(Eigen::Index size, unsigned seed, double amplitude) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-amplitude, amplitude);
  Eigen::VectorXd result(size);
  for (Eigen::Index i = 0; i < size; ++i) result[i] = uniform(generator);
  return result;
}

/// 2 x 2 x 2 cells of two materials, held at x = 0, some way from rest.
struct TwoMaterials {
  explicit TwoMaterials(double b_first, double b_second)
      : body(make(b_first, b_second)),
        held(test::nodes_at(body.mesh(), 0, 0.0)),
        damped(body, held) {
    at.u = noise(body.mesh().num_dofs(), 1, 3e-4);
    at.v = noise(body.mesh().num_dofs(), 2, 0.05);
    for (const int node : held) {
      at.u.segment<3>(3 * node).setZero();
      at.v.segment<3>(3 * node).setZero();
    }
    at.mu_per_s2 = 4e8;
    at.gamma_per_s = 2e4;
  }
  static ElasticBody make(double b_first, double b_second) {
    HexMesh mesh = test::box_mesh(ElementKind::Hex8, {2, 2, 2}, {0.01, 0.01, 0.01});
    mesh.material_names = {"first", "second"};
    for (std::size_t e = 0; e < mesh.material_of_element.size(); ++e)
      mesh.material_of_element[e] = e % 3 == 0 ? 1 : 0;
    return {mesh, {{1e6, 0.4, 1000.0, b_first, 5.0}, {3e6, 0.3, 1500.0, b_second, 5.0}}};
  }
  [[nodiscard]] Eigen::VectorXd residual(const Eigen::VectorXd& delta) const {
    return at.mu_per_s2 * damped.mass_product(delta) +
           damped.resisting_force(at.u + delta, at.v + at.gamma_per_s * delta);
  }
  [[nodiscard]] double jacobian_error() const {
    Eigen::VectorXd w = noise(at.u.size(), 3, 1.0);
    for (const int node : held) w.segment<3>(3 * node).setZero();
    const double step = 1e-8;  // [m]; round-off 1e-8, truncation far below
    const Eigen::VectorXd difference = (residual(step * w) - residual(-step * w)) / (2.0 * step);
    const Eigen::VectorXd product = damped.step_product(at, w);
    return (product - difference).norm() / difference.norm();
  }
  ElasticBody body;
  std::vector<int> held;
  DampedBody damped;
  DampedBody::Linearization at;
};

TEST(DampedBody, StepProductIsTheDerivativeOfTheForce) {
  for (const double b_second : {1e-4, 3e-4}) {  // one b and two: different formulas
    TwoMaterials bodies(1e-4, b_second);
    const double fast = bodies.jacobian_error();
    bodies.at.v *= 0.5;
    const double slow = bodies.jacobian_error();
    // K taken ahead is the derivative of D to second order in v; halving v divides it by four.
    EXPECT_LT(fast, 1e-3);
    EXPECT_LT(slow, 0.3 * fast);
    // By differences it is exact, here to the reference's own 1e-7.
    bodies.at.differences = true;
    EXPECT_LT(bodies.jacobian_error(), 1e-6);
  }
}

TEST(DampedBody, StepMatrixIsItsProduct) {
  for (const double b_second : {1e-4, 3e-4}) {
    const TwoMaterials bodies(1e-4, b_second);
    const Eigen::VectorXd w =
        bodies.damped.free().expand_vector(noise(bodies.damped.free().size(), 4, 1.0));
    const Eigen::VectorXd product =
        bodies.damped.free().restrict_vector(bodies.damped.step_product(bodies.at, w));
    const Eigen::VectorXd expected =
        bodies.damped.step_matrix(bodies.at) * bodies.damped.free().restrict_vector(w);
    EXPECT_LT((product - expected).norm(), 1e-12 * expected.norm());
  }
}

TEST(NodalRotations, AreThePolarFactorOfAHomogeneousDeformation) {
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(2.5, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  Eigen::Matrix3d stretch;
  stretch << 1.2, 0.1, 0.0, 0.1, 0.9, -0.05, 0.0, -0.05, 1.05;
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20}) {
    const HexMesh mesh = test::box_mesh(kind, {2, 1, 1}, {0.02, 0.01, 0.005});
    Eigen::VectorXd u(mesh.num_dofs());
    for (int i = 0; i < mesh.num_nodes(); ++i)
      u.segment<3>(3 * i) = (R * stretch - Eigen::Matrix3d::Identity()) * mesh.nodes.col(i);
    // The polar factor is unique, Newton's iteration reaches round-off.
    for (const Eigen::Matrix3d& rotation : detail::NodalRotations(mesh).at(u))
      EXPECT_LT((rotation - R).norm(), 1e-12);
  }
}

TEST(NodalRotations, SingularMatricesCountAsUnturned) {
  EXPECT_EQ(detail::orthogonal_factor(Eigen::Matrix3d::Zero()), Eigen::Matrix3d::Identity());
  EXPECT_EQ(detail::orthogonal_factor(Eigen::Matrix3d::Constant(std::nan(""))),
            Eigen::Matrix3d::Identity());
}

TEST(StaleFactor, IsExactForABodyThatTurnedAsAWhole) {
  TwoMaterials bodies(1e-4, 1e-4);
  const DampedBody free_body(bodies.body, {});
  DampedBody::Linearization at = bodies.at;
  at.v.setZero();
  detail::StaleFactor factor(free_body);
  ASSERT_TRUE(factor.renew(at));
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(1.0, Eigen::Vector3d(0.3, 1.0, -0.4).normalized()).toRotationMatrix();
  for (int i = 0; i < bodies.body.mesh().num_nodes(); ++i) {
    const Eigen::Vector3d x = bodies.body.mesh().nodes.col(i);
    at.u.segment<3>(3 * i) = R * (x + at.u.segment<3>(3 * i)) - x;
  }
  factor.follow(at.u);
  const Eigen::VectorXd w = noise(at.u.size(), 9, 1.0);
  // Round-off of a solve of condition 1e3 in single precision; without the turn 1.
  EXPECT_LT((factor.apply(free_body.step_product(at, w)) - w).norm(), 1e-6 * w.norm());
}

TEST(MinimalResidual, SolvesDefiniteAndIndefiniteSystems) {
  const int n = 30;
  const Eigen::MatrixXd Q = orthonormal_basis(noise(n * n, 5, 1.0).reshaped(n, n));
  for (const bool definite : {true, false}) {
    Eigen::VectorXd eigenvalues = Eigen::VectorXd::LinSpaced(n, 1.0, 30.0);
    if (!definite) eigenvalues.head(4) *= -1.0;
    const Eigen::MatrixXd A = Q * eigenvalues.asDiagonal() * Q.transpose();
    const Eigen::VectorXd P = Eigen::VectorXd::LinSpaced(n, 1.0, 4.0);
    const Eigen::VectorXd b = noise(n, 6, 1.0);
    const auto apply = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return A * x; };
    const auto precondition = [&](const Eigen::VectorXd& r) -> Eigen::VectorXd {
      return r.cwiseQuotient(P);
    };
    const Eigen::VectorXd Pb = precondition(b);
    double last = 1.0;
    for (const int iterations : {1, 2, 5, 10}) {
      const auto result = detail::minimal_residual(apply, precondition, b, Pb, 0.0, iterations);
      const Eigen::VectorXd r = b - A * result.x;
      const double norm = std::sqrt(r.dot(precondition(r)) / b.dot(Pb));
      EXPECT_NEAR(result.relative_residual, norm, 1e-10);
      EXPECT_LT(norm, last);
      last = norm;
    }
    const auto solved = detail::minimal_residual(apply, precondition, b, Pb, 1e-10, 100);
    EXPECT_TRUE(solved.converged);
    EXPECT_LE(solved.iterations, n + 5);
    EXPECT_LT((A * solved.x - b).norm(), 1e-9 * b.norm());
  }
}

TEST(MinimalResidual, ExactPreconditionerNeedsOneIteration) {
  const Eigen::VectorXd A = Eigen::VectorXd::LinSpaced(20, 1.0, 1e6);
  const Eigen::VectorXd b = noise(20, 7, 1.0);
  const auto apply = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return A.cwiseProduct(x); };
  const auto precondition = [&](const Eigen::VectorXd& r) -> Eigen::VectorXd {
    return r.cwiseQuotient(A);
  };
  const auto result = detail::minimal_residual(apply, precondition, b, precondition(b), 1e-12, 50);
  EXPECT_EQ(result.iterations, 1);
  EXPECT_TRUE(result.converged);
}

TEST(MinimalResidual, ProductThatIsNotFiniteStopsIt) {
  const Eigen::VectorXd b = noise(5, 8, 1.0);
  const auto broken = [](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    return Eigen::VectorXd::Constant(x.size(), std::nan(""));
  };
  const auto same = [](const Eigen::VectorXd& r) { return r; };
  const auto result = detail::minimal_residual(broken, same, b, b, 1e-8, 10);
  EXPECT_FALSE(result.finite);
  EXPECT_FALSE(result.converged);
  EXPECT_TRUE(result.x.allFinite());
}

}  // namespace
}  // namespace twang
