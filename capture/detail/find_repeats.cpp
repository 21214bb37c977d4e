// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/find_repeats.hpp"

#include "capture/detail/find_cadence.hpp"
#include "capture/detail/local_fit.hpp"
#include "capture/detail/path.hpp"
#include "capture/detail/repeat_witnesses.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace twang::detail {
namespace {

constexpr std::size_t kBothSides = 2;  // frames there must be on either side of slow motion
constexpr double kStood_px = 0.3;      // between two codings of one picture [px]
constexpr int kMaxRun = 4;             // alike frames in a row from which on the film stands still
constexpr double kFloor_px = 0.015;    // no track is better than this in a compressed film [px]
constexpr double kMotion_px = 0.3;     // range of a path below which it shows no motion [px]
// The light of one picture coded twice differs by so much, a lamp's ripple is larger. [grey levels]
constexpr double kLightFloor = 0.3;
constexpr double kLightStood = 2.5;
constexpr double kRipple = 3.0;
constexpr double kAway = 4.5;         // standard errors between a repeat and its proper place
constexpr double kAwayCopied = 5.0;   // where a coder may have left an honest picture as it was
constexpr double kCopied_px = 0.22;   // of motion that coders leave out of an honest picture
constexpr double kCoderSpeaks = 1.0;  // odds of the coder from which it does, as a logarithm
constexpr double kTwoCodings = 0.5;   // error between two codings of one picture over a sample's
constexpr double kOnPath = 4.0;       // standard errors within which a sample is where it should be
constexpr double kOnset = 0.01;       // of the range, the error of a fit where the motion begins
constexpr double kSideFits = 0.02;    // of the range, the residual of one side alone
constexpr double kEnough = 0.55;      // how many of the moving must differ
constexpr double kThen = 0.25;        // of the step that is missing, the error before it
constexpr double kAsGood = 2.0;       // ratio of residuals
constexpr double kExplains = 0.15;    // of what a frame is off by another motion, the residual
constexpr double kFitsRoughly = 0.03;      // of the range, the residual of a fit that says anything
constexpr double kCoarse = 6.0;            // or over the floor
constexpr double kDone = 0.3;              // of the step that is missing, done
constexpr double kUndone = 0.7;            // or undone
constexpr double kMuchBetter = 0.4;        // ratio of residuals
constexpr double kFitsWell = 0.01;         // below this there is nothing to be had by another clock
constexpr std::size_t kLongestPeriod = 6;  // of a converter: 25 frames from 30
constexpr double kFits = 0.1;              // residual over the range of motion

Path path_of(const MarkerTrack& track, int axis) {
  Path path{{}, kFloor_px, kMotion_px, kStood_px, kCopied_px};
  for (const Eigen::Vector2d& px : track.position_px) path.y.push_back(px[axis]);
  return path;
}

/// The better of two fits.
std::optional<LocalFit> better(std::optional<LocalFit> one, std::optional<LocalFit> other) {
  if (!one || (other && other->residual < one->residual)) return other;
  return one;
}

class RepeatFinder {
 public:
  RepeatFinder(const std::vector<MarkerTrack>& tracks,
               const std::vector<Likeness>& likeness,
               const std::vector<double>& light,
               std::vector<double> evidence)
      : m_likeness(likeness),
        m_repeats(likeness.size(), false),
        m_witnesses(m_likeness, m_repeats),
        m_run(likeness.size(), 0),
        m_evidence(std::move(evidence)),
        m_light{light, kLightFloor, kRipple, kLightStood, kLightStood} {
    m_evidence.resize(likeness.size(), 0.0);
    for (const MarkerTrack& track : tracks) {
      for (const int axis : {0, 1}) m_paths.push_back(path_of(track, axis));
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
    const std::vector<bool> cadence = find_cadence(m_likeness, m_paths);
    std::vector<bool> open(num_frames, false);
    for (std::size_t n = 1; n < num_frames; ++n) {
      m_repeats[n] = m_likeness[n] == Likeness::Same || cadence[n];
      open[n] = m_likeness[n] == Likeness::Alike && !m_repeats[n];
    }
    for (std::size_t n = 1; n < num_frames; ++n) {
      if (open[n]) m_repeats[n] = stands_still(n);
    }
    // Repeats found later help with earlier frames.
    for (std::size_t n = 1; n < num_frames; ++n) {
      const auto next = m_repeats.begin() + static_cast<std::ptrdiff_t>(n + 1);
      const auto end = m_repeats.begin() + static_cast<std::ptrdiff_t>(std::min(
                                               n + 1 + RepeatWitnesses::kReach, num_frames));
      if (open[n] && std::find(next, end, true) < end) m_repeats[n] = stands_still(n);
    }
    return std::move(m_repeats);
  }

 private:
  /// What the coder says. After a repeat the same difference in cost speaks for that one.
  [[nodiscard]] double evidence(std::size_t frame) const {
    return m_repeats[frame - 1] ? std::min(0.0, m_evidence[frame]) : m_evidence[frame];
  }

  /// The path that moves most, if any does.
  [[nodiscard]] const Path* liveliest(std::size_t frame,
                                      std::size_t origin,
                                      Witness witness) const {
    const Path* best = nullptr;
    double most = kMotion_px;
    for (const Path& path : m_paths) {
      if (!std::isfinite(path.at(frame)) || !std::isfinite(path.at(origin))) continue;
      const double moved = m_witnesses.range(path, frame, witness);
      if (moved <= most) continue;
      most = moved;
      best = &path;
    }
    return best;
  }

  [[nodiscard]] bool stands_still(std::size_t frame) const {
    const std::size_t origin = shown_before(frame);
    if (stands_still(frame, origin)) return true;
    // Of two in a row the first may hide too little to be told.
    return origin > 0 && m_likeness[origin] == Likeness::Alike &&
           stands_still(frame, shown_before(origin));
  }
  /// The picture that would be repeated.
  [[nodiscard]] std::size_t shown_before(std::size_t frame) const {
    std::size_t origin = frame - 1;
    while (origin > 0 && m_repeats[origin]) --origin;
    return origin;
  }

  [[nodiscard]] bool stands_still(std::size_t frame, std::size_t origin) const {
    if (has_other_light(frame, origin)) return false;
    if (m_run[frame] <= kMaxRun) {
      const Path* path = liveliest(frame, origin, Witness::Different);
      if (path && mostly_different(frame) && stands_still(*path, frame, origin)) return true;
    } else if (origin == shown_before(frame) && frame + 1 < m_likeness.size() &&
               m_likeness[frame + 1] == Likeness::Different) {
      const Path* path = liveliest(frame, origin, Witness::Different);
      if (path && begins_late(*path, frame, origin)) return true;
    }
    if (!m_light.y.empty() && m_witnesses.range(m_light, frame, Witness::NoRepeat) > kRipple &&
        stands_among_all(m_light, frame, origin, 0)) {
      return true;
    }
    const Path* path = liveliest(frame, origin, Witness::NoRepeat);
    return path && stands_among_all(*path, frame, origin, kBothSides);
  }

  /// Whether enough pictures here differ to tell the motion: at four frames a period every other
  /// one may be like the one before, and those left fit slow motions as well as the true one.
  [[nodiscard]] bool mostly_different(std::size_t frame) const {
    double different = 0.0;
    double moving = 0.0;
    const std::size_t end = std::min(frame + RepeatWitnesses::kAround + 1, m_likeness.size());
    for (std::size_t n = frame - std::min(frame, RepeatWitnesses::kAround); n < end; ++n) {
      different += m_likeness[n] == Likeness::Different ? 1.0 : 0.0;
      moving += m_run[n] <= kMaxRun ? 1.0 : 0.0;
    }
    return different > kEnough * moving;
  }

  /// Whether the light is another than in the picture that would be repeated, as a lamp's ripple
  /// wants it.
  [[nodiscard]] bool has_other_light(std::size_t frame, std::size_t origin) const {
    if (m_light.y.empty() || m_witnesses.range(m_light, frame, Witness::NoRepeat) <= kRipple)
      return false;
    const auto fit = best_fit(m_witnesses.samples(m_light, frame, Witness::NoRepeat, RepeatClock{}),
                              m_light.floor,
                              LocalFit::kMostDropped);
    if (!fit) return false;
    const LocalFit::Expected now = fit->at(0.0);
    const double off = (now.at - m_light.at(frame)) / now.error;
    const double moved = (m_light.at(frame) - m_light.at(origin)) / now.error;
    return moved * moved - off * off > kAway * kAway;
  }

  /// Where many pictures are alike: told by all other frames.
  [[nodiscard]] bool stands_among_all(const Path& path,
                                      std::size_t frame,
                                      std::size_t origin,
                                      std::size_t both_sides) const {
    if (frame + both_sides >= m_likeness.size() || frame < both_sides) return false;
    if (std::abs(path.at(frame) - path.at(origin)) > path.stood) return false;
    const auto fit = best_fit(m_witnesses.samples(path, frame, Witness::NoRepeat, RepeatClock{}),
                              path.floor,
                              LocalFit::kMostDropped);
    return fit && should_have_moved(path, *fit, frame, origin, RepeatClock{});
  }

  /// Where a motion begins after a long standstill: told by what follows.
  [[nodiscard]] bool begins_late(const Path& path, std::size_t frame, std::size_t origin) const {
    if (std::abs(path.at(frame) - path.at(origin)) > path.stood) return false;
    const auto fit = best_fit(
        m_witnesses.samples(path, frame, Witness::Different, RepeatClock{}, WitnessSide::After),
        path.floor);
    return fit && fit->residual < kSideFits * m_witnesses.range(path, frame, Witness::Different) &&
           should_have_moved(path, *fit, frame, origin, RepeatClock{});
  }

  [[nodiscard]] bool stands_still(const Path& path, std::size_t frame, std::size_t origin) const {
    if (std::abs(path.at(frame) - path.at(origin)) > path.stood) return false;
    const double range_px = m_witnesses.range(path, frame, Witness::Different);
    const auto fit_by = [&](RepeatClock clock, WitnessSide side = WitnessSide::Both) {
      return best_fit(m_witnesses.samples(path, frame, Witness::Different, clock, side),
                      path.floor);
    };
    std::optional<LocalFit> plain = fit_by(RepeatClock{});
    // About a release, or where a hand comes in, no one motion fits both sides.
    if (!plain || plain->residual > kFitsWell * range_px) {
      for (const WitnessSide side : {WitnessSide::Before, WitnessSide::After}) {
        std::optional<LocalFit> alone = fit_by(RepeatClock{}, side);
        if (alone && alone->residual < kSideFits * range_px)
          plain = better(std::move(plain), std::move(alone));
      }
    }
    constexpr RepeatClock kCounted{RepeatClock::Count::NoRepeat};
    const std::optional<LocalFit> counted = fit_by(kCounted);
    const bool by_count = counted && (!plain || counted->residual < kMuchBetter * plain->residual);
    const std::optional<LocalFit>& fit = by_count ? counted : plain;
    if (!fit) return false;
    if (should_have_moved(path, *fit, frame, origin, by_count ? kCounted : RepeatClock{})) {
      return by_count || !others_explain(path, *fit, frame);
    }
    return fit->residual > kFitsWell * range_px &&
           is_put_in_between(path, frame, std::min(kFits * range_px, kMuchBetter * fit->residual));
  }

  /// Whether a sample stands where the picture it may repeat stood, rightly then, and not where it
  /// should be: the odds of its place and the coder's multiply. A coder leaves what moved by little
  /// where it was; that is no repeat unless it says so by more.
  [[nodiscard]] bool should_have_moved(const Path& path,
                                       const LocalFit& fit,
                                       std::size_t frame,
                                       std::size_t origin,
                                       RepeatClock clock) const {
    const double origin_time = m_witnesses.time_before(origin, frame, clock);
    LocalFit::Expected now = fit.at(0.0);
    const LocalFit::Expected then = fit.at(origin_time);
    const double range_here = m_witnesses.range(path, frame, Witness::NoRepeat);
    if (fit.residual > std::max(kFitsRoughly * range_here, kCoarse * path.floor)) return false;
    const double way = now.at - path.at(origin);
    const double missing = std::abs(way);
    if (m_witnesses.begin_or_end(path, frame))
      now.error = std::hypot(now.error, kOnset * range_here);
    if (missing < path.stood && clock.count == RepeatClock::Count::All) {
      now.error = std::max(now.error, m_witnesses.off_where_alike(path, fit, frame));
    }
    const double done = path.at(frame) - path.at(origin);
    const double off = (now.at - path.at(frame)) / now.error;
    const double moved = done / (kTwoCodings * now.error);
    const double says = evidence(frame);
    const double then_off = std::abs(then.at - path.at(origin));
    const bool copied = missing < path.stood && says < kCoderSpeaks;
    const double away = copied ? kAwayCopied : kAway;
    // Where coders leave pictures as they were, those before lag behind as well.
    const double on_path = copied ? std::min(kOnPath * then.error, kThen * missing)
                                  : std::max(kOnPath * then.error, kThen * missing);
    return (!copied || missing > path.copied) && done * way < kDone * way * way &&
           done * way > -kUndone * way * way &&
           off * off - moved * moved + 2.0 * says > away * away && then_off < on_path;
  }

  /// Whether the pictures that are alike, taken for honest ones too, leave the frame where it is:
  /// without them the others may fit another motion as well as the true one.
  [[nodiscard]] bool others_explain(const Path& path,
                                    const LocalFit& fit,
                                    std::size_t frame) const {
    const auto all = best_fit(m_witnesses.samples(path, frame, Witness::NoRepeat, RepeatClock{}),
                              path.floor,
                              LocalFit::kMostDropped);
    if (!all) return false;
    const double off = std::abs(fit.at(0.0).at - path.at(frame));
    return all->residual < std::max(kAsGood * fit.residual, kExplains * off) &&
           std::abs(all->at(0.0).at - path.at(frame)) < 0.5 * off;
  }

  /// Whether a motion fits to better than `residual_px`, and the frame stands where it puts the one
  /// before, once the frame is taken out of time, with the repeats known, or with all that may be
  /// some, or with a regular row of them.
  [[nodiscard]] bool is_put_in_between(const Path& path,
                                       std::size_t frame,
                                       double residual_px) const {
    std::vector<RepeatClock> clocks = {{RepeatClock::Count::NeitherThis},
                                       {RepeatClock::Count::Different}};
    for (std::size_t period = 2; period <= kLongestPeriod; ++period) {
      if (m_witnesses.recurs(frame, period)) clocks.push_back({RepeatClock::Count::All, period});
    }
    return std::any_of(clocks.begin(), clocks.end(), [&](const RepeatClock& clock) {
      const auto fit =
          best_fit(m_witnesses.samples(path, frame, Witness::Different, clock), path.floor);
      if (!fit || fit->residual >= residual_px) return false;
      const LocalFit::Expected now = fit->at(0.0);
      return std::abs(now.at - path.at(frame)) < kOnPath * now.error;
    });
  }

  const std::vector<Likeness>& m_likeness;
  std::vector<bool> m_repeats;
  RepeatWitnesses m_witnesses;
  std::vector<int> m_run;          // length of the run of frames that may be repeats
  std::vector<double> m_evidence;  // of the coder; as a logarithm of odds
  std::vector<Path> m_paths;
  Path m_light;
};

}  // namespace

std::vector<bool> find_repeats(const std::vector<MarkerTrack>& tracks,
                               const std::vector<Likeness>& likeness,
                               const std::vector<double>& light,
                               const std::vector<double>& evidence) {
  return RepeatFinder(tracks, likeness, light, evidence).find();
}

}  // namespace twang::detail
