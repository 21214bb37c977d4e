// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/clock_check.hpp"
#include "capture/image.hpp"
#include "capture/picture_map.hpp"
#include "capture/time_base.hpp"
#include "core/constants.hpp"
#include "core/note.hpp"
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
  std::optional<BlinkingLight> clock = {};  ///< a light to hold the film's clock against
  bool clock_correct = false;               ///< scale the time by what the light says
  std::filesystem::path lens;               ///< camera file; overrules the rig's; empty: that one
  void check() const;
};

/// Frames in a row in which a marker was lost.
struct LostStretch {
  std::size_t first_frame = 0;
  std::size_t num_frames = 0;
  std::string reason;        ///< the first frame's, for a person
  bool found_again = false;  ///< in the frame after the last
};

/// How one marker fared.
struct MarkerTrack {
  std::string id;
  std::vector<Eigen::Vector2d> position_px;  ///< one a frame; nan where lost [px]
  std::vector<double> sigma_px;              ///< of one coordinate, one a frame [px]
  int frames_lost = 0;
  std::string lost_because;       ///< the first reason, for a person; empty if never lost
  std::vector<LostStretch> lost;  ///< in the order of time
  double coding_px = 0.0;         ///< part of sigma_px that compression adds, see TrackNoise [px]
  double noise_floor_px = kNaN;   ///< scatter of a coordinate while the marker is still, the
                                  ///< camera's motion and slow drift taken out; nan if it never
                                  ///< is [px]
};

/// A film turned into marker positions.
struct TrackResult {
  Trace trace;  ///< as the trace file has it: mm, rad, `<marker>.x_mm`, `observable_*` ...
  std::vector<MarkerTrack> tracks;  ///< in the rig's order, in pixels
  TimeBaseSummary time_base;
  double mm_per_px = 0.0;  ///< scale at rest [mm/px]
  double plane_residual_px =
      0.0;            ///< rms of the fixed markers about the plane map; 0 with under three [px]
  Image first_frame;  ///< the first in which the layout was found, grey
  Image first_frame_with_tracks;         ///< colour: the found layout and the paths, for the report
  std::vector<Note> notes;               ///< one sentence each
  std::size_t layout_frame = 0;          ///< the number of `first_frame`; before it all is nan
  std::optional<ClockCheck> clock = {};  ///< where a light was given
  double plane_residual_mm = 0.0;        ///< plane_residual_px in the plane [mm]
  double scale_sigma_rel = kNaN;  ///< one sigma of the scale, common to all samples and in none of
                                  ///< their sigmas; nan where nothing tells, see `PlaneMap` [-]
  std::vector<double> size_px;    ///< of each marker in the first frame [px]
  std::vector<bool> doubled;      ///< one a frame: repeats the one before
  PictureMap map;                 ///< how the film shows the rest plane
};

/// Tracks the rig's markers through a film and maps them into the rig frame.
///
/// Markers are found from the rig's layout in the first frame that shows enough of them to leave no
/// doubt, else from `start_px`; before that frame all is nan. A marker that is hidden in it is
/// looked for where the layout puts it until it is seen; one that never is has columns of nan and a
/// warning, unless the observable or the scale needs it. Pixels that are not square are taken as
/// wide as the file says, so that scale and directions are right whatever gives them.
///
/// @throws InputError if the file is no film or cannot be decoded at all or to its end, the rig
/// lacks markers or camera,
///         a marker is never found and needed or could be one of several, a `start_px` names no
///         marker or a place outside; Cancelled
[[nodiscard]] TrackResult track_markers(const Rig& rig,
                                        const std::filesystem::path& video,
                                        const TrackOptions& options = {});

}  // namespace twang
