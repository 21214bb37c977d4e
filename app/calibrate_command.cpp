// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/ladder_report.hpp"
#include "app/options.hpp"
#include "app/report_page.hpp"
#include "app/terminal.hpp"
#include "app/track_report.hpp"
#include "calibrate/calibrate.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/material_file.hpp"
#include "core/text.hpp"
#include "core/trace_file.hpp"
#include "core/units.hpp"
#include "report/html_report.hpp"
#include "report/material_table.hpp"
#include "rigs/load_rig.hpp"

#include <fmt/format.h>

#include <memory>
#include <set>

namespace twang::app {
namespace {

struct CalibrateCommand {
  std::string rig;
  std::vector<std::string> videos;
  std::vector<std::string> traces;
  std::string output;
  std::vector<std::string> columns;
  std::string time_column = "time_s";
  std::optional<double> dx_mm;
  std::string element = "hex8";
  bool no_validation = false;
  bool each_release = false;
  bool refine = false;
  std::optional<int> mode;
  TrackFlags track;
  InversionFlags inversion;
};

/// "trace.csv" for a single recording, "trace_2.csv" for the second of several.
std::string numbered(const char* stem,
                     const char* extension,
                     std::size_t index,
                     std::size_t count) {
  return count == 1 ? fmt::format("{}.{}", stem, extension)
                    : fmt::format("{}_{}.{}", stem, index + 1, extension);
}

CalibrationOptions options_of(const CalibrateCommand& command, const OutputFolder& output) {
  CalibrationOptions options;
  options.columns = command.columns;
  options.time_column = command.time_column;
  options.inversion = command.inversion.options();
  options.track = command.track.options();
  options.validate = !command.no_validation;
  options.each_release = command.each_release;
  options.refine = command.refine;
  if (command.mode) {
    if (*command.mode < 1)
      throw InputError(fmt::format("--mode is {}, must be 1 or more", *command.mode));
    options.mode = *command.mode - 1;
  }
  if (command.dx_mm) {
    if (!(*command.dx_mm > 0.0))
      throw InputError(fmt::format("--dx is {}, must be > 0 mm", *command.dx_mm));
    options.ladder.coarse_dx_m = *command.dx_mm * kMetresPerMillimetre;
  }
  options.ladder.coarse_element = element_kind_from(command.element);
  for (std::size_t i = 0; i < command.videos.size(); ++i) {
    options.overlays.push_back(output.file(numbered("overlay", "mp4", i, command.videos.size())));
  }
  return options;
}

std::string percent(double relative) { return rounded_text(100.0 * relative, 2) + " %"; }

/// What is said beside the table: distances a person asks for first.
std::string remarks(const Calibration& calibration) {
  const Material& material = calibration.material;
  std::string text = fmt::format(
      "f {} Hz, d {} 1/s; E / E_n {}\n",
      rounded_text(material.frequency_hz, 6),
      rounded_text(material.decay_per_s, 5),
      rounded_text(material.youngs_modulus_identified_pa / material.youngs_modulus_numerical_pa,
                   4));
  if (material.reported_youngs_modulus_pa) {
    text += fmt::format(
        "identified E is {} from the reported one\n",
        percent(material.youngs_modulus_identified_pa / *material.reported_youngs_modulus_pa -
                1.0));
  }
  if (material.refinement) {
    const Refinement& change = *material.refinement;
    text += fmt::format(
        "refined by the nonlinear simulation: E {:+.2f} ± {:.2f} %, b {:+.2f} ± {:.2f} %; rms {} "
        "(linear: {})\n",
        100.0 * change.modulus_change_rel,
        100.0 * change.modulus_sigma_rel,
        100.0 * change.damping_change_rel,
        100.0 * change.damping_sigma_rel,
        percent(change.residual_rel),
        percent(change.linear_residual_rel));
  }
  if (calibration.validation && calibration.validation->run.usable()) {
    const ValidationFigures& figures = material.validation;
    text += fmt::format("simulated over tracked: rms {}, frequency {}, decay {}\n",
                        percent(figures.rms_rel),
                        percent(figures.frequency_error_rel),
                        percent(figures.decay_error_rel));
  }
  return text;
}

void run(const CalibrateCommand& command) {
  if (command.videos.empty() == command.traces.empty()) {
    throw InputError("calibrate takes either films or --trace, must be one of the two");
  }
  RigNeeds needs;
  needs.mesh = true;
  needs.clamp = true;
  needs.film = !command.videos.empty();
  needs.observable = !command.videos.empty();
  const Rig rig = load_rig(command.rig, needs);
  OutputFolder output(command.output);
  CalibrationOptions options = options_of(command, output);
  const std::size_t num_films = command.videos.size();
  std::size_t num_tracked = 0;
  std::set<std::string> said;  // notes already on the terminal
  options.progress = terminal_progress([&] {
    return num_tracked >= num_films || num_films == 1
               ? std::string()
               : fmt::format("film {} of {}", num_tracked + 1, num_films);
  });
  options.on_tracked = [&](const std::filesystem::path& film, const TrackResult& result) {
    write_contact_sheet(
        output.file(numbered("contact_sheet", "png", num_tracked, num_films)), rig, film, result);
    ++num_tracked;
    say(film.string() + ": " + track_summary_text(rig, result));
    for (const Note& note : result.notes) said.insert(note.text);
  };
  const Calibration calibration =
      command.traces.empty()
          ? calibrate_from_films(rig, {command.videos.begin(), command.videos.end()}, options)
          : calibrate_from_traces(rig, {command.traces.begin(), command.traces.end()}, options);
  const std::size_t count = calibration.repeats.size();
  for (std::size_t i = 0; i < count; ++i) {
    write_trace_csv(output.file(numbered("trace", "csv", i, count)), calibration.repeats[i].trace);
  }
  write_file_atomically(output.file("modes.json"),
                        count == 1 ? modes_to_json(calibration.inversion)
                                   : modes_to_json(inversion_of_repeats(calibration)));
  write_material(output.file("material.json"), calibration.material);
  write_file_atomically(output.file("ladder.json"), ladder_json(calibration.ladder));
  write_file_atomically(output.file("table.csv"),
                        format_material_table({calibration.material}, TableFormat::Csv));
  write_file_atomically(output.file("report.html"), render_html(report_page(rig, calibration)));
  output.commit();
  for (const std::string& warning : calibration.warnings) {
    if (!said.contains(warning)) say("warning: " + warning);
  }
  for (const std::string& remark : calibration.remarks) {
    if (!said.contains(remark)) say("note: " + remark);
  }
  print_result(format_material_table({calibration.material}, TableFormat::Text) +
               remarks(calibration));
  say(fmt::format("report: {}", (std::filesystem::path(command.output) / "report.html").string()));
}

}  // namespace

void add_calibrate_command(CLI::App& cli) {
  CLI::App* sub = cli.add_subcommand("calibrate", "Film(s) or trace(s) in, a material out");
  auto command = std::make_shared<CalibrateCommand>();
  sub->add_option("rig", command->rig, "rig file (*.toml)")->required();
  sub->add_option("videos", command->videos, "film(s) of the rig; several are repeats");
  sub->add_option("--trace", command->traces, "trace (*.csv) in place of a film; may be repeated")
      ->allow_extra_args(false);
  sub->add_option("--out", command->output, "folder for the results")->required();
  sub->add_option("--column", command->columns, "column to invert; default: the observable")
      ->allow_extra_args(false);
  sub->add_option("--time-column", command->time_column, "column that holds the time [s]")
      ->capture_default_str();
  sub->add_option("--dx", command->dx_mm, "cell size of the coarse mesh [mm]; default: chosen");
  sub->add_option("--element", command->element, "of the coarse mesh: hex8 or hex8e")
      ->capture_default_str();
  sub->add_flag("--each-release",
                command->each_release,
                "every release of a recording is a repeat of its own");
  sub->add_option(
      "--mode",
      command->mode,
      "eigenmode of the part that the strongest sinusoid is, from 1; default: chosen by "
      "frequency ratios and the markers' motion");
  sub->add_flag("--refine",
                command->refine,
                "E and b by the nonlinear simulation of the coarse mesh: large motions");
  sub->add_flag(
      "--no-validation", command->no_validation, "do not simulate the coarse mesh over the trace");
  command->track.add_to(*sub);
  command->inversion.add_to(*sub);
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
