// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/plane_map.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

#include <Eigen/Dense>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

using Points = std::vector<Eigen::Vector2d>;

// The settled position is looked for in this last part of a film.
constexpr double kSettledPart = 0.3;
// Reduced chi-square up to which fixed markers are said to stand still, or to move as one: sigmas
// hold to about a factor 1.5, compression makes neighbouring frames err alike.
constexpr double kMostChiSquare = 3.0;
// Below this scatter a camera is at rest whatever the sigmas say.
constexpr double kStillCamera_px = 0.01;
constexpr int kMostIterations = 20;
// Smallest over largest singular value of points that still span a plane.
constexpr double kLeastSpread = 1e-3;
// Of known positions, from which slant and perspective are to be read all over the plane.
constexpr double kLeastAcross = 0.05;

Eigen::Vector2d mean_of(const Points& points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const auto& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

/// Moves the mean to the origin and the rms distance to sqrt(2).
Homography normalisation(const Points& points) {
  const Eigen::Vector2d mean = mean_of(points);
  double square = 0.0;
  for (const auto& point : points) square += (point - mean).squaredNorm();
  const double scale = std::sqrt(2.0 * static_cast<double>(points.size()) / square);
  Homography map;
  map << scale, 0.0, -scale * mean.x(), 0.0, scale, -scale * mean.y(), 0.0, 0.0, 1.0;
  return map;
}

/// The two rows of the direct linear transform per point.
Homography direct_linear_transform(const PointPairs& pairs) {
  const Eigen::Index n = static_cast<Eigen::Index>(pairs.from.size());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(std::max<Eigen::Index>(2 * n, 9), 9);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Eigen::RowVector3d p = pairs.from[k].homogeneous().transpose();
    A.block<1, 3>(2 * i, 0) = p;
    A.block<1, 3>(2 * i, 6) = -pairs.to[k].x() * p;
    A.block<1, 3>(2 * i + 1, 3) = p;
    A.block<1, 3>(2 * i + 1, 6) = -pairs.to[k].y() * p;
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeFullV);
  if (!(svd.singularValues()[7] > kLeastSpread * svd.singularValues()[0])) {
    throw InputError(
        "the fixed markers leave the plane's map undetermined, no three of four may be on a line");
  }
  const Eigen::Matrix<double, 9, 1> h = svd.matrixV().col(8);
  Homography map;
  map << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8];
  return map / map(2, 2);
}

/// Gauss-Newton on the distances in `to`, the last entry held at one.
Homography refine(Homography map, const PointPairs& pairs) {
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    Eigen::Matrix<double, 8, 8> normal = Eigen::Matrix<double, 8, 8>::Zero();
    Eigen::Matrix<double, 8, 1> gradient = Eigen::Matrix<double, 8, 1>::Zero();
    for (std::size_t i = 0; i < pairs.from.size(); ++i) {
      const Eigen::RowVector3d p = pairs.from[i].homogeneous().transpose();
      const Eigen::Vector2d mapped = map_point(map, pairs.from[i]);
      const double w = map.row(2).dot(p);
      Eigen::Matrix<double, 2, 8> J = Eigen::Matrix<double, 2, 8>::Zero();
      J.block<1, 3>(0, 0) = p / w;
      J.block<1, 3>(1, 3) = p / w;
      J.block<2, 2>(0, 6) = -mapped * p.head<2>() / w;
      normal += J.transpose() * J;
      gradient += J.transpose() * (pairs.to[i] - mapped);
    }
    const Eigen::Matrix<double, 8, 1> step = normal.ldlt().solve(gradient);
    if (!step.allFinite()) break;
    map.row(0) += step.segment<3>(0).transpose();
    map.row(1) += step.segment<3>(3).transpose();
    map.block<1, 2>(2, 0) += step.segment<2>(6).transpose();
    if (step.norm() < 1e-14 * map.norm()) break;
  }
  return map;
}

double rms_distance(const Homography& map, const PointPairs& pairs) {
  double square = 0.0;
  for (std::size_t i = 0; i < pairs.from.size(); ++i) {
    square += (map_point(map, pairs.from[i]) - pairs.to[i]).squaredNorm();
  }
  return std::sqrt(square / static_cast<double>(pairs.from.size()));
}

}  // namespace

Eigen::Vector2d map_point(const Homography& map, const Eigen::Vector2d& point) {
  return (map * point.homogeneous()).hnormalized();
}

Eigen::Matrix2d map_jacobian(const Homography& map, const Eigen::Vector2d& point) {
  const double w = map.row(2).dot(point.homogeneous());
  return (map.topLeftCorner<2, 2>() - map_point(map, point) * map.block<1, 2>(2, 0)) / w;
}

Homography fit_similarity_map(const PointPairs& pairs) {
  const Eigen::Vector2d from = mean_of(pairs.from);
  const Eigen::Vector2d to = mean_of(pairs.to);
  double along = 0.0;
  double across = 0.0;
  double square = 0.0;
  for (std::size_t i = 0; i < pairs.from.size(); ++i) {
    const Eigen::Vector2d a = pairs.from[i] - from;
    const Eigen::Vector2d b = pairs.to[i] - to;
    along += a.dot(b);
    across += a.x() * b.y() - a.y() * b.x();
    square += a.squaredNorm();
  }
  Eigen::Matrix2d turn;
  turn << along, -across, across, along;
  turn /= square;
  Homography map = Homography::Identity();
  map.topLeftCorner<2, 2>() = turn;
  map.topRightCorner<2, 1>() = to - turn * from;
  return map;
}

Homography fit_homography(const PointPairs& pairs) {
  const Homography from = normalisation(pairs.from);
  const Homography to = normalisation(pairs.to);
  PointPairs normal;
  for (std::size_t i = 0; i < pairs.from.size(); ++i) {
    normal.from.push_back(map_point(from, pairs.from[i]));
    normal.to.push_back(map_point(to, pairs.to[i]));
  }
  const Homography map = refine(direct_linear_transform(normal), normal);
  const Homography result = to.inverse() * map * from;
  return result / result(2, 2);
}

Eigen::Vector2d settled_position(const Points& positions) {
  const auto count = static_cast<double>(positions.size());
  const double first = (1.0 - kSettledPart) * count - 1.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weights = 0.0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const double phase = (static_cast<double>(i) - first) / (count - first);
    if (phase <= 0.0 || !positions[i].allFinite()) continue;
    const double weight = std::pow(std::sin(kPi * phase), 2);  // Hann
    sum += weight * positions[i];
    weights += weight;
  }
  if (weights <= 0.0) return Eigen::Vector2d::Constant(kNaN);
  return sum / weights;
}

namespace {

/// The fixed markers of a film and how their camera moved.
class CameraMotion {
 public:
  explicit CameraMotion(const std::vector<PlaneMarker>& markers) {
    for (const PlaneMarker& marker : markers) {
      m_num_frames = marker.position_px->size();
      if (!marker.fixed) continue;
      m_fixed.push_back(&marker);
      m_mean.push_back(mean_position(marker));
    }
    m_still = chi_square([](std::size_t) { return Homography::Identity(); }, 0.0, scatter_px) <
                  kMostChiSquare ||
              scatter_px < kStillCamera_px;
  }

  [[nodiscard]] bool still() const { return m_still; }
  [[nodiscard]] const std::vector<const PlaneMarker*>& fixed() const { return m_fixed; }
  [[nodiscard]] const Points& mean() const { return m_mean; }
  [[nodiscard]] std::size_t num_frames() const { return m_num_frames; }

  /// The fixed markers seen in a frame and where they are on the mean.
  [[nodiscard]] PointPairs seen(std::size_t frame) const {
    PointPairs pairs;
    for (std::size_t i = 0; i < m_fixed.size(); ++i) {
      const Eigen::Vector2d& px = (*m_fixed[i]->position_px)[frame];
      if (!px.allFinite()) continue;
      pairs.from.push_back(px);
      pairs.to.push_back(m_mean[i]);
    }
    return pairs;
  }

  /// A frame's picture brought onto the mean one: shift, or similarity.
  [[nodiscard]] Homography steady_from_frame(std::size_t frame) const {
    const PointPairs pairs = seen(frame);
    if (pairs.from.size() >= 2) return fit_similarity_map(pairs);
    Homography shift = Homography::Identity();
    if (pairs.from.empty()) return Homography::Constant(kNaN);
    shift.topRightCorner<2, 1>() = pairs.to[0] - pairs.from[0];
    return shift;
  }

  /// Reduced chi-square of the fixed markers about their means after a map of each frame that
  /// spends `parameters`.
  template <typename Map>
  double chi_square(const Map& map, double parameters, double& rms_px) const {
    double sum = 0.0;
    double count = 0.0;
    double square = 0.0;
    double freedom = -2.0 * static_cast<double>(m_fixed.size());
    for (std::size_t n = 0; n < m_num_frames; ++n) {
      const Homography steady = map(n);
      double seen_here = 0.0;
      for (std::size_t i = 0; i < m_fixed.size(); ++i) {
        const Eigen::Vector2d& px = (*m_fixed[i]->position_px)[n];
        if (!px.allFinite() || !steady.allFinite()) continue;
        const double distance = (map_point(steady, px) - m_mean[i]).squaredNorm();
        sum += distance / std::pow((*m_fixed[i]->sigma_px)[n], 2);
        square += distance;
        seen_here += 2.0;
      }
      count += seen_here;
      freedom += std::max(0.0, seen_here - parameters);
    }
    rms_px = count > 0.0 ? std::sqrt(square / count) : 0.0;
    return freedom > 0.0 ? sum / freedom : 0.0;
  }

  double scatter_px = 0.0;  // of the fixed markers about their means, one coordinate [px]

 private:
  static Eigen::Vector2d mean_position(const PlaneMarker& marker) {
    Points finite;
    for (const auto& px : *marker.position_px) {
      if (px.allFinite()) finite.push_back(px);
    }
    if (finite.empty()) {
      throw InputError(fmt::format("fixed marker '{}' is never seen", marker.id));
    }
    return mean_of(finite);
  }

  std::vector<const PlaneMarker*> m_fixed;
  Points m_mean;
  std::size_t m_num_frames = 0;
  bool m_still = true;
};

/// Where the markers settle, brought onto the mean picture, and where they are at rest.
PointPairs settled_pairs(const std::vector<PlaneMarker>& markers, const CameraMotion& camera) {
  PointPairs pairs;
  for (const PlaneMarker& marker : markers) {
    Points steady = *marker.position_px;
    if (!camera.fixed().empty() && !camera.still()) {
      for (std::size_t n = 0; n < steady.size(); ++n) {
        steady[n] = map_point(camera.steady_from_frame(n), steady[n]);
      }
    }
    const Eigen::Vector2d settled = settled_position(steady);
    if (!settled.allFinite()) continue;
    pairs.from.push_back(settled);
    pairs.to.push_back(marker.rest);
  }
  return pairs;
}

/// Picture and rig share their axes; a marker's size gives the scale.
Homography map_by_size(const PlaneMarker& marker, const Eigen::Vector2d& px) {
  const double m_per_px = marker.size_m / marker.size_px;
  Homography map = Homography::Identity();
  map.topLeftCorner<2, 2>() *= m_per_px;
  map.topRightCorner<2, 1>() = marker.rest - m_per_px * px;
  return map;
}

/// Whether four markers or more spread far enough off any line to show slant and perspective.
bool span_plane(const std::vector<const PlaneMarker*>& fixed) {
  if (fixed.size() < 4) return false;
  Eigen::Matrix2Xd rests(2, fixed.size());
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    rests.col(static_cast<Eigen::Index>(i)) = fixed[i]->rest;
  }
  rests.colwise() -= Eigen::Vector2d(rests.rowwise().mean());
  const Eigen::Vector2d spread = Eigen::JacobiSVD<Eigen::Matrix2Xd>(rests).singularValues();
  return spread[1] > kLeastAcross * spread[0];
}

/// The map of the mean picture, and a sentence on where it is from.
Homography mean_map(const std::vector<PlaneMarker>& markers,
                    const CameraMotion& camera,
                    std::vector<std::string>& notes) {
  const std::size_t num_fixed = camera.fixed().size();
  if (num_fixed >= 2) {
    PointPairs pairs{camera.mean(), {}};
    for (const PlaneMarker* marker : camera.fixed()) pairs.to.push_back(marker->rest);
    notes.push_back(fmt::format("Scale and rest come from {} fixed markers ({}).",
                                num_fixed,
                                span_plane(camera.fixed()) ? "homography" : "similarity"));
    return span_plane(camera.fixed()) ? fit_homography(pairs) : fit_similarity_map(pairs);
  }
  const PointPairs settled = settled_pairs(markers, camera);
  if (settled.from.empty()) {
    throw InputError("no marker is seen in the last part of the film, where it should be at rest");
  }
  Homography map;
  if (settled.from.size() >= 2) {
    map = fit_similarity_map(settled);
    notes.push_back(fmt::format("Scale and turn come from where {} markers settle at the end.",
                                settled.from.size()));
  } else {
    const auto& marker = *std::find_if(
        markers.begin(), markers.end(), [&](const auto& m) { return settled.to[0] == m.rest; });
    map = map_by_size(marker, settled.from[0]);
    notes.push_back(fmt::format("The scale comes from the size of marker '{}' alone.", marker.id));
  }
  if (num_fixed == 1) {
    const Eigen::Vector2d off = camera.fixed()[0]->rest - map_point(map, camera.mean()[0]);
    map.topRightCorner<2, 1>() += off;
  }
  return map;
}

}  // namespace

PlaneMap map_plane(const std::vector<PlaneMarker>& markers) {
  CameraMotion camera(markers);
  PlaneMap result;
  const Homography mean = mean_map(markers, camera, result.notes);
  const std::size_t num_fixed = camera.fixed().size();
  Points rests;
  for (const PlaneMarker& marker : markers) rests.push_back(marker.rest);
  const Eigen::Vector2d middle_px = map_point(mean.inverse(), mean_of(rests));
  result.mm_per_px =
      kMillimetresPerMetre * std::sqrt(std::abs(map_jacobian(mean, middle_px).determinant()));

  const auto residual_of = [&](const PointPairs& px) {
    PointPairs plane{px.from, {}};
    for (const PlaneMarker* marker : camera.fixed()) plane.to.push_back(marker->rest);
    return rms_distance(mean, plane) * kMillimetresPerMetre / result.mm_per_px;
  };
  if (camera.still()) {
    result.plane_from_px = {mean};
    if (num_fixed > 0) {
      result.notes.push_back(fmt::format(
          "The camera stood still (fixed markers scatter by {:.3f} px): one map serves all frames.",
          camera.scatter_px));
    }
    if (num_fixed >= 3) result.residual_px = residual_of({camera.mean(), {}});
    return result;
  }

  double left_px = 0.0;
  const double chi_square =
      camera.chi_square([&](std::size_t n) { return camera.steady_from_frame(n); }, 4.0, left_px);
  const bool whole =
      span_plane(camera.fixed()) && chi_square > kMostChiSquare && left_px > kStillCamera_px;
  for (std::size_t n = 0; n < camera.num_frames(); ++n) {
    const PointPairs seen = camera.seen(n);
    const bool own = whole && seen.from.size() >= 4;
    result.plane_from_px.push_back(mean *
                                   (own ? fit_homography(seen) : camera.steady_from_frame(n)));
  }
  result.notes.push_back(fmt::format(
      "The camera moved (fixed markers scatter by {:.2f} px): its {} is taken out frame by frame.",
      camera.scatter_px,
      whole            ? "homography"
      : num_fixed >= 2 ? "similarity"
                       : "shift"));
  if (num_fixed >= 3) {
    result.residual_px = std::hypot(left_px, residual_of({camera.mean(), {}}));
  }
  return result;
}

}  // namespace twang
