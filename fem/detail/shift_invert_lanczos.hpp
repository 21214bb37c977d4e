// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/termination.hpp"

#include <Eigen/Core>

#include <functional>
#include <string>

namespace twang {

/// K x = lambda M x with M positive definite, seen through (K - sigma M)^-1.
struct ShiftedProblem {
  using Operator = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;
  int size = 0;
  double sigma = 0.0;     ///< below the eigenvalues wanted
  Operator apply_mass;    ///< M x
  Operator apply_solver;  ///< (K - sigma M)^-1 x
  /// Eigenvectors already known, M-orthonormal; only what is M-orthogonal to them is sought.
  Eigen::MatrixXd known;
};

struct LanczosResult {
  Eigen::VectorXd lambda;   ///< the smallest, ascending
  Eigen::MatrixXd vectors;  ///< (size x count), M-orthonormal
  Termination termination = Termination::NotRun;
  std::string message;
};

/// The `count` smallest eigenvalues beside the known ones, by ARPACK's implicitly restarted Lanczos
/// iteration in shift-invert mode.
///
/// A Lanczos iteration sees but one vector of a multiple eigenvalue (the two bendings of a square
/// bar); therefore what is orthogonal to the vectors found is searched again until nothing smaller
/// is left in it. Needs 0 < count < size - known.
[[nodiscard]] LanczosResult find_smallest(const ShiftedProblem& problem,
                                          int count,
                                          double tolerance);

}  // namespace twang
