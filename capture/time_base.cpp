// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/time_base.hpp"

#include "capture/detail/frame_clock.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace twang {
namespace {

// Nearer to the file's rate, a stated one speaks of the same speed; slow motion begins at a factor
// of two.
constexpr double kSameSpeed = 0.4;
// No time lapse is shown at a higher rate: a tag that says so is wrong [1/s].
constexpr double kMaxTimeLapseFps = 61.0;

bool is_rate(const std::optional<double>& fps) { return fps && std::isfinite(*fps) && *fps > 0.0; }

void check_order(const std::vector<double>& stamps) {
  std::size_t last = stamps.size();
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    if (std::isnan(stamps[i])) continue;
    if (last < stamps.size() && !(stamps[i] > stamps[last])) {
      throw InputError(
          fmt::format("frame {} is stamped {:.6f} s, must be later than frame {} at {:.6f} s",
                      i + 1,
                      stamps[i],
                      last + 1,
                      stamps[last]));
    }
    last = i;
  }
}

/// Puts a stamp where there is none, evenly between its neighbours, and at the usual step outside.
std::vector<double> fill_stamps(std::vector<double> stamps, std::optional<double> rate) {
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    if (!std::isnan(stamps[i])) known.push_back(i);
  }
  if (known.size() == stamps.size()) return stamps;
  if (known.size() < 2 && !rate) {
    throw InputError("the film has neither stamps nor a frame rate, must have one of them");
  }
  const auto distance = [](std::size_t a, std::size_t b) {
    return static_cast<double>(b) - static_cast<double>(a);
  };
  std::vector<double> steps;
  for (std::size_t k = 1; k < known.size(); ++k) {
    const std::size_t a = known[k - 1];
    steps.push_back((stamps[known[k]] - stamps[a]) / distance(a, known[k]));
  }
  // The usual step is a surer guide than the declared rate, which may count fields.
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  if (!steps.empty()) std::nth_element(steps.begin(), middle, steps.end());
  const double step = steps.empty() ? 1.0 / *rate : *middle;
  const std::size_t first = known.empty() ? 0 : known.front();
  const double origin = known.empty() ? 0.0 : stamps[first];
  std::size_t next = 0;  // of known, the first at or behind i
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    while (next < known.size() && known[next] < i) ++next;
    if (next < known.size() && known[next] == i) continue;
    if (next == 0) {
      stamps[i] = origin + step * distance(first, i);
    } else if (next == known.size()) {
      stamps[i] = stamps[known.back()] + step * distance(known.back(), i);
    } else {
      const std::size_t a = known[next - 1];
      const std::size_t b = known[next];
      stamps[i] = stamps[a] + (stamps[b] - stamps[a]) * distance(a, i) / distance(a, b);
    }
  }
  return stamps;
}

/// The clock of a film that lacks some stamps or all, or is a single frame.
detail::FrameClock read_clock(const std::vector<double>& stamps,
                              double tick_s,
                              bool stamped,
                              std::optional<double> declared,
                              std::optional<double> any_rate) {
  if (stamped && stamps.size() > 1) return detail::read_frame_clock(stamps, tick_s, declared);
  // Without stamps the film is as even as its rate; a file without a rate lends the stated one.
  if (!any_rate) throw InputError("the film has one frame and no frame rate, must have a rate");
  detail::FrameClock clock;
  clock.even = true;
  clock.as_declared = true;
  clock.fps = *any_rate;
  clock.grid_s = tick_s;
  for (std::size_t i = 0; i < stamps.size(); ++i) clock.counts.push_back(static_cast<double>(i));
  return clock;
}

/// Whether the camera's tag speaks of another speed than the file's, credibly.
bool tag_counts(double tag_fps, double file_fps) {
  const double ratio = tag_fps / file_fps;
  if (ratio >= 1.0) return ratio > 1.0 + kSameSpeed;
  return ratio < 1.0 / (1.0 + kSameSpeed) && file_fps < kMaxTimeLapseFps;
}

TimeBaseKind kind_of(const TimeBaseSummary& summary) {
  const double ratio = summary.capture_fps / summary.file_fps;
  if (ratio > 1.0 + kSameSpeed) return TimeBaseKind::SlowMotion;
  if (ratio < 1.0 / (1.0 + kSameSpeed)) return TimeBaseKind::FastMotion;
  return summary.even ? TimeBaseKind::Constant : TimeBaseKind::Variable;
}

}  // namespace

TimeBase correct_time_base(const std::vector<double>& stamps_s,
                           double tick_s,
                           std::optional<double> declared_fps,
                           std::optional<StatedRate> stated,
                           std::optional<double> tag_fps) {
  if (stated && !is_rate(stated->fps)) {
    throw InputError(
        fmt::format("{}: capture rate is {}, must be > 0", stated->source, stated->fps));
  }
  if (stamps_s.empty()) throw InputError("the film has no frames, must have at least one");
  check_order(stamps_s);
  const std::optional<double> declared = is_rate(declared_fps) ? declared_fps : std::nullopt;
  const std::optional<double> tag = is_rate(tag_fps) ? tag_fps : std::nullopt;
  std::optional<double> any_rate = declared ? declared : tag;
  if (!any_rate && stated) any_rate = stated->fps;
  const bool stamped = std::any_of(
      stamps_s.begin(), stamps_s.end(), [](double stamp) { return !std::isnan(stamp); });
  const std::vector<double> stamps = fill_stamps(stamps_s, any_rate);
  const detail::FrameClock clock = read_clock(stamps, tick_s, stamped, declared, any_rate);
  if (!stated && tag && tag_counts(*tag, clock.fps)) stated = StatedRate{*tag, "tag"};

  TimeBase result;
  TimeBaseSummary& summary = result.summary;
  summary.frames = static_cast<int>(stamps.size());
  summary.file_fps = clock.fps;
  summary.capture_fps = stated ? stated->fps : clock.fps;
  summary.source = stated ? stated->source : clock.as_declared ? "container" : "stamps";
  summary.gaps = static_cast<int>(std::lround(clock.counts.back())) - (summary.frames - 1);
  summary.even = clock.even;
  summary.tick_s = clock.grid_s;
  summary.jitter_s = clock.jitter_s;
  summary.declared_fps = declared;
  summary.tag_fps = tag;
  summary.kind = kind_of(summary);

  const double stretch = summary.file_fps / summary.capture_fps;
  result.time_s.resize(stamps.size());
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    result.time_s[i] =
        clock.even ? clock.counts[i] / summary.capture_fps : (stamps[i] - stamps[0]) * stretch;
  }
  return result;
}

std::string word_for(TimeBaseKind kind) {
  switch (kind) {
    case TimeBaseKind::Constant:
      return "constant";
    case TimeBaseKind::Variable:
      return "variable";
    case TimeBaseKind::SlowMotion:
      return "slow motion";
    case TimeBaseKind::FastMotion:
      return "fast motion";
  }
  return {};
}

}  // namespace twang
