// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/place_patches.hpp"

#include "capture/detail/layout_map.hpp"
#include "capture/detail/spline_picture.hpp"
#include "core/dense_algebra.hpp"
#include "core/error.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace twang::detail {
namespace {

// With this, noise of 2 grey levels leaves 0.03 px of uncertainty in a patch of 40 px. Noise alone,
// smoothed, has a slope of a fifth of its standard deviation.
constexpr double kLeastSlope = 1.5;  // [grey levels/px]
constexpr double kSlopeSmoothing_px = 1.0;
constexpr double kSmallestPatch_px = 8.0;
constexpr std::size_t kLeastPrinted = 2;  // markers, to say where an unstated patch is

std::string rig_name(const Rig& rig) {
  return rig.file.empty() ? "rig '" + rig.name + "'" : rig.file.string();
}

/// How far the part has moved at a place, from the printed markers on it: their mean, weighted by
/// the inverse square of the distance [px].
Eigen::Vector2d motion_at(const PatchSearch& search,
                          const PartialLayout& layout,
                          const Eigen::Vector2d& rest) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < search.rig.markers.size(); ++i) {
    const Marker& marker = search.rig.markers[i];
    if (marker.fixed || !layout.markers[i]) continue;
    const Eigen::Vector2d plane = plane_position(*search.rig.camera, marker.position);
    const double near =
        std::max((plane - rest).squaredNorm(), 1e-2 * marker.size_m * marker.size_m);
    sum += (layout.markers[i]->alignment.placement.position_px -
            map_point(layout.px_from_plane, plane)) /
           near;
    total += 1.0 / near;
  }
  return total > 0.0 ? Eigen::Vector2d(sum / total) : sum;
}

/// The map from the rest plane if there are patches alone: through their stated places.
Homography map_of_starts(const PatchSearch& search) {
  std::vector<LayoutPair> pairs;
  for (const Marker& marker : search.rig.markers) {
    const auto start = search.start_px.find(marker.id);
    if (start == search.start_px.end()) continue;
    pairs.push_back({plane_position(*search.rig.camera, marker.position), start->second, 1.0});
  }
  if (pairs.size() < 2) {
    throw InputError(
        fmt::format("{}: has no marker but patches, must have another kind beside them or the "
                    "places of two patches by --marker id=x,y, to give the scale",
                    rig_name(search.rig)));
  }
  return fit_weighted_similarity(pairs);
}

/// Where a patch lies in the picture.
MarkerPlacement placement_of(const PatchSearch& search,
                             const PartialLayout& layout,
                             const Marker& marker) {
  const Eigen::Vector2d rest = plane_position(*search.rig.camera, marker.position);
  MarkerPlacement placement;
  placement.px_from_pattern = marker.size_m * map_jacobian(layout.px_from_plane, rest);
  const auto start = search.start_px.find(marker.id);
  placement.position_px = start != search.start_px.end()
                              ? start->second
                              : Eigen::Vector2d(map_point(layout.px_from_plane, rest) +
                                                motion_at(search, layout, rest));
  return placement;
}

/// What is wrong with a patch there, as the end of a sentence; empty if nothing is.
std::string complaint(const LumaFrame& frame, const MarkerPlacement& placement) {
  const Eigen::Vector2d& at = placement.position_px;
  const Eigen::Vector2d reach = 0.5 * placement.px_from_pattern.cwiseAbs().rowwise().sum();
  if (!((at - reach).minCoeff() >= 0.0 && at.x() + reach.x() <= frame.width_px - 1 &&
        at.y() + reach.y() <= frame.height_px - 1)) {
    return "does not lie within the picture";
  }
  const double size_px = placed_size_px(placement);
  if (size_px < kSmallestPatch_px) {
    return fmt::format("is {:.1f} pixels large, must be {} or more", size_px, kSmallestPatch_px);
  }
  const double slope = least_slope(frame, placement);
  if (slope < kLeastSlope) {
    return fmt::format(
        "has too little texture to fix both coordinates: its brightness changes by {:.1f} grey "
        "levels a pixel in its plainest direction, must be {} or more",
        slope,
        kLeastSlope);
  }
  return "";
}

}  // namespace

Rig without_patches(const Rig& rig) {
  Rig printed = rig;
  std::erase_if(printed.markers,
                [](const Marker& marker) { return marker.kind == MarkerKind::Patch; });
  return printed;
}

double least_slope(const LumaFrame& frame, const MarkerPlacement& placement) {
  const Eigen::Matrix2d& P = placement.px_from_pattern;
  const Eigen::Vector2d reach = 0.5 * P.cwiseAbs().rowwise().sum();
  const SplinePicture picture(frame, placement.position_px, reach, kSlopeSmoothing_px);
  const int samples = std::max(4, static_cast<int>(std::ceil(placed_size_px(placement))));
  Eigen::Matrix2d tensor = Eigen::Matrix2d::Zero();
  const Eigen::Vector2d right(0.5, 0.0);
  const Eigen::Vector2d down(0.0, 0.5);
  for (int j = 0; j < samples; ++j) {
    for (int i = 0; i < samples; ++i) {
      const Eigen::Vector2d uv((i + 0.5) / samples - 0.5, (j + 0.5) / samples - 0.5);
      const Eigen::Vector2d at = placement.position_px + P * uv;
      const Eigen::Vector2d slope(picture.at(at + right) - picture.at(at - right),
                                  picture.at(at + down) - picture.at(at - down));
      tensor += slope * slope.transpose() / (samples * samples);
    }
  }
  return std::sqrt(std::max(0.0, symmetric_eigen(tensor).values[0]));
}

PartialLayout place_patches(const PatchSearch& search, PartialLayout printed) {
  const std::vector<Marker>& markers = search.rig.markers;
  PartialLayout layout = std::move(printed);
  const std::size_t num_printed = layout.markers.size();
  std::vector<std::optional<FittedMarker>> all(markers.size());
  for (std::size_t i = 0, next = 0; i < markers.size(); ++i) {
    if (markers[i].kind != MarkerKind::Patch) all[i] = std::move(layout.markers[next++]);
  }
  layout.markers = std::move(all);
  for (const Marker& marker : markers) {
    if (marker.kind != MarkerKind::Patch || num_printed >= kLeastPrinted ||
        search.start_px.count(marker.id) > 0) {
      continue;
    }
    throw InputError(
        fmt::format("{}: the place of patch '{}' is not known, must be given by --marker {}=x,y or "
                    "by two markers of other kinds",
                    rig_name(search.rig),
                    marker.id,
                    marker.id));
  }
  if (num_printed == 0) {
    layout.px_from_plane = map_of_starts(search);
    layout.usable = true;
  }
  if (!layout.usable) return layout;
  const PartialLayout of_printed = layout;
  for (std::size_t i = 0; i < markers.size(); ++i) {
    if (markers[i].kind != MarkerKind::Patch) continue;
    const MarkerPlacement placement = placement_of(search, of_printed, markers[i]);
    const std::string wrong = complaint(search.frame, placement);
    if (!wrong.empty()) {
      layout.problem = fmt::format("{}: patch '{}' at ({:.0f}, {:.0f}) in {} {}",
                                   search.film,
                                   markers[i].id,
                                   placement.position_px.x(),
                                   placement.position_px.y(),
                                   search.picture,
                                   wrong);
      layout.usable = false;
      layout.hopeless = true;
      return layout;
    }
    MarkerTemplate cut = MarkerTemplate::cut_out(
        MarkerPattern(markers[i]), search.frame, placement.position_px, placement.px_from_pattern);
    cut.mark_even();
    layout.markers[i] = FittedMarker{cut, align_marker(search.frame, cut, placement)};
    // The reference is where it was cut out, whatever noise says.
    layout.markers[i]->alignment.placement = placement;
    ++layout.num_found;
  }
  return layout;
}

}  // namespace twang::detail
