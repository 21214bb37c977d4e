// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <optional>

/// Decompositions of small dense matrices by Eigen, compiled once: its templates take seconds of
/// every file that names them. Not by LAPACK: its complex routines go through OpenBLAS' zgemv,
/// whose AVX-512 kernel (0.3.21) reads beyond the matrix.
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

/// A = U S V^H, only as many columns as A has rows or columns.
struct RealSvd {
  Eigen::MatrixXd u;
  Eigen::VectorXd s;  ///< falling
  Eigen::MatrixXd v;
};

struct ComplexSvd {
  Eigen::MatrixXcd u;
  Eigen::VectorXd s;
  Eigen::MatrixXcd v;
};

/// Nothing for an empty A or one with values that are not finite.
[[nodiscard]] std::optional<RealSvd> thin_svd(const Eigen::MatrixXd& A);
[[nodiscard]] std::optional<ComplexSvd> thin_svd(const Eigen::MatrixXcd& A);

/// A X = X diag(values), columns of norm 1.
struct Eigenpairs {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;
};

/// Nothing for an empty A, values that are not finite, or an iteration that does not converge.
[[nodiscard]] std::optional<Eigenpairs> eigenpairs(const Eigen::MatrixXcd& A);
[[nodiscard]] std::optional<Eigen::VectorXcd> eigenvalues(const Eigen::MatrixXd& A);

/// X of A X = B, A n x n; nothing if A is singular or there are values that are not finite.
[[nodiscard]] std::optional<Eigen::MatrixXd> solve(const Eigen::MatrixXd& A,
                                                   const Eigen::MatrixXd& B);

/// R of A = R^T R, upper triangular; of A the upper triangle is read. Nothing if A is not positive
/// definite.
[[nodiscard]] std::optional<Eigen::MatrixXd> cholesky(const Eigen::MatrixXd& A);

/// R^-1 B and R^-T B; R is upper triangular, its diagonal without zeros.
[[nodiscard]] Eigen::MatrixXd solve_triangle(const Eigen::MatrixXd& R, const Eigen::MatrixXd& B);
[[nodiscard]] Eigen::MatrixXd solve_transposed_triangle(const Eigen::MatrixXd& R,
                                                        const Eigen::MatrixXd& B);

}  // namespace twang
