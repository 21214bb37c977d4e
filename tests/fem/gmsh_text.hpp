// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/hex_mesh.hpp"

#include <sstream>
#include <string>
#include <vector>

namespace twang::test {

/// Edges in the order of Gmsh's nodes 8 to 19 of a hexahedron, by its manual.
constexpr int kGmshEdges[12][2] = {
    {0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 5}, {2, 3}, {2, 6}, {3, 7}, {4, 5}, {4, 7}, {5, 6}, {6, 7}};

/// Nodes of an element in Gmsh's order: corners, then for each edge the node nearest its middle.
inline std::vector<int> gmsh_nodes(const HexMesh& mesh, int e) {
  std::vector<int> nodes;
  for (int a = 0; a < 8; ++a) nodes.push_back(mesh.elements(a, e));
  for (int i = 0; i < 12 && mesh.kind == ElementKind::Hex20; ++i) {
    const auto& edge = kGmshEdges[i];
    const Eigen::Vector3d middle = 0.5 * (mesh.nodes.col(nodes[static_cast<std::size_t>(edge[0])]) +
                                          mesh.nodes.col(nodes[static_cast<std::size_t>(edge[1])]));
    int best = mesh.elements(8, e);
    for (int a = 8; a < 20; ++a) {
      const int node = mesh.elements(a, e);
      if ((mesh.nodes.col(node) - middle).norm() < (mesh.nodes.col(best) - middle).norm()) {
        best = node;
      }
    }
    nodes.push_back(best);
  }
  return nodes;
}

inline std::string numbers(const auto& values) {
  std::ostringstream text;
  text.precision(17);
  for (const auto value : values) text << value << " ";
  return text.str();
}

/// Tags of nodes begin at 11 and run down, so that an index is not taken for a tag.
inline int tag_of(const HexMesh& mesh, int node) { return 10 + mesh.num_nodes() - node; }

inline std::vector<int> tags_of(const HexMesh& mesh, std::vector<int> nodes) {
  for (int& node : nodes) node = tag_of(mesh, node);
  return nodes;
}

/// In format 2.2, with a face and a point between, elements of material 0 in group 7 "lower", of 1
/// in group 3 without a name.
inline std::string msh_2(const HexMesh& mesh) {
  std::ostringstream text;
  text << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Comments\nany text\n$EndComments\n"
          "$PhysicalNames\n2\n2 7 \"a face\"\n3 7 \"lower\"\n$EndPhysicalNames\n$Nodes\n"
       << mesh.num_nodes() << "\n";
  for (int n = 0; n < mesh.num_nodes(); ++n) {
    text << tag_of(mesh, n) << " " << numbers(Eigen::Vector3d(mesh.nodes.col(n))) << "\n";
  }
  text << "$EndNodes\n$Elements\n"
       << mesh.num_elements() + 2 << "\n1 15 2 7 1 11\n"
       << "2 3 2 7 1 11 12 13 14\n";
  for (int e = 0; e < mesh.num_elements(); ++e) {
    const bool lower = mesh.material_of_element[static_cast<std::size_t>(e)] == 0;
    text << e + 3 << (mesh.kind == ElementKind::Hex8 ? " 5 2 " : " 17 2 ") << (lower ? 7 : 3)
         << " 1 " << numbers(tags_of(mesh, gmsh_nodes(mesh, e))) << "\n";
  }
  text << "$EndElements\n";
  return text.str();
}

/// The same in format 4.1.
inline std::string msh_4(const HexMesh& mesh) {
  std::ostringstream text;
  text << "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
          "$PhysicalNames\n2\n2 7 \"a face\"\n3 7 \"lower\"\n$EndPhysicalNames\n"
          "$Entities\n1 1 1 2\n1 0 0 0 0\n4 0 0 0 1 1 1 0 2 1 -1\n5 0 0 0 1 1 1 1 7 1 4\n"
          "21 0 0 0 1 1 1 1 7 1 5\n22 0 0 0 1 1 1 1 3 1 -5\n$EndEntities\n"
          "$Nodes\n2 "
       << mesh.num_nodes() << " 1 99\n1 4 1 1\n"
       << tag_of(mesh, 0) << "\n"
       << numbers(Eigen::Vector3d(mesh.nodes.col(0))) << " 0.5\n3 21 0 " << mesh.num_nodes() - 1
       << "\n";
  for (int n = 1; n < mesh.num_nodes(); ++n) text << tag_of(mesh, n) << "\n";
  for (int n = 1; n < mesh.num_nodes(); ++n) {
    text << numbers(Eigen::Vector3d(mesh.nodes.col(n))) << "\n";
  }
  text << "$EndNodes\n$Elements\n3 " << mesh.num_elements() + 1
       << " 1 99\n2 5 3 1\n1 11 12 13 14\n";
  for (const int material : {0, 1}) {
    std::ostringstream block;
    int count = 0;
    for (int e = 0; e < mesh.num_elements(); ++e) {
      if (mesh.material_of_element[static_cast<std::size_t>(e)] != material) continue;
      block << e + 3 << " " << numbers(tags_of(mesh, gmsh_nodes(mesh, e))) << "\n";
      ++count;
    }
    text << "3 " << 21 + material << (mesh.kind == ElementKind::Hex8 ? " 5 " : " 17 ") << count
         << "\n"
         << block.str();
  }
  text << "$EndElements\n";
  return text.str();
}

}  // namespace twang::test
