// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/find_repeats.hpp"

#include "core/constants.hpp"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace twang::detail {
namespace {

constexpr int kEnough = 24;         // samples for a fit: three times its terms
constexpr int kAtLeast = 14;        // twice its terms
constexpr std::size_t kReach = 44;  // frames on either side in which they are looked for
constexpr int kNumOmegas = 52;  // grid from 0 to half the frame rate: ω within a tenth of a radian
                                // over the window, the rest is left to the terms b and d
constexpr int kNumSlowOmegas = 10;     // of these where motion is slow
constexpr std::size_t kBothSides = 4;  // frames there must be on either side of slow motion
constexpr double kStood_px = 0.3;      // between two codings of one picture [px]
constexpr int kMaxTerms = 7;
constexpr int kCubicTerms = 4;
constexpr int kMaxRun = 4;            // alike frames in a row from which on the film stands still
constexpr double kFloor_px = 0.015;   // no track is better than this in a compressed film [px]
constexpr double kMotion_px = 0.3;    // range of a path below which it shows no motion [px]
constexpr double kAway = 4.0;         // standard errors between a repeat and its proper place
constexpr double kNear = 4.0;         // standard errors within which a sample is where it should be
constexpr double kStands = 0.3;       // of the step that is missing
constexpr double kMuchBetter = 0.4;   // ratio of residuals
constexpr double kFitsWell = 0.02;    // below this there is nothing to be had by another clock
constexpr std::size_t kCadence = 12;  // frames on either side that show a cadence
constexpr std::size_t kLongestPeriod = 6;  // of a converter: 25 frames from 30
constexpr int kFewMoves = 2;               // frames about that differ, in slow motion
constexpr double kMostly = 0.6;  // of the fresh pictures that must differ from the one before
constexpr double kFits = 0.1;    // residual over the range of motion

/// One coordinate of one marker.
struct Path {
  const MarkerTrack* track = nullptr;
  int axis = 0;
  [[nodiscard]] double at(std::size_t n) const { return track->position_px[n][axis]; }
};

// Sizes are bounded: a fit takes no memory of its own.
using Terms = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMaxTerms>;
using Design = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kEnough, kMaxTerms>;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxTerms, kMaxTerms>;
using Coefficients = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxTerms, 1>;

/// A path's fit about a frame.
struct LocalFit {
  double omega = 0.0;  // [rad/frame]; 0: cubic
  Coefficients coefficients;
  Square covariance;  // over the squared residual
  double residual_px = kNaN;

  struct Expected {
    double at_px;
    double error_px;
  };
  [[nodiscard]] Expected at(double t) const;
};

Terms terms(double omega, double t) {
  Terms row(omega == 0.0 ? kCubicTerms : kMaxTerms);
  if (omega == 0.0) {
    row << 1.0, t, t * t, t * t * t;
  } else {
    const double c = std::cos(omega * t);
    const double s = std::sin(omega * t);
    row << 1.0, t, t * t, c, s, t * c, t * s;
  }
  return row;
}

LocalFit::Expected LocalFit::at(double t) const {
  const Terms row = terms(omega, t);
  return {row * coefficients,
          residual_px * std::sqrt(1.0 + (row * covariance * row.transpose()).value())};
}

struct Samples {
  std::vector<double> t;  // from the frame in question [frames]
  std::vector<double> y;  // [px]
};

std::optional<LocalFit> fit_with(double omega, const Samples& samples) {
  const auto rows = static_cast<Eigen::Index>(samples.t.size());
  Design A(rows, terms(omega, 0.0).size());
  for (Eigen::Index i = 0; i < rows; ++i) {
    A.row(i) = terms(omega, samples.t[static_cast<std::size_t>(i)]);
  }
  const Eigen::Map<const Eigen::VectorXd> y(samples.y.data(), rows);
  const Eigen::ColPivHouseholderQR<Design> qr(A);
  if (qr.rank() < A.cols() || rows <= A.cols()) return std::nullopt;
  LocalFit fit;
  fit.omega = omega;
  fit.coefficients = qr.solve(y);
  const double freedom = static_cast<double>(rows - A.cols());
  fit.residual_px = std::max(kFloor_px, (A * fit.coefficients - y).norm() / std::sqrt(freedom));
  fit.covariance = Square(A.transpose() * A).ldlt().solve(Square::Identity(A.cols(), A.cols()));
  return fit;
}

/// The fit of the frequency that suits best, the smooth one where none does better.
std::optional<LocalFit> best_fit(const Samples& samples, int num_omegas = kNumOmegas) {
  if (samples.t.size() < kAtLeast) return std::nullopt;
  std::optional<LocalFit> best;
  for (int i = 0; i < num_omegas; ++i) {
    std::optional<LocalFit> fit = fit_with(kPi * i / kNumOmegas, samples);
    if (fit && (!best || fit->residual_px < best->residual_px)) best = std::move(fit);
  }
  return best;
}

/// The better of two fits.
std::optional<LocalFit> better(std::optional<LocalFit> one, std::optional<LocalFit> other) {
  if (!one || (other && other->residual_px < one->residual_px)) return other;
  return one;
}

class RepeatFinder {
 public:
  RepeatFinder(const std::vector<MarkerTrack>& tracks, const std::vector<Likeness>& likeness)
      : m_likeness(likeness), m_repeats(likeness.size(), false), m_run(likeness.size(), 0) {
    for (const MarkerTrack& track : tracks) {
      for (const int axis : {0, 1}) m_paths.push_back({&track, axis});
    }
    for (std::size_t begin = 0; begin < likeness.size(); ++begin) {
      std::size_t end = begin;
      while (end < likeness.size() && likeness[end] != Likeness::Different) ++end;
      const int length = static_cast<int>(end - begin);
      for (; begin < end; ++begin) m_run[begin] = length;
    }
  }

  std::vector<bool> find() {
    const std::size_t num_frames = m_likeness.size();
    std::vector<bool> open(num_frames, false);
    for (std::size_t n = 1; n < num_frames; ++n) {
      m_repeats[n] = m_likeness[n] == Likeness::Same || in_cadence(n);
      open[n] = m_likeness[n] == Likeness::Alike && !m_repeats[n];
    }
    for (std::size_t n = 1; n < num_frames; ++n) {
      if (open[n]) m_repeats[n] = stands_still(n);
    }
    // Repeats found later help with earlier frames.
    for (std::size_t n = 1; n < num_frames; ++n) {
      const auto next = m_repeats.begin() + static_cast<std::ptrdiff_t>(n + 1);
      const auto end =
          m_repeats.begin() + static_cast<std::ptrdiff_t>(std::min(n + 1 + kReach, num_frames));
      if (open[n] && std::find(next, end, true) < end) m_repeats[n] = stands_still(n);
    }
    return std::move(m_repeats);
  }

 private:
  enum class Witness { Different, NoRepeat };  // which frames a fit may use
  /// Which frames take time; every so many frames one does not, if `period` is not 0.
  enum class Count { All, NoRepeat, NeitherThis, Different };
  struct Clock {
    Count count = Count::All;
    std::size_t period = 0;
  };
  enum class Side { Both, Before, After };  // of a frame: where samples are taken from

  /// Whether the film shows each picture twice or three times here, and this is not the first.
  [[nodiscard]] bool in_cadence(std::size_t frame) const {
    if (m_likeness[frame] == Likeness::Different) return false;
    const std::size_t first = frame - std::min(frame, kCadence);
    const std::size_t end = std::min(frame + kCadence + 1, m_likeness.size());
    if (end - first <= kCadence) return false;
    for (const std::size_t period : {2, 3}) {
      for (std::size_t fresh = frame + 1; fresh < frame + period; ++fresh) {
        int num_fresh = 0;
        int num_different = 0;
        bool others_alike = true;
        for (std::size_t n = first; n < end; ++n) {
          const bool different = m_likeness[n] == Likeness::Different;
          if (n % period == fresh % period) {
            ++num_fresh;
            num_different += different ? 1 : 0;
          } else if (different && n > 0) {
            others_alike = false;
          }
        }
        if (others_alike && num_different >= kMostly * num_fresh) return true;
      }
    }
    return false;
  }

  [[nodiscard]] bool may_use(std::size_t n, Witness witness) const {
    return witness == Witness::Different ? m_likeness[n] == Likeness::Different : !m_repeats[n];
  }
  [[nodiscard]] bool takes_time(std::size_t n, std::size_t frame, Clock clock) const {
    if (clock.period > 0 && n % clock.period == frame % clock.period) return false;
    switch (clock.count) {
      case Count::All:
        return true;
      case Count::NoRepeat:
        return n == frame || !m_repeats[n];
      case Count::NeitherThis:
        return n != frame && !m_repeats[n];
      case Count::Different:
        return m_likeness[n] == Likeness::Different;
    }
    return true;
  }
  /// Time from `frame` to a frame before it.
  [[nodiscard]] double time_before(std::size_t n, std::size_t frame, Clock clock) const {
    double t = 0.0;
    for (std::size_t k = n + 1; k <= frame; ++k) t -= takes_time(k, frame, clock) ? 1.0 : 0.0;
    return t;
  }

  /// The nearest samples on both sides of a frame.
  [[nodiscard]] Samples samples(const Path& path,
                                std::size_t frame,
                                Witness witness,
                                Clock clock,
                                Side side = Side::Both) const {
    Samples result;
    double before = 0.0;
    double after = 0.0;
    const auto take = [&](std::size_t n, double t) {
      if (result.t.size() == kEnough || !may_use(n, witness) || !std::isfinite(path.at(n))) return;
      result.t.push_back(t);
      result.y.push_back(path.at(n));
    };
    for (std::size_t away = 1; away <= kReach && result.t.size() < kEnough; ++away) {
      if (frame >= away && side != Side::After) {
        before -= takes_time(frame - away + 1, frame, clock) ? 1.0 : 0.0;
        take(frame - away, before);
      }
      if (frame + away < m_likeness.size() && side != Side::Before) {
        after += takes_time(frame + away, frame, clock) ? 1.0 : 0.0;
        take(frame + away, after);
      }
    }
    return result;
  }

  struct Liveliest {
    Path path;
    double range_px = 0.0;
  };
  [[nodiscard]] Liveliest liveliest(std::size_t frame, std::size_t origin, Witness witness) const {
    Liveliest best;
    for (const Path& path : m_paths) {
      if (!std::isfinite(path.at(frame)) || !std::isfinite(path.at(origin))) continue;
      const Samples around = samples(path, frame, witness, Clock{});
      if (around.y.empty()) continue;
      const auto [low, high] = std::minmax_element(around.y.begin(), around.y.end());
      if (*high - *low > best.range_px) best = {path, *high - *low};
    }
    return best;
  }

  /// Whether so many frames before and after this one there are always such frames.
  [[nodiscard]] bool recurs(std::size_t frame, std::size_t period) const {
    std::size_t times = 0;
    const std::size_t first = frame - std::min(frame - 1, kReach) / period * period;
    for (std::size_t n = first; n < std::min(m_likeness.size(), frame + kReach); n += period) {
      if (m_likeness[n] == Likeness::Different) return false;
      ++times;
    }
    return times > kReach / period;
  }

  [[nodiscard]] bool is_slow(std::size_t frame) const {
    const auto begin =
        m_likeness.begin() + static_cast<std::ptrdiff_t>(frame - std::min(frame, kReach));
    const auto end = m_likeness.begin() +
                     static_cast<std::ptrdiff_t>(std::min(frame + kReach, m_likeness.size()));
    return std::count(begin, end, Likeness::Different) <= kFewMoves;
  }

  [[nodiscard]] bool stands_still(std::size_t frame) const {
    std::size_t origin = frame - 1;  // the picture that would be repeated
    while (origin > 0 && m_repeats[origin]) --origin;
    return (m_run[frame] <= kMaxRun && stands_still(frame, origin)) ||
           (is_slow(frame) && stands_still_slowly(frame, origin));
  }

  /// In slow motion, where all pictures are alike: low frequencies, all other frames.
  [[nodiscard]] bool stands_still_slowly(std::size_t frame, std::size_t origin) const {
    if (frame + kBothSides >= m_likeness.size() || frame < kBothSides) return false;
    const auto [path, range_px] = liveliest(frame, origin, Witness::NoRepeat);
    if (range_px < kMotion_px) return false;
    const auto fit = best_fit(samples(path, frame, Witness::NoRepeat, Clock{}), kNumSlowOmegas);
    return fit && should_have_moved(
                      *fit, path.at(frame), path.at(origin), time_before(origin, frame, Clock{}));
  }

  [[nodiscard]] bool stands_still(std::size_t frame, std::size_t origin) const {
    const auto [path, range_px] = liveliest(frame, origin, Witness::Different);
    if (range_px < kMotion_px || std::abs(path.at(frame) - path.at(origin)) > kStood_px) {
      return false;
    }
    const auto fit_by = [&, path = path](Clock clock, Side side = Side::Both) {
      return best_fit(samples(path, frame, Witness::Different, clock, side));
    };
    std::optional<LocalFit> plain = fit_by(Clock{});
    // About a release, or where a hand comes in, no one motion fits both sides.
    if (!plain || plain->residual_px > kFitsWell * range_px) {
      plain = better(std::move(plain), fit_by(Clock{}, Side::Before));
      plain = better(std::move(plain), fit_by(Clock{}, Side::After));
    }
    constexpr Clock kCounted{Count::NoRepeat};
    const std::optional<LocalFit> counted = fit_by(kCounted);
    const bool by_count =
        counted && (!plain || counted->residual_px < kMuchBetter * plain->residual_px);
    const std::optional<LocalFit>& fit = by_count ? counted : plain;
    if (!fit) return false;
    const double origin_time = time_before(origin, frame, by_count ? kCounted : Clock{});
    if (should_have_moved(*fit, path.at(frame), path.at(origin), origin_time)) return true;
    return fit->residual_px > kFitsWell * range_px &&
           is_put_in_between(
               path, frame, std::min(kFits * range_px, kMuchBetter * fit->residual_px));
  }

  /// Whether a sample stands where the picture it may repeat stood, rightly then, and not where it
  /// should be.
  static bool should_have_moved(const LocalFit& fit,
                                double here_px,
                                double origin_px,
                                double origin_time) {
    const LocalFit::Expected now = fit.at(0.0);
    const LocalFit::Expected then = fit.at(origin_time);
    return std::abs(here_px - origin_px) < kStands * std::abs(now.at_px - origin_px) &&
           std::abs(now.at_px - here_px) > kAway * now.error_px &&
           std::abs(then.at_px - origin_px) < kNear * then.error_px;
  }

  /// Whether a motion fits to better than `residual_px` once the frame is taken out of time, with
  /// the repeats known, or with all that may be some, or with a regular row of them.
  [[nodiscard]] bool is_put_in_between(const Path& path,
                                       std::size_t frame,
                                       double residual_px) const {
    std::vector<Clock> clocks = {{Count::NeitherThis}, {Count::Different}};
    for (std::size_t period = 2; period <= kLongestPeriod; ++period) {
      if (recurs(frame, period)) clocks.push_back({Count::All, period});
    }
    return std::any_of(clocks.begin(), clocks.end(), [&](const Clock& clock) {
      const auto fit = best_fit(samples(path, frame, Witness::Different, clock));
      return fit && fit->residual_px < residual_px;
    });
  }

  const std::vector<Likeness>& m_likeness;
  std::vector<bool> m_repeats;
  std::vector<int> m_run;  // length of the run of frames that may be repeats
  std::vector<Path> m_paths;
};

}  // namespace

std::vector<bool> find_repeats(const std::vector<MarkerTrack>& tracks,
                               const std::vector<Likeness>& likeness) {
  return RepeatFinder(tracks, likeness).find();
}

}  // namespace twang::detail
