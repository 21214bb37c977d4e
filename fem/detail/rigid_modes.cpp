// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/rigid_modes.hpp"

#include "core/dense_algebra.hpp"

#include <Eigen/Geometry>

namespace twang {
namespace {

/// A motion that moves what is held less than this, relative to the body's size, leaves them at
/// rest; above the round-off of positions, far below a cell.
constexpr double kAtRest = 1e-9;

using Matrix3x6 = Eigen::Matrix<double, 3, 6>;

/// Displacements at `x` of unit translations and rotations; `x` in units of the body's size, from
/// its middle.
Matrix3x6 motions_at(const Eigen::Vector3d& x) {
  Matrix3x6 result;
  result.leftCols<3>().setIdentity();
  for (int axis = 0; axis < 3; ++axis) {
    result.col(3 + axis) = Eigen::Vector3d::Unit(axis).cross(x);
  }
  return result;
}

}  // namespace

Eigen::MatrixXd rigid_motions(const HexMesh& mesh, const FreeDofs& free, const Eigen::VectorXd& u) {
  Eigen::Matrix3Xd x = mesh.nodes;
  if (u.size() > 0) x += u.reshaped(3, mesh.num_nodes());
  const Eigen::Vector3d low = x.rowwise().minCoeff();
  const Eigen::Vector3d high = x.rowwise().maxCoeff();
  x.colwise() -= Eigen::Vector3d(0.5 * (low + high));
  x /= 0.5 * (high - low).norm();

  Eigen::Matrix<double, 6, 6> gram = Eigen::Matrix<double, 6, 6>::Zero();
  const std::vector<int> held = free.held_dofs();
  for (const int dof : held) {
    const Eigen::Matrix<double, 1, 6> motion = motions_at(x.col(dof / 3)).row(dof % 3);
    gram += motion.transpose() * motion;
  }
  Eigen::MatrixXd combinations = Eigen::MatrixXd::Identity(6, 6);
  if (!held.empty()) {
    const SymmetricEigen eigen = symmetric_eigen(gram);
    // A cell far smaller than 1 / sqrt(kAtRest) of the body may not be mistaken for a point.
    const auto rank = (eigen.values.array() > kAtRest).count();
    combinations = eigen.vectors.leftCols(6 - rank);
  }
  Eigen::MatrixXd result(mesh.num_dofs(), combinations.cols());
  for (int n = 0; n < mesh.num_nodes(); ++n) {
    result.middleRows<3>(3 * n) = motions_at(x.col(n)) * combinations;
  }
  return result;
}

}  // namespace twang
