// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace twang {

/// What bodies have at an instant, in the world's frame; sums over bodies add up.
struct MechanicalState {
  double kinetic_j = 0.0;                             ///< [J]
  double elastic_j = 0.0;                             ///< [J]
  double gravity_j = 0.0;                             ///< - m g . centre of mass [J]
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< sum m v [kg m/s]
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< sum m x × v about the origin [kg m²/s]

  [[nodiscard]] double total_j() const { return kinetic_j + elastic_j + gravity_j; }
  MechanicalState& operator+=(const MechanicalState& other);
};

/// Works done, each since t = 0 [J].
struct LedgerWork {
  double external_j = 0.0;  ///< by loads and moving bases, gravity left out
  double damping_j = 0.0;   ///< taken out
  double friction_j = 0.0;  ///< taken out
  double impact_j = 0.0;    ///< taken out
};

/// Keeps account of the energy: what went in, what was taken out, and what is left over,
///
///     remainder = external - damping - friction - impact - change of (kinetic + elastic + gravity)
///
/// For the trapezoidal rule and a linear body the remainder is round-off and the tolerance of
/// Newton's iteration; otherwise it is what the rule itself makes or loses.
class EnergyLedger {
 public:
  EnergyLedger() = default;
  /// @param start  at t = 0
  explicit EnergyLedger(const MechanicalState& start) : m_start_j(start.total_j()) {}
  /// Goes on from works done before.
  EnergyLedger(double start_j, const LedgerWork& work) : m_start_j(start_j), m_work(work) {}

  void add(const LedgerWork& of_step);
  [[nodiscard]] const LedgerWork& work() const { return m_work; }
  [[nodiscard]] double start_j() const { return m_start_j; }
  [[nodiscard]] double remainder_j(const MechanicalState& now) const;

 private:
  double m_start_j = 0.0;
  LedgerWork m_work;
};

}  // namespace twang
