// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/lens.hpp"
#include "core/progress.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

namespace twang {

/// Where a marker is, in the picture's plane.
struct MarkerPose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< rig frame [m]
  double turn_rad = 0.0;  ///< from rest, anticlockwise as seen in the image [rad]
};

/// What the camera sees at one moment.
struct FilmedState {
  std::vector<MarkerPose> markers;  ///< in the rig's order
  std::vector<std::array<Eigen::Vector3d, 4>>
      part_faces;  ///< quadrilaterals of the part's surface, any order [m]
};

struct FilmOptions {
  int width_px = 640;
  int height_px = 360;
  double fps = 240.0;       ///< [1/s]
  double duration_s = 1.5;  ///< [s]
  double noise = 2.0;       ///< standard deviation of the sensor's noise [grey levels of 255]
  double exposure = 0.5;    ///< motion blur: open part of the frame interval [-], 0..1
  double tilt_deg = 0.0;    ///< of the camera about its vertical axis [deg]
  double roll_deg = 0.0;    ///< about the line of sight [deg]
  double shake_px = 0.0;    ///< standard deviation of a slow hand-held motion [px]
  double flicker = 0.0;     ///< relative amplitude of the light's 100 Hz ripple [-]
  double doubled = 0.0;     ///< part of the frames that are repeats of the one before [-]
  double defocus_px = 0.8;  ///< standard deviation of the lens's Gaussian blur [px]
  int crf = 14;             ///< H.264 constant rate factor; 0: lossless
  unsigned seed = 1;
  ProgressCallback progress = {};
  double readout_s = 0.0;         ///< rolling shutter, first row to last; 0: global [s]
  std::optional<Lens> lens = {};  ///< bends the picture, scaled to its size; absent: a pinhole
  void check() const;             ///< throws InputError naming field, value, allowed range
};

/// True marker centres, for tests and the truth file.
struct FilmTruth {
  std::vector<double> time_s;  ///< middle of each exposure; of the first row's with a readout [s]
  std::vector<std::vector<Eigen::Vector2d>>
      position_px;  ///< [frame][marker], at that time, or with a readout at that of its row [px]
  std::vector<bool> doubled;  ///< repeats of the frame before
  double mm_per_px = 0.0;     ///< at the middle of the picture [mm/px]
};

/// Renders a film of a moving rig: the part's silhouette, its markers on white paper, a bench,
/// motion blur by sub-exposures, defocus, sensor noise, compression. The file appears whole or not
/// at all; its extension chooses the container. Linear light.
///
/// The rig is seen along its camera's line of sight; everything it shows in the course of the film
/// fits into the picture. Frame n is exposed around n / fps, its rows with `readout_s` one after
/// the other: a marker is drawn where it is when the row of its centre is exposed, and stretched
/// and sheared by its velocity then (rows of one marker differ too little in time for more).
/// Without tilt the map from the rig's plane to pixels is a similarity, with tilt that of a pinhole
/// camera eight picture widths away; with a lens that picture is bent. A marker's truth is the
/// image of its position under that map, shake included.
///
/// @param state_at  what there is to see at a time [s] >= 0; asked in no particular order
/// @throws InputError if the rig lacks markers or camera, or the file cannot be written; Cancelled
FilmTruth render_film(const Rig& rig,
                      const std::function<FilmedState(double time_s)>& state_at,
                      const std::filesystem::path& video,
                      const FilmOptions& options = {});

}  // namespace twang
