// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/marker_candidates.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <complex>
#include <vector>

namespace twang::detail {

/// A map plane -> picture without reflection: z_px = scale z + shift, in complex numbers with the
/// picture's axes (x right, y down) [px/m], [px].
struct PlaneSimilarity {
  std::complex<double> scale = 0.0;
  std::complex<double> shift = 0.0;

  [[nodiscard]] Eigen::Vector2d apply(const Eigen::Vector2d& plane) const;
};

/// The similarity that takes `plane` to `px` with the least squares; two points or more.
[[nodiscard]] PlaneSimilarity fit_similarity(const std::vector<Eigen::Vector2d>& plane,
                                             const std::vector<Eigen::Vector2d>& px);

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

/// Which candidate each marker is.
struct Constellation {
  std::vector<int> candidate;  ///< one a marker; -1: none found
  PlaneSimilarity px_from_plane;
  double cost = 0.0;    ///< sum of squared deviations in sigmas, a fixed price for each missing one
  int num_matched = 0;  ///< markers with a candidate
};

/// Best assignment and the ones that are about as good.
struct ConstellationMatch {
  std::vector<Constellation> about_as_good;  ///< best first; empty if nothing fits at all
};

/// Finds the assignment of candidates to markers under which the picture is a similarity of the
/// rig's layout, turned by no more than `most_turn_rad`, sizes included.
///
/// Hypotheses come from pairs (fixed markers first: they are at rest) and are judged by all others.
[[nodiscard]] ConstellationMatch match_constellation(const std::vector<LayoutMarker>& markers,
                                                     const std::vector<MarkerCandidate>& candidates,
                                                     double most_turn_rad);

}  // namespace twang::detail
