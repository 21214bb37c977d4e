// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <functional>

namespace twang::detail {

/// A moving point as a sensor that is read row by row sees it.
struct RowReading {
  double offset_s = 0.0;                                    ///< after the first row [s]
  Eigen::Vector2d position_px = Eigen::Vector2d::Zero();    ///< there [px]
  Eigen::Vector2d velocity_px_s = Eigen::Vector2d::Zero();  ///< there [px/s]
};

/// Where and when a point crosses the row that is being read:
///
///     offset = (time a row) y(offset)
///
/// @param position_at  the point so long after the first row [px]
/// @param row_s        from one row to the next, so short that the point is slower than the reading
///                     [s]
[[nodiscard]] RowReading read_by_rows(
    const std::function<Eigen::Vector2d(double offset_s)>& position_at, double row_s);

/// How what is near the point is drawn out: an offset in the picture is so much of an offset on
/// what moves with `velocity_px_s`, to first order of the time across it.
///
///     (moving - point) = (I - row_s v e_yᵀ) (seen - point)
[[nodiscard]] Eigen::Matrix2d moving_from_seen(const RowReading& reading, double row_s);

}  // namespace twang::detail
