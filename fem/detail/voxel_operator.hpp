// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/detail/voxel_body.hpp"
#include "fem/stiffness_solver.hpp"

#include <Eigen/Core>

namespace twang {

/// A x in double precision, matrix-free, on vectors of a VoxelBody: its own cells undeformed, the
/// body's element kernels at any other displacement.
class VoxelOperator {
 public:
  /// Keeps references to all but `of`.
  VoxelOperator(const ElasticBody& body,
                const VoxelBody& voxels,
                const StiffnessCombination& of,
                const Eigen::VectorXd& u);
  [[nodiscard]] Eigen::VectorXd operator()(const Eigen::VectorXd& x) const;

 private:
  const ElasticBody& m_body;
  const VoxelBody& m_voxels;
  StiffnessCombination m_of;
  Eigen::VectorXd m_u;  ///< empty: undeformed
  CellModuli<double> m_moduli;
};

}  // namespace twang
