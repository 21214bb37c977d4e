// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/options.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace twang::app {
namespace {

std::optional<double> number_from(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

}  // namespace

void TrackFlags::add_to(CLI::App& command) {
  command.add_option(
      "--capture-fps", capture_fps, "frame rate of the camera, whatever rig and file say [1/s]");
  command
      .add_option("--marker",
                  markers,
                  "where a marker stands in the first frame, id=x,y [px]; may be repeated")
      ->allow_extra_args(false);
  command.add_option(
      "--lens", lens, "camera calibration of OpenCV or ROS (*.yml); overrules the rig's");
}

TrackOptions TrackFlags::options() const {
  TrackOptions options;
  options.capture_fps = capture_fps;
  options.lens = lens;
  for (const std::string& text : markers) {
    const std::size_t equals = text.find('=');
    const std::size_t comma = text.find(',', equals == std::string::npos ? 0 : equals);
    std::optional<double> x;
    std::optional<double> y;
    if (equals != std::string::npos && equals > 0 && comma != std::string::npos) {
      x = number_from(std::string_view(text).substr(equals + 1, comma - equals - 1));
      y = number_from(std::string_view(text).substr(comma + 1));
    }
    if (!x || !y) throw InputError(fmt::format("--marker is '{}', must be id=x,y in pixels", text));
    if (!options.start_px.emplace(text.substr(0, equals), Eigen::Vector2d(*x, *y)).second) {
      throw InputError(fmt::format("--marker names '{}' twice, must name each marker once",
                                   text.substr(0, equals)));
    }
  }
  options.check();
  return options;
}

void InversionFlags::add_to(CLI::App& command) {
  command.add_option(
      "--start", start_s, "first time used [s]; default: after the release if one is seen");
  command.add_option("--end", end_s, "last time used [s]");
  command.add_option("--band", band_hz, "lowest and highest frequency searched [Hz]")->expected(2);
  command.add_option(
      "--max-modes", max_modes, "keep the strongest only; 0: all that the data support");
}

InversionOptions InversionFlags::options() const {
  InversionOptions options;
  options.start_s = start_s;
  options.end_s = end_s;
  if (!band_hz.empty()) options.band_hz = Band{band_hz[0], band_hz[1]};
  options.max_modes = max_modes;
  options.check();
  return options;
}

}  // namespace twang::app
