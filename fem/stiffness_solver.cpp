// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/stiffness_solver.hpp"

#include "core/error.hpp"
#include "fem/detail/multigrid_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang {
namespace {

/// Measured on strips and blocks of hexahedra: 1 GB at 178,000 and 11 GB at 1,240,000 unknowns.
constexpr double kFactorBytes = 1e9;
constexpr double kFactorDofs = 178e3;
constexpr double kFactorGrowth = 1.24;

class FactorSolver final : public StiffnessSolver {
 public:
  FactorSolver(const ElasticBody& body, const FreeDofs& free, std::string reason)
      : m_body(body), m_free(free), m_reason(std::move(reason)) {}

  SolveStatus prepare(const StiffnessCombination& of, const Eigen::VectorXd& u) override {
    SparseMatrix A = m_body.stiffness(u);
    A.coeffs() *= of.stiffness;
    if (of.damping != 0.0) A.coeffs() += of.damping * m_body.stiffness_damping(u).coeffs();
    if (of.mass != 0.0) m_body.add_scaled_mass(of.mass, A);
    m_matrix = m_free.size() == A.rows() ? std::move(A) : m_free.restrict_matrix(A);
    if (!m_analyzed) {
      const SolveStatus status = m_solver->analyze(m_matrix);
      if (status != SolveStatus::Ok) return status;
      m_analyzed = true;
    }
    return m_solver->factorize(m_matrix);
  }

  StiffnessSolution solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) override {
    StiffnessSolution solution;
    solution.status = m_solver->solve(B, X);
    if (solution.status != SolveStatus::Ok) {
      solution.message = "there is no factor to solve with";
      return solution;
    }
    for (int k = 0; k < B.cols(); ++k) {
      const double scale = B.col(k).norm();
      if (scale == 0.0) continue;
      solution.relative_residual =
          std::max(solution.relative_residual, (B.col(k) - m_matrix * X.col(k)).norm() / scale);
    }
    return solution;
  }

  [[nodiscard]] StiffnessSolverKind kind() const override { return StiffnessSolverKind::Factor; }
  [[nodiscard]] std::string description() const override {
    return fmt::format("{} ({})", m_solver->name(), m_reason);
  }
  [[nodiscard]] double memory_bytes() const override {
    return estimate_factor_bytes(m_free.size()) + 12.0 * static_cast<double>(m_matrix.nonZeros());
  }

 private:
  const ElasticBody& m_body;
  const FreeDofs& m_free;
  std::string m_reason;
  SparseMatrix m_matrix;
  std::unique_ptr<LinearSolver> m_solver = make_cholesky_solver();
  bool m_analyzed = false;
};

}  // namespace

void StiffnessSolverOptions::check() const {
  if (!(tolerance > 0.0 && tolerance < 1.0)) {
    throw InputError(fmt::format("tolerance is {}, must be > 0 and < 1", tolerance));
  }
  if (max_iterations < 1) {
    throw InputError(fmt::format("max_iterations is {}, must be >= 1", max_iterations));
  }
  if (!(max_factor_bytes >= 0.0)) {
    throw InputError(fmt::format("max_factor_bytes is {}, must be >= 0", max_factor_bytes));
  }
  if (max_coarse_dofs < 1) {
    throw InputError(fmt::format("max_coarse_dofs is {}, must be >= 1", max_coarse_dofs));
  }
  if (max_quadratic_factor_dofs < 0) {
    throw InputError(
        fmt::format("max_quadratic_factor_dofs is {}, must be >= 0", max_quadratic_factor_dofs));
  }
}

double estimate_factor_bytes(int num_free_dofs) {
  return kFactorBytes * std::pow(num_free_dofs / kFactorDofs, kFactorGrowth);
}

std::unique_ptr<StiffnessSolver> make_stiffness_solver(const ElasticBody& body,
                                                       const FreeDofs& free,
                                                       const StiffnessSolverOptions& options) {
  options.check();
  const double gigabytes = 1e-9 * estimate_factor_bytes(free.size());
  const bool large = 1e9 * gigabytes > options.max_factor_bytes;
  std::string reason;
  if (options.kind == StiffnessSolverKind::Factor) {
    reason = "as asked";
  } else if (options.kind == StiffnessSolverKind::Automatic && !large) {
    reason = fmt::format("a factor of about {:.2g} GB", gigabytes);
  } else {
    const std::string fault = grid_fault(body.mesh());
    const bool asked = options.kind == StiffnessSolverKind::Multigrid;
    if (fault.empty()) {
      reason = "as asked";
      if (!asked) reason = fmt::format("a factor would take about {:.2g} GB", gigabytes);
      return std::make_unique<MultigridSolver>(body, free, options, reason);
    }
    if (asked) throw InputError(fmt::format("multigrid does not fit the mesh: {}", fault));
    reason =
        fmt::format("about {:.2g} GB, but multigrid does not fit the mesh: {}", gigabytes, fault);
  }
  return std::make_unique<FactorSolver>(body, free, reason);
}

}  // namespace twang
