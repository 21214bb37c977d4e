// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/detail/part_surface.hpp"

#include "core/constants.hpp"

#include <algorithm>
#include <cmath>

namespace twang::detail {
namespace {

double distance(const Box& box, const Eigen::Vector3d& point) { return box.distance(point); }

double distance(const Cylinder& cylinder, const Eigen::Vector3d& point) {
  const double length = (cylinder.to - cylinder.from).norm();
  const Eigen::Vector3d axis = (cylinder.to - cylinder.from) / length;
  const double along = (point - cylinder.from).dot(axis);
  const double across = (point - cylinder.from - along * axis).norm();
  const double beyond_end = std::max({-along, along - length, 0.0});
  return std::hypot(beyond_end, std::max(across - cylinder.radius, 0.0));
}

double distance(const SurfaceFile& /*surface*/, const Eigen::Vector3d& /*point*/) {
  return kInfinity;
}

}  // namespace

double distance_to_part(const std::vector<PartSolid>& solids, const Eigen::Vector3d& point) {
  double nearest = kInfinity;
  for (const PartSolid& solid : solids) {
    nearest = std::min(
        nearest,
        std::visit([&](const auto& shape) { return distance(shape, point); }, solid.shape));
  }
  return nearest;
}

bool reaches_surface(const std::vector<PartSolid>& solids,
                     const Eigen::Vector3d& point,
                     double reach) {
  // A face exactly `reach` away is reached: solids include their lower faces, so step over it.
  const double step = reach * (1.0 + 1e-9);
  constexpr int kSpread = 3;
  for (int i = -kSpread; i <= kSpread; ++i) {
    for (int j = -kSpread; j <= kSpread; ++j) {
      for (int k = -kSpread; k <= kSpread; ++k) {
        if (i == 0 && j == 0 && k == 0) continue;
        const Eigen::Vector3d direction = Eigen::Vector3d(i, j, k).normalized();
        const Eigen::Vector3d probe = point + step * direction;
        if (std::none_of(solids.begin(), solids.end(), [&](const PartSolid& solid) {
              return contains(solid, probe);
            })) {
          return true;
        }
      }
    }
  }
  return false;
}

}  // namespace twang::detail
