// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/detail/nodal_rotations.hpp"

#include "fem/hexahedron.hpp"
#include "fem/threads.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace twang::detail {
namespace {

constexpr int kMaxIterations = 20;
constexpr double kOrthogonal = 1e-12;  // last change at which the factor counts as reached [-]

/// sum_a field[nodes[a]] ⊗ gradients[a] of an element.
template <typename Field>
Eigen::Matrix3d gradient(const HexMesh& mesh,
                         int element,
                         const Eigen::Matrix3Xd& gradients,
                         const Field& field) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int a = 0; a < gradients.cols(); ++a)
    sum += field(mesh.elements(a, element)) * gradients.col(a).transpose();
  return sum;
}

}  // namespace

Eigen::Matrix3d orthogonal_factor(const Eigen::Matrix3d& A) {
  Eigen::Matrix3d X = A;
  for (int i = 0; i < kMaxIterations; ++i) {
    Eigen::Matrix3d inverse;
    bool invertible = false;
    X.computeInverseWithCheck(inverse, invertible, 0.0);
    if (!invertible || !inverse.allFinite()) break;
    const Eigen::Matrix3d change = 0.5 * (inverse.transpose() - X);
    X += change;
    if (change.squaredNorm() < kOrthogonal * kOrthogonal) return X;
  }
  return Eigen::Matrix3d::Identity();
}

NodalRotations::NodalRotations(const HexMesh& mesh)
    : m_mesh(mesh),
      m_centre_gradients(shape_gradients(mesh.kind, Eigen::Vector3d::Zero())),
      m_xi_from_x_gradient(static_cast<std::size_t>(mesh.num_elements())) {
  const auto position = [&](int node) -> Eigen::Vector3d { return mesh.nodes.col(node); };
  for (int e = 0; e < mesh.num_elements(); ++e)
    m_xi_from_x_gradient[static_cast<std::size_t>(e)] =
        gradient(mesh, e, m_centre_gradients, position).inverse();
}

std::vector<Eigen::Matrix3d> NodalRotations::at(const Eigen::VectorXd& u) const {
  std::vector<Eigen::Matrix3d> rotations(static_cast<std::size_t>(m_mesh.num_nodes()),
                                         Eigen::Matrix3d::Zero());
  const auto displacement = [&](int node) -> Eigen::Vector3d { return u.segment<3>(3 * node); };
  for (int e = 0; e < m_mesh.num_elements(); ++e) {
    const Eigen::Matrix3d F =
        Eigen::Matrix3d::Identity() + gradient(m_mesh, e, m_centre_gradients, displacement) *
                                          m_xi_from_x_gradient[static_cast<std::size_t>(e)];
    for (int a = 0; a < m_mesh.elements.rows(); ++a)
      rotations[static_cast<std::size_t>(m_mesh.elements(a, e))] += F;
  }
  for_each_range(m_mesh.num_nodes(), [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      Eigen::Matrix3d& rotation = rotations[static_cast<std::size_t>(i)];
      // The sum over the elements counts as a mean: a positive factor leaves the rotation alone.
      rotation = orthogonal_factor(rotation / std::max(1e-300, rotation.norm() / std::sqrt(3.0)));
    }
  });
  return rotations;
}

}  // namespace twang::detail
