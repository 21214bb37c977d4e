// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/trace_of_tracks.hpp"

#include "capture/find_layout.hpp"
#include "core/constants.hpp"
#include "core/units.hpp"
#include "rigs/observable.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>

namespace twang::detail {
namespace {

constexpr double kShown = 1e-9;       // component of an axis from which the image shows it
constexpr std::size_t kMapsRest = 2;  // fixed markers from which the rig's rest positions are known

using Positions = std::vector<Eigen::Vector3d>;

/// A marker's positions in the rig frame [m]; nan where lost or doubled.
Positions rig_positions(const Camera& camera,
                        const Marker& marker,
                        const std::vector<Eigen::Vector2d>& plane) {
  const Eigen::Vector2d rest = plane_position(camera, marker.position);
  Positions positions;
  positions.reserve(plane.size());
  for (const Eigen::Vector2d& at : plane) {
    const Eigen::Vector2d moved = at - rest;
    positions.push_back(marker.position + moved.x() * camera.image_right +
                        moved.y() * camera.image_down);
  }
  return positions;
}

class TraceBuilder {
 public:
  TraceBuilder(const Rig& rig, const TrackedFilm& film)
      : m_rig(rig), m_camera(*rig.camera), m_film(film) {}

  Trace build() {
    m_trace.time_s = m_film.time_s;
    for (std::size_t i = 0; i < m_film.tracks.size(); ++i) add_marker(i);
    if (m_rig.observable) add_observable();
    return std::move(m_trace);
  }

 private:
  [[nodiscard]] bool missing(const MarkerTrack& track, std::size_t n) const {
    return m_film.doubled[n] || !track.position_px[n].allFinite();
  }

  std::vector<double>& add_channel(std::string name) {
    m_trace.channels.push_back({std::move(name), std::vector<double>(m_trace.time_s.size(), kNaN)});
    return m_trace.channels.back().values;
  }

  /// How much later than the frame's first row a place is read [s].
  [[nodiscard]] double row_offset_s(const Eigen::Vector2d& px) const {
    const Eigen::Vector2d last = (m_film.size_px.array() - 1).cast<double>();
    double row = 0.0;
    double last_row = 0.0;
    for (int axis = 0; axis < 2; ++axis) {
      const int step = m_film.row_step[axis];
      row += step < 0 ? last[axis] - px[axis] : step * px[axis];
      last_row += std::abs(step) * last[axis];
    }
    return m_camera.readout_s * row / std::max(1.0, last_row);
  }

  void add_marker(std::size_t i) {
    const Marker& marker = m_rig.markers[i];
    const MarkerTrack& track = m_film.straight[i];
    std::vector<Eigen::Vector2d> plane(track.position_px.size(), Eigen::Vector2d::Constant(kNaN));
    std::vector<double> sigma_m(plane.size(), kNaN);
    for (std::size_t n = 0; n < plane.size(); ++n) {
      if (missing(track, n)) continue;
      const Homography& plane_from_px = m_film.map.at(n);
      plane[n] = map_point(plane_from_px, track.position_px[n]);
      const Eigen::Matrix2d jacobian = map_jacobian(plane_from_px, track.position_px[n]);
      const double of_map = m_film.map.noise_m.empty() ? 0.0 : m_film.map.noise_m[i][n];
      sigma_m[n] = std::hypot(track.sigma_px[n] * jacobian.norm() / std::sqrt(2.0), of_map);
    }
    m_settled.push_back(rig_positions(m_camera, marker, {settled_position(plane)}).front());
    m_positions.push_back(rig_positions(m_camera, marker, plane));

    for (const auto& [axis, letter] : {std::pair{0, 'x'}, {1, 'y'}, {2, 'z'}}) {
      if (std::hypot(m_camera.image_right[axis], m_camera.image_down[axis]) < kShown) continue;
      std::vector<double>& values = add_channel(marker.id + '.' + letter + "_mm");
      for (std::size_t n = 0; n < plane.size(); ++n) {
        values[n] = kMillimetresPerMetre * m_positions.back()[n][axis];
      }
    }
    std::vector<double>& sigma = add_channel(marker.id + ".sigma_mm");
    for (std::size_t n = 0; n < plane.size(); ++n) sigma[n] = kMillimetresPerMetre * sigma_m[n];
    m_sigmas_m.push_back(std::move(sigma_m));
    if (m_camera.readout_s > 0.0) {
      std::vector<double>& offset = add_channel(marker.id + ".time_offset_s");
      for (std::size_t n = 0; n < plane.size(); ++n) {
        if (!missing(track, n)) offset[n] = row_offset_s(m_film.tracks[i].position_px[n]);
      }
      m_offsets_s.push_back(offset);
    }
  }

  void add_observable() {
    const ObservableDefinition& definition = *m_rig.observable;
    const auto num_fixed = std::count_if(
        m_rig.markers.begin(), m_rig.markers.end(), [](const Marker& m) { return m.fixed; });
    std::vector<std::size_t> which;
    Positions rest;
    for (const std::string& id : definition.markers) {
      for (std::size_t i = 0; i < m_rig.markers.size(); ++i) {
        if (m_rig.markers[i].id != id) continue;
        which.push_back(i);
        const bool known = static_cast<std::size_t>(num_fixed) >= kMapsRest;
        rest.push_back(known ? m_rig.markers[i].position : m_settled[i]);
      }
    }
    const bool angle = definition.kind == ObservableKind::Angle;
    const double unit = angle ? 1.0 : kMillimetresPerMetre;
    std::vector<double> values(m_trace.time_s.size(), kNaN);
    std::vector<double> sigma(values.size(), kNaN);
    std::vector<double> offset_s(values.size(), kNaN);
    for (std::size_t n = 0; n < values.size(); ++n) {
      offset_s[n] = mean_offset_s(which, n);
      Positions now;
      for (const std::size_t i : which) now.push_back(position_at(i, n, offset_s[n]));
      const bool complete =
          std::all_of(now.begin(), now.end(), [](const auto& p) { return p.allFinite(); });
      if (!complete) continue;
      values[n] = unit * evaluate_observable(m_rig, now, rest);
      const Eigen::Matrix3Xd gradient = observable_gradient(m_rig, now);
      double variance = 0.0;
      for (std::size_t k = 0; k < which.size(); ++k) {
        variance += std::pow(
            gradient.col(static_cast<Eigen::Index>(k)).norm() * m_sigmas_m[which[k]][n], 2);
      }
      sigma[n] = unit * std::sqrt(variance);
    }
    if (angle) unwrap(values);
    add_channel(observable_column(definition.kind)) = std::move(values);
    add_channel("observable.sigma_" + observable_unit(definition.kind)) = std::move(sigma);
    if (m_camera.readout_s > 0.0) add_channel("observable.time_offset_s") = std::move(offset_s);
  }

  /// Mean of some markers' row times in a frame; 0 without a rolling shutter [s].
  [[nodiscard]] double mean_offset_s(const std::vector<std::size_t>& which, std::size_t n) const {
    double sum = 0.0;
    for (const std::size_t i : which) sum += m_offsets_s.empty() ? 0.0 : m_offsets_s[i][n];
    return sum / static_cast<double>(which.size());
  }

  /// A marker's position so long after the start of frame `n`: Lagrange's polynomial through its
  /// samples around, at their own times.
  [[nodiscard]] Eigen::Vector3d position_at(std::size_t i, std::size_t n, double offset_s) const {
    const Positions& positions = m_positions[i];
    if (m_offsets_s.empty() || !positions[n].allFinite()) return positions[n];
    const std::vector<double>& own_s = m_offsets_s[i];
    const std::vector<double>& time_s = m_film.time_s;
    if (own_s[n] == offset_s) return positions[n];
    const double at_s = offset_s - own_s[n];  // from this marker's own sample
    const bool later = at_s > 0.0;
    std::vector<std::size_t> nodes = {n};
    // Outwards, first to the side where the time lies; a gap ends a side.
    bool open[2] = {true, true};
    for (std::size_t reach = 1; reach <= kReadoutNeighbours / 2; ++reach) {
      for (const bool forward : {later, !later}) {
        if (!open[forward] || nodes.size() >= kReadoutNeighbours) continue;
        const bool inside = forward ? n + reach < positions.size() : n >= reach;
        const std::size_t k = forward ? n + reach : n - reach;
        open[forward] = inside && positions[k].allFinite();
        if (open[forward]) nodes.push_back(k);
      }
    }
    if (nodes.size() < 2) return Eigen::Vector3d::Constant(kNaN);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const std::size_t a : nodes) {
      double weight = 1.0;
      const double node_s = time_s[a] + own_s[a];
      for (const std::size_t b : nodes) {
        const double other_s = time_s[b] + own_s[b];
        if (b != a) weight *= (time_s[n] + offset_s - other_s) / (node_s - other_s);
      }
      sum += weight * positions[a];
    }
    return sum;
  }

  const Rig& m_rig;
  const Camera& m_camera;
  const TrackedFilm& m_film;
  std::vector<Positions> m_positions;            // one a marker
  std::vector<std::vector<double>> m_sigmas_m;   // [marker][frame]
  std::vector<std::vector<double>> m_offsets_s;  // [marker][frame]; empty: global shutter
  Positions m_settled;
  Trace m_trace;
};

}  // namespace

std::vector<MarkerTrack> straightened(const std::vector<MarkerTrack>& tracks, const Lens& lens) {
  std::vector<MarkerTrack> straight = tracks;
  for (MarkerTrack& track : straight) {
    for (std::size_t n = 0; n < track.position_px.size(); ++n) {
      Eigen::Vector2d& px = track.position_px[n];
      px = lens.undistorted(px);
      if (!px.allFinite()) continue;
      // Areas grow by the determinant; a sigma is that of either coordinate.
      track.sigma_px[n] /= std::sqrt(lens.distortion_jacobian(px).determinant());
    }
  }
  return straight;
}

Trace trace_of_tracks(const Rig& rig, const TrackedFilm& film) {
  return TraceBuilder(rig, film).build();
}

}  // namespace twang::detail
