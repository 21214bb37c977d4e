// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/render_film.hpp"
#include "core/constants.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace twang::test {

/// Two markers of one kind that vibrate before four dots on the bench: 40 px each in a picture of
/// 640 x 360.
struct VibratingMarkers {
  double amplitude_m = 0.75e-3;  ///< of either marker: 6 px
  double frequency_hz = 31.7;
  double decay_per_s = 3.0;
  double turn_rad = 0.03;  ///< amplitude of the turn that goes with it
  double rest_until_s = 0.0;

  [[nodiscard]] static Rig rig(MarkerKind kind) {
    Rig rig;
    rig.name = "vibrating markers";
    const auto add = [&](std::string id, MarkerKind picture, double x, double z, bool fixed) {
      Marker& marker = rig.markers.emplace_back();
      marker.id = std::move(id);
      marker.kind = picture;
      marker.size_m = 5e-3;
      marker.position = {x, 0.0, z};
      marker.fixed = fixed;
      if (picture == MarkerKind::ArUco) marker.dictionary = "DICT_4X4_50";
      if (picture == MarkerKind::AprilTag) marker.dictionary = "tag36h11";
      if (!marker.dictionary.empty()) marker.tag = static_cast<int>(rig.markers.size());
    };
    add("left", kind, -9.3e-3, 1.7e-3, false);
    add("right", kind, 11.2e-3, -2.1e-3, false);
    add("bench 1", MarkerKind::Dot, -33e-3, 14.3e-3, true);
    add("bench 2", MarkerKind::Dot, 32.1e-3, 15e-3, true);
    add("bench 3", MarkerKind::Dot, 33e-3, -14.2e-3, true);
    add("bench 4", MarkerKind::Dot, -30.7e-3, -15e-3, true);
    rig.observable =
        ObservableDefinition{ObservableKind::Displacement, {"left"}, Eigen::Vector3d::UnitZ()};
    rig.camera = Camera{};
    rig.camera->capture_fps = 240.0;
    return rig;
  }

  [[nodiscard]] FilmedState state_at(const Rig& rig, double time_s) const {
    FilmedState state;
    for (std::size_t i = 0; i < rig.markers.size(); ++i) {
      MarkerPose pose{rig.markers[i].position, 0.0};
      if (!rig.markers[i].fixed) {
        const double t = std::max(0.0, time_s - rest_until_s);
        const double phase = kTwoPi * frequency_hz * t;
        const double swing = std::exp(-decay_per_s * t) * std::cos(phase);
        const Eigen::Vector3d along =
            i == 0 ? Eigen::Vector3d(0.15, 0.0, 1.0) : Eigen::Vector3d(1.0, 0.0, -0.4);
        pose.position += amplitude_m * swing * along.normalized();
        pose.turn_rad = turn_rad * swing;
      }
      state.markers.push_back(pose);
    }
    return state;
  }
};

}  // namespace twang::test
