// SPDX-License-Identifier: GPL-3.0-or-later
#include "report/material_table.hpp"

#include "core/error.hpp"
#include "core/material_file.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "report/detail/table_markup.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <utility>

namespace twang {
namespace {

using detail::Cells;
using detail::PlainTable;

constexpr double kMegapascalsPerPascal = 1e-6;
constexpr double kMillisecondsPerSecond = 1e3;
constexpr int kDigitsWithoutSigma = 4;
constexpr int kLossFactorDigits = 3;
constexpr const char* kUnknown = "–";

std::string number_text(double value, int digits = kDigitsWithoutSigma) {
  return std::isfinite(value) ? rounded_text(value, digits) : kUnknown;
}

std::string mesh_text(const Material& material) {
  if (material.numerical_element.empty()) return kUnknown;
  return fmt::format("{}, {} mm, {} elements",
                     material.numerical_element,
                     exact_text(material.numerical_dx_mm),
                     material.numerical_elements);
}

PlainTable readable_table(const std::vector<Material>& materials) {
  PlainTable table;
  table.head = {"Material",
                "Reported E [MPa]",
                "Identified E [MPa]",
                "Numerical Eₙ [MPa]",
                "Mesh of Eₙ",
                "Damping b [ms]",
                "f [Hz]",
                "tan δ"};
  table.is_number = {false, true, true, true, false, true, true, true};
  for (const Material& material : materials) {
    table.rows.push_back(
        {material.material,
         number_text(material.reported_youngs_modulus_pa.value_or(kNaN) * kMegapascalsPerPascal),
         text_with_sigma(material.youngs_modulus_identified_pa * kMegapascalsPerPascal,
                         material.youngs_modulus_identified_sigma_pa * kMegapascalsPerPascal),
         number_text(material.youngs_modulus_numerical_pa * kMegapascalsPerPascal),
         mesh_text(material),
         text_with_sigma(material.damping_stiffness_b_s * kMillisecondsPerSecond,
                         material.damping_stiffness_b_sigma_s * kMillisecondsPerSecond),
         text_with_sigma(material.frequency_hz, material.frequency_sigma_hz),
         number_text(material.tan_delta, kLossFactorDigits)});
  }
  return table;
}

/// Every scalar of a calibration under its key in material.json, nested keys joined by a dot.
std::vector<std::pair<std::string, std::string>> exact_fields(const Material& material) {
  const UncertaintyBudget& budget = material.uncertainty;
  const ValidationFigures& validation = material.validation;
  return {
      {"material", material.material},
      {"reported_youngs_modulus_pa",
       exact_text(material.reported_youngs_modulus_pa.value_or(kNaN))},
      {"youngs_modulus_identified_pa", exact_text(material.youngs_modulus_identified_pa)},
      {"youngs_modulus_identified_sigma_pa",
       exact_text(material.youngs_modulus_identified_sigma_pa)},
      {"youngs_modulus_numerical_pa", exact_text(material.youngs_modulus_numerical_pa)},
      {"numerical_element", material.numerical_element},
      {"numerical_dx_mm", exact_text(material.numerical_dx_mm)},
      {"numerical_elements", fmt::format("{}", material.numerical_elements)},
      {"damping_stiffness_b_s", exact_text(material.damping_stiffness_b_s)},
      {"damping_stiffness_b_sigma_s", exact_text(material.damping_stiffness_b_sigma_s)},
      {"damping_mass_a_per_s", exact_text(material.damping_mass_a_per_s)},
      {"poissons_ratio", exact_text(material.poissons_ratio)},
      {"density_kg_m3", exact_text(material.density_kg_m3)},
      {"frequency_hz", exact_text(material.frequency_hz)},
      {"frequency_sigma_hz", exact_text(material.frequency_sigma_hz)},
      {"decay_per_s", exact_text(material.decay_per_s)},
      {"decay_sigma_per_s", exact_text(material.decay_sigma_per_s)},
      {"lambda_per_s2", exact_text(material.lambda_per_s2)},
      {"tan_delta", exact_text(material.tan_delta)},
      {"amplitude_range.min", exact_text(material.amplitude_range[0])},
      {"amplitude_range.max", exact_text(material.amplitude_range[1])},
      {"amplitude_unit", material.amplitude_unit},
      {"uncertainty.statistical", exact_text(budget.statistical)},
      {"uncertainty.repeats", exact_text(budget.repeats)},
      {"uncertainty.mesh", exact_text(budget.mesh)},
      {"uncertainty.clock", exact_text(budget.clock)},
      {"uncertainty.dimension", exact_text(budget.dimension)},
      {"uncertainty.density", exact_text(budget.density)},
      {"uncertainty.poissons_ratio", exact_text(budget.poissons_ratio)},
      {"validation.rms_rel", exact_text(validation.rms_rel)},
      {"validation.frequency_error_rel", exact_text(validation.frequency_error_rel)},
      {"validation.decay_error_rel", exact_text(validation.decay_error_rel)},
      {"rig_sha256", material.rig_sha256},
      {"twang_version", material.provenance.twang_version},
      {"date", material.provenance.date},
  };
}

std::string csv_table(const std::vector<Material>& materials) {
  Cells head;
  for (const auto& [key, value] : exact_fields(Material{})) head.push_back(key);
  std::string text = detail::csv_line(head);
  for (const Material& material : materials) {
    Cells cells;
    for (const auto& [key, value] : exact_fields(material)) cells.push_back(value);
    text += detail::csv_line(cells);
  }
  return text;
}

std::string json_table(const std::vector<Material>& materials) {
  nlohmann::ordered_json array = nlohmann::ordered_json::array();
  for (const Material& material : materials) {
    array.push_back(nlohmann::ordered_json::parse(material_to_json(material)));
  }
  return array.dump(2) + "\n";
}

}  // namespace

TableFormat table_format_from(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, TableFormat>, 5> kNames = {
      {{"text", TableFormat::Text},
       {"csv", TableFormat::Csv},
       {"markdown", TableFormat::Markdown},
       {"latex", TableFormat::Latex},
       {"json", TableFormat::Json}}};
  for (const auto& [known, format] : kNames) {
    if (name == known) return format;
  }
  throw InputError(
      fmt::format("table format is \"{}\", must be one of text, csv, markdown, latex, json", name));
}

std::string format_material_table(const std::vector<Material>& materials, TableFormat format) {
  switch (format) {
    case TableFormat::Csv:
      return csv_table(materials);
    case TableFormat::Json:
      return json_table(materials);
    case TableFormat::Markdown:
      return detail::markdown_table(readable_table(materials));
    case TableFormat::Latex:
      return detail::latex_table(readable_table(materials));
    case TableFormat::Text:
      break;
  }
  return detail::text_table(readable_table(materials));
}

}  // namespace twang
