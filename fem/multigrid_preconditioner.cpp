// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/multigrid_preconditioner.hpp"

#include "core/error.hpp"
#include "fem/detail/grid_problem.hpp"
#include "fem/detail/thread_limits.hpp"

#include <fmt/format.h>

#include <random>
#include <string>

namespace twang {
namespace {

const ElasticBody& checked(const ElasticBody& body) {
  const std::string fault = grid_fault(body.mesh());
  if (!fault.empty()) throw InputError(fmt::format("multigrid does not fit the mesh: {}", fault));
  return body;
}

}  // namespace

struct MultigridPreconditioner::Impl {
  Impl(const ElasticBody& body, const FreeDofs& free, int max_coarse_dofs)
      : problem(make_grid_problem(checked(body), free, max_coarse_dofs)) {}
  std::unique_ptr<GridProblem> problem;
};

MultigridPreconditioner::MultigridPreconditioner(const ElasticBody& body,
                                                 const FreeDofs& free,
                                                 int max_coarse_dofs)
    : m_impl(std::make_unique<Impl>(body, free, max_coarse_dofs)) {}
MultigridPreconditioner::~MultigridPreconditioner() = default;

SolveStatus MultigridPreconditioner::prepare(const StiffnessCombination& of) {
  const PoliteThreads threads;
  return m_impl->problem->prepare(of);
}

Eigen::VectorXd MultigridPreconditioner::apply(const Eigen::VectorXd& r) const {
  const PoliteThreads threads;
  GridProblem& problem = *m_impl->problem;
  return problem.to_free(problem.cycle(problem.from_free(r)));
}

/// The mean of s A s over vectors s of random signs [Hutchinson 1990], entry by entry.
Eigen::VectorXd MultigridPreconditioner::estimate_diagonal(const StiffnessCombination& of) const {
  constexpr int kProbes = 8;
  const GridProblem& problem = *m_impl->problem;
  const LinearMap A = problem.matrix(of, {});
  const Eigen::Index n = problem.size();
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(n);
  std::mt19937 random(1);
  for (int probe = 0; probe < kProbes; ++probe) {
    Eigen::VectorXd signs(n);
    for (Eigen::Index i = 0; i < n; ++i)
      signs[i] = problem.held()[static_cast<std::size_t>(i)] != 0 ? 0.0
                 : (random() & 1U) != 0                           ? 1.0
                                                                  : -1.0;
    sum += signs.cwiseProduct(A(signs));
  }
  return problem.to_free((sum / kProbes).cwiseAbs());
}

bool prefers_multigrid(const ElasticBody& body,
                       const FreeDofs& free,
                       const StiffnessSolverOptions& options) {
  options.check();
  switch (options.kind) {
    case StiffnessSolverKind::Factor:
      return false;
    case StiffnessSolverKind::Multigrid:
      return true;
    case StiffnessSolverKind::Automatic:
      break;
  }
  return estimate_factor_bytes(free.size()) > options.max_factor_bytes &&
         grid_fault(body.mesh()).empty();
}

}  // namespace twang
