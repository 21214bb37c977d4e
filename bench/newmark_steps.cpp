// SPDX-License-Identifier: GPL-3.0-or-later
// Time and iterations of a Newmark step on the L-rig, pulled down and let go.
//
//   newmark_steps RIG [--dx-mm 1.5] [--pull-mm 7] [--step-s 1e-4] [--steps 200] [--element hex8]
#include "core/units.hpp"
#include "fem/linear_solver.hpp"
#include "fem/static_solve.hpp"
#include "rigs/load_rig.hpp"
#include "simulate/energy.hpp"
#include "simulate/integrators.hpp"
#include "simulate/static_newton.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <string>
#include <vector>

namespace {

using namespace twang;

struct Settings {
  std::string rig;
  std::string element = "hex8";
  double dx_mm = 1.5;
  double pull_mm = 7.0;
  double step_s = 1e-4;
  double b_s = 1.6e-4;
  int steps = 200;
  bool multigrid = false;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Median wall time of `calls` calls.
template <typename Function>
double median_time(int calls, const Function& function) {
  std::vector<double> times;
  for (int i = 0; i < calls; ++i) {
    const auto start = std::chrono::steady_clock::now();
    function();
    times.push_back(seconds_since(start));
  }
  std::nth_element(times.begin(), times.begin() + calls / 2, times.end());
  return times[static_cast<std::size_t>(calls / 2)];
}

void time_parts(const ElasticBody& body, const BodyState& state, const std::vector<int>& held) {
  const FreeDofs free(body.mesh().num_nodes(), held);
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
  fmt::print("  ({} element bodies, {} free dofs, {} entries)\n",
             body.mesh().num_elements(),
             H.rows(),
             H.nonZeros());
}

int bench(const Settings& settings) {
  const Rig rig = load_rig(settings.rig, {true, true, false, false});
  ElasticMaterial material;
  material.youngs_modulus_pa = 1e9;
  material.poissons_ratio = rig.materials.front().poissons_ratio;
  material.density_kg_m3 = rig.materials.front().density_kg_m3;
  material.damping_stiffness_b_s = settings.b_s;
  const ElasticBody body(
      mesh_part(rig, settings.dx_mm * kMetresPerMillimetre, element_kind_from(settings.element)),
      {material});
  const std::vector<int> held = clamped_nodes(body.mesh(), rig);

  StaticLoad load;
  load.pulled_point = locate(body.mesh(), Eigen::Vector3d(9.0, 12.0, 27.0) * kMetresPerMillimetre);
  load.pull = Eigen::Vector3d(0.0, 0.0, -settings.pull_mm * kMetresPerMillimetre);
  const auto start = std::chrono::steady_clock::now();
  StiffnessSolverOptions solver;
  if (settings.multigrid) solver.kind = StiffnessSolverKind::Multigrid;
  const StaticResult pulled = settings.multigrid
                                  ? solve_static_matrix_free(body, held, load, {}, solver)
                                  : solve_static(body, held, load);
  fmt::print("pull of {} mm: {:.3f} s, {} Newton iterations, {} load steps, {:.4g} N: {}\n",
             settings.pull_mm,
             seconds_since(start),
             pulled.newton_iterations,
             pulled.load_steps,
             pulled.pull_force_n,
             pulled.message);
  if (!pulled.usable()) return 1;

  BodyState state{pulled.u, Eigen::VectorXd::Zero(pulled.u.size()), 0.0};
  if (!settings.multigrid) time_parts(body, state, held);
  NewmarkOptions options;
  options.step_s = settings.step_s;
  options.solver = solver;
  NewmarkIntegrator integrator(body, held, options);
  const double energy = measure_energy(body, state).total_j();
  const std::clock_t cpu = std::clock();
  const RunSummary summary =
      run(integrator, state, settings.step_s, settings.step_s * settings.steps, {});
  fmt::print("{}; {}\n", summary.message, integrator.solver());
  const double steps = std::max(summary.steps, 1);
  fmt::print(
      "h {} s: {:.4f} s a step ({:.4f} s of processor); a step takes {:.2f} Newton and {:.2f} "
      "linear iterations; "
      "{} factorizations; energy {:.4g} -> {:.4g} J\n",
      settings.step_s,
      summary.wall_s / steps,
      static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC / steps,
      static_cast<double>(summary.newton_iterations) / steps,
      static_cast<double>(summary.linear_iterations) / steps,
      summary.factorizations,
      energy,
      measure_energy(body, state).total_j());
  return summary.usable() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CLI::App app("Time and iterations of a Newmark step");
  app.add_option("rig", settings.rig, "rig file")->required();
  app.add_option("--dx-mm", settings.dx_mm, "cell size [mm]");
  app.add_option("--element", settings.element, "hex8, hex20 or hex8e");
  app.add_option("--pull-mm", settings.pull_mm, "deflection before the release [mm]");
  app.add_option("--step-s", settings.step_s, "time step [s]");
  app.add_option("--b-s", settings.b_s, "stiffness damping [s]");
  app.add_flag("--multigrid", settings.multigrid, "in place of a factor");
  app.add_option("--steps", settings.steps, "number of steps");
  CLI11_PARSE(app, argc, argv);
  return bench(settings);
}
