// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/mesh_rung.hpp"
#include "coarsen/detail/offset_faces.hpp"
#include "coarsen/fit_material.hpp"
#include "fem/hex_edges.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace twang {
namespace {

// Differences are of order two: with this step their error is a millionth, while round-off stays
// below a billionth.
constexpr double kRelativeStep = 1e-3;

/// Stiffness and mass that a mode shape sees on a body.
struct ModalPair {
  double stiffness = 0.0;
  double mass = 0.0;
  [[nodiscard]] double lambda_per_s2() const { return stiffness / mass; }
};

ModalPair modal_pair(const ElasticBody& body, const Eigen::VectorXd& phi) {
  return {2.0 * body.elastic_energy(phi), phi.dot(body.mass() * phi)};
}

/// The shortest edge between two corners [m].
double smallest_cell_m(const HexMesh& mesh) {
  double shortest = std::numeric_limits<double>::infinity();
  for (Eigen::Index e = 0; e < mesh.elements.cols(); ++e) {
    for (const auto& [a, b] : kHexEdges) {
      shortest = std::min(
          shortest,
          (mesh.nodes.col(mesh.elements(a, e)) - mesh.nodes.col(mesh.elements(b, e))).norm());
    }
  }
  return shortest;
}

/// d ln g / dx from the values at x - step and x + step.
double logarithmic_slope(double below, double above, double step) {
  return std::log(above / below) / (2.0 * step);
}

}  // namespace

ModulusSensitivities modulus_sensitivities(const Rig& rig, double dx_m, int mode) {
  std::vector<std::string> notes;
  const Rig identified = rig_to_identify(rig, notes);
  return modulus_sensitivities(
      identified, compute_rung(identified, dx_m, ElementKind::Hex20, mode + 1, {}), mode);
}

ModulusSensitivities modulus_sensitivities(const Rig& rig, const MeshRung& rung, int mode) {
  assert(mode < rung.modes.count());
  const Eigen::VectorXd phi = rung.modes.shapes.col(mode);
  const std::vector<ElasticMaterial> materials = elastic_materials(rig, rung.mesh);
  const std::vector<WeightAtPoint> weights = weights_at_points(rung.mesh, rig.masses);

  const Eigen::Matrix3Xd growth = outward_growth(rung.mesh);
  const auto lambda_when_grown_by = [&](double length_m) {
    HexMesh grown = rung.mesh;
    grown.nodes += length_m * growth;
    return modal_pair(linear_body(grown, materials, weights), phi).lambda_per_s2();
  };
  const auto lambda_with_poissons_ratio_plus = [&](double change) {
    std::vector<ElasticMaterial> changed = materials;
    for (ElasticMaterial& material : changed) material.poissons_ratio += change;
    return modal_pair(linear_body(rung.mesh, changed, weights), phi).lambda_per_s2();
  };

  ModulusSensitivities result;
  const double length_step = kRelativeStep * smallest_cell_m(rung.mesh);
  result.dimension_per_m = -logarithmic_slope(
      lambda_when_grown_by(-length_step), lambda_when_grown_by(length_step), length_step);

  // Near 0.5 the bulk modulus goes with 1 / (1 - 2 nu): the step keeps clear of it, and of -1.
  double room = 1.0;
  for (const ElasticMaterial& material : materials) {
    room = std::min({room, 0.5 - material.poissons_ratio, 1.0 + material.poissons_ratio});
  }
  const double ratio_step = kRelativeStep * room;
  result.poissons_ratio = -logarithmic_slope(lambda_with_poissons_ratio_plus(-ratio_step),
                                             lambda_with_poissons_ratio_plus(ratio_step),
                                             ratio_step);

  if (!weights.empty()) {
    // lambda = k / (rho m + m_weights): its slope by ln rho is the part's share of the modal mass.
    const double part = modal_pair(linear_body(rung.mesh, materials, {}), phi).mass;
    result.density = part / modal_pair(linear_body(rung.mesh, materials, weights), phi).mass;
  }
  return result;
}

}  // namespace twang
