// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"
#include "simulate/integrators.hpp"
#include "tests/simulate/box_body.hpp"

#include <cmath>
#include <vector>

namespace twang::test {

inline ElasticMaterial rubber(double b = 0.0, double a = 0.0) {
  ElasticMaterial material;
  material.youngs_modulus_pa = 2e6;
  material.poissons_ratio = 0.4;
  material.density_kg_m3 = 1100.0;
  material.damping_stiffness_b_s = b;
  material.damping_mass_a_per_s = a;
  return material;
}

/// A soft block of 30 x 10 x 10 mm, its slowest bending vibration near 200 rad/s.
inline ElasticBody block(const ElasticMaterial& material,
                         ConstitutiveModel model = ConstitutiveModel::NeoHookean,
                         const Eigen::Vector3i& cells = {4, 2, 2}) {
  return {box_mesh(ElementKind::Hex8, cells, {0.03, 0.01, 0.01}), {material}, model};
}

/// A smooth velocity field that bends, stretches and twists, 0 at x = 0 [m/s].
inline Eigen::VectorXd smooth_field(const HexMesh& mesh, double size) {
  Eigen::VectorXd field(mesh.num_dofs());
  for (int i = 0; i < mesh.num_nodes(); ++i) {
    const double s = mesh.nodes(0, i) / 0.03;
    const double y = mesh.nodes(1, i) / 0.01 - 0.5;
    const double z = mesh.nodes(2, i) / 0.01 - 0.5;
    field.segment<3>(3 * i) =
        size * Eigen::Vector3d(0.2 * s, 0.3 * s * s - 0.2 * s * z, s * s + 0.2 * s * y);
  }
  return field;
}

inline BodyState moving(const HexMesh& mesh, double speed) {
  return {Eigen::VectorXd::Zero(mesh.num_dofs()), smooth_field(mesh, speed), 0.0};
}

/// Slope of log(error) over log(step) by least squares.
inline double fitted_order(const std::vector<double>& steps, const std::vector<double>& errors) {
  const auto n = static_cast<double>(steps.size());
  double sx = 0.0;
  double sy = 0.0;
  double sxx = 0.0;
  double sxy = 0.0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double x = std::log(steps[i]);
    const double y = std::log(errors[i]);
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

}  // namespace twang::test
