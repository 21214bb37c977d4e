// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/terminal.hpp"
#include "calibrate/render_rig.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/material_file.hpp"
#include "core/units.hpp"
#include "rigs/load_rig.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

namespace twang::app {
namespace {

struct RenderCommand {
  std::string rig;
  std::string material;
  std::optional<double> youngs_modulus_pa;
  std::optional<double> damping_stiffness_b_s;
  std::string output;
  std::optional<double> dx_mm;
  std::string element = "hex20";
  double readout_ms = 0.0;
  std::string lens;
  RenderOptions options;
};

/// From the material file, or from the rig's material with E and b of the command line.
ElasticMaterial material_of(const RenderCommand& command, const Rig& rig) {
  ElasticMaterial elastic;
  if (!command.material.empty()) {
    const Material material = read_material(command.material);
    elastic = {material.youngs_modulus_identified_pa,
               material.poissons_ratio,
               material.density_kg_m3,
               material.damping_stiffness_b_s,
               material.damping_mass_a_per_s};
  } else {
    if (!command.youngs_modulus_pa || !command.damping_stiffness_b_s) {
      throw InputError(
          "neither --material nor both of --youngs-modulus-pa and --damping-b-s are given, must be "
          "one of them");
    }
    const RigMaterial& material = *rig.find_material(rig.parts.front().material);
    elastic.poissons_ratio = material.poissons_ratio;
    elastic.density_kg_m3 = material.density_kg_m3;
  }
  if (command.youngs_modulus_pa) elastic.youngs_modulus_pa = *command.youngs_modulus_pa;
  if (command.damping_stiffness_b_s) elastic.damping_stiffness_b_s = *command.damping_stiffness_b_s;
  if (!(elastic.youngs_modulus_pa > 0.0)) {
    throw InputError(
        fmt::format("--youngs-modulus-pa is {}, must be > 0", elastic.youngs_modulus_pa));
  }
  if (!(elastic.damping_stiffness_b_s >= 0.0)) {
    throw InputError(
        fmt::format("--damping-b-s is {}, must be >= 0", elastic.damping_stiffness_b_s));
  }
  return elastic;
}

void run(const RenderCommand& command) {
  RigNeeds needs;
  needs.part = true;
  needs.clamp = true;
  needs.film = true;
  const Rig rig = load_rig(command.rig, needs);
  RenderOptions options = command.options;
  if (command.dx_mm) options.dx_m = *command.dx_mm * kMetresPerMillimetre;
  options.element = element_kind_from(command.element);
  options.progress = terminal_progress();
  options.film.readout_s = command.readout_ms * kSecondsPerMillisecond;
  if (!command.lens.empty()) options.film.lens = read_lens(command.lens);
  const ElasticMaterial material = material_of(command, rig);
  const std::filesystem::path video(command.output);
  const RenderTruth truth = render_rig(rig, material, video, options);
  std::filesystem::path truth_file = video;
  truth_file.replace_extension(".truth.json");
  write_file_atomically(truth_file, truth_to_json(rig, truth));
  say(fmt::format(
      "{}: {} frames, f {:.4f} Hz, d {:.4f} 1/s; E of the limit mesh {:.6g} Pa, b {:.6g} s",
      video.string(),
      truth.film.time_s.size(),
      truth.frequency_hz,
      truth.decay_per_s,
      truth.youngs_modulus_limit_pa,
      truth.damping_stiffness_b_s));
}

}  // namespace

void add_render_command(CLI::App& cli) {
  CLI::App* sub =
      cli.add_subcommand("render", "A synthetic film of a rig with its truth beside it");
  auto command = std::make_shared<RenderCommand>();
  FilmOptions& film = command->options.film;
  sub->add_option("rig", command->rig, "rig file (*.toml)")->required();
  sub->add_option("--material", command->material, "material.json: identified E and b");
  sub->add_option(
      "--youngs-modulus-pa", command->youngs_modulus_pa, "E [Pa]; overrules the material file");
  sub->add_option(
      "--damping-b-s", command->damping_stiffness_b_s, "b [s]; overrules the material file");
  sub->add_option("--out", command->output, "film to write (*.mp4); truth beside it as .truth.json")
      ->required();
  sub->add_option("--dx", command->dx_mm, "cell size [mm]; default: the smallest edge of the part");
  sub->add_option("--element", command->element, "hex8, hex20 or hex8e")->capture_default_str();
  sub->add_flag("--nonlinear",
                command->options.nonlinear,
                "simulate it with large deflections instead of a sum of modes");
  sub->add_option("--amplitude", command->options.amplitude, "factor on the rig's release")
      ->capture_default_str();
  sub->add_option("--hold", command->options.hold_s, "held before the release [s]")
      ->capture_default_str();
  sub->add_option(
         "--plucks", command->options.plucks, "how often it is let go, evenly over the film")
      ->capture_default_str();
  sub->add_option("--pull", command->options.pull_s, "time of each further pull [s]")
      ->capture_default_str();
  sub->add_option("--duration", film.duration_s, "[s]")->capture_default_str();
  sub->add_option("--fps", film.fps, "frames a second")->capture_default_str();
  sub->add_option("--width", film.width_px, "[px]")->capture_default_str();
  sub->add_option("--height", film.height_px, "[px]")->capture_default_str();
  sub->add_option("--noise", film.noise, "sensor noise, one sigma [grey levels of 255]")
      ->capture_default_str();
  sub->add_option("--blur", film.exposure, "exposure as part of the frame interval, 0 to 1")
      ->capture_default_str();
  sub->add_option("--tilt", film.tilt_deg, "camera about its vertical axis [deg]")
      ->capture_default_str();
  sub->add_option("--roll", film.roll_deg, "camera about the line of sight [deg]")
      ->capture_default_str();
  sub->add_option("--shake", film.shake_px, "camera shake, one sigma [px]")->capture_default_str();
  sub->add_option("--flicker", film.flicker, "relative ripple of the light")->capture_default_str();
  sub->add_option("--doubled", film.doubled, "part of the frames that repeat the one before")
      ->capture_default_str();
  sub->add_option("--readout-ms", command->readout_ms, "rolling shutter, first row to last [ms]")
      ->capture_default_str();
  sub->add_option("--lens", command->lens, "camera calibration (*.yml) that bends the picture");
  sub->add_option("--crf", film.crf, "H.264 quality, 0 (lossless) to 51")->capture_default_str();
  sub->add_option("--seed", film.seed, "of the noise")->capture_default_str();
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
