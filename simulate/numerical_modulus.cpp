// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/numerical_modulus.hpp"

#include "core/units.hpp"

#include <fmt/format.h>

#include <cmath>

namespace twang {
namespace {

constexpr double kSameCellSize = 1e-6;  // relative: a cell size is typed with few digits [-]

}  // namespace

std::string numerical_modulus_fault(const Material& material, const HexMesh& mesh) {
  const double dx_mm = mesh.requested_dx_m * kMillimetresPerMetre;
  const bool same = material.numerical_element == to_string(mesh.kind) &&
                    std::abs(material.numerical_dx_mm - dx_mm) <= kSameCellSize * dx_mm &&
                    material.numerical_elements == mesh.num_elements();
  if (same) return {};
  return fmt::format(
      "belongs to a mesh of {} {} elements of {:.6g} mm, must be of this one, {} {} elements of "
      "{:.6g} mm",
      material.numerical_elements,
      material.numerical_element,
      material.numerical_dx_mm,
      mesh.num_elements(),
      to_string(mesh.kind),
      dx_mm);
}

}  // namespace twang
