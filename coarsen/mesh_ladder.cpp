// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/mesh_ladder.hpp"

#include "coarsen/detail/file_part.hpp"
#include "coarsen/detail/ladder_steps.hpp"
#include "coarsen/detail/mesh_rung.hpp"
#include "core/error.hpp"
#include "fem/read_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace twang {
namespace {

void check_open_interval(const char* name, double value) {
  if (value > 0.0 && value < 1.0) return;
  throw InputError(fmt::format("{} is {}, must be above 0 and below 1", name, value));
}

void check_length(const char* name, const std::optional<double>& value) {
  if (!value || (*value > 0.0 && std::isfinite(*value))) return;
  throw InputError(fmt::format("{} is {}, must be > 0", name, *value));
}

void check_count(const char* name, long value) {
  if (value < 1) throw InputError(fmt::format("{} is {}, must be >= 1", name, value));
}

void check_element(const char* name, ElementKind kind) {
  if (kind == ElementKind::Hex8 || kind == ElementKind::Hex8e) return;
  throw InputError(fmt::format("{} is {}, must be hex8 or hex8e", name, to_string(kind)));
}

/// What is to be said of a mesh, each sentence once.
void add_mesh_notes(const HexMesh& mesh, MeshLadder& ladder) {
  for (const std::string& note : mesh.notes) {
    if (std::find(ladder.notes.begin(), ladder.notes.end(), note) == ladder.notes.end()) {
      ladder.notes.push_back(note);
    }
  }
}

void choose(const Rig& rig, const LadderOptions& options, MeshLadder& ladder) {
  choose_mesh(rig, ladder.start_dx_m, options, ladder);
  add_mesh_notes(ladder.coarse.mesh, ladder);
}

}  // namespace

void LadderOptions::check() const {
  check_length("start_dx_m", start_dx_m);
  check_length("coarse_dx_m", coarse_dx_m);
  check_open_interval("convergent_change", convergent_change);
  check_open_interval("accurate_change", accurate_change);
  check_open_interval("shape_tolerance", shape_tolerance);
  check_element("coarse_element", coarse_element);
  if (!(enhanced_growth >= 0.0 && std::isfinite(enhanced_growth))) {
    throw InputError(fmt::format("enhanced_growth is {}, must be >= 0", enhanced_growth));
  }
  check_count("num_modes", num_modes);
  check_count("num_frequencies", num_frequencies);
  check_count("max_dofs", max_dofs);
}

const CoarseCandidate& MeshLadder::chosen() const {
  const auto found =
      std::find_if(candidates.begin(), candidates.end(), [&](const CoarseCandidate& candidate) {
        return candidate.dx_m == coarse.mesh.requested_dx_m;
      });
  assert(found != candidates.end());
  return *found;
}

double MeshLadder::identified_over_numerical() const {
  return coarse.modes.lambda_per_s2(0) / limit.lambda_per_s2;
}

double MeshLadder::sensitivity_dx_m() const {
  const auto accurate = static_cast<std::size_t>(accurate_rung.value_or(0));
  double dx_m = reference.front().mesh.requested_dx_m;
  for (std::size_t i = 0; i <= accurate; ++i) {
    if (reference[i].mesh.kind == ElementKind::Hex20) dx_m = reference[i].mesh.requested_dx_m;
  }
  return dx_m;
}

namespace {

/// The ladder without a coarse mesh, and the rig as it is meshed.
struct Reference {
  MeshLadder ladder;
  Rig identified;
};

Reference build_reference(const Rig& rig, const LadderOptions& options) {
  options.check();
  Reference built;
  MeshLadder& ladder = built.ladder;
  std::optional<HexMesh> file_mesh;
  if (rig.meshing.file) file_mesh = read_mesh_of(rig, ElementKind::Hex20);
  built.identified =
      rig_to_identify(file_mesh ? with_surfaces_of(rig, *file_mesh) : rig, ladder.notes);
  ladder.stated_moduli = has_several_materials(built.identified);
  ladder.start_dx_m = starting_dx(built.identified, options, ladder.notes);
  if (file_mesh) {
    refine_file_reference(built.identified, std::move(*file_mesh), options, ladder);
  } else {
    refine_reference(built.identified, ladder.start_dx_m, options, ladder);
  }
  for (const MeshRung& rung : ladder.reference) add_mesh_notes(rung.mesh, ladder);
  ladder.num_reference_notes = ladder.notes.size();
  return built;
}

}  // namespace

Rig as_solids(const Rig& rig) {
  return rig.meshing.file ? with_surfaces_of(rig, read_mesh_of(rig, ElementKind::Hex20)) : rig;
}

MeshLadder build_reference_ladder(const Rig& rig, const LadderOptions& options) {
  return build_reference(rig, options).ladder;
}

MeshLadder build_mesh_ladder(const Rig& rig, const LadderOptions& options) {
  Reference built = build_reference(rig, options);
  choose(built.identified, options, built.ladder);
  return std::move(built.ladder);
}

MeshLadder choose_again(const Rig& rig, MeshLadder ladder, const LadderOptions& options) {
  options.check();
  assert(!ladder.reference.empty());
  std::vector<std::string> said_before;
  const Rig identified = rig_to_identify(as_solids(rig), said_before);
  ladder.notes.resize(ladder.num_reference_notes);
  ladder.candidates.clear();
  ladder.beside.reset();
  choose(identified, options, ladder);
  return ladder;
}

}  // namespace twang
