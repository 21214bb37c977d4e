// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/hex_mesh.hpp"

#include <Eigen/Core>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace twang {

/// Values of the cells of a mesh.
struct CellArray {
  std::string name;
  int components = 1;
  Eigen::VectorXd values;  ///< (components num_elements), cell by cell
};

/// Writes a mesh with nodal vector fields (each 3 num_nodes) as VTK unstructured grid (`.vtu`) for
/// ParaView, with the material index by cell; whole or not at all.
/// @throws InputError if the file cannot be written
void write_vtu(const std::filesystem::path& path,
               const HexMesh& mesh,
               const std::vector<std::pair<std::string, Eigen::VectorXd>>& point_vectors,
               const std::vector<CellArray>& cell_arrays = {});

}  // namespace twang
