// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <vector>

namespace twang {

/// A projective map of the plane, acting on (x, y, 1).
using Homography = Eigen::Matrix3d;

/// Where a map takes a point.
[[nodiscard]] Eigen::Vector2d map_point(const Homography& map, const Eigen::Vector2d& point);
/// Its derivative there: how a small offset is mapped.
[[nodiscard]] Eigen::Matrix2d map_jacobian(const Homography& map, const Eigen::Vector2d& point);

/// Points seen and where they are known to be.
struct PointPairs {
  std::vector<Eigen::Vector2d> from;
  std::vector<Eigen::Vector2d> to;
  std::vector<double> sigma = {};  ///< one of a coordinate of `to` each; empty: all alike
};

/// The similarity without reflection that takes `from` to `to` with the least squares.
/// @param pairs  two or more, not all at one place
[[nodiscard]] Homography fit_similarity_map(const PointPairs& pairs);

/// The homography that takes `from` to `to`: the direct linear transform on normalised points, then
/// Gauss-Newton on the squared distances in `to`, over their sigmas.
/// @param pairs  four or more, no three of the first four on a line
/// @throws InputError if the points lie on a line and leave the map undetermined
[[nodiscard]] Homography fit_homography(const PointPairs& pairs);

/// Whether points spread far enough off any line to show slant and perspective all over the plane.
[[nodiscard]] bool span_plane(const std::vector<Eigen::Vector2d>& points);

/// What a map is allowed to do.
enum class MapKind {
  Shift,       ///< translation: one point or more
  Similarity,  ///< two or more
  Projective   ///< a homography: four or more
};

/// Number of a map's free parameters.
[[nodiscard]] int num_parameters(MapKind kind);

/// A map as fitted, and how uncertain its points' noise leaves it.
///
/// In coordinates u = (p - centre) scale the map is h(u) = (h0 u + h1 v + h2, h3 u + h4 v + h5) /
/// (h6 u + h7 v + 1).
struct MapFit {
  Homography map = Homography::Identity();
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double scale = 1.0;
  Eigen::Matrix<double, 8, 8> covariance =
      Eigen::Matrix<double, 8, 8>::Zero();  ///< of h0 ... h7: (Jᵀ W J)⁻¹

  /// The map from (u, v), its last entry one.
  [[nodiscard]] Homography centred() const;
  /// Covariance of where the map takes a point that is itself known exactly.
  [[nodiscard]] Eigen::Matrix2d covariance_at(const Eigen::Vector2d& point) const;
  /// Variance of the logarithm of the map's scale √|det J| at a point [-].
  [[nodiscard]] double log_scale_variance_at(const Eigen::Vector2d& point) const;
};

/// Fits a map of a kind with its covariance; `pairs.sigma` empty: as if all were 1.
/// @throws InputError as `fit_homography`
[[nodiscard]] MapFit fit_map(MapKind kind, const PointPairs& pairs);

}  // namespace twang
