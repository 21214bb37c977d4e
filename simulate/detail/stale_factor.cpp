// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/detail/stale_factor.hpp"

#include "core/constants.hpp"
#include "fem/threads.hpp"

#include <algorithm>

namespace twang::detail {
namespace {

// Assembly and factorization against one iteration (two triangular solves and a product); measured
// between 15 and 20 from 15 k to 180 k unknowns, and the optimum is flat.
constexpr int kFactorizationInIterations = 16;

}  // namespace

StaleFactor::StaleFactor(const DampedBody& body, const StiffnessSolverOptions& options)
    : m_body(body), m_rotations(body.body().mesh()) {
  if (prefers_multigrid(body.body(), body.free(), options)) {
    m_cycles = std::make_unique<MultigridPreconditioner>(
        body.body(), body.free(), options.max_coarse_dofs);
  } else {
    m_solver = make_cholesky_solver();
  }
}

/// (1 + gamma b) K(0) + (mu + gamma a) M.
SolveStatus StaleFactor::prepare_cycles(const DampedBody::Linearization& at) {
  const StiffnessCombination stiffness = {1.0, at.gamma_per_s, 0.0};
  const StiffnessCombination all = {1.0, at.gamma_per_s, m_body.inertia_weight(at)};
  m_diagonal = m_cycles->estimate_diagonal(all);
  m_stiffness_diagonal = m_cycles->estimate_diagonal(stiffness);
  m_rotations_then.assign(static_cast<std::size_t>(m_body.body().mesh().num_nodes()),
                          Eigen::Matrix3d::Identity());
  m_made_at = at;
  return m_cycles->prepare(all);
}

std::string StaleFactor::description() const {
  return m_cycles ? "MINRES with a multigrid cycle of the undeformed body, turned node by node"
                  : "MINRES with a stale sparse Cholesky factor, turned node by node";
}

SolveStatus StaleFactor::factorize(const DampedBody::Linearization& at) {
  if (m_cycles) return prepare_cycles(at);
  const SparseMatrix H = m_body.step_matrix(at);
  if (!m_analyzed) {
    if (m_solver->analyze(H) != SolveStatus::Ok) return SolveStatus::Failed;
    m_analyzed = true;
  }
  if (!H.coeffs().allFinite()) return SolveStatus::NotPositiveDefinite;
  m_diagonal = H.diagonal();
  m_stiffness_diagonal = m_diagonal - m_body.inertia_diagonal(at);
  m_rotations_then = m_rotations.at(at.u);
  m_made_at = at;
  return m_solver->factorize(H);
}

bool StaleFactor::renew(const DampedBody::Linearization& at) {
  if (m_cycles && fits(at)) {
    follow(at.u);
    return true;
  }
  m_fresh_iterations = -1;
  m_excess_iterations = 0;
  m_mu = at.mu_per_s2;
  m_gamma = at.gamma_per_s;
  SolveStatus status = factorize(at);
  if (status == SolveStatus::NotPositiveDefinite && !at.differences) {
    DampedBody::Linearization here = at;
    here.differences = true;
    status = factorize(here);
  }
  if (status == SolveStatus::NotPositiveDefinite) {
    DampedBody::Linearization rest = at;
    rest.u.setZero();
    rest.v.setZero();
    status = factorize(rest);
  }
  m_ready = status == SolveStatus::Ok;
  if (m_ready) follow(at.u);
  return m_ready;
}

bool StaleFactor::fits(const DampedBody::Linearization& at) const {
  return m_ready && at.mu_per_s2 == m_mu && at.gamma_per_s == m_gamma;
}

void StaleFactor::follow(const Eigen::VectorXd& u) {
  m_turns = m_rotations.at(u);
  for (std::size_t i = 0; i < m_turns.size(); ++i) m_turns[i] *= m_rotations_then[i].transpose();
}

Eigen::VectorXd StaleFactor::apply(const Eigen::VectorXd& r) const {
  Eigen::VectorXd turned(r.size());
  const auto num_nodes = static_cast<int>(m_turns.size());
  for_each_range(num_nodes, [&](int first, int last) {
    for (int i = first; i < last; ++i)
      turned.segment<3>(3 * i).noalias() =
          m_turns[static_cast<std::size_t>(i)].transpose() * r.segment<3>(3 * i);
  });
  Eigen::VectorXd solution;
  const Eigen::VectorXd right = m_body.free().restrict_vector(turned);
  if (m_cycles) {
    solution = m_cycles->apply(right);
  } else if (m_solver->solve_roughly(right, solution) != SolveStatus::Ok) {
    return Eigen::VectorXd::Constant(r.size(), kNaN);
  }
  turned = m_body.free().expand_vector(solution);
  Eigen::VectorXd result(r.size());
  for_each_range(num_nodes, [&](int first, int last) {
    for (int i = first; i < last; ++i)
      result.segment<3>(3 * i).noalias() =
          m_turns[static_cast<std::size_t>(i)] * turned.segment<3>(3 * i);
  });
  return result;
}

double StaleFactor::diagonal_force(const Eigen::VectorXd& u, const Eigen::VectorXd& delta) const {
  if (m_diagonal.size() == 0) return 0.0;
  return m_stiffness_diagonal.cwiseProduct(m_body.free().restrict_vector(u)).norm() +
         m_diagonal.cwiseProduct(m_body.free().restrict_vector(delta)).norm();
}

void StaleFactor::count_step(int iterations) {
  if (m_fresh_iterations < 0) {
    m_fresh_iterations = iterations;
  } else {
    m_excess_iterations += std::max(iterations - m_fresh_iterations, 0);
  }
}

bool StaleFactor::worn() const {
  return !m_cycles && m_excess_iterations > kFactorizationInIterations;
}

void StaleFactor::save(StateWriter& writer) const {
  writer.write_flag(m_ready);
  if (!m_ready) return;
  writer.write(m_made_at.u);
  writer.write(m_made_at.v);
  writer.write(m_made_at.mu_per_s2);
  writer.write(m_made_at.gamma_per_s);
  writer.write_flag(m_made_at.differences);
  writer.write_count(m_fresh_iterations);
  writer.write_count(m_excess_iterations);
}

void StaleFactor::restore(StateReader& reader) {
  m_ready = reader.read_flag();
  if (!m_ready) return;
  const Eigen::Index dofs = m_body.body().mesh().num_dofs();
  DampedBody::Linearization at;
  at.u = reader.read_vector(dofs);
  at.v = reader.read_vector(dofs);
  at.mu_per_s2 = reader.read_number();
  at.gamma_per_s = reader.read_number();
  at.differences = reader.read_flag();
  m_fresh_iterations = static_cast<int>(reader.read_count());
  m_excess_iterations = static_cast<int>(reader.read_count());
  m_mu = at.mu_per_s2;
  m_gamma = at.gamma_per_s;
  m_ready = factorize(at) == SolveStatus::Ok;
}

}  // namespace twang::detail
