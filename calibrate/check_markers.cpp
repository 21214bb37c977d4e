// SPDX-License-Identifier: GPL-3.0-or-later
// What the markers allow: size in the picture, telling them apart, scale and perspective.
#include "calibrate/detail/checks.hpp"
#include "core/constants.hpp"
#include "core/dense_algebra.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace twang::detail {
namespace {

constexpr double kWanted_px = 20.0;
constexpr double kLeast_px = 8.0;
constexpr double kFilled = 0.9;       // of the picture by layout and swing
constexpr double kPaper = 1.5;        // paper over ink
constexpr double kMostTurn = 30.0;    // degrees that the search for the layout allows
constexpr double kThinSpread = 0.15;  // of the fixed markers' narrow over their wide extent

CheckVerdict verdict_of_size(double size_px) {
  if (size_px < kLeast_px) return CheckVerdict::Problem;
  return size_px < kWanted_px ? CheckVerdict::Warning : CheckVerdict::Ok;
}

/// Box around the markers' paper and their swing [m].
Eigen::AlignedBox2d extent(const CheckSubject& subject) {
  Eigen::AlignedBox2d box;
  for (std::size_t i = 0; i < subject.rest_m.size(); ++i) {
    Eigen::Vector2d reach = Eigen::Vector2d::Constant(0.5 * kPaper * subject.rig.markers[i].size_m);
    if (!subject.swing_m.empty()) reach += subject.swing_m[i].cwiseAbs();
    box.extend(subject.rest_m[i] - reach);
    box.extend(subject.rest_m[i] + reach);
  }
  return box;
}

bool is_round(const Marker& marker) {
  return marker.kind == MarkerKind::Dot || marker.kind == MarkerKind::Ring;
}

/// Whether nothing but their places tells two markers apart.
bool look_alike(const Marker& a, const Marker& b) {
  constexpr double kSameSize = 0.2;
  return a.kind == b.kind && a.kind != MarkerKind::Patch && a.dictionary == b.dictionary &&
         a.tag == b.tag && std::abs(a.size_m / b.size_m - 1.0) < kSameSize;
}

/// Distance between two markers' outlines; negative where their ink overlaps [m].
double clearance(const Marker& a, const Marker& b, const Eigen::Vector2d& apart) {
  const double distance = is_round(a) && is_round(b) ? apart.norm() : apart.cwiseAbs().maxCoeff();
  return distance - 0.5 * (a.size_m + b.size_m);
}

/// @return whether something was found
bool check_overlaps(const CheckSubject& subject, Findings& findings) {
  const auto& markers = subject.rig.markers;
  for (std::size_t i = 0; i < markers.size(); ++i) {
    for (std::size_t j = i + 1; j < markers.size(); ++j) {
      const Eigen::Vector2d apart = subject.rest_m[j] - subject.rest_m[i];
      const double free_m = clearance(markers[i], markers[j], apart);
      double swinging_m = free_m;
      if (!subject.swing_m.empty()) {
        const Eigen::Vector2d swing = subject.swing_m[j] - subject.swing_m[i];
        swinging_m = std::min(clearance(markers[i], markers[j], apart + swing),
                              clearance(markers[i], markers[j], apart - swing));
      }
      const double margins =
          free_m - 0.25 * (markers[i].size_m + markers[j].size_m);  // a quarter of each
      if (free_m >= 0.0 && swinging_m >= 0.0 && margins >= 0.0) continue;
      add(findings,
          "layout",
          free_m < 0.0 ? CheckVerdict::Problem : CheckVerdict::Warning,
          fmt::format("'{}' and '{}' {}",
                      markers[i].id,
                      markers[j].id,
                      free_m < 0.0       ? "overlap in the picture."
                      : swinging_m < 0.0 ? "cover each other while they swing."
                                         : "stand so close that their white margins overlap: leave "
                                           "a quarter of the size white around each."));
      return true;
    }
  }
  return false;
}

bool check_symmetry(const CheckSubject& subject, Findings& findings) {
  double slack = kInfinity;
  for (const Marker& marker : subject.rig.markers) slack = std::min(slack, 0.5 * marker.size_m);
  for (const LayoutSymmetry& same : layout_symmetries(subject.rig, subject.rest_m, slack)) {
    const double turn_deg = std::abs(same.turn_rad) / kRadiansPerDegree;
    if (!same.mirrored && turn_deg <= kMostTurn) {
      add(findings,
          "layout",
          CheckVerdict::Problem,
          fmt::format("Turned by {:.0f} degrees the layout looks the same: equal markers cannot be "
                      "told apart, move one or give one another kind or size.",
                      turn_deg));
      return true;
    }
    add(findings,
        "layout",
        CheckVerdict::Warning,
        same.mirrored
            ? std::string("In a mirror the layout looks the same: a wrong sign of image_right or "
                          "image_down would go unnoticed; move one fixed marker.")
            : fmt::format(
                  "Turned by {:.0f} degrees the layout looks the same: a film that stands so "
                  "would be tracked with ids exchanged; move one marker.",
                  turn_deg));
    return true;
  }
  return false;
}

/// Fixed markers' offsets from their mean, as singular values: wide and narrow extent [m].
Eigen::Vector2d spread_of(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Matrix2Xd offsets(2, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    offsets.col(static_cast<Eigen::Index>(i)) = points[i];
  }
  offsets.colwise() -= Eigen::Vector2d(offsets.rowwise().mean());
  const Eigen::Matrix2d moments = offsets.lazyProduct(offsets.transpose());
  return symmetric_eigen(moments).values.reverse().cwiseMax(0.0).cwiseSqrt();
}

/// How far along the line of sight the moving markers stand from the fixed ones' mean plane [m].
double depth_difference(const Rig& rig) {
  const Eigen::Vector3d sight = rig.camera->image_right.cross(rig.camera->image_down);
  double fixed = 0.0;
  int num_fixed = 0;
  for (const Marker& marker : rig.markers) {
    if (!marker.fixed) continue;
    fixed += sight.dot(marker.position);
    ++num_fixed;
  }
  double farthest = 0.0;
  for (const Marker& marker : rig.markers) {
    if (marker.fixed || num_fixed == 0) continue;
    farthest = std::max(farthest, std::abs(sight.dot(marker.position) - fixed / num_fixed));
  }
  return farthest;
}

}  // namespace

void check_marker_sizes(const CheckSubject& subject, Findings& findings) {
  const auto& markers = subject.rig.markers;
  if (subject.film != nullptr) {
    if (subject.film->markers.empty()) {
      add(findings, "markers", CheckVerdict::Problem, subject.film->not_found + ".");
      return;
    }
    const auto least = std::min_element(
        subject.film->markers.begin(),
        subject.film->markers.end(),
        [](const InspectedMarker& a, const InspectedMarker& b) { return a.size_px < b.size_px; });
    add(findings,
        "markers",
        std::max(verdict_of_size(least->size_px),
                 subject.film->hidden.empty() ? CheckVerdict::Ok : CheckVerdict::Warning),
        fmt::format("{} of {} are found in frame {}{}; the smallest, '{}', is {:.0f} px wide{}",
                    subject.film->markers.size(),
                    markers.size(),
                    subject.film->frame,
                    subject.film->hidden.empty()
                        ? std::string()
                        : fmt::format(", '{}' is not", subject.film->hidden.front()),
                    least->id,
                    least->size_px,
                    least->size_px < kWanted_px
                        ? fmt::format(", {:g} or more are wanted.", kWanted_px)
                        : "."));
    return;
  }
  const Eigen::Vector2d size = extent(subject).sizes();
  const auto least =
      std::min_element(markers.begin(), markers.end(), [](const auto& a, const auto& b) {
        return a.size_m < b.size_m;
      });
  const auto in_picture = [&](double width, double height) {
    return kFilled * std::min(width / size.x(), height / size.y()) * least->size_m;
  };
  const double hd = in_picture(1280.0, 720.0);
  const double full_hd = in_picture(1920.0, 1080.0);
  const CheckVerdict verdict = hd >= kWanted_px
                                   ? CheckVerdict::Ok
                                   : std::max(CheckVerdict::Warning, verdict_of_size(full_hd));
  add(findings,
      "markers",
      verdict,
      fmt::format(
          "With the layout filling the picture, the smallest marker, '{}', is {:.0f} px wide "
          "in 1280 x 720 and {:.0f} in 1920 x 1080{}",
          least->id,
          hd,
          full_hd,
          hd < kWanted_px ? fmt::format("; {:g} or more are wanted.", kWanted_px) : "."));
}

void check_layout(const CheckSubject& subject, Findings& findings) {
  const bool overlapping = check_overlaps(subject, findings);
  const bool symmetric = check_symmetry(subject, findings);
  if (overlapping || symmetric) return;
  add(findings,
      "layout",
      CheckVerdict::Ok,
      "No two markers overlap, and no turn or mirror image of the layout looks like it.");
}

void check_scale(const CheckSubject& subject, Findings& findings) {
  std::vector<Eigen::Vector2d> fixed;
  for (std::size_t i = 0; i < subject.rest_m.size(); ++i) {
    if (subject.rig.markers[i].fixed) fixed.push_back(subject.rest_m[i]);
  }
  const std::string unsteady = "a camera that moves is taken for motion of the part";
  if (fixed.size() < 2) {
    add(findings,
        "scale",
        CheckVerdict::Warning,
        fmt::format("{}: scale comes from {}, a tilted camera is not corrected{}.",
                    fixed.empty() ? "No marker is fixed" : "One marker is fixed",
                    subject.rig.markers.size() > 1
                        ? "where the markers settle at the end of the film"
                        : "the marker's size alone",
                    fixed.empty() ? " and " + unsteady : ""));
    return;
  }
  const Eigen::Vector2d spread = spread_of(fixed);
  const double depth_m = depth_difference(subject.rig);
  const double width_m = extent(subject).sizes().maxCoeff();
  if (fixed.size() < 4) {
    add(findings,
        "scale",
        CheckVerdict::Warning,
        fmt::format(
            "{} fixed markers give scale and take out the camera's shake, but not its tilt: "
            "four or more do.",
            fixed.size()));
  } else if (spread[1] < kThinSpread * spread[0]) {
    add(findings,
        "scale",
        CheckVerdict::Warning,
        fmt::format("The {} fixed markers stand nearly on a line, so a tilted camera is hardly "
                    "corrected: spread them around the part.",
                    fixed.size()));
  } else {
    add(findings,
        "scale",
        CheckVerdict::Ok,
        fmt::format("{} fixed markers, well spread, give scale and perspective and take out the "
                    "camera's shake.",
                    fixed.size()));
  }
  constexpr double kDepth = 0.02;  // of the layout's width: half a per cent of scale from afar
  if (depth_m > kDepth * width_m) {
    add(findings,
        "depth",
        CheckVerdict::Warning,
        fmt::format(
            "Moving markers stand {} before or behind the fixed ones: amplitudes are wrong by "
            "that over the camera's distance; film from afar or move the fixed ones.",
            rounded_text(depth_m * kMillimetresPerMetre, 2) + " mm"));
  }
}

std::vector<LayoutSymmetry> layout_symmetries(const Rig& rig,
                                              const std::vector<Eigen::Vector2d>& rest_m,
                                              double slack_m) {
  std::vector<LayoutSymmetry> found;
  if (rest_m.size() < 2) return found;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& at : rest_m) centre += at / static_cast<double>(rest_m.size());
  const auto from_centre = [&](std::size_t i) { return Eigen::Vector2d(rest_m[i] - centre); };
  std::size_t outer = 0;
  for (std::size_t i = 1; i < rest_m.size(); ++i) {
    if (from_centre(i).norm() > from_centre(outer).norm()) outer = i;
  }
  const auto maps_onto_itself = [&](const Eigen::Matrix2d& turn) {
    bool moved = false;
    for (std::size_t i = 0; i < rest_m.size(); ++i) {
      std::size_t nearest = 0;
      const Eigen::Vector2d there = turn * from_centre(i);
      for (std::size_t j = 1; j < rest_m.size(); ++j) {
        if ((from_centre(j) - there).norm() < (from_centre(nearest) - there).norm()) nearest = j;
      }
      if ((from_centre(nearest) - there).norm() > slack_m) return false;
      if (!look_alike(rig.markers[i], rig.markers[nearest])) return false;
      moved = moved || nearest != i;
    }
    return moved;
  };
  for (const bool mirrored : {false, true}) {
    const Eigen::Vector2d start =
        mirrored ? Eigen::Vector2d(-from_centre(outer).x(), from_centre(outer).y())
                 : from_centre(outer);
    for (std::size_t j = 0; j < rest_m.size(); ++j) {
      if (std::abs(from_centre(j).norm() - start.norm()) > slack_m) continue;
      const double angle =
          std::atan2(start.x() * from_centre(j).y() - start.y() * from_centre(j).x(),
                     start.dot(from_centre(j)));
      Eigen::Matrix2d turn = Eigen::Rotation2Dd(angle).toRotationMatrix();
      if (mirrored) turn *= Eigen::Vector2d(-1.0, 1.0).asDiagonal();
      if (maps_onto_itself(turn)) found.push_back({angle, mirrored});
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return a.mirrored != b.mirrored ? !a.mirrored : std::abs(a.turn_rad) < std::abs(b.turn_rad);
  });
  return found;
}

}  // namespace twang::detail
