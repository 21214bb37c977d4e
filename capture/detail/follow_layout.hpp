// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/companions.hpp"
#include "capture/detail/follow_marker.hpp"
#include "capture/detail/strangers.hpp"
#include "capture/find_layout.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

namespace twang::detail {

/// Follows all markers of a rig from frame to frame.
///
/// Each marker is looked for where it is expected. That is all as long as every finding is good and
/// can be none but the marker that expected it. Where markers that look alike come so near to each
/// other that a swap would be about as likely, or where a marker is not where it was expected, the
/// places around are searched and the markers in question are assigned to them jointly, by their
/// own motion, by what those that moved with them did, and by their reach. What is not clearly the
/// best assignment is lost rather than guessed, until the markers are apart again. Things that
/// looked like a marker in the first picture and are none stay known as such.
class LayoutFollower {
 public:
  /// @param first  the picture in which the layout was found
  LayoutFollower(const LumaFrame& first, const Rig& rig, PartialLayout layout);

  /// The markers in the next frame, in the rig's order.
  [[nodiscard]] std::vector<MarkerSample> follow(const LumaFrame& frame);
  /// Where they were found in the first one.
  [[nodiscard]] const std::vector<MarkerSample>& first() const { return m_first; }
  /// Outer size of a marker in the picture; the due one as long as it was never seen [px].
  [[nodiscard]] double size_px(std::size_t marker) const { return m_followers[marker].size_px(); }
  [[nodiscard]] bool seen(std::size_t marker) const { return m_followers[marker].seen(); }

 private:
  using Finding = MarkerFollower::Finding;
  /// What is known of one marker in the present frame.
  struct State {
    std::optional<Finding> found;
    std::optional<Forecast> companion;
    std::vector<Eigen::Vector2d> places;  // where it, or something like it, was found
    bool searched = false;
    bool contradicted = false;
    std::string why = "nothing there looks like it";
  };

  [[nodiscard]] bool alike(std::size_t i, std::size_t k) const;
  void look_ahead(const LumaFrame& frame);
  void withdraw_doubtful();
  [[nodiscard]] bool swappable(std::size_t i, std::size_t k) const;
  [[nodiscard]] bool clear(std::size_t i, const Finding& finding) const;
  void note_camera();
  [[nodiscard]] std::vector<Eigen::Vector2d> moved() const;
  void ask_companions(const LumaFrame& frame);
  bool withdraw_contradicted();
  void assign_rest(const LumaFrame& frame, double margin);
  void assign_group(const LumaFrame& frame, const std::vector<std::size_t>& group, double margin);
  void withdraw_covered();
  void withdraw(std::size_t marker, std::string why);

  const Rig& m_rig;
  std::vector<MarkerFollower> m_followers;
  std::vector<MarkerSample> m_first;
  std::vector<Stranger> m_strangers;
  Companions m_companions;
  std::vector<int> m_contradicted;  // frames in a row
  Eigen::Vector2d m_camera_shift = Eigen::Vector2d::Zero();
  int m_width_px;
  int m_height_px;
  std::vector<State> m_states;
};

}  // namespace twang::detail
