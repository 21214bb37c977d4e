// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/json_values.hpp"
#include "app/terminal.hpp"
#include "coarsen/identify_moduli.hpp"
#include "core/error.hpp"
#include "core/modes_file.hpp"
#include "core/units.hpp"
#include "report/material_table.hpp"
#include "rigs/load_rig.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <deque>
#include <memory>
#include <string_view>

namespace twang::app {
namespace {

struct IdentifyCommand {
  std::vector<std::string> pairs;
  int num_modes = 1;
  std::vector<std::string> mesh_modes;
  std::optional<double> dx_mm;
  std::string json;
};

/// "1,3" as mode numbers from 0.
std::vector<int> mode_numbers(const std::string& list) {
  std::vector<int> numbers;
  if (list.empty()) throw InputError("--mesh-modes is empty, must be as in 1,3, or 'auto'");
  for (std::string_view rest = list; !rest.empty();) {
    const std::string_view word = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), word.size() + 1));
    int number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc{} || end != word.data() + word.size() || number < 1) {
      throw InputError(fmt::format(
          "--mesh-modes is '{}', must be mode numbers from 1 on, as in 1,3, or 'auto'", list));
    }
    if (std::find(numbers.begin(), numbers.end(), number - 1) != numbers.end()) {
      throw InputError(fmt::format("--mesh-modes is '{}', must name each mode once", list));
    }
    numbers.push_back(number - 1);
  }
  return numbers;
}

/// The sinusoids that are used of one file: its strongest, the mesh's modes beside them if stated.
std::vector<ModalMeasurement> measurements_of(const Rig& rig,
                                              const std::string& file,
                                              int num_modes,
                                              const std::string& mesh_modes) {
  std::vector<DampedSinusoid> sinusoids = read_modes(file);
  const std::vector<int> numbers =
      mesh_modes == "auto" ? std::vector<int>{} : mode_numbers(mesh_modes);
  const std::size_t wanted = numbers.empty() ? static_cast<std::size_t>(num_modes) : numbers.size();
  if (sinusoids.size() < wanted) {
    throw InputError(fmt::format(
        "{}: holds {} modes, must hold the {} that are asked for", file, sinusoids.size(), wanted));
  }
  sinusoids.resize(wanted);
  std::sort(sinusoids.begin(), sinusoids.end(), [](const auto& a, const auto& b) {
    return a.lambda_per_s2() < b.lambda_per_s2();
  });
  std::vector<int> ascending = numbers;
  std::sort(ascending.begin(), ascending.end());
  std::vector<ModalMeasurement> measurements;
  for (std::size_t i = 0; i < sinusoids.size(); ++i) {
    ModalMeasurement& measurement = measurements.emplace_back();
    measurement.rig = &rig;
    measurement.sinusoid = sinusoids[i];
    if (!ascending.empty()) measurement.mode = ascending[i];
    measurement.name = file;
  }
  return measurements;
}

std::string json_of(const IdentifiedMaterials& found,
                    const std::vector<ModalMeasurement>& measurements) {
  nlohmann::ordered_json json = {{"format", "twang-identified/1"},
                                 {"materials", nlohmann::ordered_json::array()},
                                 {"measurements", nlohmann::ordered_json::array()}};
  for (const IdentifiedMaterial& material : found.materials) {
    json["materials"].push_back(
        {{"material", material.name},
         {"youngs_modulus_identified_pa", material.youngs_modulus_pa},
         {"youngs_modulus_identified_sigma_pa",
          finite_or_null(material.youngs_modulus_pa * material.youngs_modulus_sigma_rel())},
         {"uncertainty",
          {{"statistical", finite_or_null(material.statistical_rel)},
           {"mesh", finite_or_null(material.mesh_rel)}}},
         {"damping_stiffness_b_s", material.damping_stiffness_b_s},
         {"damping_stiffness_b_sigma_s", finite_or_null(material.damping_stiffness_b_sigma_s)}});
  }
  for (std::size_t k = 0; k < measurements.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    nlohmann::ordered_json shares = nlohmann::ordered_json::object();
    for (std::size_t m = 0; m < found.materials.size(); ++m) {
      shares[found.materials[m].name] = found.energy_shares(row, static_cast<Eigen::Index>(m));
    }
    json["measurements"].push_back(
        {{"rig", measurements[k].rig->name},
         {"modes", measurements[k].name},
         {"natural_frequency_hz", measurements[k].sinusoid.natural_frequency_hz()},
         {"mesh_mode", found.modes[k] + 1},
         {"dx_mm", found.dx_m[k] * kMillimetresPerMetre},
         {"energy_shares", shares},
         {"known_share", found.known_shares[row]},
         {"misfit_ln_lambda", found.misfit[row]}});
  }
  json["condition_number"] = finite_or_null(found.condition_number);
  json["distinguishable"] = found.distinguishable;
  json["notes"] = found.notes;
  return json.dump(2) + "\n";
}

std::string text_of(const IdentifiedMaterials& found,
                    const std::vector<ModalMeasurement>& measurements) {
  std::string text;
  for (std::size_t k = 0; k < measurements.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    text += fmt::format("{}: {:.4g} Hz is mode {} of {} at {:.4g} mm; strain energy",
                        measurements[k].name,
                        measurements[k].sinusoid.natural_frequency_hz(),
                        found.modes[k] + 1,
                        measurements[k].rig->name,
                        found.dx_m[k] * kMillimetresPerMetre);
    for (std::size_t m = 0; m < found.materials.size(); ++m) {
      text += fmt::format("{} {:.3g} % in {}",
                          m == 0 ? "" : ",",
                          100.0 * found.energy_shares(row, static_cast<Eigen::Index>(m)),
                          found.materials[m].name);
    }
    text += fmt::format("; f {:+.2g} %\n", 50.0 * found.misfit[row]);
  }
  for (const IdentifiedMaterial& material : found.materials) {
    const double modulus_mpa = 1e-6 * material.youngs_modulus_pa;
    const double sigma_rel = material.youngs_modulus_sigma_rel();
    text += fmt::format("{}: E {}, b {} ms\n",
                        material.name,
                        std::isinf(sigma_rel)
                            ? fmt::format("about {:.3g} MPa, not told by the data", modulus_mpa)
                            : text_with_sigma(modulus_mpa, modulus_mpa * sigma_rel) + " MPa",
                        text_with_sigma(1e3 * material.damping_stiffness_b_s,
                                        1e3 * material.damping_stiffness_b_sigma_s));
  }
  if (found.materials.size() > 1) {
    text += fmt::format("condition number of the shares {:.3g}{}\n",
                        found.condition_number,
                        found.distinguishable ? "" : ": the materials cannot be told apart");
  }
  for (const std::string& note : found.notes) text += "note: " + note + "\n";
  return text;
}

void run(const IdentifyCommand& command) {
  if (command.pairs.size() % 2 != 0) {
    throw InputError(fmt::format("{} files are given, must be pairs of a rig and its modes.json",
                                 command.pairs.size()));
  }
  const std::size_t num_pairs = command.pairs.size() / 2;
  if (!command.mesh_modes.empty() && command.mesh_modes.size() != num_pairs) {
    throw InputError(
        fmt::format("--mesh-modes is given {} times, must be once for each of the {} "
                    "rigs, or never",
                    command.mesh_modes.size(),
                    num_pairs));
  }
  if (command.num_modes < 1) {
    throw InputError(fmt::format("--modes is {}, must be >= 1", command.num_modes));
  }
  if (command.dx_mm && !(*command.dx_mm > 0.0)) {
    throw InputError(fmt::format("--dx is {}, must be > 0 mm", *command.dx_mm));
  }
  RigNeeds needs;
  needs.part = true;
  needs.clamp = true;
  std::vector<std::string> files;
  std::deque<Rig> rigs;  // one a file; measurements point at them
  std::vector<ModalMeasurement> measurements;
  for (std::size_t i = 0; i < num_pairs; ++i) {
    const std::string& file = command.pairs[2 * i];
    const std::size_t known =
        static_cast<std::size_t>(std::find(files.begin(), files.end(), file) - files.begin());
    if (known == files.size()) {
      files.push_back(file);
      rigs.push_back(load_rig(file, needs));
    }
    for (ModalMeasurement& measurement :
         measurements_of(rigs[known],
                         command.pairs[2 * i + 1],
                         command.num_modes,
                         command.mesh_modes.empty() ? "auto" : command.mesh_modes[i])) {
      measurements.push_back(std::move(measurement));
    }
  }
  IdentifyOptions options;
  if (command.dx_mm) options.dx_m = *command.dx_mm * kMetresPerMillimetre;
  options.progress = terminal_progress();
  const IdentifiedMaterials found = identify_moduli(measurements, options);
  if (!command.json.empty()) write_json(command.json, json_of(found, measurements));
  if (command.json != "-") print_result(text_of(found, measurements));
}

}  // namespace

void add_identify_command(CLI::App& cli) {
  CLI::App* sub = cli.add_subcommand(
      "identify", "Several materials at once, from the modes of several rigs or of one");
  auto command = std::make_shared<IdentifyCommand>();
  sub->add_option("pairs", command->pairs, "rig file and its modes.json; further pairs may follow")
      ->required()
      ->type_name("RIG MODES.json");
  sub->add_option("--modes", command->num_modes, "modes used of each file, the strongest")
      ->capture_default_str();
  sub->add_option("--mesh-modes",
                  command->mesh_modes,
                  "which modes of the mesh these are, from 1 on, as in 1,3; once for each rig; "
                  "default: the first that the observable sees")
      ->type_size(1)
      ->allow_extra_args(false);
  sub->add_option("--dx", command->dx_mm, "cell size of the first mesh [mm]; default: chosen");
  sub->add_option(
      "--json", command->json, "machine-readable result: a file, or - for standard output");
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
