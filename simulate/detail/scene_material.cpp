// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/detail/scene_material.hpp"

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

#include <fmt/format.h>

#include <cmath>

namespace twang::detail {
namespace {

constexpr double kSameCellSize = 1e-6;  // relative: a cell size is typed with few digits [-]

/// E_n makes one mesh move as the real part does, and no other.
void check_mesh(const SceneMaterialFile& file, const HexMesh& mesh) {
  const Material& material = file.material;
  const double dx_mm = mesh.requested_dx_m * kMillimetresPerMetre;
  const bool same = material.numerical_element == to_string(mesh.kind) &&
                    std::abs(material.numerical_dx_mm - dx_mm) <= kSameCellSize * dx_mm &&
                    material.numerical_elements == mesh.num_elements();
  if (same) return;
  throw InputError(fmt::format(
      "{} is {}, whose numerical modulus belongs to a mesh of {} {} elements of {} mm, must be of "
      "this body's, {} {} elements of {} mm (or modulus = \"identified\")",
      file.key,
      file.path.string(),
      material.numerical_elements,
      material.numerical_element,
      rounded_text(material.numerical_dx_mm, 6),
      mesh.num_elements(),
      to_string(mesh.kind),
      rounded_text(dx_mm, 6)));
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
