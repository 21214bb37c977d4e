// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"
#include "fem/hex_mesh.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang::test {

/// A box from the origin to `size`, cut into `cells` equal cells per axis, of one material.
inline HexMesh box_mesh(ElementKind kind,
                        const Eigen::Vector3i& cells,
                        const Eigen::Vector3d& size) {
  Rig rig;
  rig.name = "box";
  rig.materials.push_back({"part", 1000.0, 0.3, {}, {}});
  rig.parts.push_back({"part", Box{Eigen::Vector3d::Zero(), cells.cast<double>()}});
  HexMesh mesh = mesh_part(rig, 1.0, kind);
  const Eigen::Vector3d scale = size.cwiseQuotient(cells.cast<double>());
  mesh.nodes = scale.asDiagonal() * mesh.nodes;
  mesh.actual_dx_m = scale;
  mesh.requested_dx_m = scale.maxCoeff();
  return mesh;
}

/// Nodes with coordinate `axis` equal to `value`.
inline std::vector<int> nodes_at(const HexMesh& mesh, int axis, double value) {
  std::vector<int> found;
  const double slack = 1e-9 * mesh.nodes.cwiseAbs().maxCoeff();
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (std::abs(mesh.nodes(axis, i) - value) <= slack) found.push_back(i);
  return found;
}

/// Mean of a nodal vector field over some nodes.
inline Eigen::Vector3d mean_over(const std::vector<int>& nodes, const Eigen::VectorXd& field) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const int node : nodes) sum += field.segment<3>(3 * node);
  return sum / static_cast<double>(nodes.size());
}

}  // namespace twang::test
