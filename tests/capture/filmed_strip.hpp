// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/render_film.hpp"
#include "core/constants.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace twang::test {

/// A strip 80 x 10 x 2 mm, clamped at x = 0, with a cross near its tip and dots on the bench.
inline Rig strip_rig(int num_fixed = 4) {
  Rig rig;
  rig.name = "strip";
  rig.markers.push_back({.id = "tip",
                         .kind = MarkerKind::Cross,
                         .size_m = 5e-3,
                         .position = {76e-3, 0.0, 1e-3},
                         .fixed = false,
                         .dictionary = "",
                         .tag = -1});
  const std::vector<Eigen::Vector3d> bench = {
      {-7e-3, 0.0, 22e-3}, {87e-3, 0.0, 25e-3}, {82e-3, 0.0, -21e-3}, {-9e-3, 0.0, -19e-3}};
  for (int i = 0; i < num_fixed; ++i) {
    rig.markers.push_back({.id = "bench_" + std::to_string(i + 1),
                           .kind = MarkerKind::Dot,
                           .size_m = 6e-3,
                           .position = bench[static_cast<std::size_t>(i)],
                           .fixed = true,
                           .dictionary = "",
                           .tag = -1});
  }
  rig.observable =
      ObservableDefinition{ObservableKind::Displacement, {"tip"}, Eigen::Vector3d::UnitZ()};
  rig.release = Release{{80e-3, 5e-3, 2e-3}, Eigen::Vector3d(0.0, 0.0, -3e-3), std::nullopt};
  rig.camera = Camera{};
  rig.camera->capture_fps = 240.0;
  return rig;
}

/// The strip's first bending, held until `release_s`, then free and damped.
struct StripMotion {
  double amplitude_m = 3e-3;  ///< of the free end, downwards when held [m]
  double frequency_hz = 40.0;
  double decay_per_s = 6.0;
  double release_s = 0.05;
  double length_m = 80e-3;

  /// Deflection of the free end, upwards [m].
  [[nodiscard]] double end_at(double time_s) const {
    const double t = std::max(0.0, time_s - release_s);
    return -amplitude_m * std::exp(-decay_per_s * t) * std::cos(kTwoPi * frequency_hz * t);
  }
  /// Shape of the deflection, 1 at the free end: the curve under an end load.
  [[nodiscard]] double shape(double x) const {
    const double s = std::max(0.0, x / length_m);
    return 0.5 * s * s * (3.0 - s);
  }
  [[nodiscard]] double slope(double x) const {
    const double s = std::max(0.0, x / length_m);
    return (3.0 * s - 1.5 * s * s) / length_m;
  }

  [[nodiscard]] FilmedState state_at(const Rig& rig, double time_s) const {
    const double end = end_at(time_s);
    FilmedState state;
    for (const Marker& marker : rig.markers) {
      MarkerPose pose{marker.position, 0.0};
      if (!marker.fixed) {
        pose.position.z() += end * shape(marker.position.x());
        pose.turn_rad = std::atan(end * slope(marker.position.x()));
      }
      state.markers.push_back(pose);
    }
    constexpr int kPieces = 16;
    for (int i = 0; i < kPieces; ++i) {
      const double x0 = length_m * i / kPieces;
      const double x1 = length_m * (i + 1) / kPieces;
      state.part_faces.push_back({Eigen::Vector3d(x0, 0.0, end * shape(x0)),
                                  Eigen::Vector3d(x1, 0.0, end * shape(x1)),
                                  Eigen::Vector3d(x1, 0.0, 2e-3 + end * shape(x1)),
                                  Eigen::Vector3d(x0, 0.0, 2e-3 + end * shape(x0))});
    }
    return state;
  }
};

}  // namespace twang::test
