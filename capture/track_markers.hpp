// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/image.hpp"
#include "capture/time_base.hpp"
#include "core/progress.hpp"
#include "core/trace.hpp"
#include "rigs/rig.hpp"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace twang {

struct TrackOptions {
  std::optional<double> capture_fps;  ///< overrules rig and file [1/s]
  std::map<std::string, Eigen::Vector2d>
      start_px;                    ///< where a marker stands in the first frame, by id [px]
  std::filesystem::path overlay;   ///< film to write with the tracks drawn in; empty: none
  ProgressCallback progress = {};  ///< frames done of frames expected
  void check() const;
};

/// How one marker fared.
struct MarkerTrack {
  std::string id;
  std::vector<Eigen::Vector2d> position_px;  ///< one a frame; nan where lost [px]
  std::vector<double> sigma_px;              ///< of one coordinate, one a frame [px]
  int frames_lost = 0;
  std::string lost_because;  ///< the first reason, for a person; empty if never lost
  double coding_px = 0.0;    ///< part of sigma_px that compression adds, see TrackNoise [px]
};

/// A film turned into marker positions.
struct TrackResult {
  Trace trace;  ///< as the trace file has it: mm, rad, `<marker>.x_mm`, `observable_*` ...
  std::vector<MarkerTrack> tracks;  ///< in the rig's order, in pixels
  TimeBaseSummary time_base;
  double mm_per_px = 0.0;  ///< scale at rest [mm/px]
  double plane_residual_px =
      0.0;            ///< rms of the fixed markers about the plane map; 0 with under three [px]
  Image first_frame;  ///< grey
  Image first_frame_with_tracks;   ///< colour: the found layout and the paths, for the report
  std::vector<std::string> notes;  ///< one sentence each
};

/// Tracks the rig's markers through a film and maps them into the rig frame.
///
/// Markers are found in the first frame from the rig's layout where that is unambiguous, else from
/// `start_px`.
///
/// @throws InputError if the file is no film or cannot be decoded at all or to its end, the rig
/// lacks markers or camera,
///         a marker is not found or could be one of several, a `start_px` names no marker or a
///         place outside; Cancelled
[[nodiscard]] TrackResult track_markers(const Rig& rig,
                                        const std::filesystem::path& video,
                                        const TrackOptions& options = {});

}  // namespace twang
