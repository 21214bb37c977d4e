// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <optional>

/// Decompositions of dense matrices, each compiled once; nothing where there is no answer, as for
/// values that are not finite.
namespace twang::detail {

/// A = U S V^H, only as many columns as A has rows or columns.
struct ComplexSvd {
  Eigen::MatrixXcd u;
  Eigen::VectorXd s;  ///< falling
  Eigen::MatrixXcd v;
};

struct RealSvd {
  Eigen::MatrixXd u;
  Eigen::VectorXd s;
  Eigen::MatrixXd v;
};

/// A X = X diag(values), columns of norm 1.
struct Eigenpairs {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;
};

[[nodiscard]] std::optional<ComplexSvd> thin_svd(const Eigen::MatrixXcd& a);
[[nodiscard]] std::optional<RealSvd> thin_svd(Eigen::MatrixXd a);
[[nodiscard]] std::optional<Eigenpairs> eigenpairs(const Eigen::MatrixXcd& a);
[[nodiscard]] std::optional<Eigen::VectorXcd> eigenvalues(Eigen::MatrixXd a);

/// X of A X = B; nothing if A is singular.
[[nodiscard]] std::optional<Eigen::MatrixXd> solve(Eigen::MatrixXd a, Eigen::MatrixXd b);

/// X of least ‖A X - B‖, A of full rank and of no fewer rows than columns.
[[nodiscard]] std::optional<Eigen::MatrixXd> solve_least_squares(Eigen::MatrixXd a,
                                                                 Eigen::MatrixXd b);

/// R of A = R^T R, upper triangular; of A the upper triangle is read. Nothing if A is not positive
/// definite.
[[nodiscard]] std::optional<Eigen::MatrixXd> cholesky(Eigen::MatrixXd a);

/// R^-1 B and R^-T B; R is upper triangular, its diagonal without zeros.
[[nodiscard]] Eigen::MatrixXd solve_triangle(const Eigen::MatrixXd& r, Eigen::MatrixXd b);
[[nodiscard]] Eigen::MatrixXd solve_transposed_triangle(const Eigen::MatrixXd& r,
                                                        Eigen::MatrixXd b);

}  // namespace twang::detail
