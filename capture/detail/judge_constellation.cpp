// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/judge_constellation.hpp"

#include "capture/detail/assign_markers.hpp"
#include "capture/detail/layout_map.hpp"
#include "core/constants.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

namespace twang::detail {
namespace {

// Price of a marker that is not there: above that of any candidate allowed to be it.
constexpr double kMissingCost = 30.0;
constexpr double kFarthest = 12.0;      // largest squared deviation of one that is
constexpr double kSigmaSize = 0.12;     // of the size, relative: print, perspective, blur
constexpr double kSigmaScore = 0.06;    // of one minus the score
constexpr double kSigmaGuess = 0.025;   // of places under a map through two markers, in extents
constexpr double kSigmaPlace = 0.006;   // under a map through all: lens, bent paper, in extents
constexpr double kSigmaFixed_px = 0.5;  // of a fixed marker, where the map is fitted
constexpr double kSigmaStrain = 0.4;    // of neighbours' motion against each other, in distances
constexpr std::array kHowLoose = {0.1, 0.3, 1.0};  // in parts of what moving markers may do

double distance_to_segment(const Eigen::Vector2d& point,
                           const Eigen::Vector2d& from,
                           const Eigen::Vector2d& along,
                           Eigen::Vector2d& nearest) {
  const double square = along.squaredNorm();
  const double t = square > 0.0 ? std::clamp((point - from).dot(along) / square, 0.0, 1.0) : 0.0;
  nearest = from + t * along;
  return (point - nearest).norm();
}

}  // namespace

ConstellationJudge::ConstellationJudge(const std::vector<LayoutMarker>& markers,
                                       const std::vector<MarkerCandidate>& candidates)
    : m_markers(markers), m_candidates(candidates), m_neighbour(markers.size(), -1) {
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
    m_order.push_back(i);
  }
  if (m_extent == 0.0) m_extent = markers.front().size_m;
  std::stable_partition(
      m_order.begin(), m_order.end(), [&](std::size_t i) { return markers[i].fixed; });
}

double ConstellationJudge::rough_sigma() { return kSigmaGuess; }

bool ConstellationJudge::may_be(const LayoutMarker& marker, int candidate) const {
  if (marker.given >= 0) return marker.given == candidate;
  return at(candidate).pattern == marker.pattern;
}

std::vector<ConstellationJudge::DuePlace> ConstellationJudge::due_places(
    const Homography& map) const {
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
double ConstellationJudge::looks(std::size_t marker, int candidate, double px_per_m) const {
  const double due_px = m_markers[marker].size_m * px_per_m;
  const double size = std::log(at(candidate).size_px / due_px) / kSigmaSize;
  const double score = (1.0 - at(candidate).score) / kSigmaScore;
  return size * size + score * score;
}

/// Squared deviation of a candidate from a marker's due place and looks; infinity where it cannot
/// be that marker.
double ConstellationJudge::deviation(std::size_t marker,
                                     int candidate,
                                     const DuePlace& due,
                                     double sigma_place) const {
  const LayoutMarker& m = m_markers[marker];
  if (!may_be(m, candidate)) return kInfinity;
  if (m.given >= 0) return 0.0;
  Eigen::Vector2d nearest;
  const double beside =
      distance_to_segment(at(candidate).placement.position_px, due.rest_px, due.reach_px, nearest);
  const double sigma = due.px_per_m * std::hypot(sigma_place * m_extent, m.loose);
  const double place = beside * beside / (sigma * sigma);
  if (place >= kFarthest) return kInfinity;
  const double sum = place + looks(marker, candidate, due.px_per_m);
  return sum < kFarthest ? sum : kInfinity;
}

std::optional<Constellation> ConstellationJudge::assign_roughly(const Homography& map,
                                                                int least_matched) const {
  const std::vector<DuePlace> due = due_places(map);
  const int most_missing = static_cast<int>(m_markers.size()) - least_matched;
  int missing = 0;
  std::vector<std::tuple<double, std::size_t, int>> pairs;
  for (const std::size_t i : m_order) {
    const std::size_t before = pairs.size();
    for (int c = 0; c < static_cast<int>(m_candidates.size()); ++c) {
      const double cost = deviation(i, c, due[i], kSigmaGuess);
      if (cost < kInfinity) pairs.emplace_back(cost, i, c);
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

Constellation ConstellationJudge::assign(const Homography& map, double slack) const {
  const std::vector<DuePlace> due = due_places(map);
  Eigen::MatrixXd cost(m_markers.size(), m_candidates.size());
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    for (std::size_t c = 0; c < m_candidates.size(); ++c) {
      cost(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) =
          deviation(i, static_cast<int>(c), due[i], slack * kSigmaPlace);
    }
  }
  Constellation result{assign_markers(cost, kMissingCost).place, map, 0.0, 0};
  result.num_matched = static_cast<int>(std::count_if(
      result.candidate.begin(), result.candidate.end(), [](int c) { return c >= 0; }));
  return result;
}

Homography ConstellationJudge::refit(const Constellation& found) const {
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

double ConstellationJudge::cost(const Constellation& found) const {
  const std::vector<DuePlace> due = due_places(found.px_from_plane);
  double sum = 0.0;
  std::array<double, kHowLoose.size()> loose{};
  std::vector<Eigen::Vector2d> moved(m_markers.size(), Eigen::Vector2d::Zero());
  for (std::size_t i = 0; i < m_markers.size(); ++i) {
    const int c = found.candidate[i];
    if (c < 0) {
      sum += kMissingCost;
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

}  // namespace twang::detail
