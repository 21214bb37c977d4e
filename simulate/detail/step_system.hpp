// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "simulate/detail/damped_body.hpp"
#include "simulate/detail/stale_factor.hpp"
#include "simulate/newton.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <chrono>
#include <vector>

namespace twang::detail {

/// Adds the wall time it lives to a phase.
class PhaseTimer {
 public:
  explicit PhaseTimer(double& phase_s) : m_phase_s(phase_s) {}
  ~PhaseTimer() {
    m_phase_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count();
  }
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  double& m_phase_s;
  std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
};

/// The linear equations of a step, J x = r in the space that held points leave, and their
/// preconditioner.
///
/// A held point is a column c of C, along which nothing moves: forces count without what the points
/// carry, and a solution z of P z = r becomes z - P⁻¹ C (Cᵀ P⁻¹ C)⁻¹ Cᵀ z.
class StepSystem {
 public:
  StepSystem(const ElasticBody& body,
             const std::vector<int>& held_nodes,
             const StiffnessSolverOptions& options)
      : m_damped(body, held_nodes), m_factor(m_damped, options) {}
  StepSystem(const StepSystem&) = delete;
  StepSystem& operator=(const StepSystem&) = delete;

  /// @param C  of held points (3 num_nodes x k), 0 at held nodes
  void hold(Eigen::MatrixXd C);

  /// As `StaleFactor::renew`.
  bool renew(const DampedBody::Linearization& at);
  /// Turns the preconditioner's frame to displacement `u`; call before `precondition`.
  void follow(const Eigen::VectorXd& u);

  /// A force without what the held points carry, (1 - C (Cᵀ C)⁻¹ Cᵀ) r.
  [[nodiscard]] Eigen::VectorXd off_points(Eigen::VectorXd r) const;
  /// P⁻¹ r, along which held points stay where they are.
  [[nodiscard]] Eigen::VectorXd precondition(const Eigen::VectorXd& r) const;
  /// J w without what the held points carry.
  [[nodiscard]] Eigen::VectorXd product(const DampedBody::Linearization& at,
                                        const Eigen::VectorXd& w) const;

  [[nodiscard]] const DampedBody& damped() const { return m_damped; }
  [[nodiscard]] StaleFactor& factor() { return m_factor; }
  [[nodiscard]] const StaleFactor& factor() const { return m_factor; }

  mutable StepPhases phases;  ///< of the step being solved

 private:
  void respond_to_points();

  DampedBody m_damped;
  StaleFactor m_factor;
  Eigen::MatrixXd m_C;
  Eigen::LLT<Eigen::MatrixXd> m_gram;    // Cᵀ C
  Eigen::MatrixXd m_PC;                  // P⁻¹ C
  Eigen::LDLT<Eigen::MatrixXd> m_schur;  // Cᵀ P⁻¹ C
};

}  // namespace twang::detail
