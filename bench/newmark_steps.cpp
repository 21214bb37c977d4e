// SPDX-License-Identifier: GPL-3.0-or-later
// Time, iterations and memory of a Newmark step in free vibration: a rig is bent by a tenth of its
// length and let go.
//
//   newmark_steps RIG [--dx-mm 1.5] [--element hex8] [--solver automatic] [--steps 100]
//                 [--at-mm X Y Z] [--pull-mm X Y Z] [--step-s 1e-4] [--b-s 1.6e-4] [--parts]
//                 [--paper-s-per-step S]
//
// Without --at-mm the node farthest from the clamps is pulled; without --pull-mm towards -z.
#include "core/units.hpp"
#include "fem/linear_solver.hpp"
#include "fem/static_solve.hpp"
#include "fem/threads.hpp"
#include "rigs/load_rig.hpp"
#include "simulate/energy.hpp"
#include "simulate/integrators.hpp"

#include "bench/measure.hpp"
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <string>
#include <vector>

namespace {

using namespace twang;
using bench::seconds_since;
using Clock = std::chrono::steady_clock;

struct Settings {
  std::string rig;
  std::string element = "hex8";
  std::string solver = "automatic";
  double dx_mm = 1.5;
  std::vector<double> at_mm;
  std::vector<double> pull_mm;
  double step_s = 1e-4;
  double b_s = 1.6e-4;
  int steps = 100;
  int threads = 2;
  bool parts = false;
  double paper_s_per_step = 0.0;
  double poissons_ratio = 0.0;  // 0: the rig's
};

/// Median wall time of `calls` calls.
template <typename Function>
double median_time(int calls, const Function& function) {
  std::vector<double> times;
  for (int i = 0; i < calls; ++i) {
    const auto start = Clock::now();
    function();
    times.push_back(seconds_since(start));
  }
  std::nth_element(times.begin(), times.begin() + calls / 2, times.end());
  return times[static_cast<std::size_t>(calls / 2)];
}

void time_parts(const ElasticBody& body, const BodyState& state, const FreeDofs& free) {
  volatile double sink = 0.0;
  const auto row = [](const char* name, double time_s) {
    fmt::print("  {:<28}{:8.2f} ms\n", name, 1e3 * time_s);
  };
  const Eigen::VectorXd w = state.u;
  row("internal force", median_time(9, [&] { sink = body.internal_force(state.u)[0]; }));
  row("damping force", median_time(9, [&] { sink = body.stiffness_damping_force(state.u, w)[0]; }));
  row("stiffness product", median_time(9, [&] { sink = body.stiffness_product(state.u, w)[0]; }));
  row("stiffness assembly", median_time(5, [&] { sink = body.stiffness(state.u).coeff(0, 0); }));
  const SparseMatrix K = body.stiffness(state.u) + 4e8 * body.mass();
  row("restriction", median_time(5, [&] { sink = free.restrict_matrix(K).coeff(0, 0); }));
  const SparseMatrix H = free.restrict_matrix(K);
  const auto solver = make_cholesky_solver();
  row("analysis", median_time(1, [&] { static_cast<void>(solver->analyze(H)); }));
  row("factorization", median_time(5, [&] { static_cast<void>(solver->factorize(H)); }));
  Eigen::MatrixXd x;
  const Eigen::MatrixXd rhs = free.restrict_vector(w);
  row("triangular solves", median_time(9, [&] { static_cast<void>(solver->solve(rhs, x)); }));
}

/// The node farthest from the held ones.
Eigen::Vector3d far_end(const HexMesh& mesh, const std::vector<int>& held) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const int node : held) middle += mesh.nodes.col(node) / static_cast<double>(held.size());
  Eigen::Index farthest = 0;
  (mesh.nodes.colwise() - middle).colwise().squaredNorm().maxCoeff(&farthest);
  return mesh.nodes.col(farthest);
}

Eigen::Vector3d vector_from(const std::vector<double>& mm) {
  return Eigen::Vector3d(mm[0], mm[1], mm[2]) * kMetresPerMillimetre;
}

StaticResult bend(const Settings& settings,
                  const ElasticBody& body,
                  const std::vector<int>& held,
                  const StiffnessSolverOptions& solver) {
  const HexMesh& mesh = body.mesh();
  const double length =
      (mesh.nodes.rowwise().maxCoeff() - mesh.nodes.rowwise().minCoeff()).maxCoeff();
  const Eigen::Vector3d at =
      settings.at_mm.empty() ? far_end(mesh, held) : vector_from(settings.at_mm);
  StaticLoad load;
  load.pulled_point = locate(mesh, at);
  load.pull = settings.pull_mm.empty() ? Eigen::Vector3d(0.0, 0.0, -0.1 * length)
                                       : vector_from(settings.pull_mm);
  StaticOptions options;
  options.solver.kind = solver.kind;
  options.tolerance = 1e-6;  // it is only where the vibration starts
  options.solver.tolerance = 1e-3;
  const auto start = Clock::now();
  StaticResult pulled = solve_static(body, held, load, options);
  fmt::print(
      "bent at ({:.3g}, {:.3g}, {:.3g}) mm by {:.3g} mm of {:.3g} mm: {:.2f} s, {} Newton and {} "
      "linear iterations, {:.4g} N: {}\n",
      at.x() * kMillimetresPerMetre,
      at.y() * kMillimetresPerMetre,
      at.z() * kMillimetresPerMetre,
      load.pull.norm() * kMillimetresPerMetre,
      length * kMillimetresPerMetre,
      seconds_since(start),
      pulled.newton_iterations,
      pulled.linear_iterations,
      pulled.pull_force_n,
      pulled.message);
  return pulled;
}

int run_case(const Settings& settings) {
  fix_threads(settings.threads);
  const Rig rig = load_rig(settings.rig, {true, true, false, false});
  HexMesh mesh =
      mesh_part(rig, settings.dx_mm * kMetresPerMillimetre, element_kind_from(settings.element));
  std::vector<ElasticMaterial> materials = bench::materials_of(rig, mesh, 1e9, settings.b_s);
  for (ElasticMaterial& material : materials)
    if (settings.poissons_ratio != 0.0) material.poissons_ratio = settings.poissons_ratio;
  const std::vector<int> held = clamped_nodes(mesh, rig);
  const ElasticBody body(std::move(mesh), std::move(materials));
  const FreeDofs free(body.mesh().num_nodes(), held);
  fmt::print("{}, dx {} mm: {} {} elements, {} unknowns, {} threads\n",
             rig.name,
             settings.dx_mm,
             body.mesh().num_elements(),
             settings.element,
             free.size(),
             settings.threads);
  IntegratorOptions options;
  options.step_s = settings.step_s;
  if (settings.solver == "factor") options.solver.kind = StiffnessSolverKind::Factor;
  if (settings.solver == "multigrid") options.solver.kind = StiffnessSolverKind::Multigrid;
  const StaticResult pulled = bend(settings, body, held, options.solver);
  if (!pulled.usable()) return 1;
  BodyState state{pulled.u, Eigen::VectorXd::Zero(pulled.u.size()), 0.0};
  if (settings.parts) time_parts(body, state, free);

  const double bending_peak = bench::peak_bytes();
  bench::reset_peak();
  Integrator integrator(body, held, options);
  const double energy = measure_energy(body, state).total_j();
  const std::clock_t cpu = std::clock();
  const RunSummary summary =
      run(integrator, state, settings.step_s, settings.step_s * settings.steps, {});
  const double steps = std::max(summary.steps, 1);
  const double wall = summary.wall_s / steps;
  fmt::print("{}; {}\n", summary.message, integrator.solver());
  fmt::print(
      "h {} s: {:.4f} s a step ({:.4f} s of processor), {:.2f} Newton and {:.2f} linear "
      "iterations; {} factorizations, {} steps halved; energy {:.4g} -> {:.4g} J\n",
      settings.step_s,
      wall,
      static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC / steps,
      static_cast<double>(summary.newton_iterations) / steps,
      static_cast<double>(summary.linear_iterations) / steps,
      summary.factorizations,
      summary.halved_steps,
      energy,
      measure_energy(body, state).total_j());
  const StepPhases& phases = summary.phases;
  fmt::print(
      "of it forces {:.4f}, products {:.4f}, factorization {:.4f}, preconditioner {:.4f} s\n",
      phases.forces_s / steps,
      phases.products_s / steps,
      phases.factorization_s / steps,
      phases.preconditioner_s / steps);
  fmt::print("peak memory of the bending {:.3f} GB, of the steps {:.3f} GB",
             1e-9 * bending_peak,
             1e-9 * bench::peak_bytes());
  if (settings.paper_s_per_step > 0.0)
    fmt::print(
        "; the paper's {} s a step (four threads, contact perhaps included) are {:.0f} times as "
        "many",
        settings.paper_s_per_step,
        settings.paper_s_per_step / wall);
  fmt::print("\n");
  return summary.usable() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CLI::App app("Time, iterations and memory of a Newmark step at large deflection");
  app.add_option("rig", settings.rig, "rig file")->required();
  app.add_option("--dx-mm", settings.dx_mm, "cell size [mm]");
  app.add_option("--element", settings.element, "hex8, hex20 or hex8e");
  app.add_option("--solver", settings.solver, "automatic, factor or multigrid")
      ->check(CLI::IsMember({"automatic", "factor", "multigrid"}));
  app.add_option("--at-mm", settings.at_mm, "where it is bent [mm]")->expected(3);
  app.add_option("--pull-mm", settings.pull_mm, "and how far [mm]")->expected(3);
  app.add_option("--step-s", settings.step_s, "time step [s]");
  app.add_option("--b-s", settings.b_s, "stiffness damping [s]");
  app.add_option("--poissons-ratio", settings.poissons_ratio, "in place of the rig's [-]");
  app.add_option("--steps", settings.steps, "number of steps");
  app.add_option("--threads", settings.threads, "number of threads");
  app.add_flag("--parts", settings.parts, "times of the parts of a step, too");
  app.add_option("--paper-s-per-step", settings.paper_s_per_step, "to be compared with [s]");
  CLI11_PARSE(app, argc, argv);
  return run_case(settings);
}
