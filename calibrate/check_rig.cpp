// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/check_rig.hpp"

#include "calibrate/detail/checks.hpp"
#include "capture/find_layout.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang {

std::string_view to_string(CheckVerdict verdict) {
  switch (verdict) {
    case CheckVerdict::Ok:
      return "ok";
    case CheckVerdict::Warning:
      return "warning";
    case CheckVerdict::Problem:
      break;
  }
  return "problem";
}

void CheckOptions::check() const {
  if (capture_fps && !(std::isfinite(*capture_fps) && *capture_fps > 0.0)) {
    throw InputError(fmt::format("capture_fps is {}, must be > 0", *capture_fps));
  }
  if (exposure_s && !(std::isfinite(*exposure_s) && *exposure_s > 0.0)) {
    throw InputError(fmt::format("exposure_s is {}, must be > 0", *exposure_s));
  }
  if (max_dofs < 1) throw InputError(fmt::format("max_dofs is {}, must be > 0", max_dofs));
}

void detail::add(Findings& findings,
                 const char* subject,
                 CheckVerdict verdict,
                 std::string sentence) {
  findings.push_back({subject, verdict, std::move(sentence)});
}

double detail::CheckSubject::largest_swing_m() const {
  double largest = 0.0;
  for (const Eigen::Vector2d& swing : swing_m) largest = std::max(largest, swing.norm());
  return largest;
}

bool RigCheck::can_be_filmed() const {
  return std::none_of(findings.begin(), findings.end(), [](const CheckFinding& finding) {
    return finding.verdict == CheckVerdict::Problem;
  });
}

RigCheck check_rig(const Rig& rig, const CheckOptions& options, const FilmInspection* film) {
  options.check();
  if (rig.markers.empty() || !rig.camera) {
    throw InputError(fmt::format("{}: has no {}, must have [[marker]] and [camera] to be filmed",
                                 rig.file.empty() ? "rig '" + rig.name + "'" : rig.file.string(),
                                 rig.markers.empty() ? "[[marker]]" : "[camera]"));
  }
  RigCheck result;
  result.motion = expect_motion(as_solids(rig), options);
  detail::CheckSubject subject{rig, options, result.motion, film, options.capture_fps, {}, {}};
  if (!subject.fps) subject.fps = rig.camera->capture_fps;
  if (!subject.fps && film != nullptr) subject.fps = film->time_base.capture_fps;
  for (const Marker& marker : rig.markers) {
    subject.rest_m.push_back(plane_position(*rig.camera, marker.position));
  }
  for (const Eigen::Vector3d& amplitude : result.motion.amplitude_m) {
    subject.swing_m.push_back(plane_position(*rig.camera, amplitude));
  }
  detail::Findings& findings = result.findings;
  detail::check_frequency(subject, findings);
  detail::check_swing(subject, findings);
  detail::check_observable(subject, findings);
  detail::check_marker_sizes(subject, findings);
  detail::check_layout(subject, findings);
  detail::check_scale(subject, findings);
  detail::check_clock(subject, findings);
  if (film != nullptr) detail::check_picture(subject, findings);
  return result;
}

}  // namespace twang
