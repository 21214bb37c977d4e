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
  Eigen::VectorXd start;  ///< a vector with a part of every mode wanted
};

struct LanczosResult {
  Eigen::VectorXd lambda;   ///< the smallest, ascending
  Eigen::MatrixXd vectors;  ///< (size x count), M-orthonormal
  Termination termination = Termination::NotRun;
  std::string message;
};

/// The `count` smallest eigenvalues by ARPACK's implicitly restarted Lanczos iteration in
/// shift-invert mode. Needs 0 < count < size.
[[nodiscard]] LanczosResult run_lanczos(const ShiftedProblem& problem, int count, double tolerance);

}  // namespace twang
