// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/progress.hpp"
#include "simulate/integrators.hpp"
#include "simulate/scene.hpp"

#include <cstdint>
#include <filesystem>
#include <string>

namespace twang {

struct SceneOptions {
  std::filesystem::path folder;  ///< for the results, made if it is not there
  bool resume = false;           ///< go on from the checkpoint in the folder
  int threads = 0;               ///< 0: as many as are idle, but one for factorizations
  ProgressCallback progress = {};
  void check() const;  ///< throws InputError naming field, value, allowed range
};

/// What a scene's run came to; `summary.json` says the same.
struct SceneSummary {
  RunSummary run;  ///< of all bodies and, if it was resumed, of the runs before
  double simulated_s = 0.0;
  double wall_s = 0.0;             ///< [s]
  double mesh_s = 0.0;             ///< of it: reading, meshing, settling [s]
  double output_s = 0.0;           ///< of it: tables, frames, checkpoints [s]
  double peak_memory_bytes = 0.0;  ///< of the process
  std::string solver;              ///< a few words
  std::string state_sha256;        ///< of all displacements and velocities at the end
  double remainder_rel = 0.0;      ///< largest energy remainder over the largest energy met [-]
  std::int64_t resumed_at_step = 0;
  [[nodiscard]] bool usable() const { return run.usable(); }
};

/// Runs a scene and writes `motion.csv`, `probes.csv`, `energy.csv`, frames, checkpoints and
/// `summary.json` into a folder; tables grow while it runs. A step that fails ends the run with
/// what there is until then.
///
/// The results repeat bit by bit at the same number of threads, and so do those of a run that was
/// broken off and resumed.
///
/// @throws InputError if a body cannot be made, the folder not be written to, or the checkpoint is
/// damaged or another scene's
/// @throws NumericalFailure if a load finds no equilibrium
/// @throws Cancelled after writing a checkpoint
SceneSummary run_scene(const Scene& scene, const SceneOptions& options);

/// `summary.json` as text.
[[nodiscard]] std::string summary_to_json(const Scene& scene, const SceneSummary& summary);

}  // namespace twang
