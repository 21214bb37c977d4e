// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/forecast.hpp"
#include "capture/fit_marker.hpp"
#include "core/constants.hpp"

#include <Eigen/Core>

#include <algorithm>
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

/// What is usual of the markers found in the layout: what is seen for the first time later is held
/// to it.
struct UsualLooks {
  double score = 1.0;
  double size_ratio = 1.0;  ///< of the size found to the size due
  double contrast = 0.0;    ///< [grey levels]; 0: not known
  double blur_px = 0.7;     ///< of the lens [px]
};

/// One marker's looks and motion: where it may be in the next frame and whether what is found there
/// is it. Which of several equal markers stands where is decided by `LayoutFollower`.
///
/// The pattern it is aligned with was fitted once, in the first frame that showed the marker
/// clearly; until then it is known by its kind and by where, how large and how turned the layout
/// says it is.
class MarkerFollower {
 public:
  /// A marker found in the layout.
  MarkerFollower(FittedMarker fitted, const MarkerBackground& background);
  /// One that was not: it would lie so, if at rest.
  MarkerFollower(const MarkerPattern& pattern,
                 const MarkerPlacement& due,
                 const MarkerBackground& background,
                 const UsualLooks& usual);

  /// A place and why it is not the marker's, if it is not.
  struct Finding {
    MarkerAlignment alignment;
    const char* why_not = nullptr;
    [[nodiscard]] bool good() const { return why_not == nullptr; }
    [[nodiscard]] const Eigen::Vector2d& px() const { return alignment.placement.position_px; }
  };

  /// What stands where the marker is expected, or at its last place; without any search.
  [[nodiscard]] Finding look_ahead(const LumaFrame& frame) const;
  /// What stands at a place.
  [[nodiscard]] Finding look_at(const LumaFrame& frame, const Eigen::Vector2d& px) const;
  /// Everything that could be the marker by its looks, wherever it may be: a search.
  /// @param companion  where other markers' motion puts it
  [[nodiscard]] std::vector<Finding> look_around(const LumaFrame& frame,
                                                 const std::optional<Forecast>& companion,
                                                 const char*& why_not) const;

  /// Other places near it, within so many sizes, that correlate with it by `least` or more [px].
  [[nodiscard]] std::vector<Eigen::Vector2d> look_alikes(const LumaFrame& frame,
                                                         double sizes,
                                                         double least) const;

  /// Minus twice the log of the probability density of finding it at a place, per square of its
  /// size: a mixture of what its own motion, its companions' motion and its reach say; infinity
  /// where it cannot be.
  [[nodiscard]] double cost(const Eigen::Vector2d& px,
                            const std::optional<Forecast>& companion) const;

  void accept(const LumaFrame& frame, Finding finding);
  void lose() { m_forecast.lost(); }
  /// Something that looks like it and is no marker of the rig stood so far away: beyond its reach
  /// it is not looked for farther than half of that [px].
  void keep_off(double distance_px) { m_half_way_px = std::min(m_half_way_px, 0.5 * distance_px); }
  /// The camera has moved: rest is displaced by that much [px].
  void shift_rest(const Eigen::Vector2d& shift_px) { m_shift = shift_px; }

  [[nodiscard]] bool seen() const { return m_seen; }  ///< ever
  [[nodiscard]] int frames_lost() const { return m_forecast.frames_lost(); }
  [[nodiscard]] double size_px() const { return m_size_px; }
  [[nodiscard]] const Forecast& forecast() const { return m_forecast.next(); }
  [[nodiscard]] Eigen::Vector2d rest_px() const { return m_background.rest_px + m_shift; }
  [[nodiscard]] const MarkerPattern& pattern() const { return m_marker.pattern(); }
  /// Whether a place is within what it has shown, and a little more.
  [[nodiscard]] bool within_reach(const Eigen::Vector2d& px) const;

 private:
  [[nodiscard]] MarkerAlignment align_at(const LumaFrame& frame, const Eigen::Vector2d& at) const;
  [[nodiscard]] const char* doubt(const MarkerAlignment& found) const;
  [[nodiscard]] Finding first_look(const LumaFrame& frame, const Eigen::Vector2d& at) const;
  [[nodiscard]] double reach_px() const;
  [[nodiscard]] double gate_px() const;
  [[nodiscard]] bool allowed(const Eigen::Vector2d& px,
                             const std::optional<Forecast>& companion) const;
  void look_better(const LumaFrame& frame, const MarkerAlignment& found);

  MarkerTemplate m_marker;
  Eigen::Matrix2d m_px_from_pattern;
  MarkerBackground m_background;
  Eigen::Vector2d m_shift = Eigen::Vector2d::Zero();
  UsualLooks m_usual;
  bool m_seen;
  double m_size_px;
  double m_half_way_px = kInfinity;  // to the nearest stranger that looks alike
  double m_typical_score;
  double m_typical_contrast;
  Eigen::Vector4d m_light = Eigen::Vector4d::Zero();  // of the last alignment
  double m_blur_ratio = 0.5;  // length of the motion blur over the motion from frame to frame
  int m_num_blurs = 0;        // fits behind that
  int m_better_looks = 0;     // frames in which the pattern may still be fitted better
  MotionForecast m_forecast;
};

}  // namespace twang::detail
