// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/hexahedron.hpp"

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

namespace twang {

/// A mesh as a file has it, in the file's unit.
struct RawMesh {
  std::vector<Eigen::Vector3d> nodes;
  std::optional<ElementKind> kind;         ///< of all elements; absent: no element yet
  std::vector<std::vector<int>> elements;  ///< nodes in VTK's order
  std::vector<std::string> groups;         ///< of each element

  /// Adds an element.
  /// @return  what is wrong with it, empty if nothing
  [[nodiscard]] std::string add(ElementKind element, std::vector<int> its_nodes, std::string group);
};

/// @param file  its name, for messages; `content` its text
[[nodiscard]] RawMesh parse_msh(const std::string& file, const std::string& content);
[[nodiscard]] RawMesh parse_vtu(const std::string& file, const std::string& content);

}  // namespace twang
