// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/units.hpp"
#include "fem/elastic_body.hpp"
#include "rigs/rig.hpp"

#include <string>
#include <utility>
#include <vector>

namespace twang::test {

inline Box box_mm(const Eigen::Vector3d& min, const Eigen::Vector3d& max) {
  return {min * kMetresPerMillimetre, max * kMetresPerMillimetre};
}

/// A rig of one material "part" from boxes in millimetres.
inline Rig make_rig(const std::vector<Box>& solids, const std::vector<Box>& clamps = {}) {
  Rig rig;
  rig.name = "test rig";
  RigMaterial material;
  material.name = "part";
  material.density_kg_m3 = 1180.0;
  material.poissons_ratio = 0.45;
  rig.materials.push_back(material);
  for (const Box& solid : solids) rig.parts.push_back({"part", solid});
  rig.clamps = clamps;
  return rig;
}

/// 100 x 10 x 2 mm, clamped at x = 0.
inline Rig beam_rig() {
  return make_rig({box_mm({0, 0, 0}, {100, 10, 2})}, {box_mm({0, 0, 0}, {0, 10, 2})});
}

/// Clamped plate, a leg 1.5 mm thick, and an arm on it; 24 mm deep.
inline Rig l_rig() {
  return make_rig({box_mm({0, 0, 0}, {60, 24, 3}),
                   box_mm({45, 0, 3}, {46.5, 24, 19.5}),
                   box_mm({7.5, 0, 19.5}, {46.5, 24, 27})},
                  {box_mm({0, 0, 0}, {60, 24, 0})});
}

inline ElasticMaterial elastic(double E, double nu, double rho) {
  ElasticMaterial material;
  material.youngs_modulus_pa = E;
  material.poissons_ratio = nu;
  material.density_kg_m3 = rho;
  return material;
}

}  // namespace twang::test
