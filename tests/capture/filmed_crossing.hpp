// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/render_film.hpp"
#include "capture/track_markers.hpp"
#include "capture/video_writer.hpp"
#include "core/constants.hpp"
#include "rigs/rig.hpp"
#include "tests/capture/filmed_rig.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace twang::test {

/// A dot; all dots of these rigs look alike.
inline Marker dot(std::string id, double x_mm, double z_mm, bool fixed, double size_mm = 4.0) {
  Marker marker;
  marker.id = std::move(id);
  marker.kind = MarkerKind::Dot;
  marker.size_m = 1e-3 * size_mm;
  marker.position = {1e-3 * x_mm, 0.0, 1e-3 * z_mm};
  marker.fixed = fixed;
  return marker;
}

/// Four dots on the bench about a field of 110 x 60 mm; seen along +y, z up.
inline Rig dotted_bench() {
  Rig rig;
  rig.name = "bench";
  rig.camera = Camera{};
  rig.markers = {dot("bench_1", -55.0, 30.0, true),
                 dot("bench_2", 53.0, 28.0, true),
                 dot("bench_3", 56.0, -29.0, true),
                 dot("bench_4", -52.0, -31.0, true)};
  return rig;
}

/// A free vibration about rest along one direction, held until `release_s`.
struct Swing {
  Eigen::Vector2d amplitude_mm = Eigen::Vector2d::Zero();  ///< right, up
  double frequency_hz = 0.0;
  double decay_per_s = 0.0;
  double release_s = 0.0;
  double phase_rad = 0.0;

  [[nodiscard]] Eigen::Vector3d at(double time_s) const {
    const double t = std::max(0.0, time_s - release_s);
    const double swing =
        std::exp(-decay_per_s * t) * std::cos(kTwoPi * frequency_hz * t + phase_rad);
    return {1e-3 * amplitude_mm.x() * swing, 0.0, 1e-3 * amplitude_mm.y() * swing};
  }
};

/// The rig with some of its markers swinging: one swing a marker, those without are at rest.
inline FilmedState swinging(const Rig& rig, const std::vector<Swing>& swings, double time_s) {
  FilmedState state = at_rest(rig);
  for (std::size_t i = 0; i < swings.size(); ++i) state.markers[i].position += swings[i].at(time_s);
  return state;
}

/// Rewrites a film, each picture changed by `change`; the size may change too.
inline void change_film(const std::filesystem::path& from,
                        const std::filesystem::path& to,
                        const std::function<void(std::size_t, Image&)>& change) {
  std::vector<Image> images = read_film(from);
  for (std::size_t n = 0; n < images.size(); ++n) change(n, images[n]);
  VideoWriter writer(to, images[0].width_px, images[0].height_px, {.fps = 240.0, .crf = 12});
  for (const Image& image : images) writer.write(image);
  writer.finish();
}

inline void paint_box(Image& image, const Eigen::Vector2d& middle, int half, int grey) {
  for (int dy = -half; dy <= half; ++dy) {
    for (int dx = -half; dx <= half; ++dx) {
      const int x = static_cast<int>(middle.x()) + dx;
      const int y = static_cast<int>(middle.y()) + dy;
      if (x < 0 || y < 0 || x >= image.width_px || y >= image.height_px) continue;
      image.pixels[static_cast<std::size_t>(y * image.width_px + x)] =
          static_cast<std::uint8_t>(grey);
    }
  }
}

/// How a marker's track compares with the truth.
struct Fidelity {
  int wrong = 0;   ///< frames in which it was found more than a pixel off: another one, or none
  int due = 0;     ///< frames in which it should have been found
  int missed = 0;  ///< of these, not found
  double worst_px = 0.0;
  [[nodiscard]] double found() const { return due > 0 ? 1.0 - double(missed) / due : 1.0; }
};

/// @param due  whether a marker is in plain view and apart from others in a frame
inline Fidelity fidelity(const MarkerTrack& track,
                         const std::vector<std::vector<Eigen::Vector2d>>& truth_px,
                         std::size_t marker,
                         const std::function<bool(std::size_t frame)>& due) {
  Fidelity result;
  for (std::size_t n = 0; n < track.position_px.size(); ++n) {
    const bool found = track.position_px[n].allFinite();
    if (found) {
      const double error = (track.position_px[n] - truth_px[n][marker]).norm();
      result.worst_px = std::max(result.worst_px, error);
      result.wrong += error > 1.0 ? 1 : 0;
    }
    if (!due(n)) continue;
    ++result.due;
    result.missed += found ? 0 : 1;
  }
  return result;
}

/// Distance to the nearest other marker in a frame [px].
inline double nearest_other(const std::vector<Eigen::Vector2d>& places, std::size_t marker) {
  double nearest = kInfinity;
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (k != marker) nearest = std::min(nearest, (places[k] - places[marker]).norm());
  }
  return nearest;
}

}  // namespace twang::test
