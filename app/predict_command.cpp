// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/json_values.hpp"
#include "app/options.hpp"
#include "app/terminal.hpp"
#include "calibrate/predict.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/material_file.hpp"
#include "core/text.hpp"
#include "report/html_report.hpp"
#include "report/material_table.hpp"
#include "rigs/load_rig.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <memory>

namespace twang::app {
namespace {

namespace fs = std::filesystem;

struct PredictCommand {
  std::string rig;
  std::string material;
  std::string trace;
  std::string output;
  std::vector<std::string> columns;
  std::string time_column = "time_s";
  std::optional<int> mode;
  InversionFlags inversion;
};

nlohmann::ordered_json json_of(const PredictedMotion& motion) {
  return {{"frequency_hz", motion.frequency_hz},
          {"frequency_sigma_hz", finite_or_null(motion.frequency_sigma_hz)},
          {"decay_per_s", motion.decay_per_s},
          {"decay_sigma_per_s", finite_or_null(motion.decay_sigma_per_s)}};
}

std::string json_text(const Rig& rig, const Material& material, const Prediction& prediction) {
  const DampedSinusoid& tracked = prediction.tracked;
  const nlohmann::ordered_json json = {
      {"format", "twang-prediction/1"},
      {"rig", rig.name},
      {"rig_sha256", rig.sha256},
      {"material", material.material},
      {"material_frequency_hz", material.frequency_hz},
      {"predicted", json_of(prediction.same_b)},
      {"predicted_with_same_tan_delta", json_of(prediction.same_tan_delta)},
      {"tracked",
       {{"frequency_hz", tracked.frequency_hz},
        {"frequency_sigma_hz", finite_or_null(tracked.frequency_sigma_hz)},
        {"decay_per_s", tracked.decay_per_s},
        {"decay_sigma_per_s", finite_or_null(tracked.decay_sigma_per_s)},
        {"damping_stiffness_b_s", tracked.damping_stiffness_b_s()},
        {"tan_delta", 2.0 * tracked.damping_ratio()}}},
      {"frequency_error_rel", prediction.frequency_error_rel},
      {"decay_error_rel", prediction.decay_error_rel},
      {"decay_error_rel_with_same_tan_delta", prediction.tan_delta_error_rel},
      {"tracked_over_material_b", prediction.damping_ratio_of_b},
      {"damping_exponent", finite_or_null(prediction.damping_exponent)},
      {"eigenmode", prediction.mode.mode + 1},
      {"eigenmode_reason", prediction.mode.reason},
      {"gravity_factor_of_lambda", prediction.prestress_factor},
      {"mesh_relative_sigma_of_lambda", finite_or_null(prediction.mesh_relative_sigma)},
      {"sentences", prediction.sentences},
      {"warnings", prediction.warnings},
      {"notes", prediction.remarks}};
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

Chart chart_of(const Prediction& prediction) {
  Chart chart;
  chart.x_label = "time [s]";
  chart.y_label = prediction.column + ", offset removed";
  constexpr double kPeriods = 10.0;
  const InversionResult& inversion = prediction.inversion;
  const double end_s = std::min(
      inversion.time_end_s, inversion.time_origin_s + kPeriods / prediction.tracked.frequency_hz);
  ChartSeries tracked{"tracked", {}, {}, ChartSeries::Style::Points};
  const Channel& channel = *prediction.trace.find(prediction.column);
  for (std::size_t i = 0; i < prediction.trace.num_samples(); ++i) {
    const double time = prediction.trace.time_s[i];
    if (time < inversion.time_origin_s || time > end_s) continue;
    tracked.x.push_back(time);
    tracked.y.push_back(channel.values[i] - inversion.offsets[0] -
                        inversion.drifts_per_s[0] * (time - inversion.time_origin_s));
  }
  std::vector<double> fine;
  constexpr int kPieces = 600;
  for (int i = 0; i <= kPieces; ++i) {
    fine.push_back(inversion.time_origin_s + (end_s - inversion.time_origin_s) * i / kPieces);
  }
  chart.series.push_back(std::move(tracked));
  chart.series.push_back({"predicted, same b",
                          fine,
                          motion_from_tracked_start(prediction, prediction.same_b, fine),
                          ChartSeries::Style::Line});
  chart.series.push_back({"predicted, same tan delta",
                          fine,
                          motion_from_tracked_start(prediction, prediction.same_tan_delta, fine),
                          ChartSeries::Style::Dashed});
  return chart;
}

ReportContent page_of(const Rig& rig, const Material& material, const Prediction& prediction) {
  ReportContent page;
  page.title = rig.name + ", predicted";
  page.headline = prediction.sentences.front();
  page.warnings = prediction.warnings;
  page.remarks = prediction.remarks;
  const auto signed_percent = [](double relative) {
    return fmt::format("{:+.1f} %", 100.0 * relative);
  };
  page.key_figures.head = {"quantity", "value", "meaning"};
  page.key_figures.rows = {
      {"f, predicted",
       text_with_sigma(prediction.same_b.frequency_hz, prediction.same_b.frequency_sigma_hz) +
           " Hz",
       "off the tracked by " + signed_percent(prediction.frequency_error_rel)},
      {"d, predicted",
       text_with_sigma(prediction.same_b.decay_per_s, prediction.same_b.decay_sigma_per_s) + " 1/s",
       "off the tracked by " + signed_percent(prediction.decay_error_rel)},
      {"f, tracked",
       text_with_sigma(prediction.tracked.frequency_hz, prediction.tracked.frequency_sigma_hz) +
           " Hz",
       "of the strongest sinusoid"},
      {"d, tracked",
       text_with_sigma(prediction.tracked.decay_per_s, prediction.tracked.decay_sigma_per_s) +
           " 1/s",
       "decay, exp(-d t)"}};
  ReportSection section;
  section.title = "Predicted and tracked";
  section.paragraphs = prediction.sentences;
  section.paragraphs.push_back(fmt::format(
      "Material \"{}\" as calibrated at {} Hz; eigenmodes of this rig in the limit of fine "
      "meshes{}. "
      "The curves begin where the tracked motion does; no time shift is fitted.",
      material.material,
      rounded_text(material.frequency_hz, 4),
      rig.gravity_m_s2 ? fmt::format(", about the shape in which gravity holds it (which changes "
                                     "the eigenvalue by the factor {})",
                                     rounded_text(prediction.prestress_factor, 4))
                       : ""));
  section.charts.push_back(chart_of(prediction));
  page.sections.push_back(std::move(section));
  return page;
}

void run(const PredictCommand& command) {
  RigNeeds needs;
  needs.mesh = true;
  needs.clamp = true;
  const Rig rig = load_rig(command.rig, needs);
  const fs::path file(command.material);
  const Material material = read_material(fs::is_directory(file) ? file / "material.json" : file);
  PredictionOptions options;
  options.columns = command.columns;
  options.time_column = command.time_column;
  options.inversion = command.inversion.options();
  if (command.mode) {
    if (*command.mode < 1) {
      throw InputError(fmt::format("--mode is {}, must be 1 or more", *command.mode));
    }
    options.mode = *command.mode - 1;
  }
  options.progress = terminal_progress();
  const Prediction prediction = predict_motion(rig, material, command.trace, options);
  OutputFolder output(command.output);
  write_file_atomically(output.file("prediction.json"), json_text(rig, material, prediction));
  write_file_atomically(output.file("prediction.html"),
                        render_html(page_of(rig, material, prediction)));
  output.commit();
  for (const std::string& warning : prediction.warnings) say("warning: " + warning);
  for (const std::string& remark : prediction.remarks) say("note: " + remark);
  std::string text;
  for (const std::string& sentence : prediction.sentences) text += sentence + "\n";
  print_result(text);
  say(fmt::format("report: {}", (fs::path(command.output) / "prediction.html").string()));
}

}  // namespace

void add_predict_command(CLI::App& cli) {
  CLI::App* sub = cli.add_subcommand(
      "predict", "Frequency and decay of another rig from a calibrated material, beside its trace");
  auto command = std::make_shared<PredictCommand>();
  sub->add_option("rig", command->rig, "rig file (*.toml) of the other rig, its weights included")
      ->required();
  sub->add_option("--material", command->material, "folder of a calibration, or its material.json")
      ->required();
  sub->add_option("--trace", command->trace, "trace (*.csv) of the other rig")->required();
  sub->add_option("--out", command->output, "folder for the results")->required();
  sub->add_option("--column", command->columns, "column to invert; default: the observable")
      ->allow_extra_args(false);
  sub->add_option("--time-column", command->time_column, "column that holds the time [s]")
      ->capture_default_str();
  sub->add_option(
      "--mode", command->mode, "eigenmode that the strongest sinusoid is, from 1; default: chosen");
  command->inversion.add_to(*sub);
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
