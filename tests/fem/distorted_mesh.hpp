// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/hex_edges.hpp"
#include "fem/hex_mesh.hpp"
#include "tests/support/finite_differences.hpp"
#include "tests/support/rigs.hpp"

#include <array>
#include <set>

namespace twang::test {

/// A box of 2 x 3 x 2 unit cells whose corner nodes are moved about by up to `amount` (those on the
/// outside too); mid-edge nodes stay in the middle of their edges.
[[nodiscard]] inline HexMesh distorted_mesh(ElementKind kind, double amount) {
  HexMesh mesh = mesh_part(make_rig({Box{{0, 0, 0}, {2, 3, 2}}}), 1.0, kind);
  const Eigen::VectorXd moves = random_vector(mesh.num_dofs(), amount, 11);
  std::set<int> corners;
  for (int e = 0; e < mesh.num_elements(); ++e) {
    for (int a = 0; a < 8; ++a) corners.insert(mesh.elements(a, e));
  }
  for (const int n : corners) mesh.nodes.col(n) += moves.segment<3>(3 * n);
  for (int e = 0; e < mesh.num_elements(); ++e) {
    for (int a = 8; a < mesh.elements.rows(); ++a) {
      const auto& edge = kHexEdges[static_cast<std::size_t>(a - 8)];
      mesh.nodes.col(mesh.elements(a, e)) = 0.5 * (mesh.nodes.col(mesh.elements(edge[0], e)) +
                                                   mesh.nodes.col(mesh.elements(edge[1], e)));
    }
  }
  mesh.actual_dx_m.setZero();
  return mesh;
}

/// Nodes that lie on no outer face's plane of the undistorted box.
[[nodiscard]] inline std::vector<int> inner_nodes(ElementKind kind) {
  const HexMesh mesh = distorted_mesh(kind, 0.0);
  std::vector<int> inner;
  for (int n = 0; n < mesh.num_nodes(); ++n) {
    const Eigen::Vector3d x = mesh.nodes.col(n);
    const Eigen::Vector3d gap = x.cwiseMin(Eigen::Vector3d(2, 3, 2) - x);
    if (gap.minCoeff() > 0.1) inner.push_back(n);
  }
  return inner;
}

}  // namespace twang::test
