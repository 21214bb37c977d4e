// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

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

/// The input deck of a frequency analysis of a linear elastic body of one material. The order of
/// the nodes of a C3D20 is VTK's.
[[nodiscard]] inline std::string calculix_frequency_deck(const HexMesh& mesh,
                                                         const ElasticMaterial& material,
                                                         const FreeDofs& free,
                                                         int count) {
  std::string deck = "*NODE, NSET=NALL\n";
  for (int n = 0; n < mesh.num_nodes(); ++n) {
    const Eigen::Vector3d x = mesh.nodes.col(n);
    deck += fmt::format("{}, {:.12e}, {:.12e}, {:.12e}\n", n + 1, x.x(), x.y(), x.z());
  }
  deck += fmt::format("*ELEMENT, TYPE={}, ELSET=EALL\n",
                      mesh.kind == ElementKind::Hex8 ? "C3D8" : "C3D20");
  for (int e = 0; e < mesh.num_elements(); ++e) {
    deck += fmt::format("{}", e + 1);
    for (int a = 0; a < mesh.elements.rows(); ++a) {
      // CalculiX reads up to 16 entries a line, and up to 20 characters of a number.
      deck += fmt::format("{}{}", a == 15 ? ",\n" : ", ", mesh.elements(a, e) + 1);
    }
    deck += "\n";
  }
  const std::vector<int> held = free.held_dofs();
  if (!held.empty()) deck += "*BOUNDARY\n";
  for (const int dof : held) {
    deck += fmt::format("{}, {}, {}\n", dof / 3 + 1, dof % 3 + 1, dof % 3 + 1);
  }
  deck += fmt::format(
      "*MATERIAL, NAME=M\n*ELASTIC\n{:.12e}, {:.12e}\n*DENSITY\n{:.12e}\n"
      "*SOLID SECTION, ELSET=EALL, MATERIAL=M\n*STEP\n*FREQUENCY\n{}\n*END STEP\n",
      material.youngs_modulus_pa,
      material.poissons_ratio,
      material.density_kg_m3,
      count);
  return deck;
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

/// Runs CalculiX in `folder`, on one thread.
[[nodiscard]] inline std::vector<double> run_calculix(const std::string& deck,
                                                      const std::filesystem::path& folder) {
  std::ofstream(folder / "job.inp") << deck;
  const std::string command =
      fmt::format("cd '{}' && OMP_NUM_THREADS=1 CCX_NPROC_EQUATION_SOLVER=1 ccx job > job.log 2>&1",
                  folder.string());
  if (std::system(command.c_str()) != 0) return {};
  return calculix_frequencies(folder / "job.dat");
}

}  // namespace twang::test
