// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/detail/scene_material.hpp"

#include "core/error.hpp"
#include "simulate/numerical_modulus.hpp"

#include <fmt/format.h>

namespace twang::detail {
namespace {

/// E_n makes one mesh move as the real part does, and no other.
void check_mesh(const SceneMaterialFile& file, const HexMesh& mesh) {
  const std::string fault = numerical_modulus_fault(file.material, mesh);
  if (fault.empty()) return;
  throw InputError(fmt::format("{} is {}, whose numerical modulus {} (or modulus = \"identified\")",
                               file.key,
                               file.path.string(),
                               fault));
}

ElasticMaterial material_from_file(const SceneMaterialFile& file, const HexMesh& mesh) {
  if (!file.identified) check_mesh(file, mesh);
  const Material& found = file.material;
  const double modulus =
      file.identified ? found.youngs_modulus_identified_pa : found.youngs_modulus_numerical_pa;
  const double b = found.damping_stiffness_b_s;
  if (!(modulus > 0.0) || !(b >= 0.0))
    throw InputError(fmt::format("{} is {}, which lacks the {} modulus or damping_stiffness_b_s",
                                 file.key,
                                 file.path.string(),
                                 file.identified ? "identified" : "numerical"));
  return {modulus, found.poissons_ratio, found.density_kg_m3, b, found.damping_mass_a_per_s};
}

}  // namespace

std::vector<ElasticMaterial> scene_materials(const SceneBody& body, const HexMesh& mesh) {
  std::vector<ElasticMaterial> materials;
  for (const std::string& name : mesh.material_names)
    materials.push_back(body.material_file ? material_from_file(*body.material_file, mesh)
                                           : body.materials.at(name));
  return materials;
}

}  // namespace twang::detail
