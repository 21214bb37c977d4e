// SPDX-License-Identifier: GPL-3.0-or-later
// Eigenmodes and one static solution of a rig's mesh by sparse factor and by multigrid, one after
// the other in one run: seconds, iterations, peak memory.
//
//   modes RIG [--dx-mm 1.5 0.75 0.375] [--element hex8] [--count 10] [--free] [--max-factor-gb 12]
//         [--reference-dx-mm 1.5 0.75]
//
// With --reference-dx-mm hex20 of these cell sizes stands beside it, by the solver that is chosen,
// and the frequencies on the last mesh are compared with hex20's.
#include "core/units.hpp"
#include "fem/eigenmodes.hpp"
#include "fem/stiffness_solver.hpp"
#include "rigs/load_rig.hpp"

#include "bench/measure.hpp"
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <string>
#include <vector>

namespace {

using namespace twang;
using bench::peak_bytes;
using bench::reset_peak;
using bench::seconds_since;

struct Settings {
  std::string rig;
  std::string element = "hex8";
  std::vector<double> dx_mm = {1.5, 0.75, 0.375};
  int count = 10;
  bool free_body = false;
  double max_factor_gb = 12.0;
  std::vector<double> reference_dx_mm;
};

struct Outcome {
  bool done = false;
  Eigen::VectorXd lambda;
};

void solve_once(const ElasticBody& body, const FreeDofs& free, StiffnessSolverKind kind) {
  StiffnessSolverOptions options;
  options.kind = kind;
  auto start = std::chrono::steady_clock::now();
  const auto solver = make_stiffness_solver(body, free, options);
  if (solver->prepare({}) != SolveStatus::Ok) {
    fmt::print("  static: the matrix could not be prepared\n");
    return;
  }
  const double prepared = seconds_since(start);
  const Eigen::VectorXd load =
      free.restrict_vector(Eigen::Vector3d::UnitX().replicate(body.mesh().num_nodes(), 1));
  Eigen::MatrixXd u;
  start = std::chrono::steady_clock::now();
  const StiffnessSolution solution = solver->solve(load, u);
  fmt::print(
      "  static: {:.2f} s to prepare, {:.3f} s to solve, {} iterations, residual {:.1e}; {}\n",
      prepared,
      seconds_since(start),
      solution.iterations,
      solution.relative_residual,
      solver->description());
}

Outcome run(const ElasticBody& body,
            const FreeDofs& free,
            const Settings& settings,
            StiffnessSolverKind kind) {
  EigenmodeOptions options;
  options.count = settings.count;
  options.solver.kind = kind;
  reset_peak();
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  const Eigenmodes modes = compute_eigenmodes(body, free, options);
  fmt::print(
      "  modes:  {:.2f} s ({:.2f} s of processor), peak {:.2f} GB, first {:.6g} Hz, orthonormal to "
      "{:.0e}, residual "
      "{:.0e}; {}\n",
      seconds_since(start),
      static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC,
      1e-9 * peak_bytes(),
      modes.usable() ? modes.natural_frequency_hz(settings.free_body ? 6 : 0) : 0.0,
      modes.max_orthonormality_error,
      modes.max_residual,
      modes.message);
  return {modes.usable(), modes.lambda_per_s2};
}

void compare(const Outcome& factor, const Outcome& multigrid) {
  if (!factor.done || !multigrid.done) return;
  double largest = 0.0;
  for (Eigen::Index k = 0; k < factor.lambda.size(); ++k) {
    if (factor.lambda[k] == 0.0) continue;
    largest = std::max(largest, std::abs(multigrid.lambda[k] / factor.lambda[k] - 1.0));
  }
  fmt::print("  eigenvalues agree to {:.1e}\n", largest);
}

/// A rig's mesh as a body, and what is free of it.
struct Model {
  ElasticBody body;
  FreeDofs free;
};

Model make_model(const Rig& rig, double dx_mm, ElementKind kind, bool free_body) {
  HexMesh mesh = mesh_part(rig, dx_mm * kMetresPerMillimetre, kind);
  std::vector<ElasticMaterial> materials = bench::materials_of(rig, mesh);
  FreeDofs free(mesh.num_nodes(), free_body ? std::vector<int>{} : clamped_nodes(mesh, rig));
  Model model{ElasticBody(std::move(mesh), std::move(materials)), std::move(free)};
  fmt::print("dx {} mm: {} {} elements, {} unknowns\n",
             dx_mm,
             model.body.mesh().num_elements(),
             to_string(kind),
             model.free.size());
  return model;
}

Outcome solve_both(const Rig& rig, double dx_mm, const Settings& settings) {
  const Model model =
      make_model(rig, dx_mm, element_kind_from(settings.element), settings.free_body);
  const auto& [body, free] = model;
  if (!settings.free_body) solve_once(body, free, StiffnessSolverKind::Multigrid);
  Outcome multigrid = run(body, free, settings, StiffnessSolverKind::Multigrid);
  const double gigabytes = 1e-9 * estimate_factor_bytes(free.size());
  if (gigabytes > settings.max_factor_gb) {
    fmt::print("  no factor: it would take about {:.2g} GB\n", gigabytes);
    return multigrid;
  }
  if (!settings.free_body) solve_once(body, free, StiffnessSolverKind::Factor);
  compare(run(body, free, settings, StiffnessSolverKind::Factor), multigrid);
  return multigrid;
}

/// Distances of frequencies, mode by mode, from a reference's.
void compare_with_reference(const Outcome& found, const Outcome& reference) {
  if (!found.done || !reference.done) return;
  fmt::print("  frequency over hex20's - 1, on the last mesh of each [%]:");
  for (Eigen::Index k = 0; k < found.lambda.size(); ++k) {
    if (reference.lambda[k] == 0.0) continue;
    fmt::print(" {:.2f}", 100.0 * (std::sqrt(found.lambda[k] / reference.lambda[k]) - 1.0));
  }
  fmt::print("\n");
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CLI::App app("Eigenmodes by factor and by multigrid");
  app.add_option("rig", settings.rig, "rig file")->required();
  app.add_option("--dx-mm", settings.dx_mm, "cell sizes [mm]");
  app.add_option("--element", settings.element, "hex8 or hex8e");
  app.add_option("--count", settings.count, "number of modes");
  app.add_flag("--free", settings.free_body, "without the rig's clamps");
  app.add_option("--max-factor-gb", settings.max_factor_gb, "largest factor tried [GB]");
  app.add_option("--reference-dx-mm", settings.reference_dx_mm, "cell sizes of hex20 beside [mm]");
  CLI11_PARSE(app, argc, argv);
  RigNeeds needs;
  needs.part = true;
  const Rig rig = load_rig(settings.rig, needs);
  Outcome finest;
  for (const double dx_mm : settings.dx_mm) finest = solve_both(rig, dx_mm, settings);
  Outcome reference;
  for (const double dx_mm : settings.reference_dx_mm) {
    const Model model = make_model(rig, dx_mm, ElementKind::Hex20, settings.free_body);
    reference = run(model.body, model.free, settings, StiffnessSolverKind::Automatic);
    compare_with_reference(finest, reference);
  }
  return 0;
}
