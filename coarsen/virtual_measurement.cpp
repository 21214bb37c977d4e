// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/virtual_measurement.hpp"

#include "coarsen/fit_material.hpp"
#include "coarsen/prestress.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "core/version.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <string>

namespace twang {
namespace {

/// Takes the round-off out of a cell size that was found as a difference of coordinates [m].
double rounded_to_picometres(double length_m) { return std::round(length_m * 1e12) / 1e12; }

std::string name_of(const Rig& rig) {
  return rig.file.empty() ? fmt::format("rig \"{}\"", rig.name) : rig.file.string();
}

double stated_modulus(const Rig& rig, const RigMaterial& material) {
  if (material.youngs_modulus_pa) return *material.youngs_modulus_pa;
  throw InputError(
      fmt::format("{}: materials.{} states no youngs_modulus_pa, must have one for a virtual "
                  "measurement; without it only a film tells the modulus",
                  name_of(rig),
                  material.name));
}

/// lambda of the first mode that the part shows, and E_n over E.
struct VirtualTarget {
  double lambda_per_s2 = 0.0;
  double numerical_over_identified = 1.0;
};

VirtualTarget target_of(const Rig& rig, const MeshLadder& ladder, const RigMaterial& first) {
  if (ladder.stated_moduli) {
    if (rig.gravity_m_s2) {
      throw InputError(
          fmt::format("{}: environment.gravity_m_s2 is given and the part has {} materials, must "
                      "have one for gravity to be computed",
                      name_of(rig),
                      ladder.coarse.mesh.material_names.size()));
    }
    return {ladder.limit.lambda_per_s2, 1.0 / ladder.identified_over_numerical()};
  }
  const double modulus = stated_modulus(rig, first);
  const ElasticMaterial elastic = {modulus, first.poissons_ratio, first.density_kg_m3};
  VirtualTarget target;
  target.lambda_per_s2 = modulus * ladder.limit.lambda_per_s2 *
                         prestress_factor(rig, ladder.reference.front(), elastic);
  target.numerical_over_identified =
      modulus_for_target(
          rig, ladder.coarse, elastic, ladder.coarse.modes.lambda_per_s2(0), target.lambda_per_s2) /
      modulus;
  return target;
}

Provenance provenance_of(const Rig& rig, const MeshLadder& ladder, double b_s) {
  Provenance provenance;
  provenance.twang_version = kVersion;
  provenance.date = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  provenance.inputs.push_back({rig.file.filename().string(), rig.sha256});
  const HexMesh& finest = ladder.reference.back().mesh;
  provenance.options["measurement"] = "virtual";
  provenance.options["reference"] =
      fmt::format("{} at {} mm",
                  to_string(finest.kind),
                  rounded_to_picometres(finest.requested_dx_m) * kMillimetresPerMetre);
  provenance.options["damping_stiffness_b_s"] = fmt::format("{}", b_s);
  return provenance;
}

}  // namespace

std::vector<Material> measure_virtually(const Rig& rig,
                                        const MeshLadder& ladder,
                                        double damping_stiffness_b_s) {
  if (!(damping_stiffness_b_s >= 0.0 && std::isfinite(damping_stiffness_b_s))) {
    throw InputError(fmt::format("b is {} s, must be >= 0", damping_stiffness_b_s));
  }
  const HexMesh& mesh = ladder.coarse.mesh;
  std::vector<const RigMaterial*> of_part;
  for (const std::string& name : mesh.material_names) {
    of_part.push_back(rig.find_material(name));
    (void)stated_modulus(rig, *of_part.back());
  }
  const VirtualTarget target = target_of(rig, ladder, *of_part.front());
  const FrequencyAndDecay first =
      frequency_and_decay(target.lambda_per_s2, 0.0, damping_stiffness_b_s);
  std::vector<Material> materials;
  for (const RigMaterial* stated : of_part) {
    Material material;
    material.material = stated->name;
    material.youngs_modulus_identified_pa = *stated->youngs_modulus_pa;
    material.youngs_modulus_numerical_pa =
        *stated->youngs_modulus_pa * target.numerical_over_identified;
    material.numerical_element = to_string(mesh.kind);
    material.numerical_dx_mm = rounded_to_picometres(mesh.requested_dx_m) * kMillimetresPerMetre;
    material.numerical_elements = mesh.num_elements();
    material.rig_sha256 = rig.sha256;
    material.damping_stiffness_b_s = damping_stiffness_b_s;
    material.poissons_ratio = stated->poissons_ratio;
    material.density_kg_m3 = stated->density_kg_m3;
    material.reported_youngs_modulus_pa = stated->reported_youngs_modulus_pa;
    material.frequency_hz = first.frequency_hz;
    material.decay_per_s = first.decay_per_s;
    material.lambda_per_s2 = target.lambda_per_s2;
    material.tan_delta = damping_stiffness_b_s * std::sqrt(target.lambda_per_s2);
    material.uncertainty.mesh = ladder.limit.relative_sigma;
    material.youngs_modulus_identified_sigma_pa =
        material.youngs_modulus_identified_pa * material.uncertainty.total();
    material.specimen = rig.specimen;
    material.provenance = provenance_of(rig, ladder, damping_stiffness_b_s);
    materials.push_back(std::move(material));
  }
  return materials;
}

}  // namespace twang
