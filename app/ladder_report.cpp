// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/ladder_report.hpp"

#include "core/constants.hpp"
#include "core/units.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace twang::app {
namespace {

constexpr Eigen::Index kShown = 10;  // modes in a table

std::vector<double> frequencies(const Eigen::VectorXd& hz) {
  return {hz.data(), hz.data() + hz.size()};
}

std::vector<double> frequencies(const Eigenmodes& modes) {
  std::vector<double> hz;
  for (int i = 0; i < modes.count(); ++i) hz.push_back(modes.natural_frequency_hz(i));
  return hz;
}

nlohmann::ordered_json to_json(const CoarseCandidate& candidate) {
  return {{"element", std::string(to_string(candidate.element))},
          {"dx_mm", candidate.dx_m * kMillimetresPerMetre},
          {"elements", candidate.num_elements},
          {"natural_frequency_hz", frequencies(candidate.natural_frequency_hz)},
          {"mode_difference", candidate.comparison.difference_by_mode},
          {"mode_hausdorff", candidate.comparison.hausdorff_by_mode},
          {"mixed_cells", candidate.num_mixed_cells},
          {"passes", candidate.passes},
          {"rescale", candidate.rescale},
          {"mean_frequency_error_before", candidate.mean_frequency_error_before},
          {"mean_frequency_error_after", candidate.mean_frequency_error_after}};
}

/// Micro-hertz are of a handy size where E = 1 Pa.
struct FrequencyUnit {
  double per_hz = 1.0;
  const char* name = "Hz";
};
FrequencyUnit unit_of(const MeshLadder& ladder) {
  return ladder.stated_moduli ? FrequencyUnit{} : FrequencyUnit{1e6, "1e-6 Hz"};
}

std::string reference_text(const MeshLadder& ladder) {
  const FrequencyUnit unit = unit_of(ladder);
  std::string text =
      fmt::format("reference ({})\n", ladder.stated_moduli ? "at the moduli stated" : "E = 1 Pa");
  text += fmt::format("{:>8} {:>10} {:>10} {:>16} {:>10}\n",
                      "element",
                      "dx [mm]",
                      "elements",
                      fmt::format("f1 [{}]", unit.name),
                      "time [s]");
  for (const MeshRung& rung : ladder.reference) {
    text += fmt::format("{:>8} {:10.4g} {:10d} {:16.6g} {:10.2f}\n",
                        to_string(rung.mesh.kind),
                        rung.mesh.requested_dx_m * kMillimetresPerMetre,
                        rung.mesh.num_elements(),
                        rung.modes.natural_frequency_hz(0) * unit.per_hz,
                        rung.seconds);
  }
  const bool alone = ladder.limit.order == 0.0;
  return text + fmt::format("{:>8} {:10} {:10} {:16.6g}   {}, sigma of E {:.2g} %\n\n",
                            "limit",
                            "",
                            "",
                            std::sqrt(ladder.limit.lambda_per_s2) / kTwoPi * unit.per_hz,
                            alone
                                ? std::string("the finest mesh itself")
                                : fmt::format("{} of order {:.2f}",
                                              ladder.limit.order_observed ? "observed" : "assumed",
                                              ladder.limit.order),
                            100.0 * ladder.limit.relative_sigma);
}

std::string candidates_text(const MeshLadder& ladder) {
  const FrequencyUnit unit = unit_of(ladder);
  std::string text =
      fmt::format("coarse candidates ({})\n", to_string(ladder.candidates.front().element));
  text += fmt::format("{:>10} {:>10} {:>16} {:>12} {:>12} {:>9} {:>9}\n",
                      "dx [mm]",
                      "elements",
                      fmt::format("f1 [{}]", unit.name),
                      "shapes [%]",
                      "Hausd. [%]",
                      "f err [%]",
                      "after [%]");
  for (const CoarseCandidate& candidate : ladder.candidates) {
    text += fmt::format("{:10.4g} {:10d} {:16.6g} {:12.2f} {:12.2f} {:9.1f} {:9.1f} {}{}\n",
                        candidate.dx_m * kMillimetresPerMetre,
                        candidate.num_elements,
                        candidate.natural_frequency_hz[0] * unit.per_hz,
                        100.0 * candidate.comparison.max_difference,
                        100.0 * candidate.comparison.hausdorff,
                        100.0 * candidate.mean_frequency_error_before,
                        100.0 * candidate.mean_frequency_error_after,
                        candidate.passes ? "passes" : "",
                        candidate.num_mixed_cells > 0
                            ? fmt::format("{} cells mix materials", candidate.num_mixed_cells)
                            : std::string());
  }
  return text;
}

/// The frequencies of the reference beside those of the coarse meshes, before and after eq. (15).
std::string frequencies_text(const MeshLadder& ladder) {
  const FrequencyUnit unit = unit_of(ladder);
  const Eigenmodes& truth = ladder.reference.back().modes;
  std::vector<const CoarseCandidate*> columns = {&ladder.chosen()};
  if (ladder.beside) columns.push_back(&*ladder.beside);
  std::string text =
      fmt::format("\nfrequencies at {:.4g} mm [{}], error before -> after\n{:>4} {:>12}",
                  ladder.coarse.mesh.requested_dx_m * kMillimetresPerMetre,
                  unit.name,
                  "mode",
                  "reference");
  for (const CoarseCandidate* column : columns)
    text += fmt::format(" {:>34}", to_string(column->element));
  text += "\n";
  auto count = static_cast<Eigen::Index>(truth.count());
  for (const CoarseCandidate* column : columns)
    count = std::min({count, column->natural_frequency_hz.size(), Eigen::Index{kShown}});
  for (Eigen::Index i = 0; i < count; ++i) {
    const double f = truth.natural_frequency_hz(static_cast<int>(i));
    text += fmt::format("{:4d} {:12.6g}", i + 1, f * unit.per_hz);
    for (const CoarseCandidate* column : columns) {
      const double coarse = column->natural_frequency_hz[i];
      text += fmt::format(" {:12.6g}   {:+6.1f} % -> {:+6.1f} %",
                          coarse * unit.per_hz,
                          100.0 * (coarse / f - 1.0),
                          100.0 * (column->rescale * coarse / f - 1.0));
    }
    text += "\n";
  }
  text += fmt::format("{:>4} {:12}", "mean", "");
  for (const CoarseCandidate* column : columns) {
    text += fmt::format(" {:12}   {:6.1f} % -> {:6.1f} %",
                        "",
                        100.0 * column->mean_frequency_error_before,
                        100.0 * column->mean_frequency_error_after);
  }
  return text + "\n";
}

}  // namespace

std::string ladder_json(const MeshLadder& ladder) {
  nlohmann::ordered_json json = {{"reference", nlohmann::ordered_json::array()},
                                 {"candidates", nlohmann::ordered_json::array()}};
  for (const MeshRung& rung : ladder.reference) {
    json["reference"].push_back({{"element", std::string(to_string(rung.mesh.kind))},
                                 {"dx_mm", rung.mesh.requested_dx_m * kMillimetresPerMetre},
                                 {"elements", rung.mesh.num_elements()},
                                 {"natural_frequency_hz", frequencies(rung.modes)},
                                 {"seconds", rung.seconds}});
  }
  json["convergent"] = ladder.convergent;
  json["accurate_rung"] = nullptr;
  if (ladder.accurate_rung) json["accurate_rung"] = *ladder.accurate_rung;
  json["limit"] = {{"lambda_per_s2", ladder.limit.lambda_per_s2},
                   {"natural_frequency_hz", std::sqrt(ladder.limit.lambda_per_s2) / kTwoPi},
                   {"relative_sigma", ladder.limit.relative_sigma},
                   {"order", ladder.limit.order},
                   {"order_observed", ladder.limit.order_observed}};
  json["moduli"] = ladder.stated_moduli ? "stated" : "1 Pa";
  for (const CoarseCandidate& candidate : ladder.candidates) {
    json["candidates"].push_back(to_json(candidate));
  }
  json["chosen"] = {{"element", std::string(to_string(ladder.coarse.mesh.kind))},
                    {"dx_mm", ladder.coarse.mesh.requested_dx_m * kMillimetresPerMetre},
                    {"elements", ladder.coarse.mesh.num_elements()},
                    {"modulus_identified_over_numerical", ladder.identified_over_numerical()},
                    {"choice", ladder.choice}};
  if (ladder.beside) json["beside"] = to_json(*ladder.beside);
  json["notes"] = ladder.notes;
  return json.dump(2) + "\n";
}

std::string ladder_text(const MeshLadder& ladder) {
  std::string text = reference_text(ladder) + candidates_text(ladder) + frequencies_text(ladder);
  text +=
      fmt::format("\n{}\nE / E_n = {:.3f}\n", ladder.choice, ladder.identified_over_numerical());
  for (const std::string& note : ladder.notes) text += "note: " + note + "\n";
  return text;
}

}  // namespace twang::app
