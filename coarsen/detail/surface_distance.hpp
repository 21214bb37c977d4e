// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <array>
#include <vector>

namespace twang {

using Triangle = std::array<int, 3>;

/// Closest point to `p` of the triangle a b c.
[[nodiscard]] Eigen::Vector3d closest_point_of_triangle(const Eigen::Vector3d& p,
                                                        const Eigen::Vector3d& a,
                                                        const Eigen::Vector3d& b,
                                                        const Eigen::Vector3d& c);

/// Hausdorff distance of two surfaces with the same triangles and different vertices: the largest
/// distance of a vertex of one from the other surface, both ways.
///
/// @param first, second  vertices, (3 x n) each [m]
/// @return  [m]; never above the largest distance of two vertices of the same number
[[nodiscard]] double hausdorff_distance(const Eigen::Matrix3Xd& first,
                                        const Eigen::Matrix3Xd& second,
                                        const std::vector<Triangle>& triangles);

}  // namespace twang
