// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "fem/static_solve.hpp"

#include <Eigen/QR>
#include <fmt/format.h>

namespace twang {

void check_pulls(const Eigen::MatrixXd& C) {
  for (Eigen::Index i = 0; i < C.cols(); ++i) {
    if (!(C.col(i).norm() > 0.0))
      throw InputError(
          fmt::format("pulled point {} lies among held nodes, must be free to move", i + 1));
    if (i == 0) continue;
    // Least squares by the columns before: what is left is this pull's own.
    const Eigen::MatrixXd before = C.leftCols(i);
    const Eigen::VectorXd rest = C.col(i) - before * before.colPivHouseholderQr().solve(C.col(i));
    constexpr double kOwnPart = 1e-6;
    if (!(rest.norm() > kOwnPart * C.col(i).norm()))
      throw InputError(fmt::format(
          "pulled point {} is held along its direction already by those before it, must be free to "
          "move",
          i + 1));
  }
}

Eigen::VectorXd nodal_force(const HexMesh& mesh,
                            const MeshPoint& point,
                            const Eigen::Vector3d& force_n) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(mesh.num_dofs());
  for (std::size_t i = 0; i < point.nodes.size(); ++i)
    force.segment<3>(3 * point.nodes[i]) += point.weights[static_cast<Eigen::Index>(i)] * force_n;
  return force;
}

}  // namespace twang
