// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/marker_pattern.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang::detail {

/// A marker as the layout search sees it.
struct LayoutMarker {
  MarkerPattern pattern;
  Eigen::Vector2d rest = Eigen::Vector2d::Zero();   ///< in the plane of image_right, image_down [m]
  Eigen::Vector2d reach = Eigen::Vector2d::Zero();  ///< it may stand between rest and rest + reach
                                                    ///< [m]
  double loose = 0.0;   ///< one sigma of where it may stand beside that, any direction [m]
  double size_m = 0.0;  ///< [m]
  bool fixed = false;
  int given = -1;  ///< the candidate it must be; -1: any
};

/// All of a rig's markers, in its order; the rig has a camera.
[[nodiscard]] std::vector<LayoutMarker> layout_markers(const Rig& rig);

}  // namespace twang::detail
