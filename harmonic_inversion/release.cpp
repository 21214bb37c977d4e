// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/release.hpp"

#include "harmonic_inversion/motion_scales.hpp"

#include <Eigen/Core>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

/// Parts of the highest speed: a calm stays below the first, a release passes the second and peaks
/// above the third; the next release passes the fourth.
constexpr double kCalmPart = 0.125;
constexpr double kReleasePart = 0.25;
constexpr double kReleasePeakPart = 0.4;
constexpr double kNextReleasePart = 0.5;
/// Root mean square of the speeds in a calm, in the same unit: their noise then does not reach b
/// / 4.
constexpr double kCalmRmsPart = 0.07;
/// Shortest calm, in samples, so that noise does not look like one.
constexpr Index kMinCalm = 4;
/// One sample in so many of a calm may be above its threshold, for noise.
constexpr Index kRestlessPart = 10;
/// Part of the first swing that a calm must last; a turning point stays calm for 0.08 of a swing.
constexpr double kCalmPartOfSwing = 0.5;
/// A glitch is a sample that stands off the mean of its neighbours by this factor more than any
/// other sample this near.
constexpr double kGlitchFactor = 3.0;
constexpr Index kGlitchReach = 8;
/// Means over more than this part of the record see no vibration.
constexpr Index kNarrowestPart = 16;
/// Shorter than this many samples there is nothing to be inverted.
constexpr Index kMinFreeMotion = 16;
/// A pull has left the level when the mean over a swing is off by this part of the amplitude.
constexpr double kPullPart = 0.03;
/// A record that ends in a pull is off its level by this part of the amplitude there, but not in
/// the first half of the motion, as a drift is.
constexpr double kPulledPart = 0.5;

/// The rows in which all channels are finite.
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
  return out;
}

/// Puts glitches, single samples far off, between their neighbours.
void remove_glitches(MatrixXd& value) {
  const Index n = value.rows();
  const MatrixXd bend =
      value.middleRows(1, n - 2) - 0.5 * (value.topRows(n - 2) + value.bottomRows(n - 2));
  const VectorXd size = bend.rowwise().norm();
  for (Index i = 0; i < n - 2; ++i) {
    double others = 0.0;
    for (Index j = std::max<Index>(i - kGlitchReach, 0); j < std::min(i + kGlitchReach + 1, n - 2);
         ++j) {
      if (std::abs(j - i) > 1) others = std::max(others, size(j));
    }
    if (size(i) > kGlitchFactor * others) value.row(i + 1) -= bend.row(i);
  }
}

/// Differences of the means of `width` samples after and before each place, and their norms.
struct Speed {
  Index width = 1;
  MatrixXd step;  ///< row i: between samples i + width - 1 and i + width
  VectorXd norm;
  double highest = 0.0;
};

Speed speed_over(const MatrixXd& value, Index width) {
  Speed out;
  out.width = width;
  const Index n = value.rows() - 2 * width + 1;
  MatrixXd sums(value.rows() + 1, value.cols());
  sums.row(0).setZero();
  for (Index i = 0; i < value.rows(); ++i) sums.row(i + 1) = sums.row(i) + value.row(i);
  out.step = (sums.bottomRows(n) - 2.0 * sums.middleRows(width, n) + sums.topRows(n)) /
             static_cast<double>(width);
  out.norm = out.step.rowwise().norm();
  out.highest = out.norm.maxCoeff();
  return out;
}

/// A release in terms of sample indices.
struct Release {
  Index last_calm = 0;
  Index start = 0;
  Index swing = 1;  ///< samples from release to the first turning point
};

/// Whether the first `count` speeds are those of a rest, a hold or a slow pull, noise and all.
bool is_calm(const Speed& speed, Index count) {
  const auto head = speed.norm.head(count);
  const Index restless = (head.array() > kCalmPart * speed.highest).count();
  const double rms = std::sqrt(head.squaredNorm() / static_cast<double>(count));
  return restless * kRestlessPart <= count && rms <= kCalmRmsPart * speed.highest;
}

std::optional<Release> find_release(const Speed& speed) {
  const Index n = speed.norm.size();
  const double calm = kCalmPart * speed.highest;
  Index onset = 0;
  while (onset < n && speed.norm(onset) <= kReleasePart * speed.highest) ++onset;
  if (onset >= n || !(speed.highest > 0.0)) return std::nullopt;
  Index calm_end = onset;  // first speed that is not calm
  while (calm_end > 0 && speed.norm(calm_end - 1) > calm) --calm_end;
  Index peak = onset;
  Index turn = onset;
  for (; turn < n; ++turn) {
    const bool swings_back = speed.step.row(turn).dot(speed.step.row(peak)) < 0.0;
    if (swings_back && speed.norm(turn) > calm) break;
    if (speed.norm(turn) > speed.norm(peak)) peak = turn;
  }
  if (turn >= n || speed.norm(peak) < kReleasePeakPart * speed.highest) return std::nullopt;
  Release out;
  out.last_calm = calm_end + 2 * speed.width - 2;  // the last sample that a calm speed has seen
  out.swing = std::max<Index>(turn - calm_end, 1);
  out.start = peak + speed.width + speed.width / 2;
  const Index least = std::max(
      kMinCalm, static_cast<Index>(std::ceil(kCalmPartOfSwing * static_cast<double>(out.swing))));
  if (calm_end + speed.width - 1 < least || calm_end < kMinCalm) return std::nullopt;
  if (!is_calm(speed, calm_end)) return std::nullopt;
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
std::optional<Index> find_next_event(const Speed& speed, const Release& release) {
  const Index n = speed.norm.size();
  const double highest = speed.norm.segment(0, std::min(release.start, n)).maxCoeff();
  Index calm_run = 0;
  for (Index i = release.start; i < n; ++i) {
    if (calm_run >= 4 * release.swing && speed.norm(i) > kCalmPart * highest) {
      const Index ahead = std::min(release.swing + 1, n - i);
      if (speed.norm.segment(i, ahead).maxCoeff() > kNextReleasePart * highest) return i;
    }
    calm_run = speed.norm(i) <= kCalmPart * highest ? calm_run + 1 : 0;
  }
  return std::nullopt;
}

/// The level about which the part vibrates, from `start` up to `event` or the end of the record.
class Level {
 public:
  Level(const MatrixXd& value, Index start, Index event, Index swing)
      : m_value(value), m_start(start), m_event(event), m_window(2 * swing) {
    m_level = median_level(value, start, half());
    m_amplitude =
        (value.middleRows(start, std::min(2 * m_window, event - start + 1)).rowwise() - m_level)
            .rowwise()
            .norm()
            .maxCoeff();
  }

  /// The last sample before the pull that leads to the event.
  [[nodiscard]] Index end_before_pull() const {
    Index end = m_event;
    while (end > m_start + m_window && off_before(end) > kPullPart) --end;
    // The mean lags behind the pull by half its window.
    return std::max(end - m_window, m_start);
  }

  /// Whether the event finds the part pulled away.
  [[nodiscard]] bool is_pulled() const {
    return m_event > m_start + m_window && off_before(m_event) > kPulledPart &&
           end_before_pull() > m_start + half();
  }

 private:
  [[nodiscard]] Index half() const { return std::max<Index>((m_event - m_start) / 2, 1); }

  /// How far the mean over the window before a sample is off the level, in amplitudes.
  [[nodiscard]] double off_before(Index end) const {
    const RowVectorXd mean = m_value.middleRows(end - m_window + 1, m_window).colwise().mean();
    return (mean - m_level).norm() / std::max(m_amplitude, 1e-300);
  }

  const MatrixXd& m_value;
  Index m_start;
  Index m_event;
  Index m_window;
  RowVectorXd m_level;
  double m_amplitude = 0.0;
};

/// The last sample before the next pull; nothing if none follows.
std::optional<Index> find_end(const MatrixXd& value, const Speed& speed, const Release& release) {
  const auto event = find_next_event(speed, release);
  const Index last = value.rows() - 1;
  const Level level(value, release.start, event.value_or(last), release.swing);
  if (!event && !level.is_pulled()) return std::nullopt;
  const Index end = level.end_before_pull();
  if (end < release.start + kMinFreeMotion) return std::nullopt;
  return end;
}

/// A release, and the motion and speed in which it was seen.
struct SeenRelease {
  Release release;
  MatrixXd value;
  Speed speed;
};

/// @param value  rows: samples; comparable columns
std::optional<SeenRelease> see_release(MatrixXd value) {
  remove_glitches(value);
  Speed speed;
  for (Index width = 1; width <= value.rows() / kNarrowestPart; width *= 2) {
    const double narrower = speed.highest;
    speed = speed_over(value, width);
    if (speed.highest < narrower) break;  // wider means only lose the vibration
    if (const auto release = find_release(speed)) {
      if (release->start + kMinFreeMotion > value.rows()) return std::nullopt;
      return SeenRelease{*release, std::move(value), std::move(speed)};
    }
  }
  return std::nullopt;
}

/// In the channels compared by their units, or else by their noise.
std::optional<SeenRelease> see_release(const MatrixXd& value,
                                       const std::vector<std::string>& names) {
  const auto divided_by = [&](const RowVectorXd& scales) {
    return MatrixXd(value.array().rowwise() / scales.array());
  };
  if (auto seen = see_release(divided_by(scales_by_unit(value, names)))) return seen;
  if (names.size() == 1) return std::nullopt;
  return see_release(divided_by(scales_by_noise(value)));
}

}  // namespace

FreeMotion find_free_motion(const Trace& trace,
                            const std::vector<std::string>& channels,
                            double from_s,
                            double to_s) {
  std::vector<const Channel*> used;
  std::vector<std::string> names;
  for (const std::string& name : channels) {
    const Channel* channel = trace.find(name);
    if (channel == nullptr) continue;
    used.push_back(channel);
    names.push_back(name);
  }
  FreeMotion out;
  out.start_s = from_s;
  out.end_s = to_s;
  const Motion motion = finite_motion(trace, used, from_s, to_s);
  if (motion.value.rows() < kMinFreeMotion || used.empty()) return out;
  const auto seen = see_release(motion.value, names);
  if (!seen) return out;
  const auto time_at = [&](Index i) { return motion.time_s[static_cast<std::size_t>(i)]; };
  out.release_s = time_at(seen->release.last_calm);
  out.start_s = time_at(seen->release.start);
  if (const auto end = find_end(seen->value, seen->speed, seen->release)) {
    out.end_s = time_at(*end);
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

FreeMotion find_free_motion_until(const Trace& trace,
                                  const std::vector<std::string>& channels,
                                  double from_s,
                                  double to_s) {
  FreeMotion motion = find_free_motion(trace, channels, from_s, to_s);
  if (motion.ends_early || trace.time_s.empty() || to_s >= trace.time_s.back()) return motion;
  FreeMotion whole = find_free_motion(trace, channels, from_s, trace.time_s.back());
  const bool same = whole.release_s && (!motion.release_s || whole.start_s <= motion.start_s);
  return same && whole.ends_early && whole.end_s < to_s ? whole : motion;
}

}  // namespace twang
