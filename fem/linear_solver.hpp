// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"

#include <Eigen/Core>

#include <memory>
#include <string>

namespace twang {

enum class SolveStatus {
  Ok,
  NotPositiveDefinite,
  OutOfMemory,
  NotFactorized,
  Failed,
  NotConverged  ///< of iterative solvers
};

/// Symmetric linear systems in three phases; of a matrix stored whole only the upper triangle is
/// read. Callers never name a library.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;
  /// Orders and analyses the pattern of `A`; kept until called again.
  virtual SolveStatus analyze(const SparseMatrix& A) = 0;
  /// Factorizes a matrix of the analysed pattern; after a failure there is no factor.
  virtual SolveStatus factorize(const SparseMatrix& A) = 0;
  /// Solves A X = B, (n x k).
  virtual SolveStatus solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) = 0;
  /// The same of one right side to about six digits, in half the time and with half as much memory
  /// again; for preconditioners.
  virtual SolveStatus solve_roughly(const Eigen::VectorXd& b, Eigen::VectorXd& x) = 0;
  /// What it is, in a few words for summaries ("CHOLMOD supernodal Cholesky").
  [[nodiscard]] virtual std::string name() const = 0;
};

/// Sparse supernodal Cholesky; positive definite matrices only. Ordered by nested dissection; a
/// second thread is used for factorizations of more than a second, on an idle machine.
[[nodiscard]] std::unique_ptr<LinearSolver> make_cholesky_solver();

}  // namespace twang
