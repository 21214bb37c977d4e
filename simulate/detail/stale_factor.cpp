// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/detail/stale_factor.hpp"

#include "core/constants.hpp"

#include <Eigen/Dense>

#include <algorithm>

namespace twang::detail {
namespace {

// Assembly and factorization against one iteration (two triangular solves and a product); measured
// between 10 and 20 from 15 k to 180 k unknowns, and the optimum is flat.
constexpr int kFactorizationInIterations = 16;

}  // namespace

StaleFactor::StaleFactor(const DampedBody& body)
    : m_body(body), m_solver(make_cholesky_solver()), m_arms(body.body().mesh().nodes) {
  m_arms.colwise() -= m_arms.rowwise().mean().eval();
}

Eigen::Matrix3d StaleFactor::mean_rotation(const Eigen::VectorXd& u) const {
  const Eigen::Map<const Eigen::Matrix3Xd> displacement(u.data(), 3, u.size() / 3);
  const Eigen::Matrix3d moment = (m_arms + displacement) * m_arms.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(moment, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1.0, 1.0, 1.0);
  sign.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

bool StaleFactor::renew(const DampedBody::Linearization& at) {
  m_ready = false;
  m_fresh_iterations = -1;
  m_excess_iterations = 0;
  const auto factorize = [&](const DampedBody::Linearization& where) {
    const SparseMatrix H = m_body.step_matrix(where);
    if (!m_analyzed) {
      if (m_solver->analyze(H) != SolveStatus::Ok) return SolveStatus::Failed;
      m_analyzed = true;
    }
    if (!H.coeffs().allFinite()) return SolveStatus::NotPositiveDefinite;
    m_diagonal = H.diagonal();
    m_stiffness_diagonal = m_diagonal - m_body.inertia_diagonal(where);
    return m_solver->factorize(H);
  };
  m_mu = at.mu_per_s2;
  m_gamma = at.gamma_per_s;
  m_rotation_then = m_body.held() ? Eigen::Matrix3d::Identity() : mean_rotation(at.u);
  m_turn.setIdentity();
  SolveStatus status = factorize(at);
  if (status == SolveStatus::NotPositiveDefinite) {
    DampedBody::Linearization rest = at;
    rest.u.setZero();
    rest.v.setZero();
    const Eigen::Matrix3d rotation_now = m_rotation_then;
    m_rotation_then.setIdentity();
    m_turn = rotation_now;
    status = factorize(rest);
  }
  m_ready = status == SolveStatus::Ok;
  ++m_renewals;
  return m_ready;
}

bool StaleFactor::fits(const DampedBody::Linearization& at) const {
  return m_ready && at.mu_per_s2 == m_mu && at.gamma_per_s == m_gamma;
}

void StaleFactor::follow(const Eigen::VectorXd& u) {
  if (!m_body.held()) m_turn = mean_rotation(u) * m_rotation_then.transpose();
}

Eigen::VectorXd StaleFactor::apply(const Eigen::VectorXd& r) const {
  Eigen::VectorXd turned = r;
  Eigen::Map<Eigen::Matrix3Xd> in(turned.data(), 3, turned.size() / 3);
  if (!m_body.held()) in = (m_turn.transpose() * in).eval();
  Eigen::MatrixXd solution;
  if (m_solver->solve(m_body.free().restrict_vector(turned), solution) != SolveStatus::Ok)
    return Eigen::VectorXd::Constant(r.size(), kNaN);
  Eigen::VectorXd result = m_body.free().expand_vector(solution.col(0));
  Eigen::Map<Eigen::Matrix3Xd> out(result.data(), 3, result.size() / 3);
  if (!m_body.held()) out = (m_turn * out).eval();
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

bool StaleFactor::worn() const { return m_excess_iterations > kFactorizationInIterations; }

}  // namespace twang::detail
