// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/picture_map.hpp"

#include <Eigen/LU>

namespace twang {

Eigen::Vector2d PictureMap::seen_at(std::size_t frame, const Eigen::Vector2d& plane) const {
  const Homography& map = plane_from_px.size() == 1 ? plane_from_px.front() : plane_from_px[frame];
  Eigen::Vector2d px = map_point(map.inverse(), plane);
  px.x() /= pixel_aspect;
  return lens ? lens->distorted(px) : px;
}

}  // namespace twang
