// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace twang {

/// x of the least ‖W (A x - b)‖ and the covariance (A^T W² A)^+; what no row tells stays 0.
struct WeightedSolution {
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance;
  Eigen::VectorXd untold;  // how far x lies in what no row tells, 0 .. 1, for each entry
  double condition = 0.0;  // of W A
};
/// @param A       (m x n), m >= n
/// @param weight  the diagonal of W, 1 / sigma of each row
[[nodiscard]] WeightedSolution solve_weighted(const Eigen::MatrixXd& A,
                                              const Eigen::VectorXd& b,
                                              const Eigen::VectorXd& weight);

}  // namespace twang
