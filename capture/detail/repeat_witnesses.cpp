// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/repeat_witnesses.hpp"

#include "core/constants.hpp"

#include <algorithm>
#include <cmath>

namespace twang::detail {
namespace {

constexpr std::size_t kOneSide = 6;    // frames that show a standstill
constexpr double kLively = 10.0;       // ranges of a standstill, from which on a motion is lively
constexpr std::size_t kLeftAlone = 1;  // pictures that are alike, to say how far they are off
constexpr double kSigmaOverMedian = 1.48;

}  // namespace

bool RepeatWitnesses::may_use(std::size_t n, Witness witness) const {
  return witness == Witness::Different ? m_likeness[n] == Likeness::Different : !m_repeats[n];
}

bool RepeatWitnesses::takes_time(std::size_t n, std::size_t frame, RepeatClock clock) const {
  if (clock.period > 0 && n % clock.period == frame % clock.period) return false;
  switch (clock.count) {
    case RepeatClock::Count::All:
      return true;
    case RepeatClock::Count::NoRepeat:
      return n == frame || !m_repeats[n];
    case RepeatClock::Count::NeitherThis:
      return n != frame && !m_repeats[n];
    case RepeatClock::Count::Different:
      return m_likeness[n] == Likeness::Different;
  }
  return true;
}

double RepeatWitnesses::time_before(std::size_t n, std::size_t frame, RepeatClock clock) const {
  double t = 0.0;
  for (std::size_t k = n + 1; k <= frame; ++k) t -= takes_time(k, frame, clock) ? 1.0 : 0.0;
  return t;
}

Samples RepeatWitnesses::samples(const Path& path,
                                 std::size_t frame,
                                 Witness witness,
                                 RepeatClock clock,
                                 WitnessSide side) const {
  Samples result;
  double before = 0.0;
  double after = 0.0;
  const auto take = [&](std::size_t n, double t) {
    if (result.t.size() == static_cast<std::size_t>(kMostSamples) || !may_use(n, witness) ||
        !std::isfinite(path.at(n)))
      return;
    result.t.push_back(t);
    result.y.push_back(path.at(n));
  };
  for (std::size_t away = 1;
       away <= kReach && result.t.size() < static_cast<std::size_t>(kMostSamples);
       ++away) {
    if (frame >= away && side != WitnessSide::After) {
      before -= takes_time(frame - away + 1, frame, clock) ? 1.0 : 0.0;
      take(frame - away, before);
    }
    if (frame + away < m_likeness.size() && side != WitnessSide::Before) {
      after += takes_time(frame + away, frame, clock) ? 1.0 : 0.0;
      take(frame + away, after);
    }
  }
  return result;
}

double RepeatWitnesses::range(const Path& path, std::size_t frame, Witness witness) const {
  const Samples around = samples(path, frame, witness, RepeatClock{});
  if (around.y.empty()) return 0.0;
  const auto [low, high] = std::minmax_element(around.y.begin(), around.y.end());
  return *high - *low;
}

bool RepeatWitnesses::recurs(std::size_t frame, std::size_t period) const {
  std::size_t times = 0;
  const std::size_t first = frame - std::min(frame - 1, kReach) / period * period;
  for (std::size_t n = first; n < std::min(m_likeness.size(), frame + kReach); n += period) {
    if (m_likeness[n] == Likeness::Different) return false;
    ++times;
  }
  return times > kReach / period;
}

bool RepeatWitnesses::begin_or_end(const Path& path, std::size_t frame) const {
  const auto stands = [&](std::size_t first, std::size_t end) {
    double low = kInfinity;
    double high = -kInfinity;
    for (std::size_t n = first; n < end; ++n) {
      if (!std::isfinite(path.at(n))) continue;
      low = std::min(low, path.at(n));
      high = std::max(high, path.at(n));
    }
    return high - low < path.least_range;
  };
  return range(path, frame, Witness::NoRepeat) > kLively * path.least_range &&
         (stands(frame - std::min(frame, kOneSide), frame) ||
          stands(frame + 1, std::min(frame + 1 + kOneSide, m_likeness.size())));
}

double RepeatWitnesses::off_where_alike(const Path& path,
                                        const LocalFit& fit,
                                        std::size_t frame) const {
  std::vector<double> off;
  const std::size_t end = std::min(frame + kAround + 1, m_likeness.size());
  for (std::size_t n = frame - std::min(frame, kAround); n < end; ++n) {
    if (n == frame || m_repeats[n] || m_likeness[n] != Likeness::Alike) continue;
    const double t = static_cast<double>(n) - static_cast<double>(frame);
    const double by = std::abs(path.at(n) - fit.at(t).at);
    if (by < path.stood) off.push_back(by);  // else a repeat not yet found
  }
  if (off.size() < kLeftAlone) return 0.0;
  const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
  std::nth_element(off.begin(), middle, off.end());
  return kSigmaOverMedian * *middle;
}

}  // namespace twang::detail
