// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/lens.hpp"
#include "capture/plane_fit.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <optional>
#include <vector>

namespace twang {

/// How a film shows the rig's rest plane.
struct PictureMap {
  std::vector<Homography> plane_from_px;  ///< one a frame; one alone if the camera stood still; of
                                          ///< square pixels and a straight picture [m]
  double pixel_aspect = 1.0;              ///< width of the film's pixels over their height [-]
  std::optional<Lens> lens = {};          ///< that bends the picture

  /// Where a point of the rest plane (right, down) is seen in a frame [px].
  /// @param plane  [m]
  [[nodiscard]] Eigen::Vector2d seen_at(std::size_t frame, const Eigen::Vector2d& plane) const;
};

}  // namespace twang
