// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

/// Decompositions of small dense matrices by Eigen, compiled once: its templates take seconds of
/// every file that names them.
namespace twang {

/// A X = X diag(values) or A X = B X diag(values); values ascend, X^T X = 1 or X^T B X = 1.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
  bool converged = false;
};

/// Of a symmetric A, n x n; its lower triangle is read.
[[nodiscard]] SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A);

/// Of symmetric A and B, n x n, B positive definite.
[[nodiscard]] SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// A^-1 b by A = L D L^T; A symmetric, definite or nearly so. The lower triangle is read.
[[nodiscard]] Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& b);

/// The x of the smallest |A x - b|, and the rank of A that pivoting found.
struct LeastSquares {
  Eigen::MatrixXd x;
  Eigen::Index rank = 0;
};

/// By QR with column pivoting; A is m x n, m >= n, b is m x k, x is n x k.
[[nodiscard]] LeastSquares solve_least_squares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& b);

/// Orthonormal columns that span what the columns of A do; m x n, m >= n, of full rank.
[[nodiscard]] Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& A);

/// A U^-1, where gram = U^T U; with the Gram matrix of A's columns these become orthonormal.
[[nodiscard]] Eigen::MatrixXd orthonormalized(const Eigen::MatrixXd& A,
                                              const Eigen::MatrixXd& gram);

}  // namespace twang
