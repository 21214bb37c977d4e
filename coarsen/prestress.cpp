// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/prestress.hpp"

#include "coarsen/fit_material.hpp"
#include "core/error.hpp"
#include "fem/attach_weights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

ElasticBody body_of(const Rig& rig, const MeshRung& rung, const ElasticMaterial& material) {
  if (rung.mesh.material_names.size() != 1) {
    throw InputError(
        fmt::format("{}: the part has {} materials, must have one for gravity to be computed",
                    rig.file.string(),
                    rung.mesh.material_names.size()));
  }
  ElasticBody body(rung.mesh, {material});
  attach_weights(body, rig.masses);
  return body;
}

StaticResult sag_of(const Rig& rig, const MeshRung& rung, const ElasticBody& body) {
  StaticLoad load;
  if (rig.gravity_m_s2) load.force = body.gravity_force(*rig.gravity_m_s2);
  return solve_static(body, rung.held_nodes, load);
}

}  // namespace

StaticResult sag_under_gravity(const Rig& rig,
                               const MeshRung& rung,
                               const ElasticMaterial& material) {
  return sag_of(rig, rung, body_of(rig, rung, material));
}

double prestress_factor(const Rig& rig,
                        const MeshRung& rung,
                        const ElasticMaterial& material,
                        int mode) {
  if (!rig.gravity_m_s2) return 1.0;
  const ElasticBody body = body_of(rig, rung, material);
  const StaticResult sag = sag_of(rig, rung, body);
  if (!sag.usable()) {
    throw NumericalFailure(
        fmt::format("the part does not carry its own weight at E = {:.4g} Pa: {}",
                    material.youngs_modulus_pa,
                    sag.message));
  }
  EigenmodeOptions options;
  constexpr int kSpareModes = 2;  // a sag that turns the part may let modes change places
  options.count = mode == 0 ? 1 : std::min(mode + 1 + kSpareModes, rung.modes.count());
  const Eigenmodes modes = compute_eigenmodes(body, rung.held_nodes, options, sag.u);
  if (!modes.usable()) {
    throw NumericalFailure(
        fmt::format("the modes about the sagging state at E = {:.4g} Pa are not to be had: {}",
                    material.youngs_modulus_pa,
                    modes.message));
  }
  if (modes.num_unstable > 0) {
    throw NumericalFailure(fmt::format("the part buckles under its own weight at E = {:.4g} Pa",
                                       material.youngs_modulus_pa));
  }
  Eigen::Index same = 0;
  if (mode > 0) {
    (modes.shapes.transpose() * (body.mass() * rung.modes.shapes.col(mode)))
        .cwiseAbs()
        .maxCoeff(&same);
  }
  return modes.lambda_per_s2[same] / (material.youngs_modulus_pa * rung.modes.lambda_per_s2[mode]);
}

double modulus_for_target(const Rig& rig,
                          const MeshRung& rung,
                          ElasticMaterial material,
                          double unit_lambda_per_s2,
                          double target_lambda_per_s2,
                          int mode) {
  double modulus = rescaled_modulus(1.0, target_lambda_per_s2, unit_lambda_per_s2);
  if (!rig.gravity_m_s2) return modulus;
  constexpr int kMostIterations = 30;
  constexpr double kSettled = 1e-5;  // relative, a hundredth of what a film resolves
  for (int i = 0; i < kMostIterations; ++i) {
    material.youngs_modulus_pa = modulus;
    const double next =
        target_lambda_per_s2 / (unit_lambda_per_s2 * prestress_factor(rig, rung, material, mode));
    const double change = std::abs(next / modulus - 1.0);
    modulus = next;
    if (change < kSettled) return modulus;
  }
  throw NumericalFailure(
      "Young's modulus under gravity does not settle: the part sags too much to be identified");
}

}  // namespace twang
