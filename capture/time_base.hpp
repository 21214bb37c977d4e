// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/note.hpp"

#include <optional>
#include <string>
#include <vector>

namespace twang {

/// What the time of a film is.
enum class TimeBaseKind {
  Constant,    ///< an even clock, shown as fast as it was filmed
  Variable,    ///< stamps that no even clock explains, kept as they are
  SlowMotion,  ///< shown more slowly than it was filmed, the stamps even or not
  FastMotion   ///< shown faster than it was filmed
};

/// How the stamps of a film were read.
struct TimeBaseSummary {
  double file_fps = 0.0;  ///< the container's declaration if the stamps fit it within a tick, else
                          ///< a line through them [1/s]
  double capture_fps = 0.0;  ///< used [1/s]
  std::string
      source;  ///< of capture_fps: "rig", "--capture-fps", "tag", "container", "stamps", "clock"
  int frames = 0;   ///< decoded
  int doubled = 0;  ///< repeated pictures
  int gaps = 0;     ///< frames missing by the stamps
  TimeBaseKind kind = TimeBaseKind::Constant;
  bool even = true;     ///< the frames are those of an even clock; else the stamps are kept
  double tick_s = 0.0;  ///< to which the stamps are rounded; coarser than the file's own where the
                        ///< film was copied from a file with coarser ones [s]
  double jitter_s = 0.0;  ///< rms distance of the stamps from an even clock, rounding included [s]
  std::optional<double> declared_fps;  ///< by the container [1/s]
  std::optional<double> tag_fps;       ///< by the camera's tag [1/s]
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
/// If the stamps are those of an even clock, rounded (gaps of whole frames allowed), they are
/// regularised to n / rate: the declared rate if they fit it, else that of a line through them or a
/// usual rate this cannot be told from. Else they are kept as they are and the file's rate is the
/// slope of the line. A stated rate always overrules: stamps are scaled by file rate / stated rate.
/// So does the camera's tag where no rate is stated and it speaks of slow or fast motion; a tag
/// near the file's rate is a nominal value, to which the stamps are not bent.
///
/// @param stamps_s  as read, in order of presentation; nan where the file has none [s]
/// @param tick_s    resolution of the stamps [s]
/// @param tag_fps   rate at which the camera says it filmed [1/s]
/// @throws InputError if two stamps are equal or run backwards, or there is neither a stamp nor any
/// rate
[[nodiscard]] TimeBase correct_time_base(const std::vector<double>& stamps_s,
                                         double tick_s,
                                         std::optional<double> declared_fps,
                                         std::optional<StatedRate> stated,
                                         std::optional<double> tag_fps = {});

/// The word for it: "constant", "variable", "slow motion", "fast motion".
[[nodiscard]] std::string word_for(TimeBaseKind kind);

/// What a person should know of a film's time, one sentence each: first what it is and how much
/// slower or faster than filmed the file plays; then, where it is so, that frames are missing, that
/// the rate is a television rate, that tags, stamps and stated rates contradict each other. What
/// may make the time base wrong is a warning.
[[nodiscard]] std::vector<Note> describe_time_base(const TimeBaseSummary& summary);

}  // namespace twang
