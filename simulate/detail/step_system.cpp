// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/detail/step_system.hpp"

#include <utility>

namespace twang::detail {

void StepSystem::hold(Eigen::MatrixXd C) {
  m_C = std::move(C);
  m_gram.compute(m_C.transpose() * m_C);
}

bool StepSystem::renew(const DampedBody::Linearization& at) {
  const PhaseTimer timer(phases.factorization_s);
  const bool ready = m_factor.renew(at);
  if (ready) respond_to_points();
  return ready;
}

void StepSystem::follow(const Eigen::VectorXd& u) {
  m_factor.follow(u);
  respond_to_points();
}

/// What the preconditioner makes of forces on the held points.
void StepSystem::respond_to_points() {
  if (m_C.cols() == 0) return;
  const PhaseTimer timer(phases.preconditioner_s);
  m_PC.resize(m_C.rows(), m_C.cols());
  for (Eigen::Index i = 0; i < m_C.cols(); ++i) m_PC.col(i) = m_factor.apply(m_C.col(i));
  m_schur.compute(m_C.transpose() * m_PC);
}

Eigen::VectorXd StepSystem::off_points(Eigen::VectorXd r) const {
  if (m_C.cols() > 0) r -= m_C * m_gram.solve(m_C.transpose() * r);
  return r;
}

Eigen::VectorXd StepSystem::precondition(const Eigen::VectorXd& r) const {
  const PhaseTimer timer(phases.preconditioner_s);
  if (m_C.cols() == 0) return m_factor.apply(r);
  Eigen::VectorXd z = m_factor.apply(off_points(r));
  z -= m_PC * m_schur.solve(m_C.transpose() * z);
  return z;
}

Eigen::VectorXd StepSystem::product(const DampedBody::Linearization& at,
                                    const Eigen::VectorXd& w) const {
  const PhaseTimer timer(phases.products_s);
  return off_points(m_damped.step_product(at, w));
}

}  // namespace twang::detail
