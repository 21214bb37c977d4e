// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/release.hpp"

#include <Eigen/Core>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

/// Parts of the highest speed: a calm stays below the first, a release passes the second, the next
/// release the third.
constexpr double kCalmPart = 0.125;
constexpr double kReleasePart = 0.25;
constexpr double kNextReleasePart = 0.5;
/// Shortest calm, in samples, so that noise does not look like one.
constexpr Index kMinCalm = 4;
/// One sample in so many of a calm may be above its threshold, for noise.
constexpr Index kRestlessPart = 10;
/// Part of the first swing that a calm must last; a turning point stays calm for 0.08 of a swing.
constexpr double kCalmPartOfSwing = 0.5;
/// Speeds passed over before one is called the highest: one in so many samples, within limits.
constexpr Index kSamplesPerGlitch = 50;
constexpr Index kMaxGlitches = 10;
/// A glitch gives two high speeds; a vibration soon gives this many.
constexpr Index kMinHighSpeeds = 4;
constexpr Index kHighSpeedWindow = 16;
/// A pull has left the level when the mean over a swing is off by this part of the amplitude.
constexpr double kPullPart = 0.03;

/// The rows in which all channels are finite, each channel divided by its range.
struct Motion {
  std::vector<double> time_s;
  MatrixXd value;  ///< rows: samples
};

Motion finite_motion(const Trace& trace,
                     const std::vector<const Channel*>& channels,
                     double from_s,
                     double to_s) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < trace.num_samples(); ++i) {
    if (trace.time_s[i] < from_s || trace.time_s[i] > to_s) continue;
    const bool finite = std::all_of(channels.begin(), channels.end(), [&](const Channel* channel) {
      return std::isfinite(channel->values[i]);
    });
    if (finite) rows.push_back(i);
  }
  Motion out;
  out.value.resize(static_cast<Index>(rows.size()), static_cast<Index>(channels.size()));
  for (std::size_t r = 0; r < rows.size(); ++r) {
    out.time_s.push_back(trace.time_s[rows[r]]);
    for (std::size_t c = 0; c < channels.size(); ++c) {
      out.value(static_cast<Index>(r), static_cast<Index>(c)) = channels[c]->values[rows[r]];
    }
  }
  for (Index c = 0; c < out.value.cols() && out.value.rows() > 0; ++c) {
    const double range = out.value.col(c).maxCoeff() - out.value.col(c).minCoeff();
    if (range > 0.0) out.value.col(c) /= range;
  }
  return out;
}

/// Differences over a lag, and their norms.
struct Speed {
  Index lag = 1;
  MatrixXd step;
  VectorXd norm;
  double highest = 0.0;  ///< but for a few, which may be glitches
};

Speed speed_over(const MatrixXd& value, Index lag) {
  Speed out;
  out.lag = lag;
  const Index n = value.rows() - lag;
  out.step = value.bottomRows(n) - value.topRows(n);
  out.norm = out.step.rowwise().norm();
  std::vector<double> sorted(out.norm.data(), out.norm.data() + n);
  const auto rank = std::clamp<std::ptrdiff_t>(n / kSamplesPerGlitch, 2, kMaxGlitches);
  const auto place = sorted.begin() + std::min<std::ptrdiff_t>(rank, n - 1);
  std::nth_element(sorted.begin(), place, sorted.end(), std::greater<>());
  out.highest = *place;
  return out;
}

/// A release in terms of sample indices.
struct Release {
  Index last_calm = 0;
  Index start = 0;
  Index swing = 1;  ///< samples from release to the first turning point
};

/// Takes out of the speeds what passes the release's threshold for a moment only.
void remove_glitches(Speed& speed) {
  const Index n = speed.norm.size();
  const double threshold = kReleasePart * speed.highest;
  const Index window = kHighSpeedWindow * speed.lag;
  for (Index i = 0; i < n; ++i) {
    if (speed.norm(i) <= threshold) continue;
    const Index ahead = std::min(window, n - i);
    const Index high = (speed.norm.segment(i, ahead).array() > threshold).count();
    if (high >= kMinHighSpeeds * speed.lag) return;
    speed.norm(i) = 0.0;
    speed.step.row(i).setZero();
  }
}

std::optional<Release> find_release(const Speed& speed) {
  const Index n = speed.norm.size();
  const double calm = kCalmPart * speed.highest;
  Index onset = 0;
  while (onset < n && speed.norm(onset) <= kReleasePart * speed.highest) ++onset;
  if (onset >= n || !(speed.highest > 0.0)) return std::nullopt;
  Index calm_end = onset;  // first difference that is not calm
  while (calm_end > 0 && speed.norm(calm_end - 1) > calm) --calm_end;
  const Index restless = (speed.norm.head(calm_end).array() > calm).count();
  if (restless * kRestlessPart > calm_end) return std::nullopt;
  Index peak = onset;
  Index turn = onset;
  for (; turn < n; ++turn) {
    const bool swings_back = speed.step.row(turn).dot(speed.step.row(peak)) < 0.0;
    if (swings_back && speed.norm(turn) > calm) break;
    if (speed.norm(turn) > speed.norm(peak)) peak = turn;
  }
  if (turn >= n) return std::nullopt;
  Release out;
  out.last_calm = calm_end + (speed.lag - 1);
  out.swing = std::max<Index>(turn - calm_end, 1);
  out.start = peak + (speed.lag + 1) / 2;
  const Index least =
      std::max(kMinCalm * speed.lag,
               static_cast<Index>(std::ceil(kCalmPartOfSwing * static_cast<double>(out.swing))));
  if (calm_end < least) return std::nullopt;
  return out;
}

/// Median of each column over some rows.
RowVectorXd median_level(const MatrixXd& value, Index first, Index count) {
  RowVectorXd out(value.cols());
  for (Index c = 0; c < value.cols(); ++c) {
    const VectorXd column = value.col(c).segment(first, count);
    std::vector<double> sorted(column.data(), column.data() + count);
    const auto middle = sorted.begin() + count / 2;
    std::nth_element(sorted.begin(), middle, sorted.end());
    out(c) = *middle;
  }
  return out;
}

/// The first sudden motion after the vibration has died down, if there is one.
std::optional<Index> find_next_event(const Speed& speed, Index start, Index swing) {
  const Index n = speed.norm.size();
  if (start >= n) return std::nullopt;
  const Index first = std::min(2 * swing + 1, n - start);
  const double highest = speed.norm.segment(start, first).maxCoeff();
  Index calm_run = 0;
  for (Index i = start; i < n; ++i) {
    if (calm_run >= 4 * swing) {
      const Index ahead = std::min(swing + 1, n - i);
      if (speed.norm(i) > kCalmPart * highest &&
          speed.norm.segment(i, ahead).maxCoeff() > kNextReleasePart * highest) {
        return i;
      }
    }
    calm_run = speed.norm(i) <= kCalmPart * highest ? calm_run + 1 : 0;
  }
  return std::nullopt;
}

/// The last sample before the pull that leads to `event`.
Index end_before(const MatrixXd& value, Index start, Index event, Index swing) {
  const Index half = std::max<Index>((event - start) / 2, 1);
  const RowVectorXd level = median_level(value, start, half);
  const Index window = 2 * swing;
  const double amplitude =
      (value.middleRows(start, std::min(2 * window, event - start + 1)).rowwise() - level)
          .rowwise()
          .norm()
          .maxCoeff();
  Index end = event;
  while (end > start + window) {
    const RowVectorXd mean = value.middleRows(end - window + 1, window).colwise().mean();
    if ((mean - level).norm() <= kPullPart * amplitude) break;
    --end;
  }
  // The mean lags behind the pull by half its window.
  return std::max(end - window, start);
}

}  // namespace

FreeMotion find_free_motion(const Trace& trace,
                            const std::vector<std::string>& channels,
                            double from_s,
                            double to_s) {
  std::vector<const Channel*> used;
  for (const std::string& name : channels) {
    const Channel* channel = trace.find(name);
    if (channel != nullptr) used.push_back(channel);
  }
  FreeMotion out;
  out.start_s = from_s;
  out.end_s = to_s;
  const Motion motion = finite_motion(trace, used, from_s, to_s);
  const Index n = motion.value.rows();
  if (n < 16 || used.empty()) return out;

  std::optional<Release> release;
  Speed speed;
  for (Index lag = 1; lag <= std::max<Index>(1, n / 32) && !release; lag *= 2) {
    speed = speed_over(motion.value, lag);
    remove_glitches(speed);
    release = find_release(speed);
  }
  const auto time_at = [&](Index i) { return motion.time_s[static_cast<std::size_t>(i)]; };
  if (!release) return out;
  out.release_s = time_at(release->last_calm);
  out.start_s = time_at(std::min(release->start, n - 1));
  const std::optional<Index> event = find_next_event(speed, release->start, release->swing);
  if (event) {
    out.end_s = time_at(end_before(motion.value, release->start, *event, release->swing));
    out.ends_early = true;
  }
  out.note = fmt::format(
      "release seen at {:.6g} s; free motion is taken from {:.6g} s, past the first peak of "
      "speed{}",
      *out.release_s,
      out.start_s,
      out.ends_early ? fmt::format(", to {:.6g} s, before the next disturbance", out.end_s) : "");
  return out;
}

}  // namespace twang
