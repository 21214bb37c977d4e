// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/measure.hpp"

#include <algorithm>
#include <fstream>

namespace twang::bench {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void reset_peak() { std::ofstream("/proc/self/clear_refs") << "5\n"; }

double peak_bytes() {
  std::ifstream file("/proc/self/status");
  std::string line;
  while (std::getline(file, line)) {
    if (line.rfind("VmHWM:", 0) == 0) return 1024.0 * std::stod(line.substr(6));
  }
  return 0.0;
}

std::vector<ElasticMaterial> materials_of(const Rig& rig,
                                          const HexMesh& mesh,
                                          double youngs_modulus_pa,
                                          double damping_stiffness_b_s) {
  std::vector<ElasticMaterial> materials;
  for (const std::string& name : mesh.material_names) {
    const auto at = std::find_if(
        rig.materials.begin(), rig.materials.end(), [&](const auto& m) { return m.name == name; });
    ElasticMaterial material;
    material.youngs_modulus_pa = at->youngs_modulus_pa.value_or(youngs_modulus_pa);
    material.poissons_ratio = at->poissons_ratio;
    material.density_kg_m3 = at->density_kg_m3;
    material.damping_stiffness_b_s = damping_stiffness_b_s;
    materials.push_back(material);
  }
  return materials;
}

}  // namespace twang::bench
