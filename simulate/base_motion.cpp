// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/base_motion.hpp"

#include <algorithm>
#include <cstddef>

namespace twang {
namespace {

/// Derivative, at sample `i`, of the parabola through it and its neighbours (at an end, through the
/// first or last three).
Eigen::Vector3d slope(const std::vector<double>& t, const Eigen::Matrix3Xd& x, Eigen::Index i) {
  const Eigen::Index last = x.cols() - 1;
  const Eigen::Index middle = std::clamp<Eigen::Index>(i, 1, last - 1);
  const auto at = [&](Eigen::Index k) { return t[static_cast<std::size_t>(k)]; };
  const Eigen::Vector3d left = (x.col(middle) - x.col(middle - 1)) / (at(middle) - at(middle - 1));
  const Eigen::Vector3d right = (x.col(middle + 1) - x.col(middle)) / (at(middle + 1) - at(middle));
  const double span = at(middle + 1) - at(middle - 1);
  // Newton's divided differences: p' = left + curvature (2 t - t_left - t_middle).
  return left + (right - left) / span * (2.0 * at(i) - at(middle - 1) - at(middle));
}

}  // namespace

Eigen::Vector3d base_velocity(const std::vector<double>& time_s,
                              const Eigen::Matrix3Xd& displacement,
                              double at_s) {
  if (at_s < time_s.front() || at_s > time_s.back()) return Eigen::Vector3d::Zero();
  const auto upper = std::upper_bound(time_s.begin(), time_s.end(), at_s);
  const auto count = static_cast<std::ptrdiff_t>(time_s.size());
  const Eigen::Index i = std::clamp<std::ptrdiff_t>(upper - time_s.begin() - 1, 0, count - 2);
  const double width =
      time_s[static_cast<std::size_t>(i) + 1] - time_s[static_cast<std::size_t>(i)];
  const double s = (at_s - time_s[static_cast<std::size_t>(i)]) / width;
  const Eigen::Vector3d chord = (displacement.col(i + 1) - displacement.col(i)) / width;
  return 6.0 * s * (1.0 - s) * chord +
         (1.0 - 4.0 * s + 3.0 * s * s) * slope(time_s, displacement, i) +
         (3.0 * s * s - 2.0 * s) * slope(time_s, displacement, i + 1);
}

}  // namespace twang
