// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/json_values.hpp"
#include "app/terminal.hpp"
#include "calibrate/rheology.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/material_file.hpp"
#include "core/text.hpp"
#include "report/html_report.hpp"
#include "report/material_table.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <memory>

namespace twang::app {
namespace {

namespace fs = std::filesystem;

constexpr double kMegapascals = 1e-6;
constexpr double kMilliseconds = 1e3;

struct RheologyCommand {
  std::vector<std::string> folders;
  std::string output;
  RheologyOptions options;
};

std::vector<NamedMaterial> read_all(const std::vector<std::string>& folders) {
  std::vector<NamedMaterial> all;
  for (const std::string& folder : folders) {
    const fs::path path(folder);
    all.push_back({folder, read_material(fs::is_directory(path) ? path / "material.json" : path)});
  }
  return all;
}

nlohmann::ordered_json json_of(const std::optional<PowerLaw>& law) {
  if (!law) return nullptr;
  return {{"exponent", law->exponent},
          {"exponent_sigma", finite_or_null(law->exponent_sigma)},
          {"value", law->value},
          {"reference_hz", law->reference_hz},
          {"chi_square", law->chi_square},
          {"degrees_of_freedom", law->degrees_of_freedom}};
}

std::string json_text(const FrequencyDependence& found, const RheologyOptions& options) {
  nlohmann::ordered_json json = {{"format", "twang-rheology/1"},
                                 {"material", found.material},
                                 {"same_part", options.same_part},
                                 {"points", nlohmann::ordered_json::array()}};
  for (const FrequencyPoint& point : found.points) {
    json["points"].push_back(
        {{"calibration", point.name},
         {"frequency_hz", point.frequency_hz},
         {"youngs_modulus_identified_pa", point.youngs_modulus_pa},
         {"youngs_modulus_identified_sigma_pa", finite_or_null(point.youngs_modulus_sigma_pa)},
         {"compared_sigma_pa", finite_or_null(point.compared_sigma_pa)},
         {"tan_delta", point.tan_delta},
         {"tan_delta_sigma", finite_or_null(point.tan_delta_sigma)},
         {"damping_stiffness_b_s", point.damping_stiffness_b_s},
         {"damping_stiffness_b_sigma_s", finite_or_null(point.damping_stiffness_b_sigma_s)},
         {"eigenmode", point.eigenmode}});
  }
  json["modulus_power_law"] = json_of(found.modulus);
  json["tan_delta_power_law"] = json_of(found.tan_delta);
  json["damping_power_law"] = json_of(found.damping);
  json["modulus_changes"] = found.changes;
  json["tan_delta_of_exponent"] = finite_or_null(found.tan_delta_of_exponent);
  json["tan_delta_of_exponent_sigma"] = finite_or_null(found.tan_delta_of_exponent_sigma);
  json["sentences"] = found.sentences;
  json["notes"] = found.notes;
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

/// A name as a cell of RFC 4180 CSV.
std::string quoted(const std::string& text) {
  std::string cell(1, '"');
  for (const char c : text) cell.append(c == '"' ? 2 : 1, c);
  cell.push_back('"');
  return cell;
}

std::string csv_text(const FrequencyDependence& found) {
  std::string text =
      "calibration,frequency_hz,youngs_modulus_identified_pa,youngs_modulus_identified_sigma_pa,"
      "compared_sigma_pa,tan_delta,tan_delta_sigma,damping_stiffness_b_s,"
      "damping_stiffness_b_sigma_s,eigenmode\n";
  for (const FrequencyPoint& point : found.points) {
    text += quoted(point.name);
    for (const double value : {point.frequency_hz,
                               point.youngs_modulus_pa,
                               point.youngs_modulus_sigma_pa,
                               point.compared_sigma_pa,
                               point.tan_delta,
                               point.tan_delta_sigma,
                               point.damping_stiffness_b_s,
                               point.damping_stiffness_b_sigma_s}) {
      text.push_back(',');
      text += exact_text(value);
    }
    text += fmt::format(",{}\n", point.eigenmode);
  }
  return text;
}

TextTable table_of(const FrequencyDependence& found) {
  TextTable table;
  table.head = {"f [Hz]", "E [MPa]", "tan delta", "b [ms]", "eigenmode", "calibration"};
  for (const FrequencyPoint& point : found.points) {
    table.rows.push_back({rounded_text(point.frequency_hz, 4),
                          text_with_sigma(point.youngs_modulus_pa * kMegapascals,
                                          point.youngs_modulus_sigma_pa * kMegapascals),
                          text_with_sigma(point.tan_delta, point.tan_delta_sigma),
                          text_with_sigma(point.damping_stiffness_b_s * kMilliseconds,
                                          point.damping_stiffness_b_sigma_s * kMilliseconds),
                          std::to_string(point.eigenmode),
                          point.name});
  }
  return table;
}

/// Columns of equal width, as wide as a terminal shows their UTF-8.
std::string terminal_text(const FrequencyDependence& found) {
  const TextTable table = table_of(found);
  const auto row_text = [](const std::vector<std::string>& cells) {
    return fmt::format("{:>9} {:>18} {:>18} {:>18} {:>10}  {}\n",
                       cells[0],
                       cells[1],
                       cells[2],
                       cells[3],
                       cells[4],
                       cells[5]);
  };
  std::string text = found.material + "\n" + row_text(table.head);
  for (const auto& row : table.rows) text += row_text(row);
  text += "\n";
  for (const std::string& sentence : found.sentences) text += sentence + "\n";
  return text;
}

/// One quantity over frequency with its error bars and its power law.
Chart chart_of(const FrequencyDependence& found,
               const char* label,
               double unit,
               double FrequencyPoint::*value,
               double FrequencyPoint::*sigma,
               const std::optional<PowerLaw>& law) {
  Chart chart;
  chart.x_label = "frequency [Hz]";
  chart.y_label = label;
  chart.log_x = true;
  ChartSeries measured{"calibrations", {}, {}, ChartSeries::Style::Points};
  for (const FrequencyPoint& point : found.points) {
    measured.x.push_back(point.frequency_hz);
    measured.y.push_back(point.*value * unit);
    measured.y_sigma.push_back(point.*sigma * unit);
  }
  chart.series.push_back(std::move(measured));
  if (!law) return chart;
  ChartSeries line{
      fmt::format("~ f^{}", rounded_text(law->exponent, 3)), {}, {}, ChartSeries::Style::Dashed};
  constexpr int kPieces = 40;
  const double lowest = found.points.front().frequency_hz;
  const double highest = found.points.back().frequency_hz;
  for (int i = 0; i <= kPieces; ++i) {
    const double f = lowest * std::pow(highest / lowest, static_cast<double>(i) / kPieces);
    line.x.push_back(f);
    line.y.push_back(law->at(f) * unit);
  }
  chart.series.push_back(std::move(line));
  return chart;
}

ReportContent page_of(const FrequencyDependence& found, const RheologyOptions& options) {
  ReportContent page;
  page.title = found.material + " over frequency";
  page.headline = found.sentences.front();
  page.warnings = found.notes;
  ReportSection modulus;
  modulus.title = "Young's modulus";
  modulus.paragraphs = {fmt::format(
      "Bars are one sigma of what differs between the calibrations: statistics, repeats, mesh{}; "
      "the table has the whole budget.",
      options.same_part ? "" : " and dimensions")};
  modulus.charts.push_back(chart_of(found,
                                    "E [MPa]",
                                    kMegapascals,
                                    &FrequencyPoint::youngs_modulus_pa,
                                    &FrequencyPoint::compared_sigma_pa,
                                    found.modulus));
  modulus.tables.push_back(table_of(found));
  ReportSection loss;
  loss.title = "Damping";
  loss.paragraphs.assign(found.sentences.begin() + 1, found.sentences.end());
  loss.charts.push_back(chart_of(found,
                                 "tan delta",
                                 1.0,
                                 &FrequencyPoint::tan_delta,
                                 &FrequencyPoint::tan_delta_sigma,
                                 found.tan_delta));
  loss.charts.push_back(chart_of(found,
                                 "b [ms]",
                                 kMilliseconds,
                                 &FrequencyPoint::damping_stiffness_b_s,
                                 &FrequencyPoint::damping_stiffness_b_sigma_s,
                                 found.damping));
  page.sections = {std::move(modulus), std::move(loss)};
  return page;
}

void run(const RheologyCommand& command) {
  const FrequencyDependence found =
      frequency_dependence(read_all(command.folders), command.options);
  OutputFolder output(command.output);
  write_file_atomically(output.file("rheology.json"), json_text(found, command.options));
  write_file_atomically(output.file("rheology.csv"), csv_text(found));
  write_file_atomically(output.file("rheology.html"), render_html(page_of(found, command.options)));
  output.commit();
  for (const std::string& note : found.notes) say("warning: " + note);
  print_result(terminal_text(found));
  say(fmt::format("report: {}", (fs::path(command.output) / "rheology.html").string()));
}

}  // namespace

void add_rheology_command(CLI::App& cli) {
  CLI::App* sub = cli.add_subcommand(
      "rheology", "E and tan delta of one material over frequency, from several calibrations");
  auto command = std::make_shared<RheologyCommand>();
  sub->add_option(
         "calibrations",
         command->folders,
         "folders of calibrations of one material at different frequencies (rigs, weights, "
         "eigenmodes), or their material.json")
      ->required();
  sub->add_option("--out", command->output, "folder for table and plot")->required();
  sub->add_flag("--same-part",
                command->options.same_part,
                "the rigs are one piece with other weights or clamps: its dimensions err alike");
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
