// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/rolling_shutter.hpp"

#include <cmath>

namespace twang::detail {

RowReading read_by_rows(const std::function<Eigen::Vector2d(double offset_s)>& position_at,
                        double row_s) {
  constexpr int kMostIterations = 30;
  constexpr double kSameRow_px = 1e-7;
  constexpr double kMoment_s = 1e-5;  // half the base of the velocity
  RowReading reading;
  reading.position_px = position_at(0.0);
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    reading.offset_s = row_s * reading.position_px.y();
    const Eigen::Vector2d next = position_at(reading.offset_s);
    const double moved = std::abs(next.y() - reading.position_px.y());
    reading.position_px = next;
    if (moved < kSameRow_px) break;
  }
  reading.velocity_px_s =
      (position_at(reading.offset_s + kMoment_s) - position_at(reading.offset_s - kMoment_s)) /
      (2.0 * kMoment_s);
  return reading;
}

Eigen::Matrix2d moving_from_seen(const RowReading& reading, double row_s) {
  Eigen::Matrix2d map = Eigen::Matrix2d::Identity();
  map.col(1) -= row_s * reading.velocity_px_s;
  return map;
}

}  // namespace twang::detail
