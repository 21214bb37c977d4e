// SPDX-License-Identifier: GPL-3.0-or-later
// A rig is bent to the same place twice: by static equilibrium, and by steps through time slow
// enough that it follows; how far apart the two shapes and energies are, and what each costs.
//
//   quasistatic_load RIG [--dx-mm 1.5] [--element hex8] [--modulus-pa 1e9] [--b-s 1.6e-4]
//                    [--step-s 1e-4] [--ramp-periods 10] [--rest-periods 5] [--pull 1]
#include "coarsen/mesh_ladder.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "fem/static_solve.hpp"
#include "fem/threads.hpp"
#include "rigs/load_rig.hpp"
#include "simulate/energy.hpp"
#include "simulate/integrators.hpp"

#include "bench/measure.hpp"
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

namespace {

using namespace twang;
using bench::seconds_since;
using Eigen::VectorXd;

struct Settings {
  std::string rig;
  std::string element = "hex8";
  double dx_mm = 1.5;
  double modulus_pa = 1e9;
  double b_s = 1.6e-4;
  double step_s = 1e-4;
  double ramp_periods = 10.0;
  double rest_periods = 5.0;
  double pull = 1.0;  // in units of the rig's release
  int threads = 2;
};

/// Brings the pulled point along a smooth ramp to where it shall be, and waits.
BodyState load_slowly(const Settings& settings,
                      const ElasticBody& body,
                      const std::vector<int>& held,
                      const StaticLoad& load,
                      double period_s) {
  IntegratorOptions options;
  options.step_s = settings.step_s;
  Integrator integrator(body, held, options);
  integrator.hold_points({{*load.pulled_point, load.pull}});
  const double ramp_s = settings.ramp_periods * period_s;
  const int ramp = count_steps(ramp_s, settings.step_s);
  const int rest = count_steps(settings.rest_periods * period_s, settings.step_s);
  // The trapezoidal rule's mean of the velocities at both ends of a step is what it moves by.
  const auto place = [&](int n) {
    const double part = std::clamp(static_cast<double>(n) / ramp, 0.0, 1.0);
    return load.pull.norm() * 0.5 * (1.0 - std::cos(M_PI * part));
  };
  BodyState state;
  state.u = VectorXd::Zero(body.mesh().num_dofs());
  state.v = state.u;
  double velocity = 0.0;
  for (int n = 1; n <= ramp + rest; ++n) {
    velocity = 2.0 * (place(n) - place(n - 1)) / settings.step_s - velocity;
    integrator.set_point_velocities(VectorXd::Constant(1, velocity));
    const StepReport report = integrator.step(state);
    if (report.termination != Termination::Converged) throw NumericalFailure(report.message);
  }
  fmt::print("{} steps of {} s: {:.3g} s of ramp and {:.3g} s of rest\n",
             ramp + rest,
             settings.step_s,
             ramp_s,
             rest * settings.step_s);
  return state;
}

int compare(const Settings& settings) {
  fix_threads(settings.threads);
  const Rig rig = load_rig(settings.rig, {true, true, false, false});
  const MeshRung rung = compute_rung(
      rig, settings.dx_mm * kMetresPerMillimetre, element_kind_from(settings.element), 1);
  const double period_s = 2.0 * M_PI / std::sqrt(settings.modulus_pa * rung.modes.lambda_per_s2(0));
  const ElasticBody body(rung.mesh,
                         bench::materials_of(rig, rung.mesh, settings.modulus_pa, settings.b_s));
  const StaticLoad load = bench::pull_of_release(rig, body.mesh(), settings.pull);
  fmt::print("{}, dx {} mm: {} {} elements, first period {:.4g} s, bent by {:.3g} mm\n",
             rig.name,
             settings.dx_mm,
             body.mesh().num_elements(),
             settings.element,
             period_s,
             load.pull.norm() * kMillimetresPerMetre);
  auto start = std::chrono::steady_clock::now();
  const StaticResult bent = solve_static(body, rung.held_nodes, load);
  if (!bent.usable()) throw NumericalFailure(bent.message);
  const double static_s = seconds_since(start);
  start = std::chrono::steady_clock::now();
  const BodyState slow = load_slowly(settings, body, rung.held_nodes, load, period_s);
  const double dynamic_s = seconds_since(start);
  const auto nodes = [](const VectorXd& u) {
    return Eigen::Map<const Eigen::Matrix3Xd>(u.data(), 3, u.size() / 3);
  };
  // Of one mesh's nodes, so that it is no less than the distance of the surfaces.
  const double apart = (nodes(slow.u) - nodes(bent.u)).colwise().norm().maxCoeff();
  const double peak = nodes(bent.u).colwise().norm().maxCoeff();
  BodyState still{bent.u, VectorXd::Zero(bent.u.size()), 0.0};
  const double energy = measure_energy(body, still).total_j();
  fmt::print("quasistatic {:.3f} s, dynamic {:.3f} s: {:.0f} times as long\n",
             static_s,
             dynamic_s,
             dynamic_s / static_s);
  fmt::print("shapes at most {:.4f} % of the largest deflection apart, energies {:+.4f} %\n",
             100.0 * apart / peak,
             100.0 * (measure_energy(body, slow).total_j() / energy - 1.0));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CLI::App app("A rig bent by static equilibrium and by slow steps through time");
  app.add_option("rig", settings.rig, "rig file with a release")->required();
  app.add_option("--dx-mm", settings.dx_mm, "cell size [mm]");
  app.add_option("--element", settings.element, "hex8, hex20 or hex8e");
  app.add_option("--modulus-pa", settings.modulus_pa, "Young's modulus [Pa]");
  app.add_option("--b-s", settings.b_s, "stiffness damping [s]");
  app.add_option("--step-s", settings.step_s, "time step [s]");
  app.add_option("--ramp-periods", settings.ramp_periods, "of the first mode, of loading");
  app.add_option("--rest-periods", settings.rest_periods, "and of waiting");
  app.add_option("--pull", settings.pull, "in units of the rig's release");
  app.add_option("--threads", settings.threads, "number of threads");
  CLI11_PARSE(app, argc, argv);
  return bench::exit_code_of([&] { return compare(settings); });
}
