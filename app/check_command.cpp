// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/options.hpp"
#include "app/terminal.hpp"
#include "calibrate/check_rig.hpp"
#include "core/error.hpp"
#include "rigs/load_rig.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <memory>

namespace twang::app {
namespace {

struct CheckCommand {
  std::string rig;
  std::string video;
  std::optional<double> exposure_ms;
  std::string json;
  TrackFlags flags;
};

std::string check_json(const Rig& rig, const CheckCommand& command, const RigCheck& check) {
  nlohmann::ordered_json json = {{"format", "twang-check/1"},
                                 {"rig", rig.name},
                                 {"film", nullptr},
                                 {"can_be_filmed", check.can_be_filmed()},
                                 {"expected_frequency_hz", nlohmann::ordered_json::array()},
                                 {"findings", nlohmann::ordered_json::array()}};
  if (!command.video.empty()) json["film"] = command.video;
  if (check.motion.modulus_known) json["expected_frequency_hz"] = check.motion.frequency_hz;
  for (const CheckFinding& finding : check.findings) {
    json["findings"].push_back({{"subject", finding.subject},
                                {"verdict", to_string(finding.verdict)},
                                {"sentence", finding.sentence}});
  }
  return json.dump(2) + "\n";
}

std::string check_text(const RigCheck& check) {
  std::string text;
  for (const CheckFinding& finding : check.findings) {
    text += fmt::format(
        "{:<8} {:<11} {}\n", to_string(finding.verdict), finding.subject, finding.sentence);
  }
  return text;
}

void run(const CheckCommand& command) {
  RigNeeds needs;
  needs.film = true;
  const Rig rig = load_rig(command.rig, needs);
  const TrackOptions track = command.flags.options();
  if (command.video.empty() && !track.start_px.empty()) {
    throw InputError("--marker goes with a film, must be left out without one");
  }
  CheckOptions options;
  options.capture_fps = track.capture_fps;
  if (command.exposure_ms) {
    if (!(*command.exposure_ms > 0.0)) {
      throw InputError(fmt::format("--exposure is {}, must be > 0 ms", *command.exposure_ms));
    }
    options.exposure_s = *command.exposure_ms * 1e-3;
  }
  options.progress = terminal_progress();
  std::optional<FilmInspection> film;
  if (!command.video.empty()) {
    film = inspect_film(rig, command.video, {track.capture_fps, track.start_px, options.progress});
  }
  const RigCheck check = check_rig(rig, options, film ? &*film : nullptr);
  if (!command.json.empty()) write_json(command.json, check_json(rig, command, check));
  if (command.json != "-") print_result(check_text(check));
  const auto problems =
      std::count_if(check.findings.begin(), check.findings.end(), [](const CheckFinding& finding) {
        return finding.verdict == CheckVerdict::Problem;
      });
  if (problems > 0) {
    throw NumericalFailure(fmt::format(
        "{} problem{} to be solved before filming", problems, problems == 1 ? "" : "s"));
  }
}

}  // namespace

void add_check_command(CLI::App& cli) {
  CLI::App* sub =
      cli.add_subcommand("check", "Before filming: will a film of this rig give a result?");
  auto command = std::make_shared<CheckCommand>();
  sub->add_option("rig", command->rig, "rig file (*.toml)")->required();
  sub->add_option("video", command->video, "a first film of it, to be looked at as well");
  sub->add_option(
      "--exposure", command->exposure_ms, "time a frame is exposed [ms]; default: all of it");
  sub->add_option(
      "--json", command->json, "machine-readable result: a file, or - for standard output");
  command->flags.add_to(*sub);
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
