// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/track_markers.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <string>
#include <vector>

namespace twang {

/// A stretch in which a marker was lost, on the trace's clock.
struct TimedLoss {
  LostStretch stretch;
  double start_s = 0.0;  ///< of its first frame [s]
  double end_s = 0.0;    ///< of its last frame [s]
};

/// How one marker fared, in few numbers.
struct MarkerSummary {
  std::string id;
  bool fixed = false;
  int frames_seen = 0;
  int frames_lost = 0;
  std::vector<TimedLoss> lost;  ///< in order of time
  double sigma_px = 0.0;        ///< median stated sigma of one coordinate; nan if never seen [px]
  double sigma_mm = 0.0;        ///< the same in the rig's plane [mm]
  double noise_floor_px = 0.0;  ///< scatter of one coordinate while it stands; nan if it never does
                                ///< [px]
  double travel_mm = 0.0;       ///< largest distance between two of its places, along the
                                ///< picture's axes [mm]
};

/// The markers of a tracked film in the rig's order.
[[nodiscard]] std::vector<MarkerSummary> summarize_markers(const Rig& rig,
                                                           const TrackResult& result);

/// Displacement of a marker from its rest position along image right and image down, one a frame,
/// nan where it has none [mm].
[[nodiscard]] std::vector<Eigen::Vector2d> displacement_mm(const Rig& rig,
                                                           const Trace& trace,
                                                           const Marker& marker);

/// Rms distance of the fixed markers from their places, one a frame; nan where fewer than three are
/// seen [px].
[[nodiscard]] std::vector<double> plane_residual_by_frame(const Rig& rig,
                                                          const TrackResult& result);

}  // namespace twang
