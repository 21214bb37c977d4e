// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/frame_clock.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace twang::detail {
namespace {

using Stamps = std::vector<double>;

// Grids that stamps are commonly rounded to before they get into a file with finer ticks: QuickTime
// films of telephones, and Matroska [s].
constexpr std::array kGrids = {1.0 / 600.0, 1e-3};
// Spread of rounded stamps about their clock: one grid step, and some for a finer rounding before
// [grid steps].
constexpr double kSpread = 1.25;
// Rounding of the arithmetic, beside a tick of rounding in the file [ticks].
constexpr double kTickSlack = 1e-3;
// A film of fewer frames, or one of coarser ticks, falls on a grid by chance.
constexpr std::size_t kMinFramesOnGrid = 8;
constexpr double kFineTick = 0.1;  // [grid steps]
constexpr double kNtsc = 1.001;
// A rate stated to six digits is what it says.
constexpr double kSameRate = 2e-6;

/// Distance of each stamp from n / fps, the first's being 0 [s].
Stamps residuals(const Stamps& stamps, const Stamps& counts, double fps) {
  Stamps result(stamps.size());
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    result[i] = stamps[i] - stamps[0] - counts[i] / fps;
  }
  return result;
}

double rms_about_mean(const Stamps& values) {
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double sum = 0.0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return std::sqrt(sum / n);
}

/// What a step that could be one frame or more is taken for, where rounding is as coarse as a
/// frame.
enum class Doubt { OneFrame, Nearest };

/// Frames elapsed since the first at a rate; nothing if two stamps fall on one frame or the stamps
/// spread farther about it than rounding spreads them.
std::optional<Stamps> count_at_rate(const Stamps& stamps,
                                    double spread_s,
                                    double fps,
                                    Doubt doubt) {
  Stamps counts(stamps.size(), 0.0);
  double lowest = 0.0;
  double highest = 0.0;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const double elapsed = stamps[i] - stamps[0];
    const auto fits = [&](double count) {
      const double rest = elapsed - count / fps;
      return std::max(highest, rest) - std::min(lowest, rest) <= spread_s;
    };
    const double next = counts[i - 1] + 1.0;
    // Counted from the middle of the stamps' spread: the first is rounded, too.
    counts[i] = doubt == Doubt::OneFrame && fits(next)
                    ? next
                    : std::round((elapsed - 0.5 * (lowest + highest)) * fps);
    if (counts[i] < next || !fits(counts[i])) return std::nullopt;
    lowest = std::min(lowest, elapsed - counts[i] / fps);
    highest = std::max(highest, elapsed - counts[i] / fps);
  }
  return counts;
}

std::optional<Stamps> count_at_rate(const Stamps& stamps, double spread_s, double fps) {
  auto counts = count_at_rate(stamps, spread_s, fps, Doubt::Nearest);
  return counts ? counts : count_at_rate(stamps, spread_s, fps, Doubt::OneFrame);
}

/// Whether a rate that nobody declared says more than that stamps are ticks: its frames are longer
/// than rounding, and most of them are there.
bool is_telling(double fps, double grid_s, const Stamps& counts) {
  constexpr double kMinFrame = 2.0;    // [grid steps]
  constexpr double kMaxMissing = 0.2;  // [frames missing a frame there]
  return fps * grid_s * kMinFrame <= 1.0 &&
         counts.back() <= (1.0 + kMaxMissing) * static_cast<double>(counts.size());
}

/// The usual step: the mean of those near the median, which rounding may put far from it (2, 3, 2,
/// 3 ticks) [s].
double usual_step(const Stamps& stamps) {
  Stamps steps(stamps.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = stamps[i + 1] - stamps[i];
  Stamps sorted = steps;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  constexpr double kNear = 1.6;  // as a factor: 3 is near 2, twice the step is not
  double sum = 0.0;
  double count = 0.0;
  for (const double step : steps) {
    if (step > kNear * *middle || step < *middle / kNear) continue;
    sum += step;
    count += 1.0;
  }
  return sum / count;
}

/// Frames elapsed by the stamps alone: each step is the nearest whole number of usual steps.
Stamps count_by_steps(const Stamps& stamps) {
  const double usual = usual_step(stamps);
  Stamps counts(stamps.size(), 0.0);
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const double step = std::round((stamps[i] - stamps[i - 1]) / usual);
    counts[i] = counts[i - 1] + std::max(1.0, step);
  }
  return counts;
}

/// Rate of the line through the stamps: slope of counts over time [1/s].
double slope_rate(const Stamps& stamps, const Stamps& counts) {
  const auto n = static_cast<double>(stamps.size());
  const double mean_time = std::accumulate(stamps.begin(), stamps.end(), 0.0) / n;
  const double mean_count = std::accumulate(counts.begin(), counts.end(), 0.0) / n;
  double time_by_count = 0.0;
  double count_by_count = 0.0;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const double dc = counts[i] - mean_count;
    time_by_count += dc * (stamps[i] - mean_time);
    count_by_count += dc * dc;
  }
  return count_by_count / time_by_count;
}

/// Whether every stamp is whole grid steps from the first, give or take a tick.
bool on_grid(const Stamps& stamps, double grid_s, double tick_s) {
  if (stamps.size() < kMinFramesOnGrid || tick_s > kFineTick * grid_s) return false;
  return std::all_of(stamps.begin(), stamps.end(), [&](double stamp) {
    const double elapsed = stamp - stamps[0];
    return std::abs(elapsed - std::round(elapsed / grid_s) * grid_s) <= tick_s * (1.0 + kTickSlack);
  });
}

/// The declared rate, of frames where it counts fields or ticks: no film lacks every second frame.
std::optional<double> frames_declared(std::optional<double> declared_fps, double line_fps) {
  constexpr double kNear = 0.02;  // relative
  if (!declared_fps) return std::nullopt;
  const double per_frame = std::round(*declared_fps / line_fps);
  if (per_frame < 2.0 || std::abs(*declared_fps / (per_frame * line_fps) - 1.0) > kNear) {
    return declared_fps;
  }
  return *declared_fps / per_frame;
}

/// Rates to try, the likelier first: the declared one, usual ones near the line, the line's own.
std::vector<double> rates_to_try(double line_fps, std::optional<double> declared_fps) {
  std::vector<double> rates;
  if (declared_fps) rates.push_back(*declared_fps);
  std::vector<double> usual = {std::round(line_fps)};
  if (const auto multiple = ntsc_multiple(std::round(line_fps * kNtsc) / kNtsc)) {
    usual.push_back(*multiple / kNtsc);
  }
  std::sort(usual.begin(), usual.end(), [&](double a, double b) {
    return std::abs(a - line_fps) < std::abs(b - line_fps);
  });
  for (const double rate : usual) {
    if (rate > 0.0) rates.push_back(rate);
  }
  rates.push_back(line_fps);
  return rates;
}

}  // namespace

FrameClock read_frame_clock(const std::vector<double>& stamps_s,
                            double tick_s,
                            std::optional<double> declared_fps) {
  FrameClock clock;
  clock.counts = count_by_steps(stamps_s);
  clock.fps = slope_rate(stamps_s, clock.counts);
  clock.grid_s = tick_s;
  std::vector<double> grids = {tick_s};
  for (const double grid : kGrids) {
    if (on_grid(stamps_s, grid, tick_s)) grids.push_back(grid);
  }
  declared_fps = frames_declared(declared_fps, clock.fps);
  const std::vector<double> rates = rates_to_try(clock.fps, declared_fps);
  for (const double grid : grids) {
    const double spread = grid * (kSpread + kTickSlack) + (grid > tick_s ? tick_s : 0.0);
    for (std::size_t i = 0; i < rates.size() && !clock.even; ++i) {
      auto counts = count_at_rate(stamps_s, spread, rates[i]);
      if (!counts) continue;
      const bool as_declared = declared_fps && rates[i] == *declared_fps;
      if (!as_declared && !is_telling(rates[i], grid, *counts)) continue;
      clock.even = true;
      clock.fps = rates[i];
      clock.as_declared = as_declared;
      clock.grid_s = grid;
      clock.counts = std::move(*counts);
    }
  }
  clock.jitter_s = rms_about_mean(residuals(stamps_s, clock.counts, clock.fps));
  return clock;
}

std::optional<int> ntsc_multiple(double fps) {
  const double multiple = std::round(fps * kNtsc);
  const bool usual = std::fmod(multiple, 24.0) == 0.0 || std::fmod(multiple, 30.0) == 0.0;
  if (!usual || multiple < 1.0 || multiple > 1e6) return std::nullopt;
  if (std::abs(fps * kNtsc / multiple - 1.0) > kSameRate) return std::nullopt;
  return static_cast<int>(multiple);
}

}  // namespace twang::detail
