// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dense_algebra.hpp"

#include <gtest/gtest.h>

#include <random>

namespace twang {
namespace {

using Eigen::MatrixXd;

constexpr double kRoundOff = 1e-12;  // of well conditioned matrices of this size

MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

MatrixXd symmetric(Eigen::Index n, unsigned seed) {
  const MatrixXd A = random_matrix(n, n, seed);
  return A + A.transpose();
}

MatrixXd definite(Eigen::Index n, unsigned seed) {
  const MatrixXd A = random_matrix(n, n, seed);
  return A * A.transpose() + MatrixXd::Identity(n, n);
}

TEST(SymmetricEigen, RebuildsTheMatrixFromAscendingValues) {
  const MatrixXd A = symmetric(7, 1);
  const SymmetricEigen eigen = symmetric_eigen(A);
  EXPECT_TRUE(eigen.converged);
  for (Eigen::Index i = 1; i < 7; ++i) EXPECT_LE(eigen.values(i - 1), eigen.values(i));
  EXPECT_LT((eigen.vectors * eigen.values.asDiagonal() * eigen.vectors.transpose() - A).norm(),
            kRoundOff * A.norm());
}

TEST(SymmetricEigen, OfTwoMatricesIsOrthonormalInTheSecond) {
  const MatrixXd A = symmetric(6, 2);
  const MatrixXd B = definite(6, 3);
  const SymmetricEigen eigen = symmetric_eigen(A, B);
  EXPECT_TRUE(eigen.converged);
  EXPECT_LT((eigen.vectors.transpose() * B * eigen.vectors - MatrixXd::Identity(6, 6)).norm(),
            kRoundOff);
  EXPECT_LT((A * eigen.vectors - B * eigen.vectors * eigen.values.asDiagonal()).norm(),
            kRoundOff * A.norm() * eigen.vectors.norm());
}

TEST(SolveSymmetric, UndoesTheProduct) {
  const MatrixXd A = definite(8, 4);
  const MatrixXd x = random_matrix(8, 3, 5);
  EXPECT_LT((solve_symmetric(A, A * x) - x).norm(), kRoundOff * x.norm());
}

TEST(SolveLeastSquares, LeavesAResidualAtRightAnglesToTheColumns) {
  const MatrixXd A = random_matrix(9, 4, 6);
  const MatrixXd b = random_matrix(9, 2, 7);
  const LeastSquares fit = solve_least_squares(A, b);
  EXPECT_EQ(fit.rank, 4);
  EXPECT_LT((A.transpose() * (A * fit.x - b)).norm(), kRoundOff * b.norm() * A.norm());
}

TEST(SolveLeastSquares, SeesThatAColumnIsTwiceAnother) {
  MatrixXd A = random_matrix(9, 3, 8);
  A.col(2) = 2.0 * A.col(0);
  EXPECT_EQ(solve_least_squares(A, random_matrix(9, 1, 9)).rank, 2);
}

TEST(OrthonormalBasis, SpansWhatTheColumnsSpan) {
  const MatrixXd A = random_matrix(9, 4, 10);
  const MatrixXd Q = orthonormal_basis(A);
  EXPECT_LT((Q.transpose() * Q - MatrixXd::Identity(4, 4)).norm(), kRoundOff);
  EXPECT_LT((Q * Q.transpose() * A - A).norm(), kRoundOff * A.norm());
}

TEST(Orthonormalized, IsSoInTheProductOfTheGramMatrix) {
  const MatrixXd M = definite(9, 11);
  const MatrixXd A = random_matrix(9, 4, 12);
  const MatrixXd Q = orthonormalized(A, A.transpose() * M * A);
  EXPECT_LT((Q.transpose() * M * Q - MatrixXd::Identity(4, 4)).norm(), kRoundOff);
}

}  // namespace
}  // namespace twang
