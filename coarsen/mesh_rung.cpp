// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/mesh_rung.hpp"

#include "core/error.hpp"
#include "core/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <utility>

namespace twang {
namespace {

std::set<std::string> materials_of(const Rig& rig) {
  std::set<std::string> used;
  for (const PartSolid& solid : rig.parts) used.insert(solid.material);
  return used;
}

}  // namespace

std::string millimetres(double length_m) {
  return fmt::format("{:.4g} mm", length_m * kMillimetresPerMetre);
}

std::string describe(const HexMesh& mesh) {
  return fmt::format("{} at {}", to_string(mesh.kind), millimetres(mesh.requested_dx_m));
}

bool has_several_materials(const Rig& rig) { return materials_of(rig).size() > 1; }

Rig rig_to_identify(const Rig& rig, std::vector<std::string>& notes) {
  if (rig.parts.empty()) throw InputError(fmt::format("rig \"{}\" has no part", rig.name));
  if (rig.clamps.empty()) {
    throw InputError(
        fmt::format("rig \"{}\" has no clamp, a vibrating part must be held", rig.name));
  }
  const std::set<std::string> used = materials_of(rig);
  if (used.size() > 1) {
    for (const std::string& name : used) {
      const RigMaterial* material = rig.find_material(name);
      if (material != nullptr && material->youngs_modulus_pa) continue;
      throw InputError(fmt::format(
          "the part of rig \"{}\" has {} materials, of which \"{}\" states no youngs_modulus_pa; "
          "one frequency can identify only one, of several all must be stated",
          rig.name,
          used.size(),
          name));
    }
    return rig;
  }
  Rig result = rig;
  for (RigMaterial& material : result.materials) {
    if (material.name != *used.begin() || !material.youngs_modulus_pa) continue;
    notes.push_back(fmt::format(
        "material \"{}\" states its Young's modulus, the ladder does not use it", material.name));
    material.youngs_modulus_pa.reset();
  }
  return result;
}

std::vector<ElasticMaterial> elastic_materials(const Rig& rig,
                                               const HexMesh& mesh,
                                               double unknown_modulus_pa) {
  std::vector<ElasticMaterial> materials;
  for (const std::string& name : mesh.material_names) {
    const RigMaterial* stated = rig.find_material(name);
    if (!stated) {
      throw InputError(fmt::format("rig \"{}\" does not define material \"{}\"", rig.name, name));
    }
    ElasticMaterial material;
    material.youngs_modulus_pa = stated->youngs_modulus_pa.value_or(unknown_modulus_pa);
    material.poissons_ratio = stated->poissons_ratio;
    material.density_kg_m3 = stated->density_kg_m3;
    materials.push_back(material);
  }
  return materials;
}

ElasticBody linear_body(const HexMesh& mesh,
                        const std::vector<ElasticMaterial>& materials,
                        const std::vector<WeightAtPoint>& weights) {
  ElasticBody body(mesh, materials, ConstitutiveModel::Linear);
  for (const WeightAtPoint& weight : weights) body.add_point_mass(weight.point, weight.mass_kg);
  return body;
}

namespace {

/// Factors up to this estimate are faster than the multigrid: about 85,000 unknowns [byte].
constexpr double kLadderFactorBytes = 4e8;

std::string stage_of(double dx_m, ElementKind kind) {
  return fmt::format("eigenmodes of {} at {}", to_string(kind), millimetres(dx_m));
}

MeshRung compute_rung_by(const StiffnessSolverOptions& solver,
                         const Rig& rig,
                         HexMesh mesh,
                         int num_modes,
                         const ProgressCallback& progress) {
  const auto start = std::chrono::steady_clock::now();
  const std::string stage = stage_of(mesh.requested_dx_m, mesh.kind);
  MeshRung rung;
  rung.mesh = std::move(mesh);
  rung.held_nodes = clamped_nodes(rung.mesh, rig);
  const ElasticBody body = linear_body(
      rung.mesh, elastic_materials(rig, rung.mesh), weights_at_points(rung.mesh, rig.masses));

  const int num_free = rung.mesh.num_dofs() - 3 * static_cast<int>(rung.held_nodes.size());
  EigenmodeOptions options;
  options.solver = solver;
  options.count =
      std::min(num_modes, num_free / 2);  // an iteration needs room beyond what it seeks
  if (options.count < 1) {
    throw InputError(fmt::format("{} leaves {} unknowns of \"{}\" free to move, too few to vibrate",
                                 describe(rung.mesh),
                                 num_free,
                                 rig.name));
  }
  if (progress) {
    options.progress = [&](const Progress& inner) {
      return progress({stage, inner.done, inner.total});
    };
  }
  rung.modes = compute_eigenmodes(body, rung.held_nodes, options);
  if (!rung.modes.usable()) {
    throw NumericalFailure(
        fmt::format("no eigenmodes of {}: {}", describe(rung.mesh), rung.modes.message));
  }
  rung.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return rung;
}

}  // namespace

MeshRung compute_rung(const Rig& rig,
                      double dx_m,
                      ElementKind kind,
                      int num_modes,
                      const ProgressCallback& progress) {
  report_progress(progress, {stage_of(dx_m, kind), 0.0, 0.0});
  return compute_rung_by({}, rig, mesh_part(rig, dx_m, kind), num_modes, progress);
}

MeshRung compute_ladder_rung(const Rig& rig,
                             double dx_m,
                             ElementKind kind,
                             int num_modes,
                             const ProgressCallback& progress) {
  report_progress(progress, {stage_of(dx_m, kind), 0.0, 0.0});
  return compute_ladder_rung(rig, mesh_part(rig, dx_m, kind), num_modes, progress);
}

MeshRung compute_ladder_rung(const Rig& rig,
                             HexMesh mesh,
                             int num_modes,
                             const ProgressCallback& progress) {
  StiffnessSolverOptions solver;
  solver.max_factor_bytes = kLadderFactorBytes;
  return compute_rung_by(solver, rig, std::move(mesh), num_modes, progress);
}

long count_dofs(const Rig& rig, double dx_m, ElementKind kind) {
  const HexMesh mesh = mesh_part(rig, dx_m, ElementKind::Hex8);
  const long corners = mesh.num_nodes();
  if (kind != ElementKind::Hex20) return 3 * corners;
  const long cells = mesh.num_elements();
  const long outer_faces = static_cast<long>(surface_faces(mesh).size());
  const long edges = corners + 2 * cells + outer_faces / 2 - 1;
  return 3 * (corners + edges);
}

}  // namespace twang
