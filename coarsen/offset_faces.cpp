// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/offset_faces.hpp"

#include "fem/hex_edges.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

namespace twang {
namespace {

using Eigen::Vector3d;
using GridIndex = std::array<long, 3>;

constexpr int kNumCorners = 8;

/// The outward motion of each corner node that lies on an outer face across an axis; absent where
/// it lies on none.
using FaceMotion = std::array<std::vector<std::optional<double>>, 3>;

FaceMotion motion_of_outer_faces(const HexMesh& mesh) {
  FaceMotion motion;
  for (auto& along : motion) along.resize(static_cast<std::size_t>(mesh.num_nodes()));
  for (const std::array<int, 4>& face : surface_faces(mesh)) {
    const Vector3d normal = (mesh.nodes.col(face[2]) - mesh.nodes.col(face[0]))
                                .cross(mesh.nodes.col(face[3]) - mesh.nodes.col(face[1]));
    Eigen::Index axis = 0;
    normal.cwiseAbs().maxCoeff(&axis);
    const double outwards = normal(axis) > 0.0 ? 0.5 : -0.5;
    for (const int node : face) {
      auto& moved = motion[static_cast<std::size_t>(axis)][static_cast<std::size_t>(node)];
      // Two solids that touch along an edge pull it both ways: it stays.
      moved = moved && *moved != outwards ? 0.0 : outwards;
    }
  }
  return motion;
}

std::vector<int> corner_nodes(const HexMesh& mesh) {
  std::vector<int> corners;
  for (Eigen::Index e = 0; e < mesh.elements.cols(); ++e) {
    for (int i = 0; i < kNumCorners; ++i) corners.push_back(mesh.elements(i, e));
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  return corners;
}

GridIndex grid_index(const HexMesh& mesh, const Vector3d& origin, int node) {
  GridIndex index{};
  for (int k = 0; k < 3; ++k) {
    index[static_cast<std::size_t>(k)] =
        std::lround((mesh.nodes(k, node) - origin(k)) / mesh.actual_dx_m(k));
  }
  return index;
}

/// Fills the motion along one grid line: given at its ends and at the outer faces it crosses,
/// linear between.
void interpolate_along(const std::vector<int>& line,
                       const HexMesh& mesh,
                       Eigen::Index axis,
                       const std::vector<std::optional<double>>& given,
                       Eigen::Matrix3Xd& growth) {
  std::size_t before = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (!given[static_cast<std::size_t>(line[i])]) continue;
    const double x0 = mesh.nodes(axis, line[before]);
    const double x1 = mesh.nodes(axis, line[i]);
    const double g1 = *given[static_cast<std::size_t>(line[i])];
    const double g0 = given[static_cast<std::size_t>(line[before])].value_or(g1);
    for (std::size_t j = before; j <= i; ++j) {
      const double s = x1 > x0 ? (mesh.nodes(axis, line[j]) - x0) / (x1 - x0) : 1.0;
      growth(axis, line[j]) = (1.0 - s) * g0 + s * g1;
    }
    before = i;
  }
}

Eigen::Matrix3Xd growth_of_voxels(const HexMesh& mesh) {
  Eigen::Matrix3Xd growth = Eigen::Matrix3Xd::Zero(3, mesh.num_nodes());
  const FaceMotion given = motion_of_outer_faces(mesh);
  const std::vector<int> corners = corner_nodes(mesh);
  const Vector3d origin = mesh.nodes.rowwise().minCoeff();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::map<GridIndex, std::vector<int>> lines;
    for (const int node : corners) {
      GridIndex line = grid_index(mesh, origin, node);
      line[axis] = 0;
      lines[line].push_back(node);
    }
    const auto row = static_cast<Eigen::Index>(axis);
    for (auto& [index, line] : lines) {
      std::sort(line.begin(), line.end(), [&](int a, int b) {
        return mesh.nodes(row, a) < mesh.nodes(row, b);
      });
      interpolate_along(line, mesh, row, given[axis], growth);
    }
  }
  return growth;
}

/// Moves the corner nodes of the outside so that each face around them moves out by one half, by
/// least squares where a node has more than three; which nodes these are.
std::vector<bool> move_faces_outwards(const HexMesh& mesh, Eigen::Matrix3Xd& growth) {
  constexpr double kFlat = 1e-4;  // faces this parallel do not tell how a node moves along them
  std::vector<bool> outside(static_cast<std::size_t>(mesh.num_nodes()), false);
  std::vector<Eigen::Matrix3d> normals(outside.size(), Eigen::Matrix3d::Zero());
  Eigen::Matrix3Xd sums = Eigen::Matrix3Xd::Zero(3, mesh.num_nodes());
  for (const std::array<int, 4>& face : surface_faces(mesh)) {
    const Vector3d n = (mesh.nodes.col(face[2]) - mesh.nodes.col(face[0]))
                           .cross(mesh.nodes.col(face[3]) - mesh.nodes.col(face[1]))
                           .normalized();
    for (const int node : face) {
      outside[static_cast<std::size_t>(node)] = true;
      normals[static_cast<std::size_t>(node)] += n * n.transpose();
      sums.col(node) += 0.5 * n;
    }
  }
  for (int node = 0; node < mesh.num_nodes(); ++node) {
    if (!outside[static_cast<std::size_t>(node)]) continue;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(
        normals[static_cast<std::size_t>(node)]);
    for (Eigen::Index k = 0; k < 3; ++k) {
      if (axes.eigenvalues()[k] <= kFlat * axes.eigenvalues()[2]) continue;
      const Vector3d axis = axes.eigenvectors().col(k);
      growth.col(node) += axis * (axis.dot(sums.col(node)) / axes.eigenvalues()[k]);
    }
  }
  return outside;
}

/// Corner nodes that are not `given` move as the mean of those they share an edge with.
void follow_smoothly(const HexMesh& mesh,
                     const std::vector<bool>& given,
                     Eigen::Matrix3Xd& growth) {
  std::vector<int> unknown(given.size(), -1);
  int count = 0;
  for (const int node : corner_nodes(mesh)) {
    if (!given[static_cast<std::size_t>(node)]) unknown[static_cast<std::size_t>(node)] = count++;
  }
  if (count == 0) return;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(count, 3);
  const auto pull = [&](int node, int other) {
    const int row = unknown[static_cast<std::size_t>(node)];
    if (row < 0) return;
    entries.emplace_back(row, row, 1.0);
    const int column = unknown[static_cast<std::size_t>(other)];
    if (column >= 0) {
      entries.emplace_back(row, column, -1.0);
    } else {
      right.row(row) += growth.col(other).transpose();
    }
  };
  for (Eigen::Index e = 0; e < mesh.elements.cols(); ++e) {
    for (const auto& [a, b] : kHexEdges) {
      pull(mesh.elements(a, e), mesh.elements(b, e));
      pull(mesh.elements(b, e), mesh.elements(a, e));
    }
  }
  Eigen::SparseMatrix<double> A(count, count);
  A.setFromTriplets(entries.begin(), entries.end());
  Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper> solver(A);
  const Eigen::MatrixXd inside = solver.solve(right);
  for (std::size_t node = 0; node < unknown.size(); ++node) {
    if (unknown[node] < 0) continue;
    growth.col(static_cast<Eigen::Index>(node)) = inside.row(unknown[node]).transpose();
  }
}

}  // namespace

Eigen::Matrix3Xd outward_growth(const HexMesh& mesh) {
  Eigen::Matrix3Xd growth;
  if (mesh.actual_dx_m.minCoeff() > 0.0) {
    growth = growth_of_voxels(mesh);
  } else {
    growth.setZero(3, mesh.num_nodes());
    follow_smoothly(mesh, move_faces_outwards(mesh, growth), growth);
  }
  if (mesh.kind == ElementKind::Hex20) {
    for (Eigen::Index e = 0; e < mesh.elements.cols(); ++e) {
      for (std::size_t i = 0; i < kHexEdges.size(); ++i) {
        const auto [a, b] = kHexEdges[i];
        growth.col(mesh.elements(kNumCorners + static_cast<int>(i), e)) =
            0.5 * (growth.col(mesh.elements(a, e)) + growth.col(mesh.elements(b, e)));
      }
    }
  }
  return growth;
}

}  // namespace twang
