// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"

#include <Eigen/Core>

#include <memory>
#include <string>

namespace twang {

enum class SolveStatus { Ok, NotPositiveDefinite, OutOfMemory, NotFactorized, Failed };

/// Symmetric linear systems in three phases. Callers never name a library.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;
  /// Orders and analyses the pattern of `A`; kept until called again.
  virtual SolveStatus analyze(const SparseMatrix& A) = 0;
  /// Factorizes a matrix of the analysed pattern.
  virtual SolveStatus factorize(const SparseMatrix& A) = 0;
  /// Solves A X = B, (n x k).
  virtual SolveStatus solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) = 0;
  /// What it is, in a few words for summaries ("CHOLMOD supernodal Cholesky").
  [[nodiscard]] virtual std::string name() const = 0;
};

/// Sparse supernodal Cholesky; positive definite matrices only.
[[nodiscard]] std::unique_ptr<LinearSolver> make_cholesky_solver();

}  // namespace twang
