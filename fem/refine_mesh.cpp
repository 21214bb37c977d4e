// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/refine_mesh.hpp"

#include "fem/read_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

namespace twang {
namespace {

/// Corners of the edge, face or element in whose middle a point of the half grid lies, ascending:
/// what neighbours know it by.
std::vector<int> key_of(const HexMesh& mesh, int element, const Eigen::Vector3d& xi) {
  std::vector<int> corners;
  for (int a = 0; a < 8; ++a) {
    const Eigen::Vector3d corner = reference_node(a);
    bool near = true;
    for (int axis = 0; axis < 3; ++axis) {
      near = near && (xi[axis] == 0.0 || xi[axis] == corner[axis]);
    }
    if (near) corners.push_back(mesh.elements(a, element));
  }
  std::sort(corners.begin(), corners.end());
  return corners;
}

Eigen::VectorXd repeated(const Eigen::VectorXd& by_element) {
  Eigen::VectorXd result(8 * by_element.size());
  for (Eigen::Index i = 0; i < result.size(); ++i) result[i] = by_element[i / 8];
  return result;
}

}  // namespace

HexMesh refine_uniformly(const HexMesh& mesh) {
  HexMesh fine = mesh;
  fine.kind = mesh.kind == ElementKind::Hex20 ? ElementKind::Hex8 : mesh.kind;
  fine.elements.resize(8, 8 * mesh.elements.cols());
  fine.material_of_element.clear();
  std::map<std::vector<int>, int> node_of;
  std::vector<Eigen::Vector3d> nodes;
  for (int e = 0; e < mesh.num_elements(); ++e) {
    const auto node_at = [&](const Eigen::Vector3d& xi) {
      const auto [at, is_new] =
          node_of.try_emplace(key_of(mesh, e, xi), static_cast<int>(nodes.size()));
      if (is_new) {
        const Eigen::VectorXd N = shape_functions(mesh.kind, xi);
        Eigen::Vector3d position = Eigen::Vector3d::Zero();
        for (Eigen::Index a = 0; a < mesh.elements.rows(); ++a) {
          position += N[a] * mesh.nodes.col(mesh.elements(a, e));
        }
        nodes.push_back(position);
      }
      return at->second;
    };
    for (int part = 0; part < 8; ++part) {
      const Eigen::Vector3d centre = 0.5 * reference_node(part);
      for (int a = 0; a < 8; ++a) {
        fine.elements(a, 8 * e + part) = node_at(centre + 0.5 * reference_node(a));
      }
      fine.material_of_element.push_back(mesh.material_of_element[static_cast<std::size_t>(e)]);
    }
  }
  fine.nodes.resize(3, static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    fine.nodes.col(static_cast<Eigen::Index>(i)) = nodes[i];
  }
  fine.requested_dx_m = 0.5 * mesh.requested_dx_m;
  fine.actual_dx_m = 0.5 * mesh.actual_dx_m;
  fine.fill = repeated(mesh.fill);
  fine.mass_fill = repeated(mesh.mass_fill);
  fine.stiffness_fill = repeated(mesh.stiffness_fill);
  return with_kind(fine, mesh.kind);
}

}  // namespace twang
