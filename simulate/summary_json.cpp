// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/run_scene.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace twang {

std::string summary_to_json(const Scene& scene, const SceneSummary& summary) {
  const RunSummary& run = summary.run;
  const double steps = std::max(run.steps, 1);
  const StepPhases& phases = run.phases;
  const double counted_s = phases.forces_s + phases.products_s + phases.factorization_s +
                           phases.preconditioner_s + summary.output_s + summary.mesh_s;
  const nlohmann::ordered_json json = {
      {"format", "twang-simulation/1"},
      {"scene_sha256", scene.sha256},
      {"integrator", std::string(to_string(scene.scheme))},
      {"step_s", scene.step_s},
      {"steps", run.steps},
      {"simulated_s", summary.simulated_s},
      {"completed", summary.usable()},
      {"message", run.message},
      {"resumed_at_step", summary.resumed_at_step},
      {"wall_s", summary.wall_s},
      {"wall_s_per_step", summary.wall_s / steps},
      {"newton_iterations_per_step", static_cast<double>(run.newton_iterations) / steps},
      {"linear_iterations_per_step", static_cast<double>(run.linear_iterations) / steps},
      {"factorizations", run.factorizations},
      {"halved_steps", run.halved_steps},
      {"solver", summary.solver},
      {"peak_memory_bytes", summary.peak_memory_bytes},
      {"phases",
       {{"meshing_and_loading_s", summary.mesh_s},
        {"forces_s", phases.forces_s},
        {"products_s", phases.products_s},
        {"factorization_s", phases.factorization_s},
        {"preconditioner_s", phases.preconditioner_s},
        {"output_s", summary.output_s},
        {"other_s", std::max(summary.wall_s - counted_s, 0.0)}}},
      {"energy_remainder_rel", summary.remainder_rel},
      {"state_sha256", summary.state_sha256}};
  return json.dump(2) + "\n";
}

}  // namespace twang
