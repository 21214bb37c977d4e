// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/measure.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cstdio>
#include <exception>
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

StaticLoad pull_of_release(const Rig& rig, const HexMesh& mesh, double factor) {
  if (!rig.release || !rig.release->displacement)
    throw InputError(rig.file.string() + ": has no [release] with a displacement_mm");
  StaticLoad load;
  load.pulled_point = locate(mesh, rig.release->at);
  load.pull = factor * *rig.release->displacement;
  return load;
}

int exit_code_of(const std::function<int()>& work) {
  try {
    return work();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}

}  // namespace twang::bench
