// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/plane_map.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang::detail {

/// Where a marker should be in the plane, where it is in the picture, and how far from its due
/// place it may be.
struct LayoutPair {
  Eigen::Vector2d plane;  ///< [m]
  Eigen::Vector2d px;     ///< [px]
  double sigma_px = 1.0;  ///< one standard deviation of one coordinate, > 0 [px]
};

/// The similarity without reflection through weighted pairs; two or more, not all at one place.
[[nodiscard]] Homography fit_weighted_similarity(const std::vector<LayoutPair>& pairs);

/// The homography through weighted pairs that is as near to a similarity as they allow: slant and
/// perspective are held by what a camera at a distance of a few widths, turned by some twenty
/// degrees, shows. So two pairs already determine it, and markers on a line do not upset it.
///
/// @param extent_m  of the whole layout, for scale [m]
[[nodiscard]] Homography fit_layout_map(const std::vector<LayoutPair>& pairs, double extent_m);

}  // namespace twang::detail
