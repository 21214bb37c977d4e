// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/rig_modes.hpp"

#include "coarsen/detail/mesh_rung.hpp"
#include "coarsen/detail/visible_modes.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang {
namespace {

constexpr int kSpareModes = 4;  // beyond those wanted: some change places, some cannot be seen

}  // namespace

void RigModes::add(std::size_t index, const ModalMeasurement& measurement) {
  m_wanted.push_back({index, measurement.sinusoid.natural_frequency_hz(), measurement.mode});
}

int RigModes::most_modes() const {
  int most = static_cast<int>(m_wanted.size());
  for (const Wanted& wanted : m_wanted) most = std::max(most, wanted.stated.value_or(0) + 1);
  return most + kSpareModes;
}

/// Gives each sinusoid without a stated mode one, both ascending.
std::vector<int> RigModes::assign(const MeshRung& rung) const {
  std::vector<int> numbers;
  std::vector<std::size_t> open;
  std::vector<int> visible = visible_modes(*m_rig, rung);
  for (std::size_t k = 0; k < m_wanted.size(); ++k) {
    numbers.push_back(m_wanted[k].stated.value_or(-1));
    if (m_wanted[k].stated) {
      std::erase(visible, *m_wanted[k].stated);
    } else {
      open.push_back(k);
    }
  }
  std::sort(open.begin(), open.end(), [&](std::size_t a, std::size_t b) {
    return m_wanted[a].frequency_hz < m_wanted[b].frequency_hz;
  });
  if (open.size() > visible.size()) {
    throw InputError(
        fmt::format("rig \"{}\": {} sinusoids are to be modes of the mesh, of the first "
                    "{} only {} can be seen; name the modes",
                    m_rig->name,
                    open.size(),
                    rung.modes.count(),
                    visible.size()));
  }
  for (std::size_t i = 0; i < open.size(); ++i) numbers[open[i]] = visible[i];
  return numbers;
}

std::vector<MeasuredMode> RigModes::compute(const std::map<std::string, double>& moduli,
                                            const ProgressCallback& progress) {
  Rig rig = *m_rig;
  for (RigMaterial& material : rig.materials) {
    const auto modulus = moduli.find(material.name);
    if (!material.youngs_modulus_pa && modulus != moduli.end()) {
      material.youngs_modulus_pa = modulus->second;
    }
  }
  const MeshRung rung = compute_rung(rig, m_dx_m, ElementKind::Hex20, most_modes(), progress);
  const std::vector<ElasticMaterial> materials = elastic_materials(rig, rung.mesh);
  const ElasticBody body =
      linear_body(rung.mesh, materials, weights_at_points(rung.mesh, rig.masses));
  const std::vector<int> numbers = assign(rung);

  std::vector<MeasuredMode> modes;
  for (std::size_t k = 0; k < m_wanted.size(); ++k) {
    if (numbers[k] >= rung.modes.count()) {
      throw InputError(fmt::format("rig \"{}\": mode {} is asked for, the mesh at {} has {}",
                                   m_rig->name,
                                   numbers[k] + 1,
                                   millimetres(m_dx_m),
                                   rung.modes.count()));
    }
    modes.push_back({m_wanted[k].index, numbers[k], rung.modes.lambda_per_s2[numbers[k]], {}});
  }
  for (std::size_t m = 0; m < materials.size(); ++m) {
    const std::string& name = rung.mesh.material_names[m];
    if (m_rig->find_material(name)->youngs_modulus_pa) continue;
    // The energy is linear in each modulus.
    std::vector<ElasticMaterial> doubled = materials;
    doubled[m].youngs_modulus_pa *= 2.0;
    const ElasticBody stiffer = linear_body(rung.mesh, doubled, {});
    for (std::size_t k = 0; k < modes.size(); ++k) {
      const Eigen::VectorXd shape = rung.modes.shapes.col(modes[k].number);
      const double all = body.elastic_energy(shape);
      modes[k].energy_shares[name] = (stiffer.elastic_energy(shape) - all) / all;
    }
  }
  return modes;
}

bool RigModes::refine(long max_dofs) {
  const long before = count_dofs(*m_rig, m_dx_m, ElementKind::Hex20);
  double finer_m = 0.5 * m_dx_m;
  // Cells larger than the part make the same mesh as half of them.
  while (count_dofs(*m_rig, finer_m, ElementKind::Hex20) == before) finer_m *= 0.5;
  if (count_dofs(*m_rig, finer_m, ElementKind::Hex20) > max_dofs) return false;
  m_dx_m = finer_m;
  return true;
}

}  // namespace twang
