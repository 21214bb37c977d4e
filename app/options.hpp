// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/track_markers.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"

#include <CLI/App.hpp>

#include <optional>
#include <string>
#include <vector>

namespace twang::app {

/// `--capture-fps`, `--marker id=x,y`, `--clock x,y,w,h,HZ`, `--clock-correct`: shared by `track`
/// and `calibrate`.
struct TrackFlags {
  std::optional<double> capture_fps;
  std::vector<std::string> markers;
  std::string clock;
  bool clock_correct = false;
  void add_to(CLI::App& command);
  /// @throws InputError for a malformed or repeated `--marker`, a malformed `--clock`
  [[nodiscard]] TrackOptions options() const;
};

/// `--start`, `--end`, `--band`, `--max-modes`: shared by `invert` and `calibrate`.
struct InversionFlags {
  std::optional<double> start_s;
  std::optional<double> end_s;
  std::vector<double> band_hz;
  int max_modes = 0;
  void add_to(CLI::App& command);
  [[nodiscard]] InversionOptions options() const;
};

}  // namespace twang::app
