// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/find_cadence.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace twang::detail {
namespace {

constexpr std::size_t kCadence = 12;  // frames on either side that show a cadence
constexpr std::size_t kLongest = 3;   // frames a picture is shown
constexpr double kMostly = 0.6;       // of the fresh pictures that must differ from the one before
constexpr double kThroughout = 0.8;   // of where something moves
constexpr double kStands = 0.3;       // of the step of the fresh frames, the others'
constexpr double kStep = 0.3;         // of the least range of motion, from which a step is one

struct Window {
  std::size_t first;
  std::size_t end;
  [[nodiscard]] std::size_t size() const { return end - first; }
};

struct Cadence {
  std::size_t period;
  std::size_t fresh;  // frames at this place in a period show a picture for the first time
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Whether what moves does so in the fresh frames and stands in the others.
bool stands_between(const std::vector<Path>& paths, Window window, Cadence cadence) {
  return std::none_of(paths.begin(), paths.end(), [&](const Path& path) {
    std::vector<double> moving;
    std::vector<double> standing;
    for (std::size_t n = std::max<std::size_t>(window.first, 1); n < window.end; ++n) {
      const double step = std::abs(path.at(n) - path.at(n - 1));
      if (!std::isfinite(step)) continue;
      (n % cadence.period == cadence.fresh ? moving : standing).push_back(step);
    }
    if (moving.empty() || standing.empty()) return false;
    const double most = median(moving);
    return most > kStep * path.least_range && median(standing) > kStands * most;
  });
}

class CadenceFinder {
 public:
  CadenceFinder(const std::vector<Likeness>& likeness, const std::vector<Path>& paths)
      : m_likeness(likeness), m_paths(paths) {}

  [[nodiscard]] std::vector<bool> find() const {
    std::vector<bool> repeats(m_likeness.size(), false);
    double moving = 0.0;
    double in_cadence = 0.0;
    for (std::size_t n = 0; n < m_likeness.size(); ++n) {
      const Window window = around(n);
      const std::optional<Cadence> cadence = cadence_in(window);
      repeats[n] =
          cadence && n % cadence->period != cadence->fresh && m_likeness[n] != Likeness::Different;
      // The first frame is called different though nothing need have moved.
      const std::size_t first = std::max<std::size_t>(window.first, 1);
      const double different = count_different(m_likeness, first, window.end);
      if (different * kLongest <= kMostly * static_cast<double>(window.size())) continue;
      moving += 1.0;
      in_cadence += cadence ? 1.0 : 0.0;
    }
    if (in_cadence < kThroughout * moving) repeats.assign(m_likeness.size(), false);
    return repeats;
  }

 private:
  [[nodiscard]] Window around(std::size_t frame) const {
    return {frame - std::min(frame, kCadence), std::min(frame + kCadence + 1, m_likeness.size())};
  }
  [[nodiscard]] std::optional<Cadence> cadence_in(Window window) const {
    if (window.size() <= kCadence) return std::nullopt;
    for (const std::size_t period : {std::size_t{2}, kLongest}) {
      for (std::size_t fresh = 0; fresh < period; ++fresh) {
        if (is_cadence(window, {period, fresh})) return Cadence{period, fresh};
      }
    }
    return std::nullopt;
  }
  [[nodiscard]] bool is_cadence(Window window, Cadence cadence) const {
    const auto [period, fresh] = cadence;
    const std::size_t begin = window.first + (fresh + period - window.first % period) % period;
    const auto num_fresh = static_cast<double>((window.end - begin + period - 1) / period);
    const double different = count_different(m_likeness, begin, window.end, period);
    double others = count_different(m_likeness, window.first, window.end) - different;
    if (window.first == 0 && begin > 0) others -= 1.0;  // the first frame
    return others == 0.0 && different >= kMostly * num_fresh &&
           stands_between(m_paths, window, cadence);
  }

  const std::vector<Likeness>& m_likeness;
  const std::vector<Path>& m_paths;
};

}  // namespace

double count_different(const std::vector<Likeness>& likeness,
                       std::size_t first,
                       std::size_t end,
                       std::size_t step) {
  double count = 0.0;
  for (std::size_t n = first; n < end; n += step) {
    count += likeness[n] == Likeness::Different ? 1.0 : 0.0;
  }
  return count;
}

std::vector<bool> find_cadence(const std::vector<Likeness>& likeness,
                               const std::vector<Path>& paths) {
  return CadenceFinder(likeness, paths).find();
}

}  // namespace twang::detail
