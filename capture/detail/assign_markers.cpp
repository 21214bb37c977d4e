// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/assign_markers.hpp"

#include "core/constants.hpp"

#include <algorithm>
#include <cstddef>

namespace twang::detail {
namespace {

constexpr double kForbidden = 1e9;  // dearer than any sum of what is allowed

/// Column of each row of a (n x m) matrix, n <= m, with the least sum.
std::vector<int> least_sum(const Eigen::MatrixXd& cost) {
  const int n = static_cast<int>(cost.rows());
  const int m = static_cast<int>(cost.cols());
  const auto size = [](int k) { return static_cast<std::size_t>(k); };
  // Row and column 0 are the start of each augmenting path.
  std::vector<double> row_price(size(n + 1), 0.0), column_price(size(m + 1), 0.0);
  std::vector<int> row_of(size(m + 1), 0), before(size(m + 1), 0);
  for (int i = 1; i <= n; ++i) {
    row_of[0] = i;
    int column = 0;
    std::vector<double> least(size(m + 1), kInfinity);
    std::vector<bool> done(size(m + 1), false);
    do {
      done[size(column)] = true;
      const int row = row_of[size(column)];
      double step = kInfinity;
      int next = 0;
      for (int j = 1; j <= m; ++j) {
        if (done[size(j)]) continue;
        const double reduced = cost(row - 1, j - 1) - row_price[size(row)] - column_price[size(j)];
        if (reduced < least[size(j)]) {
          least[size(j)] = reduced;
          before[size(j)] = column;
        }
        if (least[size(j)] < step) {
          step = least[size(j)];
          next = j;
        }
      }
      for (int j = 0; j <= m; ++j) {
        if (done[size(j)]) {
          row_price[size(row_of[size(j)])] += step;
          column_price[size(j)] -= step;
        } else {
          least[size(j)] -= step;
        }
      }
      column = next;
    } while (row_of[size(column)] != 0);
    while (column != 0) {
      row_of[size(column)] = row_of[size(before[size(column)])];
      column = before[size(column)];
    }
  }
  std::vector<int> column_of(size(n), -1);
  for (int j = 1; j <= m; ++j) {
    if (row_of[size(j)] > 0) column_of[size(row_of[size(j)] - 1)] = j - 1;
  }
  return column_of;
}

}  // namespace

Assignment assign_markers(const Eigen::MatrixXd& cost, double missing) {
  const Eigen::Index n = cost.rows();
  const Eigen::Index m = cost.cols();
  Assignment result;
  if (n == 0) return result;
  // To each marker a place of its own that means none.
  Eigen::MatrixXd padded = Eigen::MatrixXd::Constant(n, m + n, kForbidden);
  padded.leftCols(m) = cost.cwiseMin(kForbidden);
  padded.rightCols(n).diagonal().setConstant(missing);
  for (const int column : least_sum(padded)) {
    const auto row = static_cast<Eigen::Index>(result.place.size());
    result.cost += padded(row, column);
    result.place.push_back(column < m ? column : -1);
  }
  result.margin.assign(result.place.size(), kInfinity);
  return result;
}

Assignment assign_markers_with_margins(const Eigen::MatrixXd& cost, double missing) {
  Assignment best = assign_markers(cost, missing);
  for (std::size_t i = 0; i < best.place.size(); ++i) {
    if (best.place[i] < 0) continue;
    Eigen::MatrixXd without = cost;
    without(static_cast<Eigen::Index>(i), best.place[i]) = kInfinity;
    best.margin[i] = assign_markers(without, missing).cost - best.cost;
  }
  return best;
}

}  // namespace twang::detail
