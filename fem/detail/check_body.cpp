// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/check_body.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>

namespace twang {

void check_materials(const HexMesh& mesh, const std::vector<ElasticMaterial>& materials) {
  if (materials.size() != mesh.material_names.size()) {
    throw InputError(fmt::format(
        "{} materials are given for a mesh with {}", materials.size(), mesh.material_names.size()));
  }
  for (std::size_t m = 0; m < materials.size(); ++m) {
    const auto require = [&](bool good, const char* key, double value, const char* bounds) {
      if (good) return;
      throw InputError(fmt::format(
          "material \"{}\": {} is {}, must be {}", mesh.material_names[m], key, value, bounds));
    };
    const ElasticMaterial& at = materials[m];
    const auto positive = [](double value) { return value > 0.0 && std::isfinite(value); };
    const auto not_negative = [](double value) { return value >= 0.0 && std::isfinite(value); };
    require(positive(at.youngs_modulus_pa), "youngs_modulus_pa", at.youngs_modulus_pa, "> 0");
    require(at.poissons_ratio > -1.0 && at.poissons_ratio < 0.5,
            "poissons_ratio",
            at.poissons_ratio,
            "> -1 and < 0.5");
    require(positive(at.density_kg_m3), "density_kg_m3", at.density_kg_m3, "> 0");
    require(not_negative(at.damping_stiffness_b_s),
            "damping_stiffness_b_s",
            at.damping_stiffness_b_s,
            ">= 0");
    require(not_negative(at.damping_mass_a_per_s),
            "damping_mass_a_per_s",
            at.damping_mass_a_per_s,
            ">= 0");
  }
  if (mesh.material_of_element.size() != static_cast<std::size_t>(mesh.num_elements())) {
    throw InputError(fmt::format("the mesh names the material of {} elements, must be {}",
                                 mesh.material_of_element.size(),
                                 mesh.num_elements()));
  }
  for (const int material : mesh.material_of_element) {
    if (material >= 0 && static_cast<std::size_t>(material) < materials.size()) continue;
    throw InputError(fmt::format("an element's material is number {}, must be in 0..{}",
                                 material,
                                 static_cast<int>(materials.size()) - 1));
  }
}

void check_fill(const HexMesh& mesh) {
  for (const Eigen::VectorXd* fill : {&mesh.mass_fill, &mesh.stiffness_fill}) {
    if (fill->size() == 0) continue;
    if (fill->size() == mesh.num_elements() && (fill->array() > 0.0).all()) continue;
    throw InputError("the mesh says how full its elements are, but not of each, or not > 0");
  }
}

}  // namespace twang
