// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/ladder_report.hpp"
#include "app/terminal.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "rigs/load_rig.hpp"

#include <fmt/format.h>

#include <memory>

namespace twang::app {
namespace {

struct CoarsenCommand {
  std::string rig;
  std::optional<double> dx_mm;
  std::string element = "hex8";
  int num_modes = LadderOptions{}.num_modes;
  std::string json;
};

void run(const CoarsenCommand& command) {
  RigNeeds needs;
  needs.part = true;
  needs.clamp = true;
  const Rig rig = load_rig(command.rig, needs);
  LadderOptions options;
  if (command.dx_mm) {
    if (!(*command.dx_mm > 0.0))
      throw InputError(fmt::format("--dx is {}, must be > 0 mm", *command.dx_mm));
    options.coarse_dx_m = *command.dx_mm * kMetresPerMillimetre;
  }
  options.coarse_element = element_kind_from(command.element);
  options.num_modes = command.num_modes;
  options.beside = true;
  options.progress = terminal_progress();
  const MeshLadder ladder = build_mesh_ladder(rig, options);
  if (!command.json.empty()) write_json(command.json, ladder_json(ladder));
  if (command.json != "-") print_result(ladder_text(ladder));
}

}  // namespace

void add_coarsen_command(CLI::App& cli) {
  CLI::App* sub = cli.add_subcommand("coarsen", "The ladder of meshes, and the coarse one chosen");
  auto command = std::make_shared<CoarsenCommand>();
  sub->add_option("rig", command->rig, "rig file (*.toml)")->required();
  sub->add_option("--dx", command->dx_mm, "cell size of the coarse mesh [mm]; default: chosen");
  sub->add_option("--element", command->element, "of the coarse mesh: hex8 or hex8e")
      ->capture_default_str();
  sub->add_option("--modes", command->num_modes, "modes whose shapes must agree")
      ->capture_default_str();
  sub->add_option(
      "--json", command->json, "machine-readable result: a file, or - for standard output");
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
