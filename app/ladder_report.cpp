// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/ladder_report.hpp"

#include "core/constants.hpp"
#include "core/units.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <vector>

namespace twang::app {
namespace {

std::vector<double> frequencies(const Eigen::VectorXd& hz) {
  return {hz.data(), hz.data() + hz.size()};
}

std::vector<double> frequencies(const Eigenmodes& modes) {
  std::vector<double> hz;
  for (int i = 0; i < modes.count(); ++i) hz.push_back(modes.natural_frequency_hz(i));
  return hz;
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
  for (const CoarseCandidate& candidate : ladder.candidates) {
    json["candidates"].push_back(
        {{"element", "hex8"},
         {"dx_mm", candidate.dx_m * kMillimetresPerMetre},
         {"elements", candidate.num_elements},
         {"natural_frequency_hz", frequencies(candidate.natural_frequency_hz)},
         {"mode_difference", candidate.comparison.difference_by_mode},
         {"mode_hausdorff", candidate.comparison.hausdorff_by_mode},
         {"passes", candidate.passes},
         {"mean_frequency_error_before", candidate.mean_frequency_error_before},
         {"mean_frequency_error_after", candidate.mean_frequency_error_after}});
  }
  json["chosen"] = {{"element", "hex8"},
                    {"dx_mm", ladder.coarse.mesh.requested_dx_m * kMillimetresPerMetre},
                    {"elements", ladder.coarse.mesh.num_elements()},
                    {"modulus_identified_over_numerical",
                     ladder.coarse.modes.lambda_per_s2[0] / ladder.limit.lambda_per_s2},
                    {"choice", ladder.choice}};
  json["notes"] = ladder.notes;
  return json.dump(2) + "\n";
}

std::string ladder_text(const MeshLadder& ladder) {
  std::string text = "reference (hex20, E = 1 Pa)\n";
  text += fmt::format(
      "{:>10} {:>10} {:>16} {:>10}\n", "dx [mm]", "elements", "f1 [1e-6 Hz]", "time [s]");
  for (const MeshRung& rung : ladder.reference) {
    text += fmt::format("{:10.4g} {:10d} {:16.6g} {:10.2f}\n",
                        rung.mesh.requested_dx_m * kMillimetresPerMetre,
                        rung.mesh.num_elements(),
                        rung.modes.natural_frequency_hz(0) * 1e6,
                        rung.seconds);
  }
  text += fmt::format("{:>10} {:>10} {:16.6g}   {} of order {:.2f}, sigma of E {:.2g} %\n\n",
                      "limit",
                      "",
                      std::sqrt(ladder.limit.lambda_per_s2) / kTwoPi * 1e6,
                      ladder.limit.order_observed ? "observed" : "assumed",
                      ladder.limit.order,
                      100.0 * ladder.limit.relative_sigma);
  text += "coarse candidates (hex8)\n";
  text += fmt::format("{:>10} {:>10} {:>16} {:>12} {:>12} {:>9} {:>9}\n",
                      "dx [mm]",
                      "elements",
                      "f1 [1e-6 Hz]",
                      "shapes [%]",
                      "Hausd. [%]",
                      "f err [%]",
                      "after [%]");
  for (const CoarseCandidate& candidate : ladder.candidates) {
    text += fmt::format("{:10.4g} {:10d} {:16.6g} {:12.2f} {:12.2f} {:9.1f} {:9.1f} {}\n",
                        candidate.dx_m * kMillimetresPerMetre,
                        candidate.num_elements,
                        candidate.natural_frequency_hz[0] * 1e6,
                        100.0 * candidate.comparison.max_difference,
                        100.0 * candidate.comparison.hausdorff,
                        100.0 * candidate.mean_frequency_error_before,
                        100.0 * candidate.mean_frequency_error_after,
                        candidate.passes ? "passes" : "");
  }
  text += fmt::format("\n{}\nE / E_n = {:.3f}\n",
                      ladder.choice,
                      ladder.coarse.modes.lambda_per_s2[0] / ladder.limit.lambda_per_s2);
  for (const std::string& note : ladder.notes) text += "note: " + note + "\n";
  return text;
}

}  // namespace twang::app
