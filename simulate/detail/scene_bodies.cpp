// SPDX-License-Identifier: GPL-3.0-or-later
// The tables [[body]] and [body.material] of a scene file.
#include "core/material_file.hpp"
#include "core/units.hpp"
#include "rigs/load_rig.hpp"
#include "simulate/detail/scene_tables.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace twang::detail {
namespace {

const std::vector<std::string> kMaterialKeys = {"youngs_modulus_pa",
                                                "poissons_ratio",
                                                "density_kg_m3",
                                                "damping_stiffness_b_s",
                                                "damping_mass_a_per_s",
                                                "model"};

ConstitutiveModel read_model(const TomlTable& table) {
  if (!table.has("model")) return ConstitutiveModel::NeoHookean;
  return static_cast<ConstitutiveModel>(table.choice("model", {"neo_hookean", "stvk", "linear"}));
}

/// What the table does not say of density and Poisson's ratio, the rig does.
ElasticMaterial read_material_table(const TomlTable& table, const RigMaterial& of_rig) {
  table.allow_only(kMaterialKeys);
  ElasticMaterial material;
  material.youngs_modulus_pa = table.positive("youngs_modulus_pa");
  material.poissons_ratio =
      table.has("poissons_ratio") ? table.number("poissons_ratio") : of_rig.poissons_ratio;
  if (!(material.poissons_ratio > -1.0 && material.poissons_ratio < 0.5))
    table.refuse("poissons_ratio", "between -1 and 0.5, both excluded");
  material.density_kg_m3 =
      table.has("density_kg_m3") ? table.positive("density_kg_m3") : of_rig.density_kg_m3;
  if (table.has("damping_stiffness_b_s"))
    material.damping_stiffness_b_s = table.non_negative("damping_stiffness_b_s");
  if (table.has("damping_mass_a_per_s"))
    material.damping_mass_a_per_s = table.non_negative("damping_mass_a_per_s");
  return material;
}

std::vector<std::string> names_of_materials(const Rig& rig) {
  std::vector<std::string> names;
  for (const RigMaterial& material : rig.materials) names.push_back(material.name);
  return names;
}

/// [body.material.NAME], one for each of the rig's materials.
void read_named_materials(const TomlTable& table, SceneBody& body) {
  table.allow_only(names_of_materials(body.rig));
  bool first = true;
  for (const RigMaterial& of_rig : body.rig.materials) {
    const auto own = table.table(of_rig.name);
    if (!own)
      table.complain("", fmt::format("has no table for the rig's material \"{}\"", of_rig.name));
    body.materials[of_rig.name] = read_material_table(*own, of_rig);
    const ConstitutiveModel model = read_model(*own);
    if (!first && model != body.model)
      own->complain(own->has("model") ? "model" : "",
                    "must be of the same model as the body's other materials");
    body.model = model;
    first = false;
  }
}

void read_inline_material(const TomlTable& table, SceneBody& body) {
  if (!table.keys().empty() && table.is_table(table.keys().front())) {
    read_named_materials(table, body);
    return;
  }
  if (body.rig.materials.size() != 1)
    table.complain("",
                   fmt::format("is one material, must be a table [body.material.NAME] for each of "
                               "the rig's {}",
                               body.rig.materials.size()));
  body.materials[body.rig.materials.front().name] =
      read_material_table(table, body.rig.materials.front());
  body.model = read_model(table);
}

void read_material_file(const TomlTable& table,
                        const std::filesystem::path& folder,
                        SceneBody& body) {
  if (body.rig.materials.size() != 1)
    table.complain("material",
                   fmt::format("is a file of one material, must be a table [body.material.NAME] "
                               "for each of the rig's {}",
                               body.rig.materials.size()));
  SceneMaterialFile file;
  file.path = folder / table.text("material");
  file.material = read_material(file.path);
  if (table.has("modulus"))
    file.identified = table.choice("modulus", {"numerical", "identified"}) == 1;
  file.key = table.place("material");
  body.material_file = std::move(file);
}

Eigen::Matrix3d rotation_from(const Eigen::Vector3d& degrees) {
  const Eigen::Vector3d angle = degrees * kRadiansPerDegree;
  const Eigen::Quaterniond turned = Eigen::AngleAxisd(angle.z(), Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(angle.y(), Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(angle.x(), Eigen::Vector3d::UnitX());
  return turned.toRotationMatrix();
}

void read_pose(const TomlTable& table, SceneBody& body) {
  if (table.has("clamped")) body.clamped = table.flag("clamped");
  if (body.clamped && body.rig.clamps.empty())
    table.complain("", "is clamped but its rig has no clamp, must have clamped = false");
  if (table.has("position_mm")) body.position = table.vector("position_mm") * kMetresPerMillimetre;
  if (table.has("rotation_deg")) body.rotation = rotation_from(table.vector("rotation_deg"));
  for (const std::string key : {"velocity_m_s", "spin_rad_s"}) {
    if (!table.has(key)) continue;
    const Eigen::Vector3d value = table.vector(key);
    if (body.clamped && !value.isZero(0.0)) table.refuse(key, "zero, the body is clamped");
    (key == "spin_rad_s" ? body.spin_rad_s : body.velocity_m_s) = value;
  }
  if (body.model == ConstitutiveModel::Linear && !body.spin_rad_s.isZero(0.0))
    table.refuse("spin_rad_s", "zero, the linear model knows no large turns");
}

SceneBody read_body(const TomlTable& table, const std::filesystem::path& folder) {
  table.allow_only({"name",
                    "rig",
                    "dx_mm",
                    "element",
                    "material",
                    "modulus",
                    "clamped",
                    "position_mm",
                    "rotation_deg",
                    "velocity_m_s",
                    "spin_rad_s",
                    "solver"});
  SceneBody body;
  body.key = table.place("");
  body.name = table.text("name");
  if (body.name.find_first_of(",\"\n/\\") != std::string::npos)
    table.refuse("name", "a name without commas, quotes, slashes and line breaks");
  RigNeeds needs;
  needs.mesh = true;
  body.rig = load_rig(folder / table.text("rig"), needs);
  if (!body.rig.meshing.file || table.has("dx_mm"))
    body.dx_m = table.positive("dx_mm") * kMetresPerMillimetre;
  if (table.has("element")) {
    constexpr ElementKind kKinds[] = {ElementKind::Hex8, ElementKind::Hex20, ElementKind::Hex8e};
    body.element = kKinds[table.choice("element", {"hex8", "hex20", "hex8e"})];
  }
  if (table.is_table("material")) {
    if (table.has("modulus"))
      table.complain("modulus", "belongs to a material file, must not be there beside a table");
    read_inline_material(*table.table("material"), body);
  } else {
    read_material_file(table, folder, body);
  }
  if (table.has("solver")) {
    constexpr StiffnessSolverKind kSolvers[] = {StiffnessSolverKind::Automatic,
                                                StiffnessSolverKind::Factor,
                                                StiffnessSolverKind::Multigrid};
    body.solver = kSolvers[table.choice("solver", {"automatic", "factor", "multigrid"})];
  }
  read_pose(table, body);
  return body;
}

}  // namespace

std::vector<SceneBody> read_bodies(const TomlTable& document, const std::filesystem::path& folder) {
  std::vector<SceneBody> bodies;
  std::set<std::string> names;
  for (const TomlTable& table : document.tables("body")) {
    bodies.push_back(read_body(table, folder));
    if (!names.insert(bodies.back().name).second)
      table.refuse("name", "a name that no other body has");
  }
  if (bodies.empty()) document.complain("", "[[body]] is missing, must be there to say what moves");
  return bodies;
}

}  // namespace twang::detail
