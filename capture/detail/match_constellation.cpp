// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/match_constellation.hpp"

#include "core/constants.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

namespace twang::detail {
namespace {

using Complex = std::complex<double>;

constexpr double kMissing = 16.0;      // price of a marker that is not there: four sigmas
constexpr double kFarthest = 12.0;     // largest squared deviation of one that is
constexpr double kSigmaSize = 0.12;    // of the size, relative: print, perspective, blur
constexpr double kSigmaScore = 0.06;   // of one minus the score
constexpr double kSigmaPlace = 0.025;  // perspective and lens, of the layout's extent
constexpr double kAboutAsGood = 4.0;   // a likelihood ratio of e²
constexpr std::size_t kMostKept = 64;

Complex complex(const Eigen::Vector2d& v) { return {v.x(), v.y()}; }

double distance_to_segment(Complex point, Complex from, Complex along) {
  const double square = std::norm(along);
  const Complex offset = point - from;
  const double t =
      square > 0.0 ? std::clamp((std::conj(along) * offset).real() / square, 0.0, 1.0) : 0.0;
  return std::abs(offset - t * along);
}

class Search {
 public:
  Search(const std::vector<LayoutMarker>& markers,
         const std::vector<MarkerCandidate>& candidates,
         double most_turn_rad)
      : m_markers(markers), m_candidates(candidates), m_most_turn(most_turn_rad) {
    for (const LayoutMarker& a : markers) {
      for (const LayoutMarker& b : markers) {
        m_extent = std::max(m_extent, (a.rest - b.rest).norm());
      }
    }
    if (m_extent == 0.0) m_extent = markers.front().size_m;
  }

  ConstellationMatch run();

 private:
  bool may_be(const LayoutMarker& marker, int candidate) const;
  double deviation(const LayoutMarker& marker, int candidate, const PlaneSimilarity& map) const;
  Constellation assign(const PlaneSimilarity& map) const;
  PlaneSimilarity refit(const Constellation& found) const;
  void judge(const PlaneSimilarity& guess);
  void keep(const Constellation& found);
  void keep_alternatives(const Constellation& found);
  void try_pairs(bool fixed_only);
  void try_singles();
  [[nodiscard]] int most_matched() const;

  const std::vector<LayoutMarker>& m_markers;
  const std::vector<MarkerCandidate>& m_candidates;
  double m_most_turn;
  double m_extent = 0.0;               // of the layout [m]
  std::vector<Constellation> m_found;  // distinct, best first
};

bool Search::may_be(const LayoutMarker& marker, int candidate) const {
  if (marker.given >= 0) return marker.given == candidate;
  return m_candidates[static_cast<std::size_t>(candidate)].pattern == marker.pattern;
}

/// Squared deviation of a candidate from what the map says of a marker, in sigmas.
double Search::deviation(const LayoutMarker& marker,
                         int candidate,
                         const PlaneSimilarity& map) const {
  const MarkerCandidate& c = m_candidates[static_cast<std::size_t>(candidate)];
  const double px_per_m = std::abs(map.scale);
  const Complex rest = map.scale * complex(marker.rest) + map.shift;
  const double beside = distance_to_segment(
      complex(c.placement.position_px), rest, map.scale * complex(marker.reach));
  const double sigma = px_per_m * std::hypot(kSigmaPlace * m_extent, marker.loose);
  const double size = std::log(c.size_px / (marker.size_m * px_per_m)) / kSigmaSize;
  const double score = (1.0 - c.score) / kSigmaScore;
  return beside * beside / (sigma * sigma) + size * size + score * score;
}

/// One-to-one assignment under a map: the cheapest pair first.
Constellation Search::assign(const PlaneSimilarity& map) const {
  std::vector<std::tuple<double, int, int>> pairs;
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    for (int c = 0; c < static_cast<int>(m_candidates.size()); ++c) {
      if (!may_be(m_markers[i], c)) continue;
      const double cost = deviation(m_markers[i], c, map);
      const double limit = m_markers[i].given >= 0 ? kInfinity : kFarthest;
      if (cost < limit) pairs.emplace_back(cost, static_cast<int>(i), c);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  Constellation result{std::vector<int>(m_markers.size(), -1), map, 0.0, 0};
  for (const auto& [cost, marker, candidate] : pairs) {
    int& place = result.candidate[static_cast<std::size_t>(marker)];
    const auto& taken = result.candidate;
    if (place >= 0 || std::find(taken.begin(), taken.end(), candidate) != taken.end()) continue;
    place = candidate;
    result.cost += cost;
    ++result.num_matched;
  }
  result.cost += kMissing * static_cast<double>(m_markers.size() -
                                                static_cast<std::size_t>(result.num_matched));
  return result;
}

/// The map through the fixed markers that were matched, through all if those are under two.
PlaneSimilarity Search::refit(const Constellation& found) const {
  std::array<std::vector<Eigen::Vector2d>, 2> plane, px;  // all, fixed
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    if (found.candidate[i] < 0) continue;
    const auto c = static_cast<std::size_t>(found.candidate[i]);
    plane[0].push_back(m_markers[i].rest);
    px[0].push_back(m_candidates[c].placement.position_px);
    if (!m_markers[i].fixed) continue;
    plane[1].push_back(m_markers[i].rest);
    px[1].push_back(m_candidates[c].placement.position_px);
  }
  const std::size_t use = plane[1].size() >= 2 ? 1 : 0;
  return plane[use].size() >= 2 ? fit_similarity(plane[use], px[use]) : found.px_from_plane;
}

void Search::judge(const PlaneSimilarity& guess) {
  Constellation found = assign(guess);
  if (found.num_matched < std::max(1, most_matched() - 1)) return;
  found = assign(refit(found));
  if (std::abs(std::arg(found.px_from_plane.scale)) > m_most_turn) return;
  if (!m_found.empty() && found.cost > m_found.front().cost + 4.0 * kAboutAsGood) return;
  keep(found);
  keep_alternatives(found);
}

/// Files an assignment by its cost, once.
void Search::keep(const Constellation& found) {
  const auto same = std::find_if(m_found.begin(), m_found.end(), [&](const Constellation& other) {
    return other.candidate == found.candidate;
  });
  if (same != m_found.end()) {
    if (same->cost <= found.cost) return;
    m_found.erase(same);
  }
  const auto place = std::upper_bound(
      m_found.begin(), m_found.end(), found, [](const Constellation& a, const Constellation& b) {
        return a.cost < b.cost;
      });
  m_found.insert(place, found);
  if (m_found.size() > kMostKept) m_found.pop_back();
}

/// Under the same map: one marker is another candidate, or two have changed places.
void Search::keep_alternatives(const Constellation& found) {
  const PlaneSimilarity& map = found.px_from_plane;
  const auto try_with = [&](Constellation other, double added) {
    if (!(added < kAboutAsGood)) return;
    other.cost = found.cost + added;
    keep(other);
  };
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    const int own = found.candidate[i];
    if (own < 0 || m_markers[i].given >= 0) continue;
    const double cost = deviation(m_markers[i], own, map);
    for (int c = 0; c < static_cast<int>(m_candidates.size()); ++c) {
      if (c == own || !may_be(m_markers[i], c)) continue;
      Constellation other = found;
      const auto owner = std::find(found.candidate.begin(), found.candidate.end(), c);
      other.candidate[i] = c;
      double added = deviation(m_markers[i], c, map) - cost;
      if (owner != found.candidate.end()) {
        const auto k = static_cast<std::size_t>(owner - found.candidate.begin());
        if (!may_be(m_markers[k], own)) continue;
        other.candidate[k] = own;
        added += deviation(m_markers[k], own, map) - deviation(m_markers[k], c, map);
      }
      try_with(other, added);
    }
  }
}

int Search::most_matched() const {
  int most = 0;
  for (const Constellation& found : m_found) most = std::max(most, found.num_matched);
  return most;
}

void Search::try_pairs(bool fixed_only) {
  const int num_candidates = static_cast<int>(m_candidates.size());
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    for (std::size_t j = i + 1; j < m_markers.size(); ++j) {
      const LayoutMarker& first = m_markers[i];
      const LayoutMarker& second = m_markers[j];
      if (fixed_only && !(first.fixed && second.fixed)) continue;
      const Complex base = complex(second.rest - first.rest);
      if (std::abs(base) < 0.5 * (first.size_m + second.size_m)) continue;
      for (int a = 0; a < num_candidates; ++a) {
        if (!may_be(first, a)) continue;
        const MarkerCandidate& at_a = m_candidates[static_cast<std::size_t>(a)];
        for (int b = 0; b < num_candidates; ++b) {
          if (b == a || !may_be(second, b)) continue;
          const MarkerCandidate& at_b = m_candidates[static_cast<std::size_t>(b)];
          const Complex span = complex(at_b.placement.position_px - at_a.placement.position_px);
          const Complex scale = span / base;
          const double px_per_m = std::abs(scale);
          const auto misfit = [&](const LayoutMarker& marker, const MarkerCandidate& candidate) {
            return std::abs(std::log(candidate.size_px / (marker.size_m * px_per_m)));
          };
          if (std::abs(std::arg(scale)) > m_most_turn || misfit(first, at_a) > 3.0 * kSigmaSize ||
              misfit(second, at_b) > 3.0 * kSigmaSize) {
            continue;
          }
          judge({scale, complex(at_a.placement.position_px) - scale * complex(first.rest)});
        }
      }
    }
  }
}

/// One marker gives scale and place by its size, the picture's axes the turn.
void Search::try_singles() {
  for (const LayoutMarker& marker : m_markers) {
    for (int c = 0; c < static_cast<int>(m_candidates.size()); ++c) {
      if (!may_be(marker, c)) continue;
      const MarkerCandidate& at = m_candidates[static_cast<std::size_t>(c)];
      const Complex scale = at.size_px / marker.size_m;
      judge({scale, complex(at.placement.position_px) - scale * complex(marker.rest)});
    }
  }
}

ConstellationMatch Search::run() {
  const auto complete = [&] { return most_matched() == static_cast<int>(m_markers.size()); };
  try_pairs(true);
  if (!complete()) try_pairs(false);
  if (m_found.empty() || m_markers.size() == 1) try_singles();
  ConstellationMatch match;
  for (const Constellation& found : m_found) {
    if (found.cost < m_found.front().cost + kAboutAsGood) match.about_as_good.push_back(found);
  }
  return match;
}

}  // namespace

Eigen::Vector2d PlaneSimilarity::apply(const Eigen::Vector2d& plane) const {
  const Complex z = scale * complex(plane) + shift;
  return {z.real(), z.imag()};
}

PlaneSimilarity fit_similarity(const std::vector<Eigen::Vector2d>& plane,
                               const std::vector<Eigen::Vector2d>& px) {
  const double n = static_cast<double>(plane.size());
  Complex mean_plane = 0.0;
  Complex mean_px = 0.0;
  for (std::size_t i = 0; i < plane.size(); ++i) {
    mean_plane += complex(plane[i]) / n;
    mean_px += complex(px[i]) / n;
  }
  Complex product = 0.0;
  double square = 0.0;
  for (std::size_t i = 0; i < plane.size(); ++i) {
    product += std::conj(complex(plane[i]) - mean_plane) * (complex(px[i]) - mean_px);
    square += std::norm(complex(plane[i]) - mean_plane);
  }
  const Complex scale = product / square;
  return {scale, mean_px - scale * mean_plane};
}

ConstellationMatch match_constellation(const std::vector<LayoutMarker>& markers,
                                       const std::vector<MarkerCandidate>& candidates,
                                       double most_turn_rad) {
  if (markers.empty() || candidates.empty()) return {};
  return Search(markers, candidates, most_turn_rad).run();
}

}  // namespace twang::detail
