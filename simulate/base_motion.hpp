// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <vector>

namespace twang {

/// Velocity of a base whose displacement was sampled: the derivative of the cubic Hermite curve
/// through the samples, whose slopes there are those of the parabola through each and its
/// neighbours; continuous, 0 before the first sample and after the last [m/s].
/// @param time_s        increasing, three or more [s]
/// @param displacement  (3 x samples) [m]
[[nodiscard]] Eigen::Vector3d base_velocity(const std::vector<double>& time_s,
                                            const Eigen::Matrix3Xd& displacement,
                                            double at_s);

}  // namespace twang
