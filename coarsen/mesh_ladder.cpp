// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/mesh_ladder.hpp"

#include "coarsen/detail/ladder_steps.hpp"
#include "coarsen/detail/mesh_rung.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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

/// What is to be said of the meshes, each sentence once.
void add_mesh_notes(MeshLadder& ladder) {
  const auto add = [&](const HexMesh& mesh) {
    for (const std::string& note : mesh.notes) {
      if (std::find(ladder.notes.begin(), ladder.notes.end(), note) == ladder.notes.end()) {
        ladder.notes.push_back(note);
      }
    }
  };
  for (const MeshRung& rung : ladder.reference) add(rung.mesh);
  add(ladder.coarse.mesh);
}

}  // namespace

void LadderOptions::check() const {
  check_length("start_dx_m", start_dx_m);
  check_length("coarse_dx_m", coarse_dx_m);
  check_open_interval("convergent_change", convergent_change);
  check_open_interval("accurate_change", accurate_change);
  check_open_interval("shape_tolerance", shape_tolerance);
  check_count("num_modes", num_modes);
  check_count("num_frequencies", num_frequencies);
  check_count("max_dofs", max_dofs);
}

MeshLadder build_reference_ladder(const Rig& rig, const LadderOptions& options) {
  options.check();
  MeshLadder ladder;
  const Rig identified = rig_to_identify(rig, ladder.notes);
  refine_reference(identified, starting_dx(identified, options, ladder.notes), options, ladder);
  return ladder;
}

MeshLadder build_mesh_ladder(const Rig& rig, const LadderOptions& options) {
  options.check();
  MeshLadder ladder;
  const Rig identified = rig_to_identify(rig, ladder.notes);
  const double start_dx_m = starting_dx(identified, options, ladder.notes);
  refine_reference(identified, start_dx_m, options, ladder);
  choose_mesh(identified, start_dx_m, options, ladder);
  add_mesh_notes(ladder);
  return ladder;
}

}  // namespace twang
