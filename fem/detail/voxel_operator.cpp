// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/voxel_operator.hpp"

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

}  // namespace twang
