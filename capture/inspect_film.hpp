// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/time_base.hpp"
#include "core/progress.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace twang {

struct InspectOptions {
  std::optional<double> capture_fps;                ///< overrules rig and file [1/s]
  std::map<std::string, Eigen::Vector2d> start_px;  ///< where a marker stands, by id [px]
  ProgressCallback progress = {};
};

/// A marker as the film shows it.
struct InspectedMarker {
  std::string id;
  Eigen::Vector2d position_px = Eigen::Vector2d::Zero();
  double size_px = 0.0;   ///< outer size [px]
  double blur_px = 0.0;   ///< standard deviation of the blur of its edges [px]
  double contrast = 0.0;  ///< paper over ink [grey levels]
  double ink = 0.0;       ///< brightness of the ink [grey levels]
};

/// What a film is like, before it is tracked.
struct FilmInspection {
  std::string film;
  int width_px = 0;
  int height_px = 0;
  TimeBaseSummary time_base;
  std::optional<double> declared_fps;     ///< of the container [1/s]
  std::optional<double> capture_fps_tag;  ///< of the camera [1/s]
  double least_interval_s = 0.0;          ///< between frames [s]
  double largest_interval_s = 0.0;        ///< [s]

  std::string not_found;                 ///< why the layout was not found; empty if it was
  int frame = 0;                         ///< in which it was found
  std::vector<InspectedMarker> markers;  ///< those found in that frame, in the rig's order
  std::vector<std::string> hidden;       ///< ids of those that were not
  double px_per_m = 0.0;                 ///< scale of the rest plane in its middle [px/m]

  double black_part = 0.0;         ///< pixels at the lower end of the scale [-]
  double white_part = 0.0;         ///< pixels at its upper end [-]
  double noise = 0.0;              ///< one sigma from frame to frame [grey levels]
  std::optional<double> shake_px;  ///< rms of a coordinate of the fixed markers' common motion;
                                   ///< absent without a fixed marker [px]
};

/// Looks at a film's clock, its light, its sharpness and its steadiness, and for the layout in the
/// first frame that shows enough of it.
/// @throws InputError as `track_markers` for a film that cannot be read or whose stamps are no
/// clock; a layout that is not found is a result
[[nodiscard]] FilmInspection inspect_film(const Rig& rig,
                                          const std::filesystem::path& video,
                                          const InspectOptions& options = {});

}  // namespace twang
