// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/options.hpp"
#include "app/terminal.hpp"
#include "calibrate/outline_recorder.hpp"
#include "calibrate/validate_material.hpp"
#include "capture/outline_overlay.hpp"
#include "capture/track_markers.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/material_file.hpp"
#include "core/text.hpp"
#include "core/trace_file.hpp"
#include "core/units.hpp"
#include "report/html_report.hpp"
#include "rigs/load_rig.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

namespace twang::app {
namespace {

struct ValidateCommand {
  std::string rig;
  std::string material;
  std::string trace;
  std::string column;
  std::string time_column = "time_s";
  std::optional<double> dx_mm;
  std::string element;
  std::string modulus = "numerical";
  std::string out;
  std::string json;
  std::string video;
  std::string overlay;
  InversionFlags inversion;
};

MaterialValidationOptions options_of(const ValidateCommand& command) {
  MaterialValidationOptions options;
  options.column = command.column;
  options.inversion = command.inversion.options();
  options.progress = terminal_progress();
  if (command.modulus != "numerical" && command.modulus != "identified")
    throw InputError(
        fmt::format("--modulus is '{}', must be numerical or identified", command.modulus));
  options.identified = command.modulus == "identified";
  if (command.dx_mm) {
    if (!(*command.dx_mm > 0.0))
      throw InputError(fmt::format("--dx is {}, must be > 0 mm", *command.dx_mm));
    options.dx_m = *command.dx_mm * kMetresPerMillimetre;
  }
  if (!command.element.empty()) options.element = element_kind_from(command.element);
  return options;
}

std::string percent(double relative) {
  if (!std::isfinite(relative)) return "not found";
  return rounded_text(100.0 * relative, 3) + " %";
}

TextTable table_of(const MaterialValidation& result) {
  TextTable table;
  table.head = {"simulated over tracked", "value", "bound", ""};
  for (const FigureOfMerit& figure : result.figures())
    table.rows.push_back({figure.name,
                          percent(figure.value),
                          percent(figure.bound),
                          figure.met() ? "met" : "not met"});
  table.rows.push_back({"phase drift", rounded_text(result.phase_drift_rad, 3) + " rad", "", ""});
  return table;
}

std::string text_of(const TextTable& table) {
  std::string text;
  for (const auto& row : table.rows)
    text += fmt::format("{:<12} {:>12}  {}{}\n",
                        row[0],
                        row[1],
                        row[2].empty() ? "" : "bound " + row[2] + ", ",
                        row[3]);
  return text;
}

ReportContent page_of(const Rig& rig, const MaterialValidation& result) {
  const Validation& v = result.validation;
  ReportSection section;
  section.title = "Simulated over tracked";
  section.paragraphs.push_back(fmt::format(
      "A mesh of {} {} elements of {} mm starts where the tracked motion began and is let go. No "
      "time shift is fitted, the offset is removed.",
      result.num_elements,
      to_string(result.element),
      rounded_text(result.dx_m * kMillimetresPerMetre, 4)));
  Chart chart;
  chart.x_label = "time [s]";
  chart.y_label = result.column;
  chart.series = {{"tracked", v.time_s, v.tracked, ChartSeries::Style::Points},
                  {"simulated", v.fine_time_s, v.fine_simulated, ChartSeries::Style::Line}};
  Chart difference;
  difference.x_label = "time [s]";
  difference.y_label = "simulated minus tracked [" + v.unit + "]";
  std::vector<double> residual;
  for (std::size_t i = 0; i < v.time_s.size(); ++i)
    residual.push_back(v.simulated[i] - v.tracked[i]);
  difference.series = {{"difference", v.time_s, residual, ChartSeries::Style::Points}};
  section.charts = {std::move(chart), std::move(difference)};
  ReportContent content;
  content.title = rig.name;
  content.headline = fmt::format("simulated over tracked: rms {}, frequency {}, decay {}",
                                 percent(v.figures.rms_rel),
                                 percent(v.figures.frequency_error_rel),
                                 percent(v.figures.decay_error_rel));
  content.key_figures = table_of(result);
  content.sections = {std::move(section)};
  return content;
}

Trace samples_of(const MaterialValidation& result) {
  const Validation& v = result.validation;
  Trace trace;
  trace.time_s = v.time_s;
  trace.channels = {{"tracked_" + v.unit, v.tracked}, {"simulated_" + v.unit, v.simulated}};
  return trace;
}

constexpr double kOverlayFps = 30.0;

/// The film is tracked again, for how it shows the rig's plane; its times are the trace's.
TrackResult tracked_again(const ValidateCommand& command, const Rig& rig, const Trace& trace) {
  TrackOptions options;
  options.progress = terminal_progress();
  TrackResult film = track_markers(rig, command.video, options);
  if (film.trace.num_samples() != trace.num_samples())
    throw InputError(fmt::format(
        "{}: has {} rows, must have one for each of the {} frames of {} to be drawn over it",
        command.trace,
        trace.num_samples(),
        film.trace.num_samples(),
        command.video));
  return film;
}

/// Validates, and draws the simulated outline over the film if that is wanted.
MaterialValidation validate(const ValidateCommand& command,
                            const Rig& rig,
                            const Material& material,
                            const Trace& trace) {
  MaterialValidationOptions options = options_of(command);
  if (command.overlay.empty()) return validate_material(rig, material, trace, options);
  const TrackResult film = tracked_again(command, rig, trace);
  OutlineRecorder recorder(*rig.camera, trace.time_s);
  options.on_state = [&](const HexMesh& mesh, double time_s, const Eigen::VectorXd& u) {
    recorder.see(mesh, time_s, u);
  };
  MaterialValidation result = validate_material(rig, material, trace, options);
  BodyDrawing drawing = recorder.drawing();
  drawing.map = film.map;
  drawing.name = "simulated";
  write_outline_overlay(command.video, command.overlay, drawing, kOverlayFps, terminal_progress());
  return result;
}

void run(const ValidateCommand& command) {
  if (command.overlay.empty() != command.video.empty())
    throw InputError("--overlay FILM_TO_WRITE and --video FILM must come together");
  std::error_code ignored;
  for (const std::string& read : {command.rig, command.material, command.trace, command.video})
    if (std::filesystem::equivalent(command.overlay, read, ignored))
      throw InputError(
          fmt::format("{} would be written over by the overlay, must be another file", read));
  RigNeeds needs;
  needs.mesh = true;
  needs.clamp = true;
  needs.film = !command.overlay.empty();
  const Rig rig = load_rig(command.rig, needs);
  const Material material = read_material(command.material);
  const Trace trace = read_trace_csv(command.trace, command.time_column);
  // What cannot be written is said before the long work; the overlay may go into the folder.
  std::optional<OutputFolder> output;
  if (!command.out.empty()) output.emplace(command.out);
  if (!command.overlay.empty()) AtomicFile writable(command.overlay);
  const MaterialValidation result = validate(command, rig, material, trace);
  const std::string json = validation_to_json(result);
  if (output) {
    write_file_atomically(output->file("validation.json"), json);
    write_trace_csv(output->file("validation.csv"), samples_of(result));
    write_file_atomically(output->file("validation.html"), render_html(page_of(rig, result)));
    output->commit();
  }
  if (!command.json.empty()) write_json(command.json, json);
  if (command.json != "-") print_result(text_of(table_of(result)));
}

}  // namespace

void add_validate_command(CLI::App& cli) {
  CLI::App* sub = cli.add_subcommand(
      "validate", "A material against a trace: simulated from the tracked start and compared");
  auto command = std::make_shared<ValidateCommand>();
  sub->add_option("rig", command->rig, "rig file (*.toml)")->required();
  sub->add_option("--material", command->material, "material file (material.json)")->required();
  sub->add_option("--trace", command->trace, "trace (*.csv) of the rig's motion")->required();
  sub->add_option("--column", command->column, "column compared; default: the observable");
  sub->add_option("--time-column", command->time_column, "column that holds the time [s]")
      ->capture_default_str();
  sub->add_option("--modulus", command->modulus, "numerical or identified")->capture_default_str();
  sub->add_option("--dx", command->dx_mm, "cell size [mm]; default: that of the numerical modulus");
  sub->add_option("--element", command->element, "hex8, hex20 or hex8e; default: the same");
  sub->add_option("--out", command->out, "folder for validation.json, .csv and .html");
  sub->add_option(
      "--json", command->json, "machine-readable result: a file, or - for standard output");
  sub->add_option("--video", command->video, "film of which the trace is, for --overlay");
  sub->add_option(
      "--overlay", command->overlay, "film to write: the simulated outline over that one");
  command->inversion.add_to(*sub);
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
