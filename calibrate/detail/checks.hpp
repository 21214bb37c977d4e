// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibrate/check_rig.hpp"

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

namespace twang::detail {

/// What the single checks share.
struct CheckSubject {
  const Rig& rig;
  const CheckOptions& options;
  const ExpectedMotion& motion;
  const FilmInspection* film;            // may be nullptr
  std::optional<double> fps;             // of the capture, as far as it is known [1/s]
  std::vector<Eigen::Vector2d> rest_m;   // of each marker in the picture's plane
  std::vector<Eigen::Vector2d> swing_m;  // from rest to the release; empty: not known

  /// Largest swing of a marker [m]; 0 if it is not known.
  [[nodiscard]] double largest_swing_m() const;
};

using Findings = std::vector<CheckFinding>;
void add(Findings& findings, const char* subject, CheckVerdict verdict, std::string sentence);

void check_frequency(const CheckSubject& subject, Findings& findings);
void check_swing(const CheckSubject& subject, Findings& findings);
void check_observable(const CheckSubject& subject, Findings& findings);

void check_marker_sizes(const CheckSubject& subject, Findings& findings);
void check_layout(const CheckSubject& subject, Findings& findings);
void check_scale(const CheckSubject& subject, Findings& findings);

void check_clock(const CheckSubject& subject, Findings& findings);
void check_picture(const CheckSubject& subject, Findings& findings);

/// A turn (and reflection) of the layout about its middle that takes every marker to an equal one
/// that is not itself in all cases.
struct LayoutSymmetry {
  double turn_rad = 0.0;  // in (-pi, pi]; of a mirrored layout: about the picture's vertical first
  bool mirrored = false;
};
/// @param slack_m  markers this near count as one place
[[nodiscard]] std::vector<LayoutSymmetry> layout_symmetries(
    const Rig& rig, const std::vector<Eigen::Vector2d>& rest_m, double slack_m);

}  // namespace twang::detail
