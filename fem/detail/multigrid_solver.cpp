// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/multigrid_solver.hpp"

#include "fem/detail/thread_limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace twang {
namespace {

/// Iterations by the undeformed body's cycles alone after which the deformed one's coarse problem
/// repays its 81 products.
constexpr int kPatience = 25;

}  // namespace

MultigridSolver::MultigridSolver(const ElasticBody& body,
                                 const FreeDofs& free,
                                 const StiffnessSolverOptions& options,
                                 std::string reason)
    : m_options(options),
      m_reason(std::move(reason)),
      m_problem(make_grid_problem(body, free, options.max_coarse_dofs)) {}

SolveStatus MultigridSolver::prepare(const StiffnessCombination& of, const Eigen::VectorXd& u) {
  m_matrix = {};
  m_balanced = false;
  m_deformed = u.size() > 0 && u.cwiseAbs().maxCoeff() > 0.0;
  const SolveStatus status = m_problem->prepare(of);
  if (status == SolveStatus::Ok) m_matrix = m_problem->matrix(of, u);
  return status;
}

SolveStatus MultigridSolver::balance() {
  if (m_deformed_coarse == nullptr) {
    m_deformed_coarse = m_problem->make_deformed_coarse(m_options.max_coarse_dofs);
  }
  if (m_deformed_coarse == nullptr) {
    m_deformed = false;
    return SolveStatus::Ok;
  }
  const SolveStatus status = m_deformed_coarse->prepare(m_matrix);
  m_balanced = status == SolveStatus::Ok;
  return status;
}

Eigen::VectorXd MultigridSolver::precondition(const Eigen::VectorXd& r) {
  if (!m_balanced) return m_problem->cycle(r);
  const Eigen::VectorXd coarse = m_deformed_coarse->solve(r);
  const Eigen::VectorXd z = m_problem->cycle(r - m_matrix(coarse));
  return coarse + z - m_deformed_coarse->solve(m_matrix(z));
}

StiffnessSolution MultigridSolver::solve_one(const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  StiffnessSolution solution;
  solution.status = SolveStatus::Ok;
  const double scale = b.norm();
  x = Eigen::VectorXd::Zero(b.size());
  if (scale == 0.0) return solution;
  // Needed once, the deformed coarse problem will be needed again.
  const int patience = m_deformed_coarse == nullptr ? kPatience : 0;
  Eigen::VectorXd r = b;
  Eigen::VectorXd p;
  Eigen::VectorXd q;
  double rz = 0.0;
  double step = 0.0;
  double residual = 1.0;
  while (residual > m_options.tolerance && solution.iterations < m_options.max_iterations) {
    const bool balance_now = m_deformed && !m_balanced && solution.iterations >= patience;
    if (balance_now && balance() != SolveStatus::Ok) {
      solution.status = SolveStatus::NotPositiveDefinite;
      solution.message = "the matrix is not positive definite, nor is the coarse problem";
      break;
    }
    const Eigen::VectorXd z = precondition(r);
    const double last_rz = rz;
    rz = r.dot(z);
    if (solution.iterations == 0 || balance_now) {
      p = z;
    } else {
      // r - r before = -step q
      p = z - (step * q.dot(z) / last_rz) * p;
    }
    q = m_matrix(p);
    const double curvature = p.dot(q);
    if (!(curvature > 0.0) || !(rz > 0.0)) {
      solution.status =
          curvature <= 0.0 || rz <= 0.0 ? SolveStatus::NotPositiveDefinite : SolveStatus::Failed;
      solution.message = fmt::format(
          "the matrix is not positive definite: iteration {} of the conjugate gradients found "
          "{} of {:.3g}",
          solution.iterations + 1,
          curvature <= 0.0 ? "a curvature" : "a norm of the residual",
          curvature <= 0.0 ? curvature : rz);
      break;
    }
    step = rz / curvature;
    x += step * p;
    r -= step * q;
    ++solution.iterations;
    residual = r.norm() / scale;
  }
  solution.relative_residual = (b - m_matrix(x)).norm() / scale;
  if (solution.status == SolveStatus::Ok && !(residual <= m_options.tolerance)) {
    solution.status = SolveStatus::NotConverged;
    solution.message = fmt::format("the residual is {:.2g} after {} iterations, must be <= {:.2g}",
                                   solution.relative_residual,
                                   solution.iterations,
                                   m_options.tolerance);
  }
  return solution;
}

StiffnessSolution MultigridSolver::solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) {
  StiffnessSolution worst;
  if (!m_matrix) {
    worst.message = "no matrix has been prepared";
    return worst;
  }
  worst.status = SolveStatus::Ok;
  const PoliteThreads threads;
  X.resize(B.rows(), B.cols());
  for (int k = 0; k < B.cols(); ++k) {
    Eigen::VectorXd x;
    const StiffnessSolution one = solve_one(m_problem->from_free(B.col(k)), x);
    X.col(k) = m_problem->to_free(x);
    worst.iterations = std::max(worst.iterations, one.iterations);
    worst.relative_residual = std::max(worst.relative_residual, one.relative_residual);
    if (one.status == SolveStatus::Ok || worst.status != SolveStatus::Ok) continue;
    worst.status = one.status;
    worst.message = one.message;
  }
  return worst;
}

std::string MultigridSolver::description() const {
  return fmt::format("multigrid of {} level{} with conjugate gradients ({})",
                     m_problem->num_levels(),
                     m_problem->num_levels() == 1 ? "" : "s",
                     m_reason);
}

double MultigridSolver::memory_bytes() const {
  constexpr double kVectors = 6.0;  // of the conjugate gradients
  const double deformed = m_deformed_coarse == nullptr ? 0.0 : m_deformed_coarse->memory_bytes();
  return m_problem->memory_bytes() + deformed + 8.0 * kVectors * m_problem->size();
}

}  // namespace twang
