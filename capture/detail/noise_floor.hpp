// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/track_markers.hpp"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace twang::detail {

/// Scatter of one coordinate of a point while it is still, in the positions' unit; nan if it never
/// is.
///
/// In each stretch of `kStillFrames` the scatter about a straight line is taken, so that slow drift
/// does not count. A stretch is still if that is no more than `kStillOverSigma` of the stated
/// sigmas, and of the still ones those count that are about as quiet as the quietest: before a
/// release, or after all has settled, but not while the last of a vibration dies away.
///
/// @param positions  one a frame, nan where lost
/// @param sigmas     stated, of a coordinate, one a frame
[[nodiscard]] double scatter_while_still(const std::vector<Eigen::Vector2d>& positions,
                                         const std::vector<double>& sigmas);

inline constexpr int kStillFrames = 12;
inline constexpr double kStillOverSigma = 5.0;

/// A sentence on the noise floors of the moving markers; empty if none was ever still.
[[nodiscard]] std::string describe_noise_floors(const std::vector<MarkerTrack>& tracks,
                                                const std::vector<bool>& fixed,
                                                double mm_per_px);

}  // namespace twang::detail
