// SPDX-License-Identifier: GPL-3.0-or-later
// A film of a rig plucked far, rendered from its nonlinear simulation, calibrated linearly and then
// refined: what each makes of the known E and b, and how the coarse mesh follows the film with
// either.
#include "calibrate/calibrate.hpp"
#include "calibrate/render_rig.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "rigs/load_rig.hpp"

#include "bench/measure.hpp"
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

namespace {

using namespace twang;
using bench::seconds_since;
using Clock = std::chrono::steady_clock;

struct Arguments {
  std::string rig = "rigs/lrig.toml";
  std::filesystem::path film = "nonlinear_pluck.mp4";
  bool reuse = false;
  double modulus_pa = 2e8;
  double damping_b_s = 4e-4;
  double dx_mm = 1.5;
  std::string element = "hex20";
  std::optional<double> coarse_dx_mm;
  std::string coarse_element = "hex8";
  RenderOptions render;
};

/// On a terminal a line that changes, else one now and then.
ProgressCallback shown_progress() {
  return [said = Clock::time_point{}, begun = Clock::now()](const Progress& progress) mutable {
    const bool on_terminal = ::isatty(STDERR_FILENO) != 0;
    if (seconds_since(said) < (on_terminal ? 0.2 : 60.0)) return true;
    said = Clock::now();
    fmt::print(stderr,
               "{}{:.0f} s: {} {:.3g} of {:.3g}{}",
               on_terminal ? "\r\033[K" : "",
               seconds_since(begun),
               progress.stage,
               progress.done,
               progress.total,
               on_terminal ? "" : "\n");
    return true;
  };
}

void end_progress_line() {
  if (::isatty(STDERR_FILENO) != 0) fmt::print(stderr, "\r\033[K");
}

std::filesystem::path truth_file_of(std::filesystem::path film) {
  return film.replace_extension(".truth.json");
}

void render(const Arguments& arguments, const Rig& rig) {
  const RigMaterial& part = *rig.find_material(rig.parts.front().material);
  const ElasticMaterial material = {
      arguments.modulus_pa, part.poissons_ratio, part.density_kg_m3, arguments.damping_b_s};
  RenderOptions options = arguments.render;
  options.nonlinear = true;
  options.element = element_kind_from(arguments.element);
  options.dx_m = arguments.dx_mm * kMetresPerMillimetre;
  options.progress = shown_progress();
  const auto start = Clock::now();
  const RenderTruth truth = render_rig(rig, material, arguments.film, options);
  write_file_atomically(truth_file_of(arguments.film), truth_to_json(rig, truth));
  end_progress_line();
  fmt::print("{:.0f} s to simulate and render the film\n", seconds_since(start));
}

/// What a line of the table says of one estimate.
struct Estimate {
  double modulus_pa = 0.0;
  double modulus_sigma_rel = 0.0;
  double damping_b_s = 0.0;
  double damping_sigma_rel = 0.0;
  ValidationFigures figures;
};

void print_estimate(const char* name, const Estimate& estimate, const nlohmann::json& truth) {
  const double modulus =
      estimate.modulus_pa / truth.at("youngs_modulus_limit_pa").get<double>() - 1.0;
  const double damping =
      estimate.damping_b_s / truth.at("damping_stiffness_b_s").get<double>() - 1.0;
  fmt::print(
      "{:<8} {:>+8.2f} {:>7.2f} {:>6.1f} {:>+8.2f} {:>7.2f} {:>6.1f} {:>8.2f} {:>+13.3f} "
      "{:>+9.2f}\n",
      name,
      100.0 * modulus,
      100.0 * estimate.modulus_sigma_rel,
      std::abs(modulus) / estimate.modulus_sigma_rel,
      100.0 * damping,
      100.0 * estimate.damping_sigma_rel,
      std::abs(damping) / estimate.damping_sigma_rel,
      100.0 * estimate.figures.rms_rel,
      100.0 * estimate.figures.frequency_error_rel,
      100.0 * estimate.figures.decay_error_rel);
}

Estimate estimate_of(const Material& material) {
  return {material.youngs_modulus_identified_pa,
          material.youngs_modulus_identified_sigma_pa / material.youngs_modulus_identified_pa,
          material.damping_stiffness_b_s,
          material.damping_stiffness_b_sigma_s / material.damping_stiffness_b_s,
          material.validation};
}

/// As the calibration would have it without the refinement, held against the film likewise.
Estimate linear_estimate(const Rig& rig, const Calibration& found) {
  if (!found.material.refinement) return estimate_of(found.material);
  Material linear = found.material;
  const Refinement& change = *found.material.refinement;
  linear.youngs_modulus_numerical_pa = change.linear_youngs_modulus_numerical_pa;
  linear.youngs_modulus_identified_pa /= 1.0 + change.modulus_change_rel;
  linear.uncertainty.statistical = found.target.lambda_sigma_per_s2 / found.target.lambda_per_s2;
  linear.youngs_modulus_identified_sigma_pa =
      linear.youngs_modulus_identified_pa * linear.uncertainty.total();
  linear.damping_stiffness_b_s = change.linear_damping_stiffness_b_s;
  linear.damping_stiffness_b_sigma_s = found.target.damping_stiffness_b_sigma_s;
  const Repeat& repeat = found.repeats.front();
  linear.validation = validate_against_trace(rig,
                                             found.ladder.coarse,
                                             linear,
                                             repeat.trace,
                                             repeat.columns.front(),
                                             repeat.inversion,
                                             shown_progress(),
                                             found.coarse_mode)
                          .figures;
  return estimate_of(linear);
}

void run(const Arguments& arguments) {
  Rig rig =
      load_rig(arguments.rig, {.part = true, .clamp = true, .film = true, .observable = true});
  rig.tolerance = {};  // of the film's part all is known
  if (!arguments.reuse) render(arguments, rig);
  // The rig that was plucked so far says so.
  if (rig.release && rig.release->displacement)
    *rig.release->displacement *= arguments.render.amplitude;
  std::ifstream file(truth_file_of(arguments.film));
  const nlohmann::json truth = nlohmann::json::parse(file);
  fmt::print("film: {} elements of {} mm, E {:.4g} Pa, plucked to {:.4f}\n",
             truth.at("elements").get<int>(),
             truth.at("dx_mm").get<double>(),
             truth.at("youngs_modulus_limit_pa").get<double>(),
             truth.at("observable_at_release").get<double>());

  CalibrationOptions options;
  if (arguments.coarse_dx_mm)
    options.ladder.coarse_dx_m = *arguments.coarse_dx_mm * kMetresPerMillimetre;
  options.ladder.coarse_element = element_kind_from(arguments.coarse_element);
  options.refine = true;
  options.progress = shown_progress();
  const auto start = Clock::now();
  const Calibration found = calibrate_from_films(rig, {arguments.film}, options);
  const double seconds = seconds_since(start);
  const RefinedMaterial& refined = *found.refined;
  const Estimate linear = linear_estimate(rig, found);
  end_progress_line();
  fmt::print(
      "         E off [%]   sigma  in it b off [%]   sigma  in it  rms [%] frequency [%] "
      "decay [%]\n");
  print_estimate("linear", linear, truth);
  if (refined.usable()) {
    print_estimate("refined", estimate_of(found.material), truth);
  } else {
    fmt::print("{}\n", refined.message);
  }
  fmt::print(
      "bound           2              3        5              3        3           0.5         "
      "5\n");
  const Refinement& change = refined.change;
  fmt::print(
      "changed: E {:+.2f} ± {:.2f} %, b {:+.2f} ± {:.2f} %; rms over the samples followed {:.2f} "
      "%, before {:.2f} %\n{} simulations of {} elements, {:.0f} s from the film to the material\n",
      100.0 * change.modulus_change_rel,
      100.0 * change.modulus_sigma_rel,
      100.0 * change.damping_change_rel,
      100.0 * change.damping_sigma_rel,
      100.0 * change.residual_rel,
      100.0 * change.linear_residual_rel,
      refined.simulations,
      found.material.numerical_elements,
      seconds);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  RenderOptions& render = arguments.render;
  FilmOptions& film = render.film;
  render.amplitude = 9.0;
  film.duration_s = 0.65;
  film.noise = 1.5;
  film.exposure = 0.1;
  film.crf = 12;
  CLI::App app{"Bias of a linear calibration at large deflection, and what is left after --refine"};
  app.add_option("--rig", arguments.rig)->capture_default_str();
  app.add_option("--film", arguments.film, "written, its truth beside it")->capture_default_str();
  app.add_flag("--reuse", arguments.reuse, "the film and its truth are there");
  app.add_option("--youngs-modulus-pa", arguments.modulus_pa)->capture_default_str();
  app.add_option("--damping-b-s", arguments.damping_b_s)->capture_default_str();
  app.add_option("--dx", arguments.dx_mm, "of the film's mesh [mm]")->capture_default_str();
  app.add_option("--element", arguments.element, "of the film's mesh")->capture_default_str();
  app.add_option("--coarse-dx", arguments.coarse_dx_mm, "of the mesh of E_n [mm]; default: chosen");
  app.add_option("--coarse-element", arguments.coarse_element, "of it: hex8 or hex8e")
      ->capture_default_str();
  app.add_option("--amplitude", render.amplitude, "factor on the release")->capture_default_str();
  app.add_option("--duration", film.duration_s, "[s]")->capture_default_str();
  app.add_option("--noise", film.noise, "[grey levels]")->capture_default_str();
  app.add_option("--blur", film.exposure, "[frame intervals]")->capture_default_str();
  app.add_option("--seed", film.seed, "of the noise")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    run(arguments);
  } catch (const std::exception& error) {
    fmt::print(stderr, "\nbench_nonlinear_pluck: {}\n", error.what());
    return 1;
  }
  return 0;
}
