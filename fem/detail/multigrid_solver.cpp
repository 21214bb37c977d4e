// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/multigrid_solver.hpp"

#include "fem/detail/thread_limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace twang {

VoxelOperator::VoxelOperator(const ElasticBody& body,
                             const VoxelBody& voxels,
                             const StiffnessCombination& of,
                             const Eigen::VectorXd& u)
    : m_body(body), m_voxels(voxels), m_of(of) {
  const bool deformed =
      u.size() > 0 && u.cwiseAbs().maxCoeff() > 0.0 && body.model() != ConstitutiveModel::Linear;
  if (deformed) m_u = u;
  m_moduli = voxels.moduli<double>(deformed ? StiffnessCombination{0.0, 0.0, of.mass} : of);
}

Eigen::VectorXd VoxelOperator::operator()(const Eigen::VectorXd& x) const {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(x.size());
  if (m_u.size() > 0) {
    const Eigen::VectorXd w = m_voxels.to_full(x);
    Eigen::VectorXd full = Eigen::VectorXd::Zero(x.size());
    if (m_of.stiffness != 0.0) full += m_of.stiffness * m_body.stiffness_product(m_u, w);
    if (m_of.damping != 0.0) full += m_of.damping * m_body.stiffness_damping_force(m_u, w);
    y = m_voxels.from_full(full);
  }
  m_voxels.add_product(m_moduli, 1.0, x.data(), y.data());
  m_voxels.add_point_masses(m_of.mass, x, y);
  return y;
}

MultigridSolver::MultigridSolver(const ElasticBody& body,
                                 const FreeDofs& free,
                                 const StiffnessSolverOptions& options,
                                 std::string reason)
    : m_body(body),
      m_options(options),
      m_reason(std::move(reason)),
      m_voxels(body, free),
      m_multigrid(m_voxels, options.max_coarse_dofs) {}

SolveStatus MultigridSolver::prepare(const StiffnessCombination& of, const Eigen::VectorXd& u) {
  m_operator.reset();
  const SolveStatus status = m_multigrid.prepare(of);
  if (status == SolveStatus::Ok) {
    m_operator = std::make_unique<VoxelOperator>(m_body, m_voxels, of, u);
  }
  return status;
}

StiffnessSolution MultigridSolver::solve_one(const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  StiffnessSolution solution;
  solution.status = SolveStatus::Ok;
  const double scale = b.norm();
  x = Eigen::VectorXd::Zero(b.size());
  if (scale == 0.0) return solution;
  Eigen::VectorXd r = b;
  Eigen::VectorXd z = m_multigrid.cycle(r);
  Eigen::VectorXd p = z;
  double rz = r.dot(z);
  double residual = 1.0;
  while (residual > m_options.tolerance && solution.iterations < m_options.max_iterations) {
    const Eigen::VectorXd q = (*m_operator)(p);
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
    const double step = rz / curvature;
    x += step * p;
    r -= step * q;
    ++solution.iterations;
    residual = r.norm() / scale;
    if (residual <= m_options.tolerance) break;
    z = m_multigrid.cycle(r);
    const double next_rz = r.dot(z);
    // r - r before = -step q
    p = z - (step * q.dot(z) / rz) * p;
    rz = next_rz;
  }
  solution.relative_residual = (b - (*m_operator)(x)).norm() / scale;
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
  if (m_operator == nullptr) {
    worst.message = "no matrix has been prepared";
    return worst;
  }
  worst.status = SolveStatus::Ok;
  const PoliteThreads threads;
  X.resize(B.rows(), B.cols());
  for (int k = 0; k < B.cols(); ++k) {
    Eigen::VectorXd x;
    const StiffnessSolution one = solve_one(m_voxels.from_free(B.col(k)), x);
    X.col(k) = m_voxels.to_free(x);
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
                     m_multigrid.num_levels(),
                     m_multigrid.num_levels() == 1 ? "" : "s",
                     m_reason);
}

double MultigridSolver::memory_bytes() const {
  // Moduli in double precision, maps to and from the mesh, vectors of the conjugate gradients.
  return m_multigrid.memory_bytes() + 24.0 * m_voxels.grid().num_cells() +
         (9.0 + 6.0 * 8.0) * m_voxels.size();
}

}  // namespace twang
