// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/detail/cell_stress.hpp"

#include "fem/constitutive.hpp"
#include "fem/hexahedron.hpp"

#include <Eigen/LU>

#include <cmath>

namespace twang::detail {

Eigen::MatrixXd cell_stress(const ElasticBody& body,
                            const Eigen::VectorXd& u,
                            const Eigen::Matrix3d& rotation) {
  const HexMesh& mesh = body.mesh();
  const Eigen::Matrix3Xd by_xi = shape_gradients(mesh.kind, Eigen::Vector3d::Zero());
  Eigen::MatrixXd stress(6, mesh.num_elements());
  for (int e = 0; e < mesh.num_elements(); ++e) {
    Eigen::Matrix3d x_by_xi = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d u_by_xi = Eigen::Matrix3d::Zero();
    for (int a = 0; a < mesh.elements.rows(); ++a) {
      const int node = mesh.elements(a, e);
      x_by_xi += mesh.nodes.col(node) * by_xi.col(a).transpose();
      u_by_xi += u.segment<3>(3 * node) * by_xi.col(a).transpose();
    }
    const Eigen::Matrix3d F = Eigen::Matrix3d::Identity() + u_by_xi * x_by_xi.inverse();
    const ElasticMaterial& material = body.materials()[static_cast<std::size_t>(
        mesh.material_of_element[static_cast<std::size_t>(e)])];
    const LameConstants lame = lame_constants(material.youngs_modulus_pa, material.poissons_ratio);
    Eigen::Matrix3d sigma = piola_stress(body.model(), lame, F);
    if (body.model() != ConstitutiveModel::Linear) sigma = sigma * F.transpose() / F.determinant();
    sigma = rotation * sigma * rotation.transpose();
    stress.col(e) << sigma(0, 0), sigma(1, 1), sigma(2, 2), sigma(0, 1), sigma(1, 2), sigma(0, 2);
  }
  return stress;
}

Eigen::VectorXd von_mises(const Eigen::MatrixXd& stress) {
  Eigen::VectorXd result(stress.cols());
  for (Eigen::Index e = 0; e < stress.cols(); ++e) {
    const auto s = stress.col(e);
    const double normal =
        std::pow(s[0] - s[1], 2) + std::pow(s[1] - s[2], 2) + std::pow(s[2] - s[0], 2);
    const double shear = s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
    result[e] = std::sqrt(0.5 * normal + 3.0 * shear);
  }
  return result;
}

}  // namespace twang::detail
