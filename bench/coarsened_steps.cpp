// SPDX-License-Identifier: GPL-3.0-or-later
// What coarsening saves: a rig is bent and let go on an accurate mesh and on a coarse one at its
// numerical modulus, and both are followed through the same time.
//
//   coarsened_steps RIG [--accurate hex8] [--accurate-dx-mm 0.375] [--coarse hex8]
//                   [--coarse-dx-mm 1.5] [--modulus-pa 1e9] [--b-s 1.6e-4] [--step-s 1e-4]
//                   [--periods 1] [--pull 1]
#include "coarsen/fit_material.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "fem/static_solve.hpp"
#include "fem/threads.hpp"
#include "rigs/load_rig.hpp"
#include "simulate/integrators.hpp"

#include "bench/measure.hpp"
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace {

using namespace twang;
using Eigen::Vector3d;
using Eigen::VectorXd;

struct Settings {
  std::string rig;
  std::string accurate = "hex8";
  std::string coarse = "hex8";
  double accurate_dx_mm = 0.375;
  double coarse_dx_mm = 1.5;
  double modulus_pa = 1e9;
  double b_s = 1.6e-4;
  double step_s = 1e-4;
  double periods = 1.0;
  double pull = 1.0;  // in units of the rig's release
  int threads = 2;
};

struct Mesh {
  std::string name;
  MeshRung rung;
};

Mesh mesh_of(const Rig& rig, const std::string& element, double dx_mm) {
  return {fmt::format("{} {} mm", element, dx_mm),
          compute_rung(rig, dx_mm * kMetresPerMillimetre, element_kind_from(element), 1, {})};
}

struct Followed {
  Eigen::Matrix3Xd moved;  // the pulled point's displacement after each step [m]
  double s_per_step = 0.0;
  double newton = 0.0;
};

Followed follow(
    const Settings& settings, const Rig& rig, const Mesh& mesh, double modulus_pa, int steps) {
  const ElasticBody body(mesh.rung.mesh,
                         bench::materials_of(rig, mesh.rung.mesh, modulus_pa, settings.b_s));
  const StaticLoad load = bench::pull_of_release(rig, body.mesh(), settings.pull);
  StaticOptions statics;
  statics.tolerance = 1e-8;
  statics.solver.tolerance = 1e-3;
  const StaticResult bent = solve_static(body, mesh.rung.held_nodes, load, statics);
  if (!bent.usable()) throw NumericalFailure(bent.message);
  IntegratorOptions options;
  options.step_s = settings.step_s;
  Integrator integrator(body, mesh.rung.held_nodes, options);
  BodyState state{bent.u, VectorXd::Zero(bent.u.size()), 0.0};
  Followed followed;
  followed.moved.resize(3, steps + 1);
  int n = 0;
  const RunSummary summary =
      run(integrator, state, options.step_s, steps * options.step_s, [&](const BodyState& now) {
        followed.moved.col(n++) = interpolate(*load.pulled_point, now.u);
      });
  if (!summary.usable()) throw NumericalFailure(summary.message);
  followed.s_per_step = summary.wall_s / summary.steps;
  followed.newton = static_cast<double>(summary.newton_iterations) / summary.steps;
  return followed;
}

int compare(const Settings& settings) {
  fix_threads(settings.threads);
  const Rig rig = load_rig(settings.rig, {true, true, false, false});
  const Mesh accurate = mesh_of(rig, settings.accurate, settings.accurate_dx_mm);
  const Mesh coarse = mesh_of(rig, settings.coarse, settings.coarse_dx_mm);
  const double lambda = accurate.rung.modes.lambda_per_s2(0);
  const double numerical =
      rescaled_modulus(settings.modulus_pa, lambda, coarse.rung.modes.lambda_per_s2(0));
  const double period_s = 2.0 * M_PI / std::sqrt(settings.modulus_pa * lambda);
  const int steps = static_cast<int>(std::ceil(settings.periods * period_s / settings.step_s));
  fmt::print("{}: E {:.4g} Pa, E_n {:.4g} Pa; period {:.4g} s, {} steps of {} s, {} threads\n",
             rig.name,
             settings.modulus_pa,
             numerical,
             period_s,
             steps,
             settings.step_s,
             settings.threads);
  const auto row = [&](const Mesh& mesh, const Followed& followed) {
    fmt::print("{:<16}{:>9} elements {:>9} unknowns {:>9.4f} s a step {:>6.2f} Newton\n",
               mesh.name,
               mesh.rung.mesh.num_elements(),
               mesh.rung.mesh.num_dofs(),
               followed.s_per_step,
               followed.newton);
    std::fflush(stdout);
  };
  const Followed cheap = follow(settings, rig, coarse, numerical, steps);
  row(coarse, cheap);
  const Followed dear = follow(settings, rig, accurate, settings.modulus_pa, steps);
  row(accurate, dear);
  const double amplitude = dear.moved.colwise().norm().maxCoeff();
  const auto apart = (cheap.moved - dear.moved).colwise().norm();
  fmt::print(
      "coarsening makes a step {:.0f} times as fast; the pulled point's paths are {:.2f} % rms, at "
      "most {:.2f} %, "
      "of its {:.3g} mm apart\n",
      dear.s_per_step / cheap.s_per_step,
      100.0 * apart.norm() / std::sqrt(steps + 1.0) / amplitude,
      100.0 * apart.maxCoeff() / amplitude,
      amplitude * kMillimetresPerMetre);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CLI::App app("An accurate mesh and a coarse one on the same path");
  app.add_option("rig", settings.rig, "rig file with a release")->required();
  app.add_option("--accurate", settings.accurate, "its element");
  app.add_option("--accurate-dx-mm", settings.accurate_dx_mm, "its cell size [mm]");
  app.add_option("--coarse", settings.coarse, "its element");
  app.add_option("--coarse-dx-mm", settings.coarse_dx_mm, "its cell size [mm]");
  app.add_option("--modulus-pa", settings.modulus_pa, "Young's modulus of the accurate mesh [Pa]");
  app.add_option("--b-s", settings.b_s, "stiffness damping [s]");
  app.add_option("--step-s", settings.step_s, "time step [s]");
  app.add_option("--periods", settings.periods, "of the first mode, followed");
  app.add_option("--pull", settings.pull, "in units of the rig's release");
  app.add_option("--threads", settings.threads, "number of threads");
  CLI11_PARSE(app, argc, argv);
  return bench::exit_code_of([&] { return compare(settings); });
}
