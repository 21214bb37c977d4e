// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/hex_mesh.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang::detail {

/// How far each node's surroundings have turned.
class NodalRotations {
 public:
  /// Keeps a reference to `mesh`.
  explicit NodalRotations(const HexMesh& mesh);

  /// At displacement `u` (3 num_nodes), an orthogonal matrix for each node: the polar factor of the
  /// mean deformation gradient at the centres of the elements around it; identity where that is
  /// singular.
  [[nodiscard]] std::vector<Eigen::Matrix3d> at(const Eigen::VectorXd& u) const;

 private:
  const HexMesh& m_mesh;
  Eigen::Matrix3Xd m_centre_gradients;                // of the shape functions by xi
  std::vector<Eigen::Matrix3d> m_xi_from_x_gradient;  // d xi / d x at each centre [1/m]
};

/// The orthogonal factor of A = Q S by Newton's iteration X <- (X + X^-T) / 2 [Higham 1986];
/// identity if A is singular or not finite.
[[nodiscard]] Eigen::Matrix3d orthogonal_factor(const Eigen::Matrix3d& A);

}  // namespace twang::detail
