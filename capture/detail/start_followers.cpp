// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/start_followers.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang::detail {
namespace {

constexpr double kReachOfRelease = 1.2;  // a marker may stand on a longer lever than the release
constexpr double kReachOfExtent = 0.2;   // of one that was never seen and has no stated release

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double due_size_px(const PartialLayout& layout, const Camera& camera, const Marker& marker) {
  const Eigen::Vector2d rest = plane_position(camera, marker.position);
  return marker.size_m *
         std::sqrt(std::abs(map_jacobian(layout.px_from_plane, rest).determinant()));
}

/// What is usual of the markers in the layout.
UsualLooks usual_looks(const PartialLayout& layout, const Rig& rig) {
  std::vector<double> scores, sizes, contrasts, blurs;
  for (std::size_t i = 0; i < layout.markers.size(); ++i) {
    if (!layout.markers[i]) continue;
    const MarkerAlignment& found = layout.markers[i]->alignment;
    scores.push_back(found.score);
    sizes.push_back(placed_size_px(found.placement) /
                    due_size_px(layout, *rig.camera, rig.markers[i]));
    contrasts.push_back(found.contrast);
    blurs.push_back(layout.markers[i]->marker.blur_px());
  }
  return {median(scores), median(sizes), median(contrasts), median(blurs)};
}

double extent_px(const PartialLayout& layout, const Rig& rig) {
  double extent = 0.0;
  for (const Marker& a : rig.markers) {
    for (const Marker& b : rig.markers) {
      extent = std::max(extent,
                        (map_point(layout.px_from_plane, plane_position(*rig.camera, a.position)) -
                         map_point(layout.px_from_plane, plane_position(*rig.camera, b.position)))
                            .norm());
    }
  }
  return extent;
}

}  // namespace

std::vector<MarkerFollower> start_followers(const Rig& rig, PartialLayout layout) {
  const Camera& camera = *rig.camera;
  const UsualLooks usual = usual_looks(layout, rig);
  std::vector<MarkerFollower> followers;
  for (std::size_t i = 0; i < rig.markers.size(); ++i) {
    const Marker& marker = rig.markers[i];
    const Eigen::Vector2d rest = plane_position(camera, marker.position);
    const auto to_px = [&](const Eigen::Vector2d& p) { return map_point(layout.px_from_plane, p); };
    MarkerBackground background;
    background.rest_px = to_px(rest);
    if (!marker.fixed && rig.release && rig.release->displacement) {
      const Eigen::Vector2d far =
          plane_position(camera, marker.position + kReachOfRelease * *rig.release->displacement);
      background.reach_px = (to_px(far) - background.rest_px).norm();
    } else if (!marker.fixed && !layout.markers[i]) {
      background.reach_px = kReachOfExtent * extent_px(layout, rig);
    }
    if (layout.markers[i]) {
      followers.emplace_back(std::move(*layout.markers[i]), background);
    } else {
      const Eigen::Matrix2d jacobian = map_jacobian(layout.px_from_plane, rest);
      followers.emplace_back(
          MarkerPattern(marker),
          MarkerPlacement{background.rest_px, marker.size_m * jacobian, Eigen::Vector2d::Zero()},
          background,
          usual);
    }
  }
  return followers;
}

}  // namespace twang::detail
