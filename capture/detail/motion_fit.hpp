// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/camera_motion.hpp"
#include "capture/plane_fit.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

namespace twang::detail {

/// One way the camera may have moved, fitted to the whole film.
class MotionFit {
 public:
  MotionFit(const std::vector<FixedMarker>& markers, std::optional<MapKind> kind);

  double cost = 0.0;            // sum of squares in sigmas, each no worse than a bump's
  double parameters = 0.0;      // spent on the frames
  double freedom = 0.0;         // left
  double rms_px = 0.0;          // of a coordinate, what was left out apart
  double share_left_out = 0.0;  // of the sightings

  [[nodiscard]] double reduced() const { return freedom > 0.0 ? m_inlier_cost / freedom : 0.0; }
  [[nodiscard]] const std::vector<Eigen::Vector2d>& mean_px() const { return m_mean; }
  [[nodiscard]] bool leaves_out(std::size_t i) const {
    return std::find(m_left_out[i].begin(), m_left_out[i].end(), true) != m_left_out[i].end();
  }
  [[nodiscard]] CameraMotion result() &&;
  /// Reduced chi-square of a marker about its own mean.
  [[nodiscard]] double own_chi_square(std::size_t i) const;

 private:
  /// The markers seen in a frame.
  struct Seen {
    std::vector<std::size_t> which;
    PointPairs pairs;  // picture to mean picture
  };

  [[nodiscard]] double sigma(std::size_t i, std::size_t n) const {
    return (*m_markers[i].sigma_px)[n];
  }
  /// Off by more than this the marker has moved by itself [px].
  [[nodiscard]] double bump_px(std::size_t i, std::size_t n) const;
  [[nodiscard]] Seen seen(std::size_t n) const;
  /// Means from the first frame that shows most markers; others where they first appear.
  void begin();
  /// The kind of map that so many markers allow.
  [[nodiscard]] MapKind kind_for(std::size_t count) const;
  /// The freest map that the points determine.
  [[nodiscard]] MapFit fit_allowed(const PointPairs& pairs) const;
  /// Truncated cost of a map in a frame, with a touch of belief that the camera is held straight.
  [[nodiscard]] double cost_of(const Homography& map, const Seen& seen, std::size_t n) const;
  /// Those of a frame's markers that a map explains.
  [[nodiscard]] Seen explained(const Homography& map, const Seen& all, std::size_t n) const;
  /// The map of a frame that explains its markers, or if there is none most of them.
  [[nodiscard]] MapFit fit_frame(std::size_t n) const;
  /// A frame that shows one marker only is turned and stretched as the frame before, or after it.
  void borrow_turns();
  void fit_frames();
  /// Each marker's mean over the frames it is not left out of; at first where it first stood.
  void average(bool first);
  void judge();

  const std::vector<FixedMarker>& m_markers;
  std::optional<MapKind> m_kind;
  std::size_t m_num_frames;
  std::vector<Eigen::Vector2d> m_mean;
  std::vector<std::vector<bool>> m_left_out;
  std::vector<MapFit> m_fits;
  double m_inlier_cost = 0.0;
};

/// rms of a coordinate of the fixed markers about their means, whatever moved [px].
[[nodiscard]] double scatter_of(const std::vector<FixedMarker>& markers);

}  // namespace twang::detail
