// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/layout_marker.hpp"

#include "capture/find_layout.hpp"

#include <algorithm>

namespace twang::detail {
namespace {

// One sigma of where a moving marker may stand: half the release, any direction, or without one
// this part of the layout's extent.
constexpr double kLooseOfRelease = 0.5;
constexpr double kLooseOfExtent = 0.075;

}  // namespace

std::vector<LayoutMarker> layout_markers(const Rig& rig) {
  const Camera& camera = *rig.camera;
  double extent = 0.0;
  for (const Marker& a : rig.markers) {
    for (const Marker& b : rig.markers) {
      extent = std::max(
          extent, (plane_position(camera, a.position) - plane_position(camera, b.position)).norm());
    }
  }
  std::vector<LayoutMarker> markers;
  for (const Marker& marker : rig.markers) {
    LayoutMarker& described = markers.emplace_back(LayoutMarker{MarkerPattern(marker)});
    described.rest = plane_position(camera, marker.position);
    described.size_m = marker.size_m;
    described.fixed = marker.fixed;
    if (!marker.fixed && rig.release && rig.release->displacement) {
      described.reach = plane_position(camera, *rig.release->displacement);
      described.loose = kLooseOfRelease * described.reach.norm();
    } else if (!marker.fixed) {
      described.loose = kLooseOfExtent * extent;
    }
  }
  return markers;
}

}  // namespace twang::detail
