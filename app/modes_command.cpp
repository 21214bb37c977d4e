// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/commands.hpp"
#include "app/terminal.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "fem/eigenmodes.hpp"
#include "fem/vtu.hpp"
#include "rigs/load_rig.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <memory>

namespace twang::app {
namespace {

struct ModesCommand {
  std::string rig;
  double dx_mm = 0.0;
  std::string element = "hex8";
  int count = 10;
  std::string vtu;
  std::string json;
  std::string partial_cells;
};

constexpr double kCubicMillimetresPerCubicMetre =
    kMillimetresPerMetre * kMillimetresPerMetre * kMillimetresPerMetre;

std::string modes_json(const HexMesh& mesh, const Eigenmodes& modes) {
  nlohmann::ordered_json json = {{"element", std::string(to_string(mesh.kind))},
                                 {"dx_mm", mesh.requested_dx_m * kMillimetresPerMetre},
                                 {"actual_dx_mm",
                                  {mesh.actual_dx_m.x() * kMillimetresPerMetre,
                                   mesh.actual_dx_m.y() * kMillimetresPerMetre,
                                   mesh.actual_dx_m.z() * kMillimetresPerMetre}},
                                 {"elements", mesh.num_elements()},
                                 {"nodes", mesh.num_nodes()},
                                 {"solver", modes.message},
                                 {"modes", nlohmann::ordered_json::array()}};
  json["mesh_volume_mm3"] = mesh.volume() * kCubicMillimetresPerCubicMetre;
  json["part_volume_mm3"] = nullptr;
  if (std::isfinite(mesh.part_volume_m3)) {
    json["part_volume_mm3"] = mesh.part_volume_m3 * kCubicMillimetresPerCubicMetre;
  }
  json["notes"] = mesh.notes;
  for (int i = 0; i < modes.count(); ++i) {
    json["modes"].push_back({{"natural_frequency_hz", modes.natural_frequency_hz(i)}});
  }
  return json.dump(2) + "\n";
}

void write_shapes(const std::string& folder, const HexMesh& mesh, const Eigenmodes& modes) {
  OutputFolder output(folder);
  for (int i = 0; i < modes.count(); ++i) {
    // drawn with a peak of a twentieth of the part, so that a mode is seen without a scale factor
    const Eigen::VectorXd shape = modes.shapes.col(i);
    const double extent =
        (mesh.nodes.rowwise().maxCoeff() - mesh.nodes.rowwise().minCoeff()).maxCoeff();
    const double peak = shape.lpNorm<Eigen::Infinity>();
    write_vtu(output.file(fmt::format("mode_{:02d}.vtu", i + 1)),
              mesh,
              {{"displacement", shape * (0.05 * extent / peak)}});
  }
  output.commit();
}

/// hex8 keeps its volume cell by cell: near nu = 0.5 that leaves it little to bend by.
void note_locking(const Rig& rig, HexMesh& mesh) {
  constexpr double kLocks = 0.48;  // above what prints have; E_n answers for those
  if (mesh.kind != ElementKind::Hex8) return;
  for (const RigMaterial& material : rig.materials) {
    if (material.poissons_ratio < kLocks) continue;
    mesh.notes.push_back(
        fmt::format("hex8 locks at nu = {:.6g} of \"{}\": its frequencies are too high; hex8e and "
                    "hex20 do not lock",
                    material.poissons_ratio,
                    material.name));
  }
}

void run(ModesCommand command) {
  RigNeeds needs;
  needs.mesh = true;
  Rig rig = load_rig(command.rig, needs);
  const ElementKind kind = element_kind_from(command.element);
  if (!command.partial_cells.empty()) {
    if (rig.meshing.file) throw InputError("--partial-cells does not belong to a mesh file");
    rig.meshing.partial_cells = partial_cells_from(command.partial_cells);
  }
  if (rig.meshing.file) command.dx_mm = kMillimetresPerMetre;  // plays no role
  if (!(command.dx_mm > 0.0))
    throw InputError(fmt::format("--dx is {}, must be > 0 mm", command.dx_mm));
  if (command.count < 1)
    throw InputError(fmt::format("--count is {}, must be >= 1", command.count));
  MeshRung rung = compute_rung(
      rig, command.dx_mm * kMetresPerMillimetre, kind, command.count, terminal_progress());
  note_locking(rig, rung.mesh);
  if (!command.vtu.empty()) write_shapes(command.vtu, rung.mesh, rung.modes);
  if (!command.json.empty()) write_json(command.json, modes_json(rung.mesh, rung.modes));
  if (command.json == "-") return;
  const Eigen::Vector3d dx_mm = rung.mesh.actual_dx_m * kMillimetresPerMetre;
  std::string text =
      fmt::format("{} {} elements, {} nodes, cells {:.4g} x {:.4g} x {:.4g} mm\n{:>4} {:>16}\n",
                  rung.mesh.num_elements(),
                  to_string(kind),
                  rung.mesh.num_nodes(),
                  dx_mm.x(),
                  dx_mm.y(),
                  dx_mm.z(),
                  "mode",
                  "frequency [Hz]");
  for (int i = 0; i < rung.modes.count(); ++i) {
    text += fmt::format("{:4d} {:16.6g}\n", i + 1, rung.modes.natural_frequency_hz(i));
  }
  for (const std::string& note : rung.mesh.notes) text += "note: " + note + "\n";
  print_result(text + rung.modes.message + "\n");
}

}  // namespace

void add_modes_command(CLI::App& cli) {
  CLI::App* sub = cli.add_subcommand(
      "modes", "Eigenmodes of a rig's mesh, at its stated Young's modulus or 1 Pa");
  auto command = std::make_shared<ModesCommand>();
  sub->add_option("rig", command->rig, "rig file (*.toml)")->required();
  sub->add_option("--dx", command->dx_mm, "cell size [mm]; not of a mesh file");
  sub->add_option("--element", command->element, "hex8, hex20 or hex8e")->capture_default_str();
  sub->add_option("--partial-cells",
                  command->partial_cells,
                  "none, mass or mass_and_stiffness; default: the rig's");
  sub->add_option("--count", command->count, "number of modes")->capture_default_str();
  sub->add_option("--vtu", command->vtu, "folder for the mode shapes (*.vtu)");
  sub->add_option(
      "--json", command->json, "machine-readable result: a file, or - for standard output");
  sub->callback([command] { run(*command); });
}

}  // namespace twang::app
