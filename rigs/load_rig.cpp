// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/load_rig.hpp"

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/sha256.hpp"
#include "core/units.hpp"
#include "rigs/detail/rig_tables.hpp"

#include <fmt/format.h>

namespace twang {
namespace {

constexpr const char* kFormat = "twang-rig/1";

std::optional<Release> read_release(const TomlTable& document) {
  const auto table = document.table("release");
  if (!table) return std::nullopt;
  table->allow_only({"at_mm", "displacement_mm", "force_n"});
  Release release;
  release.at = detail::metres(*table, "at_mm");
  if (table->has("displacement_mm") == table->has("force_n")) {
    table->complain("", "must have exactly one of displacement_mm and force_n");
  }
  if (table->has("displacement_mm")) {
    release.displacement = table->direction("displacement_mm") * kMetresPerMillimetre;
  } else {
    release.force = table->direction("force_n");
  }
  return release;
}

Tolerance read_tolerance(const TomlTable& document) {
  Tolerance tolerance;
  const auto table = document.table("tolerance");
  if (!table) return tolerance;
  table->allow_only({"dimension_mm", "density_rel", "poissons_ratio", "clock_rel"});
  const auto read = [&](std::string_view key) {
    return table->has(key) ? table->non_negative(key) : 0.0;
  };
  tolerance.dimension_m = read("dimension_mm") * kMetresPerMillimetre;
  tolerance.density_rel = read("density_rel");
  tolerance.poissons_ratio = read("poissons_ratio");
  tolerance.clock_rel = read("clock_rel");
  return tolerance;
}

std::optional<Eigen::Vector3d> read_gravity(const TomlTable& document) {
  const auto table = document.table("environment");
  if (!table) return std::nullopt;
  table->allow_only({"gravity_m_s2"});
  if (!table->has("gravity_m_s2")) return std::nullopt;
  return table->vector("gravity_m_s2");
}

std::vector<PointMass> read_masses(const TomlTable& document) {
  std::vector<PointMass> masses;
  for (const TomlTable& table : document.tables("mass")) {
    table.allow_only({"at_mm", "mass_g", "size_mm"});
    masses.push_back(
        {detail::metres(table, "at_mm"), table.positive("mass_g") * kKilogramsPerGram});
    if (!table.has("size_mm")) continue;
    masses.back().size = detail::metres(table, "size_mm");
    if (masses.back().size.minCoeff() < 0.0) table.refuse("size_mm", "three lengths >= 0");
  }
  return masses;
}

void check_needs(const TomlTable& document, const Rig& rig, const RigNeeds& needs) {
  const auto need = [&](bool needed, bool there, const char* header, const char* purpose) {
    if (needed && !there) {
      document.complain("", fmt::format("{} is missing, must be there {}", header, purpose));
    }
  };
  need(needs.part, !rig.materials.empty(), "[materials.NAME]", "to say what the part is made of");
  need(needs.part, !rig.parts.empty(), "[[part]]", "to say what shape the part has");
  need(needs.mesh, !rig.materials.empty(), "[materials.NAME]", "to say what the part is made of");
  need(needs.mesh,
       !rig.parts.empty() || rig.meshing.file,
       "[[part]]",
       "to say what shape the part has (or [mesh] with a file)");
  need(needs.clamp, !rig.clamps.empty(), "[[clamp]]", "to say where the part is held");
  need(needs.film, !rig.markers.empty(), "[[marker]]", "to be found in a film");
  need(needs.film, rig.camera.has_value(), "[camera]", "to say how the rig is filmed");
  need(needs.observable, rig.observable.has_value(), "[observable]", "to say what is measured");
}

}  // namespace

Rig parse_rig(const std::string& content,
              const std::filesystem::path& file,
              const RigNeeds& needs) {
  const TomlDocument parsed(content, file.string(), fmt::format("a rig file ({})", kFormat));
  const TomlTable document = parsed.root();
  if (document.has("format") && document.text("format") != kFormat) {
    document.refuse("format", fmt::format("\"{}\"", kFormat));
  }
  document.allow_only({"format",
                       "name",
                       "specimen",
                       "materials",
                       "part",
                       "clamp",
                       "marker",
                       "observable",
                       "release",
                       "camera",
                       "tolerance",
                       "environment",
                       "mass",
                       "mesh"});
  Rig rig;
  (void)document.text("format");
  rig.name = document.text("name");
  rig.file = file;
  rig.sha256 = sha256_of_text(content);
  rig.specimen = detail::read_specimen(document);
  rig.materials = detail::read_materials(document);
  rig.parts = detail::read_parts(document, rig.materials, file.parent_path());
  rig.clamps = detail::read_clamps(document, rig);
  rig.masses = read_masses(document);
  rig.markers = detail::read_markers(document, rig);
  rig.camera = detail::read_camera(document, file.parent_path());
  rig.observable = detail::read_observable(document, rig);
  rig.release = read_release(document);
  rig.tolerance = read_tolerance(document);
  rig.gravity_m_s2 = read_gravity(document);
  rig.meshing = detail::read_meshing(document, rig, file.parent_path());
  check_needs(document, rig, needs);
  return rig;
}

Rig load_rig(const std::filesystem::path& path, const RigNeeds& needs) {
  return parse_rig(read_file(path), path, needs);
}

}  // namespace twang
