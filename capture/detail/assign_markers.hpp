// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <vector>

namespace twang::detail {

/// Who stands where.
struct Assignment {
  std::vector<int> place;      ///< one a marker; -1: none
  std::vector<double> margin;  ///< what it would cost more if this marker stood at no place or any
                               ///< other; infinity if it has none to begin with and can have none
  double cost = 0.0;
};

/// The cheapest one-to-one assignment of markers to places: the Hungarian method (shortest
/// augmenting paths).
///
/// @param cost  (markers x places); infinity where a marker cannot stand
/// @param missing  price of a marker without a place
[[nodiscard]] Assignment assign_markers(const Eigen::MatrixXd& cost, double missing);

/// The same, with margins: for each marker that has a place, how much dearer the cheapest
/// assignment is that takes this place from it. O(markers) times the cost of one assignment.
[[nodiscard]] Assignment assign_markers_with_margins(const Eigen::MatrixXd& cost, double missing);

}  // namespace twang::detail
