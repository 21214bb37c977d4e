// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/options.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
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

BlinkingLight light_from(const std::string& text) {
  std::vector<double> numbers;
  std::string_view rest = text;
  while (true) {
    const std::size_t comma = rest.find(',');
    if (const auto number = number_from(rest.substr(0, comma))) numbers.push_back(*number);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (numbers.size() != 5 || std::count(text.begin(), text.end(), ',') != 4) {
    throw InputError(
        fmt::format("--clock is '{}', must be x,y,w,h,HZ: a region in pixels and a rate", text));
  }
  return {numbers[0], numbers[1], numbers[2], numbers[3], numbers[4]};
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
      "--clock",
      clock,
      "a light of known rate in shot, to check the film's clock: x,y,width,height of "
      "its region [px] and its blinks a second, x,y,w,h,HZ");
  command.add_flag("--clock-correct", clock_correct, "scale the time by what --clock measures");
}

TrackOptions TrackFlags::options() const {
  TrackOptions options;
  options.capture_fps = capture_fps;
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
  if (!clock.empty()) options.clock = light_from(clock);
  options.clock_correct = clock_correct;
  if (clock_correct && clock.empty()) {
    throw InputError("--clock-correct stands alone, must come with --clock x,y,w,h,HZ");
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
