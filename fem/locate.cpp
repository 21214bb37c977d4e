// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/constants.hpp"
#include "core/error.hpp"
#include "fem/detail/element_geometry.hpp"
#include "fem/hex_mesh.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

/// A point this near to an element, in units of its size, lies in it.
constexpr double kInsideTolerance = 1e-9;
constexpr int kMaxIterations = 60;

Eigen::Matrix3d jacobian_at(const HexMesh& mesh,
                            const Eigen::Matrix3Xd& X,
                            const Eigen::Vector3d& xi) {
  return X * shape_gradients(mesh.kind, xi).transpose();
}

/// The point of the element nearest to `position`: projected Gauss-Newton on the cube, exact in one
/// step for a box.
struct Nearest {
  Eigen::Vector3d xi = Eigen::Vector3d::Zero();
  double distance = kInfinity;
};

/// Gauss-Newton step from `xi` with the coordinates that press against the cube's faces held.
Eigen::Vector3d bounded_step(const Eigen::Matrix3d& J,
                             const Eigen::Vector3d& residual,
                             const Eigen::Vector3d& xi) {
  Eigen::Matrix3d normal = J.transpose() * J;
  Eigen::Vector3d descent = J.transpose() * residual;
  for (int i = 0; i < 3; ++i) {
    const bool pressed = (xi[i] >= 1.0 && descent[i] > 0.0) || (xi[i] <= -1.0 && descent[i] < 0.0);
    if (!pressed) continue;
    normal.row(i).setZero();
    normal.col(i).setZero();
    normal(i, i) = 1.0;
    descent[i] = 0.0;
  }
  return normal.inverse() * descent;
}

Nearest nearest_in_element(const HexMesh& mesh,
                           const Eigen::Matrix3Xd& X,
                           const Eigen::Vector3d& position) {
  Nearest nearest;
  const auto residual_at = [&](const Eigen::Vector3d& xi) -> Eigen::Vector3d {
    return position - X * shape_functions(mesh.kind, xi);
  };
  Eigen::Vector3d residual = residual_at(nearest.xi);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Eigen::Vector3d step =
        bounded_step(jacobian_at(mesh, X, nearest.xi), residual, nearest.xi);
    double length = 1.0;
    Eigen::Vector3d trial = nearest.xi;
    Eigen::Vector3d trial_residual = residual;
    do {
      trial = (nearest.xi + length * step).cwiseMax(-1.0).cwiseMin(1.0);
      trial_residual = residual_at(trial);
      length *= 0.5;
    } while (trial_residual.norm() > residual.norm() && length > 1e-6);
    if (trial_residual.norm() > residual.norm()) break;
    const double moved = (trial - nearest.xi).norm();
    nearest.xi = trial;
    residual = trial_residual;
    if (moved < 1e-14) break;
  }
  nearest.distance = residual.norm();
  return nearest;
}

/// Distance from `position` to the box around each element's nodes, squared: below the distance to
/// the element itself as long as mid-edge nodes do not bulge.
struct Candidate {
  double box_distance = 0.0;
  int element = -1;
};

std::vector<Candidate> sorted_candidates(const HexMesh& mesh, const Eigen::Vector3d& position) {
  std::vector<Candidate> candidates(static_cast<std::size_t>(mesh.num_elements()));
  for (int e = 0; e < mesh.num_elements(); ++e) {
    Eigen::Vector3d low = mesh.nodes.col(mesh.elements(0, e));
    Eigen::Vector3d high = low;
    for (int a = 1; a < mesh.elements.rows(); ++a) {
      low = low.cwiseMin(mesh.nodes.col(mesh.elements(a, e)));
      high = high.cwiseMax(mesh.nodes.col(mesh.elements(a, e)));
    }
    const Eigen::Vector3d outside = (low - position).cwiseMax(position - high).cwiseMax(0.0);
    candidates[static_cast<std::size_t>(e)] = {outside.norm(), e};
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.box_distance < b.box_distance ||
           (a.box_distance == b.box_distance && a.element < b.element);
  });
  return candidates;
}

}  // namespace

MeshPoint locate(const HexMesh& mesh, const Eigen::Vector3d& position) {
  if (mesh.num_elements() == 0) throw InputError("a point is sought in a mesh without elements");
  if (!position.allFinite()) {
    throw InputError(fmt::format("a point at ({}, {}, {}) m is sought in a mesh, must be finite",
                                 position.x(),
                                 position.y(),
                                 position.z()));
  }
  MeshPoint point;
  point.distance_m = kInfinity;
  for (const Candidate& candidate : sorted_candidates(mesh, position)) {
    if (candidate.box_distance >= point.distance_m) break;
    const Eigen::Matrix3Xd X = positions_of(mesh, candidate.element);
    const double size = (X.col(6) - X.col(0)).norm();
    Nearest nearest = nearest_in_element(mesh, X, position);
    if (nearest.distance <= kInsideTolerance * size) nearest.distance = 0.0;
    if (nearest.distance >= point.distance_m * (1.0 - kInsideTolerance)) continue;
    point.element = candidate.element;
    point.xi = nearest.xi;
    point.distance_m = nearest.distance;
    if (point.distance_m == 0.0) break;
  }
  const Eigen::Matrix3Xd X = positions_of(mesh, point.element);
  const Eigen::VectorXd N = shape_functions(mesh.kind, point.xi);
  point.gradients =
      jacobian_at(mesh, X, point.xi).transpose().inverse() * shape_gradients(mesh.kind, point.xi);
  point.weights = N + point.gradients.transpose() * (position - X * N);
  for (int a = 0; a < mesh.elements.rows(); ++a) {
    point.nodes.push_back(mesh.elements(a, point.element));
  }
  return point;
}

Eigen::Vector3d interpolate(const MeshPoint& point, const Eigen::VectorXd& field) {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  for (std::size_t a = 0; a < point.nodes.size(); ++a) {
    value += point.weights[static_cast<Eigen::Index>(a)] * field.segment<3>(3 * point.nodes[a]);
  }
  return value;
}

Eigen::Matrix3d interpolate_gradient(const MeshPoint& point, const Eigen::VectorXd& field) {
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
  for (std::size_t a = 0; a < point.nodes.size(); ++a) {
    gradient += field.segment<3>(3 * point.nodes[a]) *
                point.gradients.col(static_cast<Eigen::Index>(a)).transpose();
  }
  return gradient;
}

}  // namespace twang
