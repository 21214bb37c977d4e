// SPDX-License-Identifier: GPL-3.0-or-later
// A film of a rig plucked far, rendered from its nonlinear simulation, calibrated linearly and then
// refined: what each makes of the known E and b.
#include "calibrate/calibrate.hpp"
#include "calibrate/render_rig.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "rigs/load_rig.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>

namespace {

using namespace twang;

struct Arguments {
  std::string rig = "rigs/lrig.toml";
  std::string film = "nonlinear_pluck.mp4";
  double modulus_pa = 2e8;
  double damping_b_s = 4e-4;
  double dx_mm = 1.5;
  double coarse_dx_mm = 1.5;
  std::string element = "hex20";
  RenderOptions render;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

bool on_terminal(const Progress& progress) {
  fmt::print(stderr, "\r\033[K{} {:.0f} of {:.0f}", progress.stage, progress.done, progress.total);
  return true;
}

void print_material(const char* name,
                    double modulus_ratio,
                    double modulus_sigma_rel,
                    double damping_ratio,
                    double damping_sigma_rel,
                    const ValidationFigures& figures) {
  fmt::print("{:<8} {:>+8.2f} {:>7.2f} {:>+9.2f} {:>7.2f} {:>8.2f} {:>10.3f} {:>8.2f}\n",
             name,
             100.0 * (modulus_ratio - 1.0),
             100.0 * modulus_sigma_rel,
             100.0 * (damping_ratio - 1.0),
             100.0 * damping_sigma_rel,
             100.0 * figures.rms_rel,
             100.0 * figures.frequency_error_rel,
             100.0 * figures.decay_error_rel);
}

void run(const Arguments& arguments) {
  Rig rig =
      load_rig(arguments.rig, {.part = true, .clamp = true, .film = true, .observable = true});
  rig.tolerance = {};  // of the film's part all is known
  const RigMaterial& part = *rig.find_material(rig.parts.front().material);
  const ElasticMaterial truth_material = {
      arguments.modulus_pa, part.poissons_ratio, part.density_kg_m3, arguments.damping_b_s};
  RenderOptions render = arguments.render;
  render.nonlinear = true;
  render.element = element_kind_from(arguments.element);
  render.dx_m = arguments.dx_mm * kMetresPerMillimetre;
  render.progress = on_terminal;
  auto start = std::chrono::steady_clock::now();
  const RenderTruth truth = render_rig(rig, truth_material, arguments.film, render);
  fmt::print(stderr, "\r\033[K");
  fmt::print("film: {} {} elements of {} mm, plucked to {:.4f}, {:.0f} s to simulate and render\n",
             truth.num_elements,
             arguments.element,
             arguments.dx_mm,
             truth.observable_at_release,
             seconds_since(start));

  CalibrationOptions options;
  options.refine = true;
  options.ladder.coarse_dx_m = arguments.coarse_dx_mm * kMetresPerMillimetre;
  options.progress = on_terminal;
  start = std::chrono::steady_clock::now();
  const Calibration found = calibrate_from_films(rig, {arguments.film}, options);
  const double calibration_s = seconds_since(start);
  const Repeat& repeat = found.repeats.front();
  const Refinement& change = *found.material.refinement;
  Material linear = found.material;
  linear.youngs_modulus_numerical_pa = change.linear_youngs_modulus_numerical_pa;
  linear.damping_stiffness_b_s = change.linear_damping_stiffness_b_s;
  const Validation before = validate_against_trace(rig,
                                                   found.ladder.coarse,
                                                   linear,
                                                   repeat.trace,
                                                   repeat.columns.front(),
                                                   repeat.inversion,
                                                   on_terminal,
                                                   found.coarse_mode);
  fmt::print(stderr, "\r\033[K");
  const double refined =
      found.material.youngs_modulus_identified_pa / truth.youngs_modulus_limit_pa;
  const double damping = found.material.damping_stiffness_b_s / truth.damping_stiffness_b_s;
  fmt::print("         E off [%]   sigma b off [%]   sigma  rms [%] frequency [%] decay [%]\n");
  print_material("linear",
                 refined / (1.0 + change.modulus_change_rel),
                 0.5 * found.target.lambda_sigma_per_s2 / found.target.lambda_per_s2 * 2.0,
                 damping / (1.0 + change.damping_change_rel),
                 found.target.damping_stiffness_b_sigma_s / found.target.damping_stiffness_b_s,
                 before.figures);
  print_material("refined",
                 refined,
                 found.material.uncertainty.total(),
                 damping,
                 change.damping_sigma_rel,
                 found.material.validation);
  fmt::print("bound         2                 5                  3         0.5          5\n");
  fmt::print("{} simulations of {} elements, {:.0f} s from the film to the material\n",
             change.simulations,
             found.material.numerical_elements,
             calibration_s);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  RenderOptions& render = arguments.render;
  render.amplitude = 9.0;
  render.film.duration_s = 0.55;
  CLI::App app{"Bias of a linear calibration at large deflection, and what is left after --refine"};
  app.add_option("--rig", arguments.rig)->capture_default_str();
  app.add_option("--film", arguments.film, "written")->capture_default_str();
  app.add_option("--youngs-modulus-pa", arguments.modulus_pa)->capture_default_str();
  app.add_option("--damping-b-s", arguments.damping_b_s)->capture_default_str();
  app.add_option("--dx", arguments.dx_mm, "of the film's mesh [mm]")->capture_default_str();
  app.add_option("--element", arguments.element, "of the film's mesh")->capture_default_str();
  app.add_option("--coarse-dx", arguments.coarse_dx_mm, "of the calibrated mesh [mm]")
      ->capture_default_str();
  app.add_option("--amplitude", render.amplitude, "factor on the release")->capture_default_str();
  app.add_option("--duration", render.film.duration_s, "[s]")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    run(arguments);
  } catch (const std::exception& error) {
    fmt::print(stderr, "\nbench_nonlinear_pluck: {}\n", error.what());
    return 1;
  }
  return 0;
}
