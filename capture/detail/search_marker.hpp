// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/align_marker.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang::detail {

/// A place in a picture that looks like a marker, to a pixel.
struct MarkerPeak {
  Eigen::Vector2d position_px;
  double correlation;  ///< with the marker's ideal picture [-]
};

/// Places within `reach_px` of `middle_px` (along either axis) where the picture correlates with a
/// marker of that shape by `least` or more: local maxima at least half a size apart, best first.
[[nodiscard]] std::vector<MarkerPeak> search_marker(const LumaFrame& frame,
                                                    const MarkerTemplate& marker,
                                                    const Eigen::Matrix2d& px_from_pattern,
                                                    const Eigen::Vector2d& middle_px,
                                                    double reach_px,
                                                    double least);

}  // namespace twang::detail
