// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/hex_mesh.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>

namespace twang {
namespace {

/// Corners of the six faces of a hexahedron, seen anticlockwise from outside.
constexpr std::array<std::array<int, 4>, 6> kFaces = {{
    {0, 3, 2, 1},
    {4, 5, 6, 7},
    {0, 1, 5, 4},
    {2, 3, 7, 6},
    {1, 2, 6, 5},
    {0, 4, 7, 3},
}};

/// How far from a clamp's box a node may lie to be held, in cells.
constexpr double kClampMargin = 1e-3;

double shortest_edge(const HexMesh& mesh) {
  if (mesh.actual_dx_m.minCoeff() > 0.0) return mesh.actual_dx_m.minCoeff();
  double shortest = kInfinity;
  for (int e = 0; e < mesh.num_elements(); ++e) {
    for (const auto& face : kFaces) {
      for (std::size_t i = 0; i < 4; ++i) {
        const int a = mesh.elements(face[i], e);
        const int b = mesh.elements(face[(i + 1) % 4], e);
        shortest = std::min(shortest, (mesh.nodes.col(a) - mesh.nodes.col(b)).norm());
      }
    }
  }
  return shortest;
}

}  // namespace

double HexMesh::volume() const {
  const Quadrature& rule = quadrature(kind);
  double sum = 0.0;
  for (std::size_t g = 0; g < rule.points.size(); ++g) {
    const Eigen::Matrix3Xd dN = shape_gradients(kind, rule.points[g]);
    for (int e = 0; e < num_elements(); ++e) {
      Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
      for (int a = 0; a < dN.cols(); ++a) {
        jacobian += nodes.col(elements(a, e)) * dN.col(a).transpose();
      }
      sum += rule.weights[g] * jacobian.determinant() * (fill.size() > 0 ? fill[e] : 1.0);
    }
  }
  return sum;
}

std::vector<int> clamped_nodes(const HexMesh& mesh, const Rig& rig) {
  std::vector<char> held(static_cast<std::size_t>(mesh.num_nodes()), 0);
  const double margin = kClampMargin * shortest_edge(mesh);
  for (std::size_t c = 0; c < rig.clamps.size(); ++c) {
    bool any = false;
    for (int n = 0; n < mesh.num_nodes(); ++n) {
      if (!rig.clamps[c].contains(mesh.nodes.col(n), margin)) continue;
      held[static_cast<std::size_t>(n)] = 1;
      any = true;
    }
    if (any) continue;
    const Box& box = rig.clamps[c];
    throw InputError(fmt::format(
        "{}: clamp {} of {}, from ({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g}) mm, holds "
        "no node of the mesh with cells of {:.4g} x {:.4g} x {:.4g} mm; it must reach a corner of "
        "a cell",
        rig.file.empty() ? rig.name : rig.file.string(),
        c + 1,
        rig.clamps.size(),
        box.min.x() * kMillimetresPerMetre,
        box.min.y() * kMillimetresPerMetre,
        box.min.z() * kMillimetresPerMetre,
        box.max.x() * kMillimetresPerMetre,
        box.max.y() * kMillimetresPerMetre,
        box.max.z() * kMillimetresPerMetre,
        mesh.actual_dx_m.x() * kMillimetresPerMetre,
        mesh.actual_dx_m.y() * kMillimetresPerMetre,
        mesh.actual_dx_m.z() * kMillimetresPerMetre));
  }
  std::vector<int> nodes;
  for (std::size_t n = 0; n < held.size(); ++n) {
    if (held[n] != 0) nodes.push_back(static_cast<int>(n));
  }
  return nodes;
}

std::vector<std::array<int, 4>> surface_faces(const HexMesh& mesh) {
  struct Seen {
    std::array<int, 4> sorted;
    std::array<int, 4> face;
  };
  std::vector<Seen> all;
  all.reserve(static_cast<std::size_t>(mesh.num_elements()) * kFaces.size());
  for (int e = 0; e < mesh.num_elements(); ++e) {
    for (const auto& corners : kFaces) {
      Seen seen;
      for (std::size_t i = 0; i < 4; ++i) seen.face[i] = mesh.elements(corners[i], e);
      seen.sorted = seen.face;
      std::sort(seen.sorted.begin(), seen.sorted.end());
      all.push_back(seen);
    }
  }
  std::sort(
      all.begin(), all.end(), [](const Seen& a, const Seen& b) { return a.sorted < b.sorted; });
  std::vector<std::array<int, 4>> faces;
  for (std::size_t i = 0; i < all.size();) {
    std::size_t end = i + 1;
    while (end < all.size() && all[end].sorted == all[i].sorted) ++end;
    if (end == i + 1) faces.push_back(all[i].face);
    i = end;
  }
  return faces;
}

}  // namespace twang
