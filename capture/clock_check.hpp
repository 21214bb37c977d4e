// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace twang {

struct LumaFrame;
struct TimeBase;

/// A light of known rate in shot: where it is seen, and how often it blinks.
struct BlinkingLight {
  double x_px = 0.0;       ///< upper left corner of the region [px]
  double y_px = 0.0;       ///< [px]
  double width_px = 0.0;   ///< > 0 [px]
  double height_px = 0.0;  ///< > 0 [px]
  double rate_hz = 0.0;    ///< > 0: how often it lights up [Hz]
  void check() const;      ///< throws InputError naming field, value, allowed range
};

/// The film's clock held against a blinking light.
struct ClockCheck {
  bool found = false;        ///< a blinking was found; else all below is 0
  double stated_hz = 0.0;    ///< of the light [Hz]
  double measured_hz = 0.0;  ///< in the film's time [Hz]
  double sigma_hz = 0.0;     ///< of measured_hz [Hz]
  double deviation_rel =
      0.0;                 ///< measured / stated - 1: true time is the film's times 1 + this [-]
  double contrast = 0.0;   ///< from dark to bright [grey levels]
  bool corrected = false;  ///< the time of the trace was scaled by it
  std::string message;     ///< the outcome in one sentence
  std::string warning;  ///< where the clock is wrong beyond doubt, with the likely cause; or empty
};

/// Mean grey level of the region of a picture.
/// @throws InputError if the region is not within the picture
[[nodiscard]] double mean_brightness(const LumaFrame& frame, const BlinkingLight& light);

/// Measures the rate of a light's blinking.
///
/// A periodic signal of any shape, a sum of harmonics, those beyond the Nyquist frequency folded
/// back as sampling folds them:
///
///     y(t) = c + c' t + sum_k a_k cos(2 pi k f t) + b_k sin(2 pi k f t),  k = 1..9
///
/// linear in all but f, each amplitude expected to fall off as 1 / k. f is first sought over the
/// whole band (the film may run at another speed than it says), then refined by least squares with
/// weights that leave out what passes in front of the light; sigma from the curvature.
///
/// @param time_s      of the frames, increasing [s]
/// @param brightness  one a frame; nan is left out [grey levels]
/// @param rate_hz     stated rate of the light [Hz]
/// @throws InputError if the rate is beyond half the frame rate
[[nodiscard]] ClockCheck check_clock(const std::vector<double>& time_s,
                                     const std::vector<double>& brightness,
                                     double rate_hz);

/// Scales a film's time to what the light says, and notes it in both; nothing if no blinking was
/// found.
void correct_by_light(TimeBase& time, ClockCheck& check);

}  // namespace twang
