// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/energy_ledger.hpp"

namespace twang {

MechanicalState& MechanicalState::operator+=(const MechanicalState& other) {
  kinetic_j += other.kinetic_j;
  elastic_j += other.elastic_j;
  gravity_j += other.gravity_j;
  linear += other.linear;
  angular += other.angular;
  return *this;
}

void EnergyLedger::add(const LedgerWork& of_step) {
  m_work.external_j += of_step.external_j;
  m_work.damping_j += of_step.damping_j;
  m_work.friction_j += of_step.friction_j;
  m_work.impact_j += of_step.impact_j;
}

double EnergyLedger::remainder_j(const MechanicalState& now) const {
  return m_work.external_j - m_work.damping_j - m_work.friction_j - m_work.impact_j -
         (now.total_j() - m_start_j);
}

}  // namespace twang
