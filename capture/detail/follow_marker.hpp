// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/fit_marker.hpp"

#include <Eigen/Core>

#include <array>
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace twang::detail {

/// Where a marker is in one frame.
struct MarkerSample {
  Eigen::Vector2d position_px;  ///< nan where lost [px]
  double sigma_px = 0.0;        ///< of one coordinate; nan where lost [px]
  std::string lost_because;     ///< empty where found
};

/// What else is known of a marker before it is followed.
struct MarkerBackground {
  Eigen::Vector2d rest_px = Eigen::Vector2d::Zero();  ///< where the layout puts it at rest [px]
  double reach_px = 0.0;  ///< how far from there it is known to come; grows with what is seen [px]
};

/// Follows one marker from frame to frame.
///
/// Its place is predicted by constant velocity or as a free vibration about rest, whichever has
/// done better of late, and found by alignment. Where that fails it is sought by correlation,
/// within the reach it has shown about its rest, and beyond within a gate about its last place, no
/// wider than half way to the nearest thing that looks alike. A place counts only if score,
/// contrast and turn are the marker's own; if several places look alike and none is where the
/// prediction is, it is lost rather than guessed.
class MarkerFollower {
 public:
  MarkerFollower(const LumaFrame& first, FittedMarker fitted, MarkerBackground background);

  /// The marker in the next frame.
  /// @param taken  places of other markers in this frame: not to be taken again [px]
  [[nodiscard]] MarkerSample follow(const LumaFrame& frame,
                                    const std::vector<Eigen::Vector2d>& taken);

 private:
  struct Verdict {
    bool good = false;
    const char* why = "";
  };
  [[nodiscard]] Eigen::Vector2d predict();
  [[nodiscard]] MarkerAlignment align_at(const LumaFrame& frame, const Eigen::Vector2d& at) const;
  [[nodiscard]] Verdict judge(const MarkerAlignment& found,
                              const std::vector<Eigen::Vector2d>& taken) const;
  [[nodiscard]] std::optional<MarkerAlignment> search(const LumaFrame& frame,
                                                      const std::vector<Eigen::Vector2d>& taken,
                                                      std::string& why) const;
  [[nodiscard]] double gate_px() const;
  [[nodiscard]] bool within_reach(const Eigen::Vector2d& px) const;
  [[nodiscard]] bool allowed(const Eigen::Vector2d& px) const;
  void accept(const MarkerAlignment& found);

  MarkerTemplate m_marker;
  Eigen::Matrix2d m_px_from_pattern;
  MarkerBackground m_background;
  double m_size_px;
  double m_half_way_px;  // to the nearest thing that looks alike
  double m_typical_score;
  double m_typical_contrast;
  double m_blur_ratio = 0.5;  // length of the motion blur over the motion from frame to frame
  int m_num_blurs = 0;        // fits behind that
  int m_frames_lost = 0;      // since the last time it was found
  Eigen::Vector2d m_predicted;
  std::array<Eigen::Vector2d, 2> m_forecasts;        // by velocity, as a vibration
  std::array<double, 2> m_forecast_error{0.0, 0.0};  // running means [px]
  std::deque<Eigen::Vector2d> m_recent;              // consecutive positions, the last one last
};

}  // namespace twang::detail
