// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/first_lambda.hpp"

#include "core/constants.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace twang {

double estimate_first_lambda(const ElasticBody& body) {
  const HexMesh& mesh = body.mesh();
  double wave_speed2 = kInfinity;
  for (const ElasticMaterial& material : body.materials()) {
    wave_speed2 = std::min(wave_speed2, material.youngs_modulus_pa / material.density_kg_m3);
  }
  double area = 0.0;
  for (const auto& face : surface_faces(mesh)) {
    const Eigen::Vector3d diagonal = mesh.nodes.col(face[2]) - mesh.nodes.col(face[0]);
    const Eigen::Vector3d other = mesh.nodes.col(face[3]) - mesh.nodes.col(face[1]);
    area += 0.5 * diagonal.cross(other).norm();
  }
  const double thickness = 2.0 * mesh.volume() / area;
  const double length = (mesh.nodes.rowwise().maxCoeff() - mesh.nodes.rowwise().minCoeff()).norm();
  const double beta_l = 4.730041;
  return std::pow(beta_l, 4) / 12.0 * wave_speed2 * std::pow(thickness, 2) / std::pow(length, 4);
}

}  // namespace twang
