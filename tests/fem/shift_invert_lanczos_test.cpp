// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/shift_invert_lanczos.hpp"

#include <gtest/gtest.h>

namespace twang {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Diagonal K and M.
ShiftedProblem diagonal_problem(const VectorXd& lambda, const VectorXd& mass, double sigma) {
  ShiftedProblem problem;
  problem.size = static_cast<int>(lambda.size());
  problem.sigma = sigma;
  problem.apply_mass = [=](const VectorXd& x) -> VectorXd { return mass.cwiseProduct(x); };
  problem.apply_solver = [=](const VectorXd& x) -> VectorXd {
    return x.cwiseQuotient(mass.cwiseProduct((lambda.array() - sigma).matrix()));
  };
  problem.known.resize(problem.size, 0);
  return problem;
}

VectorXd squares(int size) { return VectorXd::LinSpaced(size, 1.0, size).array().square(); }

TEST(FindSmallest, FindsEveryCopyOfAMultipleEigenvalue) {
  // 1, 1, 1, 2, 2, 3, 4, 5, 6 and others far above: one iteration alone passes a copy over.
  VectorXd lambda = 1e4 * VectorXd::LinSpaced(300, 1.0, 300.0);
  lambda.head(6) = VectorXd::LinSpaced(6, 1.0, 6.0);
  lambda.tail(2).setConstant(1.0);
  lambda[150] = 2.0;
  const VectorXd mass = VectorXd::Constant(300, 4.0);
  const LanczosResult found = find_smallest(diagonal_problem(lambda, mass, 0.0), 6, 1e-10);
  ASSERT_EQ(found.termination, Termination::Converged) << found.message;
  VectorXd expected(6);
  expected << 1, 1, 1, 2, 2, 3;
  EXPECT_LT((found.lambda - expected).cwiseAbs().maxCoeff(), 1e-9);
  const MatrixXd gram = found.vectors.transpose() * mass.asDiagonal() * found.vectors;
  EXPECT_LT((gram - MatrixXd::Identity(6, 6)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(FindSmallest, LeavesKnownVectorsOut) {
  const VectorXd mass = VectorXd::Constant(200, 4.0);
  ShiftedProblem problem = diagonal_problem(squares(200), mass, 0.0);
  problem.known = MatrixXd::Zero(200, 2);
  problem.known(0, 0) = 0.5;
  problem.known(2, 1) = 0.5;
  const LanczosResult found = find_smallest(problem, 3, 1e-12);
  ASSERT_EQ(found.termination, Termination::Converged) << found.message;
  EXPECT_LT((found.lambda - Eigen::Vector3d(4, 16, 25)).cwiseAbs().maxCoeff(), 1e-9);
}

}  // namespace
}  // namespace twang
