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

}  // namespace twang::detail
