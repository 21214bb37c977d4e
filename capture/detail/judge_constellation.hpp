// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/match_constellation.hpp"

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace twang::detail {

/// How well candidates in a picture fit a rig's layout under a map.
class ConstellationJudge {
 public:
  ConstellationJudge(const std::vector<LayoutMarker>& markers,
                     const std::vector<MarkerCandidate>& candidates);

  /// Whether a candidate has the marker's looks, or is the one it was said to be.
  [[nodiscard]] bool may_be(const LayoutMarker& marker, int candidate) const;
  /// Quick assignment under a rough map: the cheapest pair first; none as soon as it is clear that
  /// fewer than `least_matched` markers find a candidate.
  [[nodiscard]] std::optional<Constellation> assign_roughly(const Homography& map,
                                                            int least_matched) const;
  /// The cheapest assignment under a good map, its places `slack` times as uncertain as they end
  /// up.
  [[nodiscard]] Constellation assign(const Homography& map, double slack) const;
  /// The map through the matched markers: fixed ones are where they should be, moving ones about
  /// so.
  [[nodiscard]] Homography refit(const Constellation& found) const;
  /// Of a whole assignment. How far moving markers went is a scale that all share and that is
  /// fitted:
  ///
  ///     min over tau of  sum d² / sigma(tau)² + 4 ln(sigma(tau) / sigma(1))
  ///
  /// beside which stand sizes, scores, and the motion of neighbours against each other.
  [[nodiscard]] double cost(const Constellation& found) const;

  [[nodiscard]] double extent() const { return m_extent; }  ///< of the layout [m]
  /// How uncertain places are under a rough map, in extents.
  [[nodiscard]] static double rough_sigma();

 private:
  struct DuePlace {
    Eigen::Vector2d rest_px;
    Eigen::Vector2d reach_px;
    double px_per_m;
  };
  [[nodiscard]] std::vector<DuePlace> due_places(const Homography& map) const;
  [[nodiscard]] const MarkerCandidate& at(int candidate) const {
    return m_candidates[static_cast<std::size_t>(candidate)];
  }
  [[nodiscard]] double looks(std::size_t marker, int candidate, double px_per_m) const;
  [[nodiscard]] double deviation(std::size_t marker,
                                 int candidate,
                                 const DuePlace& due,
                                 double sigma_place) const;

  const std::vector<LayoutMarker>& m_markers;
  const std::vector<MarkerCandidate>& m_candidates;
  double m_extent = 0.0;
  std::vector<std::size_t> m_order;  // fixed markers first
  std::vector<int> m_neighbour;      // nearest other moving marker alike; -1: none
};

}  // namespace twang::detail
