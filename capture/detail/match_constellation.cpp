// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/match_constellation.hpp"

#include "capture/detail/layout_map.hpp"
#include "core/constants.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

namespace twang::detail {
namespace {

constexpr double kMissing = 16.0;       // price of a marker that is not there: four sigmas
constexpr double kFarthest = 12.0;      // largest squared deviation of one that is
constexpr double kSigmaSize = 0.12;     // of the size, relative: print, perspective, blur
constexpr double kSigmaScore = 0.06;    // of one minus the score
constexpr double kSigmaGuess = 0.025;   // of places under a map through two markers, in extents
constexpr double kSigmaPlace = 0.006;   // under a map through all: lens, bent paper, in extents
constexpr double kSigmaFixed_px = 0.5;  // of a fixed marker, where the map is fitted
constexpr double kSigmaStrain = 0.4;    // of neighbours' motion against each other, in distances
constexpr double kAboutAsGood = 4.0;    // a likelihood ratio of e²
constexpr double kMostBeside = 1.0;     // of a guess's sigma: places at which no map is new
constexpr std::array kHowLoose = {0.1, 0.3, 1.0};  // in parts of what moving markers may do
constexpr std::size_t kMostKept = 64;
constexpr std::size_t kMostPairs = 64;
constexpr int kMostCandidates = 300;  // for hypotheses, best first

double distance_to_segment(const Eigen::Vector2d& point,
                           const Eigen::Vector2d& from,
                           const Eigen::Vector2d& along,
                           Eigen::Vector2d& nearest) {
  const double square = along.squaredNorm();
  const double t = square > 0.0 ? std::clamp((point - from).dot(along) / square, 0.0, 1.0) : 0.0;
  nearest = from + t * along;
  return (point - nearest).norm();
}

/// Where a map puts a marker.
struct DuePlace {
  Eigen::Vector2d rest_px;
  Eigen::Vector2d reach_px;
  double px_per_m;
};

class Search {
 public:
  Search(const std::vector<LayoutMarker>& markers,
         const std::vector<MarkerCandidate>& candidates,
         double most_turn_rad);

  ConstellationMatch run();

 private:
  using Pair = std::pair<std::size_t, std::size_t>;

  [[nodiscard]] bool may_be(const LayoutMarker& marker, int candidate) const;
  [[nodiscard]] std::vector<DuePlace> due_places(const Homography& map) const;
  [[nodiscard]] const MarkerCandidate& at(int candidate) const {
    return m_candidates[static_cast<std::size_t>(candidate)];
  }
  [[nodiscard]] double looks(std::size_t marker, int candidate, double px_per_m) const;
  [[nodiscard]] std::optional<Constellation> assign(const Homography& map,
                                                    double sigma_place,
                                                    int least_matched) const;
  [[nodiscard]] Homography refit(const Constellation& found) const;
  [[nodiscard]] double cost(const Constellation& found) const;
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
  double m_most_turn;
  double m_extent = 0.0;  // of the layout [m]
  Eigen::Vector2d m_low, m_high;
  std::vector<std::size_t> m_order;       // fixed markers first
  std::vector<int> m_neighbour;           // nearest other moving marker alike; -1: none
  std::vector<Constellation> m_found;     // distinct, best first
  std::set<std::array<long, 4>> m_tried;  // guesses, coarsely
};

Search::Search(const std::vector<LayoutMarker>& markers,
               const std::vector<MarkerCandidate>& candidates,
               double most_turn_rad)
    : m_markers(markers),
      m_candidates(candidates),
      m_most_turn(most_turn_rad),
      m_low(markers.front().rest),
      m_high(markers.front().rest),
      m_neighbour(markers.size(), -1) {
  for (std::size_t i = 0; i < markers.size(); ++i) {
    double least = kInfinity;
    for (std::size_t k = 0; k < markers.size(); ++k) {
      const double distance = (markers[i].rest - markers[k].rest).norm();
      m_extent = std::max(m_extent, distance);
      if (k == i || markers[i].fixed || markers[k].fixed ||
          markers[i].pattern != markers[k].pattern || distance >= least || distance == 0.0) {
        continue;
      }
      least = distance;
      m_neighbour[i] = static_cast<int>(k);
    }
    m_low = m_low.cwiseMin(markers[i].rest);
    m_high = m_high.cwiseMax(markers[i].rest);
    m_order.push_back(i);
  }
  if (m_extent == 0.0) m_extent = markers.front().size_m;
  std::stable_partition(
      m_order.begin(), m_order.end(), [&](std::size_t i) { return markers[i].fixed; });
}

bool Search::may_be(const LayoutMarker& marker, int candidate) const {
  if (marker.given >= 0) return marker.given == candidate;
  return at(candidate).pattern == marker.pattern;
}

std::vector<DuePlace> Search::due_places(const Homography& map) const {
  std::vector<DuePlace> due;
  due.reserve(m_markers.size());
  for (const LayoutMarker& marker : m_markers) {
    const Eigen::Vector2d rest = map_point(map, marker.rest);
    due.push_back({rest,
                   map_point(map, marker.rest + marker.reach) - rest,
                   std::sqrt(std::abs(map_jacobian(map, marker.rest).determinant()))});
  }
  return due;
}

/// Squared deviation of a candidate's size and score from a marker's, in sigmas.
double Search::looks(std::size_t marker, int candidate, double px_per_m) const {
  const double due_px = m_markers[marker].size_m * px_per_m;
  const double size = std::log(at(candidate).size_px / due_px) / kSigmaSize;
  const double score = (1.0 - at(candidate).score) / kSigmaScore;
  return size * size + score * score;
}

/// One-to-one assignment under a map: the cheapest pair first; none as soon as it is clear that too
/// few markers find a candidate.
std::optional<Constellation> Search::assign(const Homography& map,
                                            double sigma_place,
                                            int least_matched) const {
  const std::vector<DuePlace> due = due_places(map);
  const int most_missing = static_cast<int>(m_markers.size()) - least_matched;
  int missing = 0;
  std::vector<std::tuple<double, std::size_t, int>> pairs;
  for (const std::size_t i : m_order) {
    const LayoutMarker& marker = m_markers[i];
    const double sigma = due[i].px_per_m * std::hypot(sigma_place * m_extent, marker.loose);
    const std::size_t before = pairs.size();
    for (int c = 0; c < static_cast<int>(m_candidates.size()); ++c) {
      if (!may_be(marker, c)) continue;
      Eigen::Vector2d nearest;
      const double beside = distance_to_segment(
          at(c).placement.position_px, due[i].rest_px, due[i].reach_px, nearest);
      const double place = beside * beside / (sigma * sigma);
      if (place >= kFarthest && marker.given < 0) continue;
      const double cost = place + looks(i, c, due[i].px_per_m);
      if (cost < kFarthest || marker.given >= 0) pairs.emplace_back(cost, i, c);
    }
    if (pairs.size() == before && ++missing > most_missing) return std::nullopt;
  }
  std::sort(pairs.begin(), pairs.end());
  Constellation result{std::vector<int>(m_markers.size(), -1), map, 0.0, 0};
  std::vector<bool> taken(m_candidates.size(), false);
  for (const auto& [cost, marker, candidate] : pairs) {
    int& place = result.candidate[marker];
    if (place >= 0 || taken[static_cast<std::size_t>(candidate)]) continue;
    place = candidate;
    taken[static_cast<std::size_t>(candidate)] = true;
    ++result.num_matched;
  }
  if (result.num_matched < least_matched) return std::nullopt;
  return result;
}

/// The map through the matched markers: fixed ones are where they should be, moving ones about so.
Homography Search::refit(const Constellation& found) const {
  const std::vector<DuePlace> due = due_places(found.px_from_plane);
  std::vector<LayoutPair> pairs;
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    if (found.candidate[i] < 0) continue;
    const LayoutMarker& marker = m_markers[i];
    const Eigen::Vector2d px = at(found.candidate[i]).placement.position_px;
    Eigen::Vector2d nearest;
    static_cast<void>(distance_to_segment(px, due[i].rest_px, due[i].reach_px, nearest));
    const double loose = std::hypot(marker.loose, 0.5 * marker.reach.norm());
    const double sigma = marker.fixed ? 0.0 : due[i].px_per_m * loose;
    pairs.push_back(
        {marker.rest, px - (nearest - due[i].rest_px), std::hypot(kSigmaFixed_px, sigma)});
  }
  if (pairs.size() < 2) return found.px_from_plane;
  return fit_layout_map(pairs, m_extent);
}

/// Of a whole assignment. How far moving markers went is a scale that all share and that is fitted:
///
///     min over tau of  sum d² / sigma(tau)² + 4 ln(sigma(tau) / sigma(1))
///
/// beside which stand sizes, scores, and the motion of neighbours against each other.
double Search::cost(const Constellation& found) const {
  const std::vector<DuePlace> due = due_places(found.px_from_plane);
  double sum = 0.0;
  std::array<double, kHowLoose.size()> loose{};
  std::vector<Eigen::Vector2d> moved(m_markers.size(), Eigen::Vector2d::Zero());
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    const int c = found.candidate[i];
    if (c < 0) {
      sum += kMissing;
      continue;
    }
    sum += looks(i, c, due[i].px_per_m);
    const Eigen::Vector2d& px = at(c).placement.position_px;
    Eigen::Vector2d nearest;
    const double beside =
        distance_to_segment(px, due[i].rest_px, due[i].reach_px, nearest) / due[i].px_per_m;
    moved[i] = px - due[i].rest_px;
    const double place = kSigmaPlace * m_extent;
    const double widest = std::hypot(place, m_markers[i].loose);
    for (std::size_t k = 0; k < loose.size(); ++k) {
      const double sigma = std::hypot(place, kHowLoose[k] * m_markers[i].loose);
      loose[k] += beside * beside / (sigma * sigma) + 4.0 * std::log(sigma / widest);
    }
  }
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    if (m_neighbour[i] < 0) continue;
    const auto k = static_cast<std::size_t>(m_neighbour[i]);
    if (found.candidate[i] < 0 || found.candidate[k] < 0) continue;
    const double distance = (due[i].rest_px - due[k].rest_px).norm();
    const double strain = (moved[i] - moved[k]).norm() / distance / kSigmaStrain;
    sum += strain * strain;
  }
  return sum + *std::min_element(loose.begin(), loose.end());
}

void Search::judge(const Homography& guess) {
  const double step = kMostBeside * kSigmaGuess * m_extent * guess.col(0).norm();
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
  auto found = assign(guess, kSigmaGuess, least);
  for (int pass = 0; pass < 2 && found; ++pass) {
    found = assign(refit(*found), pass == 0 ? 2.0 * kSigmaPlace : kSigmaPlace, least);
  }
  if (!found) return;
  const Eigen::Matrix2d turned = map_jacobian(found->px_from_plane, 0.5 * (m_low + m_high));
  const double turn = std::atan2(turned(1, 0) - turned(0, 1), turned(0, 0) + turned(1, 1));
  if (std::abs(turn) > m_most_turn) return;
  found->cost = cost(*found);
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
  const std::vector<DuePlace> due = due_places(found.px_from_plane);
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    const int own = found.candidate[i];
    if (own < 0 || m_markers[i].given >= 0) continue;
    for (int c = 0; c < static_cast<int>(m_candidates.size()); ++c) {
      if (c == own || !may_be(m_markers[i], c)) continue;
      Constellation other = found;
      const auto owner = std::find(found.candidate.begin(), found.candidate.end(), c);
      other.candidate[i] = c;
      if (owner != found.candidate.end()) {
        const auto k = static_cast<std::size_t>(owner - found.candidate.begin());
        if (!may_be(m_markers[k], own)) continue;
        other.candidate[k] = own;
      }
      other.cost = cost(other);
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
    return may_be(m, candidate) && (candidate < kMostCandidates || m.given >= 0);
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
      if (!may_be(marker, c)) continue;
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
