// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace twang {

/// How the stamps of a film were read.
struct TimeBaseSummary {
  double file_fps = 0.0;  ///< the container's declaration if the stamps fit it within a tick, else
                          ///< a line through them [1/s]
  double capture_fps = 0.0;  ///< used [1/s]
  std::string source;  ///< of capture_fps: "rig", "--capture-fps", "tag", "container", "stamps"
  int frames = 0;      ///< decoded
  int doubled = 0;     ///< repeated pictures
  int gaps = 0;        ///< frames missing by the stamps
};

struct TimeBase {
  std::vector<double> time_s;  ///< one a frame, 0 at the first, strictly increasing [s]
  TimeBaseSummary summary;
};

/// A rate that overrules the file's, and who stated it.
struct StatedRate {
  double fps = 0.0;
  std::string source;
};

/// Corrects the stamps of a film, once.
///
/// If the stamps fit the declared rate within a tick (gaps of whole frames allowed) they are
/// regularised to n / rate, else kept as they are and the file's rate is the slope of a line
/// through them. A stated rate always overrules: stamps are scaled by file rate / stated rate.
///
/// @param stamps_s  as read, in order of presentation; nan where the file has none [s]
/// @param tick_s    resolution of the stamps [s]
/// @throws InputError if two stamps are equal or run backwards, or there is neither a stamp nor any
/// rate
[[nodiscard]] TimeBase correct_time_base(const std::vector<double>& stamps_s,
                                         double tick_s,
                                         std::optional<double> declared_fps,
                                         std::optional<StatedRate> stated);

}  // namespace twang
