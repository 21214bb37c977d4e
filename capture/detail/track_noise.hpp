// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace twang::detail {

/// How a marker's measured positions scatter, judged by the positions alone.
struct TrackNoise {
  double scatter_px = 0.0;  ///< of one coordinate, white from frame to frame [px]
  double motion_px = 0.0;   ///< rms of the motion about its mean, one coordinate [px]
};

/// The part of a track that no vibration explains.
///
/// Damped sinusoids, an offset and a drift obey a linear recurrence: windows of L consecutive
/// positions then lie in a subspace of few dimensions, and what stands out of it is noise. The
/// subspace is that of the strongest eigenvectors of the windows' covariance (singular spectrum
/// analysis, Broomhead & King 1986); the variance is a low quantile over the windows, so that
/// plucking hands do not count. It sees what no single picture shows: that a codec moves whole
/// markers.
///
/// @param position_px  one a frame; nan where lost; frames are evenly spaced [px]
/// @return             nothing if there are too few windows without a gap
[[nodiscard]] std::optional<TrackNoise> measure_track_noise(
    const std::vector<Eigen::Vector2d>& position_px);

/// Widens the sigmas of a film's tracks to what their positions scatter.
///
/// A moving marker's sigmas grow by what its scatter exceeds their mean square; a marker that
/// stands, which a codec does not code anew, by a part of what the moving ones showed, as its
/// error does not scatter. Where nothing can be measured, by the usual error of a codec.
///
/// @param position_px, sigma_px  [marker][frame]; nan where lost [px]
/// @param cut_out                one a marker: its reference was cut out of a picture, whose own
///                               noise its residuals hold too; its sigmas may shrink to the scatter
/// @return                       what was added to each marker's sigmas, in quadrature [px]
std::vector<double> widen_by_scatter(
    const std::vector<const std::vector<Eigen::Vector2d>*>& position_px,
    const std::vector<std::vector<double>*>& sigma_px,
    const std::vector<bool>& cut_out = {});

}  // namespace twang::detail
