// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/render_film.hpp"
#include "core/constants.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <cmath>
#include <string>

namespace twang::test {

inline constexpr double kKindSize_m = 8e-3;
inline constexpr double kKindPitch_m = 16e-3;

/// A marker of a kind, named after it; tags of the middle of their dictionaries.
inline Marker marker_of_kind(MarkerKind kind) {
  Marker marker;
  marker.id = to_string(kind);
  marker.kind = kind;
  marker.size_m = kKindSize_m;
  if (kind == MarkerKind::ArUco) {
    marker.dictionary = "DICT_6X6_250";
    marker.tag = 123;
  } else if (kind == MarkerKind::AprilTag) {
    marker.dictionary = "tag36h11";
    marker.tag = 321;
  }
  return marker;
}

/// A bench with a dot near each corner, in the middle a row of one moving marker of each kind; seen
/// along +y, z up.
inline Rig rig_of_seven_kinds() {
  Rig rig;
  rig.name = "seven kinds";
  rig.camera = Camera{};
  rig.camera->capture_fps = 240.0;
  double x = -3.0 * kKindPitch_m;
  for (const MarkerKind kind : {MarkerKind::Cross,
                                MarkerKind::Dot,
                                MarkerKind::Ring,
                                MarkerKind::Checker,
                                MarkerKind::ArUco,
                                MarkerKind::AprilTag,
                                MarkerKind::Patch}) {
    Marker marker = marker_of_kind(kind);
    marker.position = {x, 0.0, (kind == MarkerKind::Ring || kind == MarkerKind::ArUco ? 2e-3 : 0)};
    rig.markers.push_back(marker);
    x += kKindPitch_m;
  }
  const auto bench = [&](const char* id, double at_x, double at_z) {
    Marker marker = marker_of_kind(MarkerKind::Dot);
    marker.id = id;
    marker.fixed = true;
    marker.position = {at_x, 0.0, at_z};
    rig.markers.push_back(marker);
  };
  bench("bench_1", -50e-3, 19e-3);
  bench("bench_2", 49e-3, 20e-3);
  bench("bench_3", -47e-3, -20e-3);
  bench("bench_4", 51e-3, -19e-3);
  return rig;
}

/// Everything at rest; the tags turned so.
inline FilmedState seven_at_rest(const Rig& rig, double tag_turn_rad = 0.0) {
  FilmedState state;
  for (const Marker& marker : rig.markers) {
    const bool tag = marker.kind == MarkerKind::ArUco || marker.kind == MarkerKind::AprilTag;
    state.markers.push_back({marker.position, tag ? tag_turn_rad : 0.0});
  }
  return state;
}

/// Everything that is not fixed swings up and down and, less, to the side. The tags are turned a
/// little: where all edges run along the pixels, what the film's discrete blur differs from a
/// lens's by is the same at all of them and shifts the marker by up to 0.02 px.
inline FilmedState seven_swinging(const Rig& rig, double amplitude_m, double time_s) {
  FilmedState state = seven_at_rest(rig, 0.1);
  for (std::size_t i = 0; i < rig.markers.size(); ++i) {
    if (rig.markers[i].fixed) continue;
    const double decay = std::exp(-2.0 * time_s);
    const double phase = kTwoPi * 7.3 * time_s;
    state.markers[i].position +=
        amplitude_m * decay * Eigen::Vector3d(0.3 * std::sin(1.37 * phase), 0.0, std::cos(phase));
  }
  return state;
}

/// A film in which the markers are about so large, lossless.
inline FilmOptions film_of_seven(double size_px) {
  FilmOptions options;
  const double px_per_m = size_px / kKindSize_m;
  options.width_px = 2 * static_cast<int>(std::ceil(0.5 * px_per_m * 130e-3));
  options.height_px = 2 * static_cast<int>(std::ceil(0.5 * px_per_m * 70e-3));
  options.duration_s = 1.0 / options.fps;
  options.crf = 0;
  return options;
}

}  // namespace twang::test
