// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "rigs/detail/rig_tables.hpp"
#include "rigs/surface_mesh.hpp"

#include <fmt/format.h>

#include <array>

namespace twang::detail {
namespace {

/// Refuses keys that belong to another shape.
void forbid(const TomlTable& table, const std::vector<std::string>& keys, std::string_view shape) {
  for (const std::string& key : keys) {
    if (table.has(key)) table.complain(key, fmt::format("does not belong to {}", shape));
  }
}

Box read_part_box(const TomlTable& table) {
  forbid(table, {"from_mm", "to_mm", "radius_mm", "file", "unit_mm", "at_mm"}, "a box");
  const Box box = {metres(table, "min_mm"), metres(table, "max_mm")};
  if (!(box.min.array() < box.max.array()).all()) {
    table.refuse("max_mm", "greater than min_mm in each coordinate");
  }
  return box;
}

Cylinder read_cylinder(const TomlTable& table) {
  forbid(table, {"min_mm", "max_mm", "file", "unit_mm", "at_mm"}, "a cylinder");
  const Cylinder cylinder = {
      metres(table, "from_mm"), metres(table, "to_mm"), positive_metres(table, "radius_mm")};
  if (cylinder.from == cylinder.to) table.refuse("to_mm", "another point than from_mm");
  return cylinder;
}

SurfaceFile read_surface_file(const TomlTable& table, const std::filesystem::path& folder) {
  forbid(table, {"min_mm", "max_mm", "from_mm", "to_mm", "radius_mm"}, "a mesh");
  SurfaceFile surface;
  surface.file = folder / table.text("file");
  if (table.has("unit_mm")) surface.metres_per_unit = positive_metres(table, "unit_mm");
  if (table.has("at_mm")) surface.at = metres(table, "at_mm");
  try {
    surface.box = bounds_of(read_surface(surface));
  } catch (const InputError& error) {
    table.complain("file", fmt::format("cannot be used: {}", error.what()));
  }
  return surface;
}

}  // namespace

std::map<std::string, std::string> read_specimen(const TomlTable& document) {
  std::map<std::string, std::string> specimen;
  const auto table = document.table("specimen");
  if (!table) return specimen;
  table->allow_only({"batch",
                     "printer",
                     "orientation",
                     "infill",
                     "cure",
                     "temperature_c",
                     "printed_on",
                     "tested_on",
                     "note"});
  for (const std::string& key : table->keys()) specimen[key] = table->free_text(key);
  return specimen;
}

std::vector<RigMaterial> read_materials(const TomlTable& document) {
  std::vector<RigMaterial> materials;
  const auto all = document.table("materials");
  if (!all) return materials;
  for (const std::string& name : all->keys()) {
    if (name.empty()) all->complain(name, "has a material without a name, must have one");
    const TomlTable table = *all->table(name);
    table.allow_only(
        {"density_kg_m3", "poissons_ratio", "youngs_modulus_pa", "reported_youngs_modulus_pa"});
    RigMaterial material;
    material.name = name;
    material.density_kg_m3 = table.positive("density_kg_m3");
    material.poissons_ratio = table.number("poissons_ratio");
    if (material.poissons_ratio == 0.5) {
      table.refuse("poissons_ratio",
                   "below 0.5: a material that keeps its volume exactly has no finite stiffness "
                   "against pressure, say 0.499 of a rubber");
    }
    if (!(material.poissons_ratio > -1.0 && material.poissons_ratio < 0.5)) {
      table.refuse("poissons_ratio", "between -1 and 0.5, both excluded");
    }
    if (table.has("youngs_modulus_pa")) {
      material.youngs_modulus_pa = table.positive("youngs_modulus_pa");
    }
    if (table.has("reported_youngs_modulus_pa")) {
      material.reported_youngs_modulus_pa = table.positive("reported_youngs_modulus_pa");
    }
    materials.push_back(std::move(material));
  }
  return materials;
}

std::vector<PartSolid> read_parts(const TomlTable& document,
                                  const std::vector<RigMaterial>& materials,
                                  const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const RigMaterial& material : materials) names.push_back(material.name);
  std::vector<PartSolid> parts;
  for (const TomlTable& table : document.tables("part")) {
    table.allow_only({"material",
                      "shape",
                      "min_mm",
                      "max_mm",
                      "from_mm",
                      "to_mm",
                      "radius_mm",
                      "file",
                      "unit_mm",
                      "at_mm"});
    const std::size_t shape = table.choice("shape", {"box", "cylinder", "mesh"});
    PartSolid solid;
    if (shape == 0) solid.shape = read_part_box(table);
    if (shape == 1) solid.shape = read_cylinder(table);
    if (shape == 2) solid.shape = read_surface_file(table, folder);
    solid.material = table.text("material");
    if (names.empty()) {
      table.refuse("material", "defined in a table [materials.NAME], there is none");
    }
    solid.material = names[table.choice("material", names)];
    parts.push_back(std::move(solid));
  }
  return parts;
}

namespace {

MeshFile read_mesh_file(const TomlTable& table,
                        const Rig& rig,
                        const std::filesystem::path& folder) {
  MeshFile mesh;
  mesh.file = folder / table.text("file");
  if (!rig.parts.empty()) {
    table.complain("file", "stands beside [[part]], must be alone: the mesh is the part");
  }
  if (mesh.file.extension() != ".msh" && mesh.file.extension() != ".vtu") {
    table.refuse("file", "a Gmsh .msh or VTK .vtu file");
  }
  if (!std::filesystem::is_regular_file(mesh.file)) table.refuse("file", "a file that exists");
  if (table.has("unit_mm")) mesh.metres_per_unit = positive_metres(table, "unit_mm");
  if (table.has("at_mm")) mesh.at = metres(table, "at_mm");
  if (const auto groups = table.table("groups")) {
    std::vector<std::string> names;
    for (const RigMaterial& material : rig.materials) names.push_back(material.name);
    for (const std::string& group : groups->keys()) {
      if (names.empty()) {
        groups->refuse(group, "defined in a table [materials.NAME], there is none");
      }
      mesh.material_of_group[group] = names[groups->choice(group, names)];
    }
  }
  return mesh;
}

}  // namespace

Meshing read_meshing(const TomlTable& document,
                     const Rig& rig,
                     const std::filesystem::path& folder) {
  Meshing meshing;
  const auto table = document.table("mesh");
  if (!table) return meshing;
  table->allow_only({"partial_cells", "file", "unit_mm", "at_mm", "groups"});
  if (table->has("file")) {
    if (table->has("partial_cells")) {
      table->complain("partial_cells", "does not belong to a mesh that is read from a file");
    }
    meshing.file = read_mesh_file(*table, rig, folder);
    return meshing;
  }
  for (const char* key : {"unit_mm", "at_mm", "groups"}) {
    if (table->has(key)) table->complain(key, "belongs to a mesh file, there is none");
  }
  if (table->has("partial_cells")) {
    constexpr std::array kRules = {
        PartialCells::None, PartialCells::Mass, PartialCells::MassAndStiffness};
    std::vector<std::string> names;
    for (const PartialCells rule : kRules) names.emplace_back(to_string(rule));
    meshing.partial_cells = kRules[table->choice("partial_cells", names)];
  }
  return meshing;
}

std::vector<Box> read_clamps(const TomlTable& document, const Rig& rig) {
  std::vector<Box> clamps;
  for (const TomlTable& table : document.tables("clamp")) {
    table.allow_only({"min_mm", "max_mm"});
    const Box box = {metres(table, "min_mm"), metres(table, "max_mm")};
    if (!(box.min.array() <= box.max.array()).all()) {
      table.refuse("max_mm", "at least min_mm in each coordinate");
    }
    if (!rig.parts.empty()) {
      const Box part = rig.bounding_box();
      constexpr double kRounding_m = 1e-9;
      if ((box.min.array() > part.max.array() + kRounding_m).any() ||
          (box.max.array() < part.min.array() - kRounding_m).any()) {
        table.complain("", "holds nothing, must touch the box around the part");
      }
    }
    clamps.push_back(box);
  }
  return clamps;
}

}  // namespace twang::detail
