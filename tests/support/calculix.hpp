// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"
#include "core/material.hpp"
#include "fem/elastic_body.hpp"

#include <Eigen/Core>
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace twang::test {

/// Whether CalculiX (`ccx`, Debian package calculix-ccx) can be run here.
[[nodiscard]] inline bool has_calculix() {
  return std::system("command -v ccx > /dev/null 2>&1") == 0;
}

/// Nodes, elements, materials and supports of a linear elastic body, as the head of an input deck.
/// The order of the nodes of a C3D20 is VTK's.
/// @param materials  one for each of mesh.material_names
[[nodiscard]] inline std::string calculix_body(const HexMesh& mesh,
                                               const std::vector<ElasticMaterial>& materials,
                                               const FreeDofs& free) {
  std::string deck = "*NODE, NSET=NALL\n";
  for (int n = 0; n < mesh.num_nodes(); ++n) {
    const Eigen::Vector3d x = mesh.nodes.col(n);
    deck += fmt::format("{}, {:.12e}, {:.12e}, {:.12e}\n", n + 1, x.x(), x.y(), x.z());
  }
  const char* type = mesh.kind == ElementKind::Hex8 ? "C3D8" : "C3D20";
  for (std::size_t m = 0; m < materials.size(); ++m) {
    deck += fmt::format("*ELEMENT, TYPE={}, ELSET=E{}\n", type, m);
    for (int e = 0; e < mesh.num_elements(); ++e) {
      if (mesh.material_of_element[static_cast<std::size_t>(e)] != static_cast<int>(m)) continue;
      deck += fmt::format("{}", e + 1);
      for (int a = 0; a < mesh.elements.rows(); ++a) {
        // CalculiX reads up to 16 entries a line, and up to 20 characters of a number.
        deck += fmt::format("{}{}", a == 15 ? ",\n" : ", ", mesh.elements(a, e) + 1);
      }
      deck += "\n";
    }
    deck += fmt::format(
        "*MATERIAL, NAME=M{0}\n*ELASTIC\n{1:.12e}, {2:.12e}\n*DENSITY\n{3:.12e}\n"
        "*SOLID SECTION, ELSET=E{0}, MATERIAL=M{0}\n",
        m,
        materials[m].youngs_modulus_pa,
        materials[m].poissons_ratio,
        materials[m].density_kg_m3);
  }
  const std::vector<int> held = free.held_dofs();
  if (!held.empty()) deck += "*BOUNDARY\n";
  for (const int dof : held) {
    deck += fmt::format("{}, {}, {}\n", dof / 3 + 1, dof % 3 + 1, dof % 3 + 1);
  }
  return deck;
}

/// The input deck of a frequency analysis.
[[nodiscard]] inline std::string calculix_frequency_deck(
    const HexMesh& mesh,
    const std::vector<ElasticMaterial>& materials,
    const FreeDofs& free,
    int count) {
  return calculix_body(mesh, materials, free) +
         fmt::format("*STEP\n*FREQUENCY\n{}\n*END STEP\n", count);
}

/// The input deck of a static analysis that prints the displacements and the nodes' stresses.
/// @param force  (3 num_nodes) [N]
[[nodiscard]] inline std::string calculix_static_deck(const HexMesh& mesh,
                                                      const std::vector<ElasticMaterial>& materials,
                                                      const FreeDofs& free,
                                                      const Eigen::VectorXd& force) {
  std::string deck = calculix_body(mesh, materials, free) + "*STEP\n*STATIC\n*CLOAD\n";
  for (int dof = 0; dof < mesh.num_dofs(); ++dof) {
    if (force[dof] == 0.0) continue;
    deck += fmt::format("{}, {}, {:.12e}\n", dof / 3 + 1, dof % 3 + 1, force[dof]);
  }
  return deck + "*NODE PRINT, NSET=NALL\nU\n*EL FILE\nS\n*END STEP\n";
}

/// The frequencies [Hz] in a `.dat` file of a frequency analysis; those of rigid modes as CalculiX
/// has them.
[[nodiscard]] inline std::vector<double> calculix_frequencies(const std::filesystem::path& dat) {
  std::ifstream file(dat);
  std::vector<double> frequencies;
  std::string line;
  bool in_table = false;
  while (std::getline(file, line)) {
    if (line.find("P A R T I C I P A T I O N") != std::string::npos) break;
    in_table = in_table || line.find("(CYCLES/TIME") != std::string::npos;
    std::istringstream row(line);
    int number = 0;
    double eigenvalue = 0.0;
    double angular = 0.0;
    double cycles = 0.0;
    if (in_table && row >> number >> eigenvalue >> angular >> cycles) {
      frequencies.push_back(cycles);
    }
  }
  return frequencies;
}

/// Runs CalculiX on `deck` in `folder`, on one thread.
[[nodiscard]] inline bool run_calculix_job(const std::string& deck,
                                           const std::filesystem::path& folder) {
  std::ofstream(folder / "job.inp") << deck;
  const std::string command =
      fmt::format("cd '{}' && OMP_NUM_THREADS=1 CCX_NPROC_EQUATION_SOLVER=1 ccx job > job.log 2>&1",
                  folder.string());
  return std::system(command.c_str()) == 0;
}

/// The frequencies [Hz] of a frequency analysis; none if it failed.
[[nodiscard]] inline std::vector<double> run_calculix(const std::string& deck,
                                                      const std::filesystem::path& folder) {
  if (!run_calculix_job(deck, folder)) return {};
  return calculix_frequencies(folder / "job.dat");
}

/// The displacements (3 num_nodes) in the `.dat` file of a static analysis [m].
[[nodiscard]] inline Eigen::VectorXd calculix_displacements(const std::filesystem::path& dat,
                                                            int num_nodes) {
  Eigen::VectorXd u = Eigen::VectorXd::Constant(3 * num_nodes, kNaN);
  std::ifstream file(dat);
  std::string line;
  while (std::getline(file, line)) {
    std::istringstream row(line);
    int node = 0;
    Eigen::Vector3d value;
    if (row >> node >> value.x() >> value.y() >> value.z() && node >= 1 && node <= num_nodes) {
      u.segment<3>(3 * (node - 1)) = value;
    }
  }
  return u;
}

/// A component (xx, yy, zz, xy, yz, zx) of the stress at a node in the `.frd` file of a static
/// analysis, as CalculiX extrapolates and averages it [Pa]; not a number if it is not there.
[[nodiscard]] inline double calculix_stress(const std::filesystem::path& frd,
                                            int node,
                                            int component) {
  std::ifstream file(frd);
  std::string line;
  bool in_block = false;
  while (std::getline(file, line)) {
    if (line.rfind(" -4", 0) == 0) in_block = line.find("STRESS") != std::string::npos;
    // Columns of fixed width: a key of 3, the node of 10, numbers of 12.
    if (!in_block || line.rfind(" -1", 0) != 0 || std::stoi(line.substr(3, 10)) != node + 1) {
      continue;
    }
    return std::stod(line.substr(13 + 12 * static_cast<std::size_t>(component), 12));
  }
  return kNaN;
}

}  // namespace twang::test
