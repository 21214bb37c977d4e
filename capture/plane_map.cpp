// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/plane_map.hpp"

#include "capture/detail/camera_motion.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

#include <Eigen/Dense>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

using detail::CameraMotion;
using detail::FixedMarker;
using Points = std::vector<Eigen::Vector2d>;

// The settled position is looked for in this last part of a film.
constexpr double kSettledPart = 0.3;

}  // namespace

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

/// The map of the mean picture, and where it is from.
struct MeanMap {
  MapFit fit;
  PointPairs pairs;  ///< picture to rest plane, what it was fitted to; empty: a marker's size
  MapKind kind = MapKind::Similarity;

  /// Points more than the map needs, in coordinates.
  [[nodiscard]] double freedom() const {
    return 2.0 * static_cast<double>(pairs.from.size()) - num_parameters(kind);
  }
  [[nodiscard]] double sum_of_squares_m2() const {
    double square = 0.0;
    for (std::size_t i = 0; i < pairs.from.size(); ++i) {
      square += (map_point(fit.map, pairs.from[i]) - pairs.to[i]).squaredNorm();
    }
    return square;
  }
};

/// From the tracks of a rig's markers to the plane map.
class PlaneMapper {
 public:
  explicit PlaneMapper(const std::vector<PlaneMarker>& markers) : m_markers(markers) {
    std::vector<FixedMarker> fixed;
    for (std::size_t i = 0; i < markers.size(); ++i) {
      if (!markers[i].fixed) continue;
      const Points& px = *markers[i].position_px;
      if (std::none_of(px.begin(), px.end(), [](const auto& p) { return p.allFinite(); })) {
        throw InputError(fmt::format("fixed marker '{}' is never seen", markers[i].id));
      }
      m_fixed.push_back(i);
      fixed.push_back({markers[i].position_px, markers[i].sigma_px});
    }
    if (!fixed.empty()) m_camera = detail::find_camera_motion(fixed);
  }

  PlaneMap map() {
    find_mean_map();
    Points rests;
    for (const PlaneMarker& marker : m_markers) rests.push_back(marker.rest);
    const Eigen::Vector2d middle_px = map_point(m_mean.fit.map.inverse(), map_middle(rests));
    m_result.mm_per_px = kMillimetresPerMetre *
                         std::sqrt(std::abs(map_jacobian(m_mean.fit.map, middle_px).determinant()));
    judge_mean_map(middle_px);
    follow_camera();
    note_left_out();
    return std::move(m_result);
  }

 private:
  static Eigen::Vector2d map_middle(const Points& points) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const auto& point : points) sum += point;
    return sum / static_cast<double>(points.size());
  }

  void note(std::string sentence, Severity severity = Severity::Remark) {
    m_result.notes.emplace_back(std::move(sentence), severity);
  }

  /// Where the markers settle, brought onto the mean picture, and where they are at rest.
  [[nodiscard]] PointPairs settled_pairs() const {
    PointPairs pairs;
    for (const PlaneMarker& marker : m_markers) {
      Points steady = *marker.position_px;
      for (std::size_t n = 0; n < steady.size() && !m_camera.still(); ++n) {
        steady[n] = map_point(m_camera.mean_from_frame[n].map, steady[n]);
      }
      const Eigen::Vector2d settled = settled_position(steady);
      if (!settled.allFinite()) continue;
      pairs.from.push_back(settled);
      pairs.to.push_back(marker.rest);
    }
    return pairs;
  }

  /// Picture and rig share their axes; a marker's size gives the scale.
  void map_by_size(const PlaneMarker& marker, const Eigen::Vector2d& px) {
    const double m_per_px = marker.size_m / marker.size_px;
    m_mean.fit.map = Homography::Identity();
    m_mean.fit.map.topLeftCorner<2, 2>() *= m_per_px;
    m_mean.fit.map.topRightCorner<2, 1>() = marker.rest - m_per_px * px;
    note(fmt::format("The scale comes from the size of marker '{}' alone.", marker.id),
         Severity::Warning);
  }

  void find_mean_map() {
    if (m_fixed.size() >= 2) {
      m_mean.pairs.from = m_camera.mean_px;
      for (const std::size_t i : m_fixed) m_mean.pairs.to.push_back(m_markers[i].rest);
      if (span_plane(m_mean.pairs.to)) m_mean.kind = MapKind::Projective;
      m_mean.fit = fit_map(m_mean.kind, m_mean.pairs);
      note(fmt::format("Scale and rest come from {} fixed markers ({}).",
                       m_fixed.size(),
                       m_mean.kind == MapKind::Projective ? "homography" : "similarity"));
      return;
    }
    const PointPairs settled = settled_pairs();
    if (settled.from.empty()) {
      throw InputError(
          "no marker is seen in the last part of the film, where it should be at rest");
    }
    if (settled.from.size() >= 2) {
      m_mean.pairs = settled;
      m_mean.fit = fit_map(MapKind::Similarity, settled);
      note(fmt::format("Scale and turn come from where {} markers settle at the end.",
                       settled.from.size()));
    } else {
      const auto& marker = *std::find_if(m_markers.begin(), m_markers.end(), [&](const auto& m) {
        return settled.to[0] == m.rest;
      });
      map_by_size(marker, settled.from[0]);
    }
    if (m_fixed.size() == 1) {
      const Eigen::Vector2d off =
          m_markers[m_fixed[0]].rest - map_point(m_mean.fit.map, m_camera.mean_px[0]);
      m_mean.fit.map.topRightCorner<2, 1>() += off;
    }
  }

  /// Residual and scale's uncertainty by how well the known places agree.
  void judge_mean_map(const Eigen::Vector2d& middle_px) {
    const double freedom = m_mean.pairs.from.empty() ? 0.0 : m_mean.freedom();
    if (freedom <= 0.0) return;
    const double square_m2 = m_mean.sum_of_squares_m2();
    m_result.scale_sigma_rel =
        std::sqrt(square_m2 / freedom * m_mean.fit.log_scale_variance_at(middle_px));
    if (m_fixed.size() < 2) return;
    m_result.residual_mm =
        kMillimetresPerMetre * std::sqrt(square_m2 / static_cast<double>(m_mean.pairs.from.size()));
    m_result.residual_px = m_result.residual_mm / m_result.mm_per_px;
  }

  void follow_camera() {
    if (m_camera.still()) {
      m_result.plane_from_px = {m_mean.fit.map};
      if (!m_fixed.empty()) {
        note(fmt::format(
            "The camera stood still (fixed markers scatter by {:.3f} px): one map serves all "
            "frames.",
            m_fixed.size() > 1 ? m_camera.left_px : m_camera.scatter_px));
      }
    } else {
      for (const MapFit& frame : m_camera.mean_from_frame) {
        m_result.plane_from_px.push_back(m_mean.fit.map * frame.map);
      }
      add_noise();
      note(fmt::format(
          "The camera moved (fixed markers scatter by {:.2f} px): its {} is taken out frame by "
          "frame, {:.3f} px are left.",
          m_camera.scatter_px,
          *m_camera.kind == MapKind::Projective   ? "homography"
          : *m_camera.kind == MapKind::Similarity ? "similarity"
                                                  : "shift",
          m_camera.left_px));
      // Both per point, not per coordinate.
      m_result.residual_px = std::hypot(m_result.residual_px, std::sqrt(2.0) * m_camera.left_px);
      m_result.residual_mm = m_result.residual_px * m_result.mm_per_px;
    }
    if (m_mean.freedom() > 0.0 && m_fixed.size() >= 2) {
      note(
          fmt::format("The fixed markers lie within {:.3f} px ({:.4f} mm) rms of the plane's map; "
                      "by that the scale is good to {:.2g} %.",
                      m_result.residual_px,
                      m_result.residual_mm,
                      100.0 * m_result.scale_sigma_rel));
    }
  }

  /// What the fixed markers' noise makes of each frame's map, at the other markers.
  void add_noise() {
    for (const PlaneMarker& marker : m_markers) {
      std::vector<double>& noise = m_result.noise_m.emplace_back(marker.position_px->size(), 0.0);
      for (std::size_t n = 0; n < noise.size() && !marker.fixed; ++n) {
        const Eigen::Vector2d& px = (*marker.position_px)[n];
        if (!px.allFinite()) continue;
        const MapFit& frame = m_camera.mean_from_frame[n];
        const Eigen::Matrix2d J = map_jacobian(m_mean.fit.map, map_point(frame.map, px));
        noise[n] = m_camera.widening *
                   std::sqrt(0.5 * (J * frame.covariance_at(px) * J.transpose()).trace());
      }
    }
  }

  void note_left_out() {
    m_result.frames_left_out.assign(m_markers.size(), 0);
    for (std::size_t k = 0; k < m_fixed.size(); ++k) {
      const std::vector<bool>& out = m_camera.left_out[k];
      const int count = m_camera.frames_left_out(k);
      m_result.frames_left_out[m_fixed[k]] = count;
      if (count == 0) continue;
      const auto first = std::find(out.begin(), out.end(), true) - out.begin();
      note(fmt::format("Fixed marker '{}' moves against the others, or is misread, in {} of {} "
                       "frames (first {}) and is left out there.",
                       m_markers[m_fixed[k]].id,
                       count,
                       out.size(),
                       first),
           Severity::Warning);
    }
  }

  const std::vector<PlaneMarker>& m_markers;
  std::vector<std::size_t> m_fixed;
  CameraMotion m_camera;
  MeanMap m_mean;
  PlaneMap m_result;
};

}  // namespace

PlaneMap map_plane(const std::vector<PlaneMarker>& markers) { return PlaneMapper(markers).map(); }

}  // namespace twang
