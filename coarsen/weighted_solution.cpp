// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/weighted_solution.hpp"

#include "core/constants.hpp"
#include "core/dense_algebra.hpp"

#include <cmath>

namespace twang {
namespace {

constexpr double kRankTolerance = 1e-3;  // of singular values: below, a combination is not told
constexpr double kRoundOff = 1e-14;      // of squared ones

}  // namespace

WeightedSolution solve_weighted(const Eigen::MatrixXd& A,
                                const Eigen::VectorXd& b,
                                const Eigen::VectorXd& weight) {
  const Eigen::MatrixXd WA = weight.asDiagonal() * A;
  const SymmetricEigen normal = symmetric_eigen(WA.transpose() * WA);
  const double largest = normal.values.maxCoeff();
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(normal.values.size());
  WeightedSolution solution;
  solution.untold = Eigen::VectorXd::Zero(normal.values.size());
  for (Eigen::Index i = 0; i < inverse.size(); ++i) {
    if (normal.values[i] > kRankTolerance * kRankTolerance * largest) {
      inverse[i] = 1.0 / normal.values[i];
    } else {
      solution.untold += normal.vectors.col(i).cwiseAbs2();
    }
  }
  solution.covariance = normal.vectors * inverse.asDiagonal() * normal.vectors.transpose();
  solution.x = solution.covariance * (WA.transpose() * weight.cwiseProduct(b));
  const double least = normal.values.minCoeff();
  solution.condition = least > kRoundOff * largest ? std::sqrt(largest / least) : kInfinity;
  return solution;
}

}  // namespace twang
