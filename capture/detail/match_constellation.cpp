// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/match_constellation.hpp"

#include "capture/detail/judge_constellation.hpp"
#include "capture/detail/layout_map.hpp"
#include "core/constants.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

namespace twang::detail {
namespace {

constexpr double kSigmaSize = 0.12;   // of the size, relative: print, perspective, blur
constexpr double kAboutAsGood = 4.0;  // a likelihood ratio of e²
constexpr std::size_t kMostKept = 64;
constexpr std::size_t kMostPairs = 64;
constexpr int kMostCandidates = 300;  // for hypotheses, best first

class Search {
 public:
  Search(const std::vector<LayoutMarker>& markers,
         const std::vector<MarkerCandidate>& candidates,
         double most_turn_rad)
      : m_markers(markers),
        m_candidates(candidates),
        m_judge(markers, candidates),
        m_most_turn(most_turn_rad),
        m_low(markers.front().rest),
        m_high(markers.front().rest) {
    for (const LayoutMarker& marker : markers) {
      m_low = m_low.cwiseMin(marker.rest);
      m_high = m_high.cwiseMax(marker.rest);
    }
  }

  ConstellationMatch run();

 private:
  using Pair = std::pair<std::size_t, std::size_t>;

  [[nodiscard]] const MarkerCandidate& at(int candidate) const {
    return m_candidates[static_cast<std::size_t>(candidate)];
  }
  void judge(const Homography& guess);
  void keep(const Constellation& found);
  void keep_alternatives(const Constellation& found);
  [[nodiscard]] std::vector<Pair> pairs(bool fixed_only) const;
  void try_pairs(bool fixed_only);
  void try_pair(const Pair& pair, int a, int b);
  void try_singles();
  [[nodiscard]] int most_matched() const;

  const std::vector<LayoutMarker>& m_markers;
  const std::vector<MarkerCandidate>& m_candidates;
  ConstellationJudge m_judge;
  double m_most_turn;
  Eigen::Vector2d m_low, m_high;
  std::vector<Constellation> m_found;     // distinct, best first
  std::set<std::array<long, 4>> m_tried;  // guesses, coarsely
};

void Search::judge(const Homography& guess) {
  const double step = ConstellationJudge::rough_sigma() * m_judge.extent() * guess.col(0).norm();
  const Eigen::Vector2d low = map_point(guess, m_low) / step;
  const Eigen::Vector2d high = map_point(guess, m_high) / step;
  if (!m_tried
           .insert({std::lround(2.0 * low.x()),
                    std::lround(2.0 * low.y()),
                    std::lround(2.0 * high.x()),
                    std::lround(2.0 * high.y())})
           .second) {
    return;
  }
  const int least = std::max(1, most_matched() - 1);
  auto found = m_judge.assign_roughly(guess, least);
  if (!found) return;
  for (const double slack : {2.0, 1.0}) found = m_judge.assign(m_judge.refit(*found), slack);
  if (found->num_matched < least) return;
  const Eigen::Matrix2d turned = map_jacobian(found->px_from_plane, 0.5 * (m_low + m_high));
  const double turn = std::atan2(turned(1, 0) - turned(0, 1), turned(0, 0) + turned(1, 1));
  if (std::abs(turn) > m_most_turn) return;
  found->cost = m_judge.cost(*found);
  if (!m_found.empty() && found->cost > m_found.front().cost + 4.0 * kAboutAsGood) return;
  keep(*found);
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
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    const int own = found.candidate[i];
    if (own < 0 || m_markers[i].given >= 0) continue;
    for (int c = 0; c < static_cast<int>(m_candidates.size()); ++c) {
      if (c == own || !m_judge.may_be(m_markers[i], c)) continue;
      Constellation other = found;
      const auto owner = std::find(found.candidate.begin(), found.candidate.end(), c);
      other.candidate[i] = c;
      if (owner != found.candidate.end()) {
        const auto k = static_cast<std::size_t>(owner - found.candidate.begin());
        if (!m_judge.may_be(m_markers[k], own)) continue;
        other.candidate[k] = own;
      }
      other.cost = m_judge.cost(other);
      if (other.cost < found.cost + kAboutAsGood) keep(other);
    }
  }
}

int Search::most_matched() const {
  int most = 0;
  for (const Constellation& found : m_found) most = std::max(most, found.num_matched);
  return most;
}

/// Pairs to start from, the farthest apart first; of many, such that every marker has its share.
std::vector<Search::Pair> Search::pairs(bool fixed_only) const {
  std::vector<std::pair<double, Pair>> all;
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    for (std::size_t k = i + 1; k < m_markers.size(); ++k) {
      const LayoutMarker& first = m_markers[i];
      const LayoutMarker& second = m_markers[k];
      const double distance = (second.rest - first.rest).norm();
      if (fixed_only && !(first.fixed && second.fixed)) continue;
      if (distance < 0.5 * (first.size_m + second.size_m)) continue;
      all.push_back({-distance, {i, k}});
    }
  }
  std::sort(all.begin(), all.end());
  const std::size_t share = 1 + 2 * kMostPairs / m_markers.size();
  std::vector<std::size_t> used(m_markers.size(), 0);
  std::vector<Pair> chosen;
  for (const auto& [distance, pair] : all) {
    if (all.size() > kMostPairs && std::max(used[pair.first], used[pair.second]) >= share) continue;
    ++used[pair.first];
    ++used[pair.second];
    chosen.push_back(pair);
  }
  return chosen;
}

void Search::try_pair(const Pair& pair, int a, int b) {
  const LayoutMarker& first = m_markers[pair.first];
  const LayoutMarker& second = m_markers[pair.second];
  const Eigen::Vector2d base = second.rest - first.rest;
  const Eigen::Vector2d span = at(b).placement.position_px - at(a).placement.position_px;
  const double px_per_m = span.norm() / base.norm();
  const auto misfit = [&](const LayoutMarker& marker, int candidate) {
    return std::abs(std::log(at(candidate).size_px / (marker.size_m * px_per_m)));
  };
  const double turn = std::atan2(base.x() * span.y() - base.y() * span.x(), base.dot(span));
  if (std::abs(turn) > m_most_turn || misfit(first, a) > 3.0 * kSigmaSize ||
      misfit(second, b) > 3.0 * kSigmaSize) {
    return;
  }
  judge(fit_weighted_similarity({{first.rest, at(a).placement.position_px, 1.0},
                                 {second.rest, at(b).placement.position_px, 1.0}}));
}

void Search::try_pairs(bool fixed_only) {
  const int num_candidates = static_cast<int>(m_candidates.size());
  const auto tried = [&](std::size_t marker, int candidate) {
    const LayoutMarker& m = m_markers[marker];
    return m_judge.may_be(m, candidate) && (candidate < kMostCandidates || m.given >= 0);
  };
  for (const Pair& pair : pairs(fixed_only)) {
    for (int a = 0; a < num_candidates; ++a) {
      if (!tried(pair.first, a)) continue;
      for (int b = 0; b < num_candidates; ++b) {
        if (b != a && tried(pair.second, b)) try_pair(pair, a, b);
      }
    }
  }
}

/// One marker gives scale and place by its size, the picture's axes the turn.
void Search::try_singles() {
  for (const LayoutMarker& marker : m_markers) {
    for (int c = 0; c < static_cast<int>(m_candidates.size()); ++c) {
      if (!m_judge.may_be(marker, c)) continue;
      const double scale = at(c).size_px / marker.size_m;
      Homography map = Homography::Identity();
      map.topLeftCorner<2, 2>() *= scale;
      map.topRightCorner<2, 1>() = at(c).placement.position_px - scale * marker.rest;
      judge(map);
    }
  }
}

ConstellationMatch Search::run() {
  const auto complete = [&] { return most_matched() == static_cast<int>(m_markers.size()); };
  try_pairs(true);
  if (!complete()) try_pairs(false);
  if (m_found.empty() || m_markers.size() == 1) try_singles();
  ConstellationMatch match;
  if (m_found.empty()) return match;
  const std::vector<Constellation> found = m_found;
  for (const Constellation& one : found) {
    if (one.cost < found.front().cost + kAboutAsGood) keep_alternatives(one);
  }
  for (const Constellation& one : m_found) {
    if (one.cost < m_found.front().cost + kAboutAsGood) match.about_as_good.push_back(one);
  }
  return match;
}

}  // namespace

ConstellationMatch match_constellation(const std::vector<LayoutMarker>& markers,
                                       const std::vector<MarkerCandidate>& candidates,
                                       double most_turn_rad) {
  if (markers.empty() || candidates.empty()) return {};
  return Search(markers, candidates, most_turn_rad).run();
}

}  // namespace twang::detail
