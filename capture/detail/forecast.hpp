// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <array>
#include <deque>

namespace twang::detail {

/// Where something is expected, one standard deviation of one coordinate.
struct Forecast {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  double sigma_px = 0.0;
};

/// Forecasts a marker's next place from its recent ones.
///
/// Three ways are tried side by side and the one that has done best of late is believed:
///
///     constant velocity                     y(n+1) = 2 y(n) − y(n−1)
///     free vibration about rest             y(n+1) = κ y(n) − y(n−1)
///     damped vibration about any middle     y(n+1) = a y(n) − b y(n−1) + c
///
/// y from rest; κ, and a, b, c, from the recent places by least squares, held where these say
/// nothing. While the marker is lost the same recurrence runs on without it and the uncertainty
/// grows.
class MotionForecast {
 public:
  /// @param scale_px  a length to which errors are compared: the marker's size [px]
  MotionForecast(const Eigen::Vector2d& rest_px, const Eigen::Vector2d& first_px, double scale_px);

  /// Where the marker is expected in the next frame; the same until `found` or `lost` is called.
  [[nodiscard]] const Forecast& next() const { return m_next; }
  void found(const Eigen::Vector2d& px);
  void lost();

  [[nodiscard]] int frames_lost() const { return m_frames_lost; }
  /// The last place: found, or while lost expected.
  [[nodiscard]] const Eigen::Vector2d& last_px() const { return m_recent.back().px; }
  [[nodiscard]] const Eigen::Vector2d& rest_px() const { return m_rest; }

 private:
  struct Place {
    Eigen::Vector2d px;
    bool seen;
  };
  void predict();
  [[nodiscard]] Eigen::Vector2d by_velocity() const;
  void fit_vibration();
  void fit_damped_vibration();

  Eigen::Vector2d m_rest;
  double m_scale_px;
  std::deque<Place> m_recent;  // one a frame, the last one last
  int m_frames_lost = 0;
  int m_num_triples = 0;  // of places behind the fits
  double m_kappa = 2.0;
  Eigen::Vector4d m_damped;                    // a, b, c
  std::array<Eigen::Vector2d, 3> m_forecasts;  // each way
  std::array<double, 3> m_error;               // of each, running means [px]
  std::size_t m_best = 0;
  Forecast m_next;
};

}  // namespace twang::detail
