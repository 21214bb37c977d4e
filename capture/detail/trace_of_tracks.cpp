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
  TraceBuilder(const Rig& rig,
               const std::vector<MarkerTrack>& tracks,
               const PlaneMap& map,
               const std::vector<bool>& doubled)
      : m_rig(rig), m_camera(*rig.camera), m_tracks(tracks), m_map(map), m_doubled(doubled) {}

  Trace build(const std::vector<double>& time_s, int height_px) {
    m_trace.time_s = time_s;
    for (std::size_t i = 0; i < m_tracks.size(); ++i) add_marker(i, height_px);
    if (m_rig.observable) add_observable();
    return std::move(m_trace);
  }

 private:
  [[nodiscard]] bool missing(const MarkerTrack& track, std::size_t n) const {
    return m_doubled[n] || !track.position_px[n].allFinite();
  }

  std::vector<double>& add_channel(std::string name) {
    m_trace.channels.push_back({std::move(name), std::vector<double>(m_trace.time_s.size(), kNaN)});
    return m_trace.channels.back().values;
  }

  void add_marker(std::size_t i, int height_px) {
    const Marker& marker = m_rig.markers[i];
    const MarkerTrack& track = m_tracks[i];
    std::vector<Eigen::Vector2d> plane(track.position_px.size(), Eigen::Vector2d::Constant(kNaN));
    std::vector<double> sigma_m(plane.size(), kNaN);
    for (std::size_t n = 0; n < plane.size(); ++n) {
      if (missing(track, n)) continue;
      const Homography& plane_from_px = m_map.at(n);
      plane[n] = map_point(plane_from_px, track.position_px[n]);
      const Eigen::Matrix2d jacobian = map_jacobian(plane_from_px, track.position_px[n]);
      sigma_m[n] = track.sigma_px[n] * jacobian.norm() / std::sqrt(2.0);
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
    if (m_camera.readout_s > 0.0) {
      std::vector<double>& offset = add_channel(marker.id + ".time_offset_s");
      for (std::size_t n = 0; n < plane.size(); ++n) {
        if (missing(track, n)) continue;
        offset[n] = m_camera.readout_s * track.position_px[n].y() / std::max(1, height_px - 1);
      }
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
    std::vector<double> values(m_trace.time_s.size(), kNaN);
    for (std::size_t n = 0; n < values.size(); ++n) {
      Positions now;
      for (const std::size_t i : which) now.push_back(m_positions[i][n]);
      const bool complete =
          std::all_of(now.begin(), now.end(), [](const auto& p) { return p.allFinite(); });
      if (!complete) continue;
      values[n] = evaluate_observable(m_rig, now, rest) * (angle ? 1.0 : kMillimetresPerMetre);
    }
    if (angle) unwrap(values);
    add_channel(observable_column(definition.kind)) = std::move(values);
  }

  const Rig& m_rig;
  const Camera& m_camera;
  const std::vector<MarkerTrack>& m_tracks;
  const PlaneMap& m_map;
  const std::vector<bool>& m_doubled;
  std::vector<Positions> m_positions;  // one a marker
  Positions m_settled;
  Trace m_trace;
};

}  // namespace

Trace trace_of_tracks(const Rig& rig,
                      const std::vector<MarkerTrack>& tracks,
                      const PlaneMap& map,
                      const std::vector<double>& time_s,
                      const std::vector<bool>& doubled,
                      int height_px) {
  return TraceBuilder(rig, tracks, map, doubled).build(time_s, height_px);
}

}  // namespace twang::detail
