// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/ladder_report.hpp"
#include "app/terminal.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "coarsen/virtual_measurement.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/material_file.hpp"
#include "core/units.hpp"
#include "report/material_table.hpp"
#include "rigs/load_rig.hpp"

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

namespace twang::app {
namespace {

struct CoarsenCommand {
  std::string rig;
  std::optional<double> dx_mm;
  std::string element = "hex8";
  int num_modes = LadderOptions{}.num_modes;
  std::string json;
  std::string output;
  double damping_b_s = 0.0;
};

/// The virtual measurement's files: a material each, the table of them, the ladder.
void write_results(const std::string& folder,
                   const MeshLadder& ladder,
                   const std::vector<Material>& materials) {
  OutputFolder output(folder);
  for (std::size_t i = 0; i < materials.size(); ++i) {
    write_material(output.file(materials.size() == 1 ? std::string("material.json")
                                                     : fmt::format("material_{}.json", i + 1)),
                   materials[i]);
  }
  write_file_atomically(output.file("table.csv"),
                        format_material_table(materials, TableFormat::Csv));
  write_file_atomically(output.file("ladder.json"), ladder_json(ladder));
  output.commit();
}

/// @throws InputError if a material of the part states no modulus, before the meshes are computed
void check_stated(const Rig& rig) {
  for (const PartSolid& solid : rig.parts) {
    const RigMaterial* material = rig.find_material(solid.material);
    if (material != nullptr && material->youngs_modulus_pa) continue;
    throw InputError(
        fmt::format("{}: materials.{} states no youngs_modulus_pa, must have one for --out: the "
                    "virtual measurement calibrates the coarse mesh at that modulus",
                    rig.file.string(),
                    solid.material));
  }
}

void run(const CoarsenCommand& command) {
  RigNeeds needs;
  needs.mesh = true;
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
  if (!command.output.empty()) check_stated(rig);
  if (command.output.empty() && command.damping_b_s != 0.0)
    throw InputError("--damping-b stands alone, must come with --out DIR");
  if (!(command.damping_b_s >= 0.0))
    throw InputError(fmt::format("--damping-b is {}, must be >= 0 s", command.damping_b_s));
  const MeshLadder ladder = build_mesh_ladder(rig, options);
  if (!command.json.empty()) write_json(command.json, ladder_json(ladder));
  std::string text = ladder_text(ladder);
  if (!command.output.empty()) {
    const std::vector<Material> materials = measure_virtually(rig, ladder, command.damping_b_s);
    write_results(command.output, ladder, materials);
    text += "\n" + format_material_table(materials, TableFormat::Text);
  }
  if (command.json != "-") print_result(text);
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
  sub->add_option("--out",
                  command->output,
                  "virtual measurement: folder for material.json, E_n of the coarse mesh at the "
                  "modulus that the rig states");
  sub->add_option("--damping-b", command->damping_b_s, "b of that material [s]; default: 0");
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
