// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/attach_weights.hpp"

#include "core/error.hpp"
#include "core/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang {
namespace {

constexpr int kFewestAlongAnEdge = 4;
constexpr int kMostAlongAnEdge = 64;
constexpr double kFarthest = 0.5;  // apart, over a cell [-]
constexpr double kOutside = 1e-6;  // from the mesh, over a cell: beyond round-off [-]

Eigen::Vector3i grid_over(const HexMesh& mesh, const Eigen::Vector3d& size) {
  Eigen::Vector3i count = Eigen::Vector3i::Ones();
  for (int axis = 0; axis < 3; ++axis) {
    if (size[axis] == 0.0) continue;
    const double wanted = std::ceil(size[axis] / (kFarthest * mesh.requested_dx_m));
    count[axis] =
        static_cast<int>(std::clamp<double>(wanted, kFewestAlongAnEdge, kMostAlongAnEdge));
  }
  return count;
}

/// The points of a grid over a weight's box that lie in the mesh.
std::vector<MeshPoint> points_under(const HexMesh& mesh, const PointMass& weight) {
  const Eigen::Vector3i count = grid_over(mesh, weight.size);
  std::vector<MeshPoint> points;
  for (int k = 0; k < count.z(); ++k)
    for (int j = 0; j < count.y(); ++j)
      for (int i = 0; i < count.x(); ++i) {
        const Eigen::Array3d part =
            (Eigen::Array3d(i, j, k) + 0.5) / count.cast<double>().array() - 0.5;
        MeshPoint point = locate(mesh, weight.at + (part * weight.size.array()).matrix());
        if (point.distance_m <= kOutside * mesh.requested_dx_m) points.push_back(std::move(point));
      }
  return points;
}

}  // namespace

std::vector<WeightAtPoint> weights_at_points(const HexMesh& mesh,
                                             const std::vector<PointMass>& weights) {
  std::vector<WeightAtPoint> shares;
  for (const PointMass& weight : weights) {
    if (weight.size.isZero(0.0)) {
      shares.push_back({locate(mesh, weight.at), weight.mass_kg});
      continue;
    }
    std::vector<MeshPoint> points = points_under(mesh, weight);
    if (points.empty()) {
      const Eigen::Vector3d at = weight.at * kMillimetresPerMetre;
      throw InputError(
          fmt::format("the weight of {} g around ({}, {}, {}) mm touches none of the part, must "
                      "lie in or on it",
                      weight.mass_kg / kKilogramsPerGram,
                      at.x(),
                      at.y(),
                      at.z()));
    }
    const double share = weight.mass_kg / static_cast<double>(points.size());
    for (MeshPoint& point : points) shares.push_back({std::move(point), share});
  }
  return shares;
}

void attach_weights(ElasticBody& body, const std::vector<PointMass>& weights) {
  for (const WeightAtPoint& weight : weights_at_points(body.mesh(), weights))
    body.add_point_mass(weight.point, weight.mass_kg);
}

}  // namespace twang
