// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/plane_map.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang::test {

using Points = std::vector<Eigen::Vector2d>;

inline const Points kBench_m = {{-7e-3, -22e-3}, {87e-3, -25e-3}, {82e-3, 21e-3}, {-9e-3, 19e-3}};

/// Picture from plane: 6 px/mm, turned, shifted and seen at a slant.
inline Homography px_from_plane() {
  Homography map;
  map << 5900.0, 500.0, 90.0, -450.0, 6100.0, 160.0, 0.9, -0.4, 1.0;
  return map;
}

inline PointPairs pairs_of(const Homography& map, const Points& points) {
  PointPairs pairs{points, {}};
  for (const auto& point : points) pairs.to.push_back(map_point(map, point));
  return pairs;
}

}  // namespace twang::test
