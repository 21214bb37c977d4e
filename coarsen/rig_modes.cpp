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
  m_wanted.push_back(
      {index, measurement.sinusoid.natural_frequency_hz(), measurement.mode.value_or(-1), {}});
}

int RigModes::most_modes() const {
  int most = static_cast<int>(m_wanted.size());
  for (const Wanted& wanted : m_wanted) most = std::max(most, wanted.number + 1);
  return most + kSpareModes;
}

/// Gives each sinusoid without a mode one, both ascending.
void RigModes::assign(const MeshRung& rung) {
  std::vector<Wanted*> open;
  std::vector<int> visible = visible_modes(*m_rig, rung);
  for (Wanted& wanted : m_wanted) {
    if (wanted.number < 0) {
      open.push_back(&wanted);
    } else {
      std::erase(visible, wanted.number);
    }
  }
  std::sort(open.begin(), open.end(), [](const Wanted* a, const Wanted* b) {
    return a->frequency_hz < b->frequency_hz;
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
  for (std::size_t i = 0; i < open.size(); ++i) open[i]->number = visible[i];
}

/// The modes that look like those of the last iteration.
void RigModes::follow(const MeshRung& rung, const ElasticBody& body) {
  for (Wanted& wanted : m_wanted) {
    if (wanted.shape.size() > 0) {
      const Eigen::VectorXd moved = body.mass() * wanted.shape;
      (rung.modes.shapes.transpose() * moved).cwiseAbs().maxCoeff(&wanted.number);
    }
    wanted.shape = rung.modes.shapes.col(wanted.number);
  }
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
  const ElasticBody body = linear_body(rig, rung.mesh, materials, mass_points(rig, rung.mesh));
  assign(rung);
  follow(rung, body);

  std::vector<MeasuredMode> modes;
  for (const Wanted& wanted : m_wanted) {
    modes.push_back({wanted.index, wanted.number, rung.modes.lambda_per_s2[wanted.number], {}});
  }
  for (std::size_t m = 0; m < materials.size(); ++m) {
    const std::string& name = rung.mesh.material_names[m];
    if (m_rig->find_material(name)->youngs_modulus_pa) continue;
    // The energy is linear in each modulus.
    std::vector<ElasticMaterial> doubled = materials;
    doubled[m].youngs_modulus_pa *= 2.0;
    const ElasticBody stiffer = linear_body(rig, rung.mesh, doubled, {});
    for (std::size_t k = 0; k < modes.size(); ++k) {
      const Eigen::VectorXd& shape = m_wanted[k].shape;
      const double all = body.elastic_energy(shape);
      modes[k].energy_shares[name] = (stiffer.elastic_energy(shape) - all) / all;
    }
  }
  return modes;
}

bool RigModes::refine(long max_dofs) {
  if (count_dofs(*m_rig, 0.5 * m_dx_m, ElementKind::Hex20) > max_dofs) return false;
  m_dx_m *= 0.5;
  for (Wanted& wanted : m_wanted) wanted.shape.resize(0);
  return true;
}

}  // namespace twang
