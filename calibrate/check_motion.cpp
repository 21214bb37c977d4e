// SPDX-License-Identifier: GPL-3.0-or-later
// What is expected of the motion: frequency against frame rate, swing, blur, the observable.
#include "calibrate/detail/checks.hpp"
#include "core/constants.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang::detail {
namespace {

constexpr double kComfortable = 1.0 / 3.0;  // of the frame rate: three samples a period
constexpr double kAliasPart = 0.4;          // above, inversion flags a mode as a possible alias
constexpr double kNyquist = 0.5;
constexpr double kManySamples = 8.0;  // a period
constexpr double kAliasWidth = 0.05;  // of the first frequency: a predicted one is no better
constexpr double kBlurOfMarker = 0.25;
constexpr double kAveraged = 3.0;  // of the frame rate: faster motion an exposure averages out
constexpr double kUnseen = 0.02;   // part of the mode's motion that the observable shows
constexpr double kOutOfPlane = 0.1;

std::string gigapascals(double pa) {
  return pa >= 1e9 ? rounded_text(pa * 1e-9, 3) + " GPa" : rounded_text(pa * 1e-6, 3) + " MPa";
}

std::string millimetres(double metres) {
  return rounded_text(metres * kMillimetresPerMetre, 2) + " mm";
}

/// Of a part whose modulus nobody states: which moduli suit the frame rate.
void check_range_of_moduli(const CheckSubject& subject, Findings& findings) {
  const double unit_hz = subject.motion.frequency_hz.front();
  if (!subject.fps) return;
  const auto modulus_for = [&](double hz) { return std::pow(hz / unit_hz, 2); };
  add(findings,
      "frequency",
      CheckVerdict::Warning,
      fmt::format("The rig states no modulus: at {:g} frames/s the first frequency stays below 0.4 "
                  "of the frame rate for E below {}, with {} samples a period below {}; give "
                  "reported_youngs_modulus_pa to have it checked.",
                  *subject.fps,
                  gigapascals(modulus_for(kAliasPart * *subject.fps)),
                  kManySamples,
                  gigapascals(modulus_for(*subject.fps / kManySamples))));
}

void check_known_frequency(const CheckSubject& subject, Findings& findings) {
  const double hz = subject.motion.frequency_hz.front();
  const std::string expected = fmt::format("The first frequency is expected {} {} Hz (E {})",
                                           subject.motion.thin_parts_missed ? "below" : "at",
                                           rounded_text(hz, 3),
                                           gigapascals(subject.motion.modulus_pa));
  if (!subject.fps) {
    add(findings,
        "frequency",
        CheckVerdict::Warning,
        fmt::format(
            "{}: film at {:.0f} frames/s or more.", expected, std::ceil(hz / kComfortable)));
    return;
  }
  const double part = hz / *subject.fps;
  const std::string samples = fmt::format("{}, {} samples a period at {:g} frames/s",
                                          expected,
                                          rounded_text(1.0 / part, 3),
                                          *subject.fps);
  if (part <= kComfortable) {
    add(findings, "frequency", CheckVerdict::Ok, samples + ".");
    return;
  }
  const bool hopeless = part >= kNyquist;
  add(findings,
      "frequency",
      hopeless ? CheckVerdict::Problem : CheckVerdict::Warning,
      fmt::format("{}: {}; film at {:.0f} frames/s or more, or lengthen or thin the part.",
                  samples,
                  hopeless            ? "it cannot be told from its alias"
                  : part > kAliasPart ? "close to half the frame rate, an alias is not excluded"
                                      : "more than a third of the frame rate",
                  std::ceil(hz / kComfortable)));
}

/// Higher modes whose alias falls on the first.
void check_aliases(const CheckSubject& subject, Findings& findings) {
  const double first = subject.motion.frequency_hz.front();
  const double fps = *subject.fps;
  if (first >= kNyquist * fps) return;
  for (std::size_t k = 1; k < subject.motion.frequency_hz.size(); ++k) {
    const double hz = subject.motion.frequency_hz[k];
    const auto& share = subject.motion.observable_share;
    if (hz <= kNyquist * fps || hz > kAveraged * fps) continue;
    if (k < share.size() && share[k] < kUnseen) continue;
    const double folded = std::abs(hz - fps * std::round(hz / fps));
    if (std::abs(folded - first) > kAliasWidth * first) continue;
    add(findings,
        "alias",
        CheckVerdict::Warning,
        fmt::format("Mode {} at {} Hz looks like {} Hz at {:g} frames/s, near the first: another "
                    "frame rate would keep them apart.",
                    k + 1,
                    rounded_text(hz, 3),
                    rounded_text(folded, 3),
                    fps));
    return;
  }
  add(findings,
      "alias",
      CheckVerdict::Ok,
      "No higher mode that the film would show folds onto the first frequency.");
}

/// Where the film shows a marker: whether its swing keeps it in the picture.
void check_swing_in_picture(const CheckSubject& subject, Findings& findings) {
  for (const InspectedMarker& marker : subject.film->markers) {
    std::size_t i = 0;
    while (subject.rig.markers[i].id != marker.id) ++i;
    const Eigen::Vector2d swing_px = subject.film->px_per_m * subject.swing_m[i].cwiseAbs();
    const double half = 0.5 * marker.size_px;
    const Eigen::Vector2d low = marker.position_px - swing_px - Eigen::Vector2d::Constant(half);
    const Eigen::Vector2d high = marker.position_px + swing_px + Eigen::Vector2d::Constant(half);
    const bool inside = low.minCoeff() >= 0.0 && high.x() <= subject.film->width_px - 1 &&
                        high.y() <= subject.film->height_px - 1;
    if (inside) continue;
    add(findings,
        "swing",
        CheckVerdict::Problem,
        fmt::format("'{}' may leave the picture: it swings by {:.0f} px about ({:.0f}, {:.0f}).",
                    marker.id,
                    swing_px.norm(),
                    marker.position_px.x(),
                    marker.position_px.y()));
    return;
  }
}

void check_blur(const CheckSubject& subject, Findings& findings) {
  if (!subject.motion.modulus_known || !subject.fps) return;
  const double hz = subject.motion.frequency_hz.front();
  std::size_t worst = 0;
  double most = 0.0;
  for (std::size_t i = 0; i < subject.swing_m.size(); ++i) {
    const double part = subject.swing_m[i].norm() / subject.rig.markers[i].size_m;
    if (part > most) {
      most = part;
      worst = i;
    }
  }
  if (!(most > 0.0)) return;
  const Marker& marker = subject.rig.markers[worst];
  const double speed_m_s = kTwoPi * hz * subject.swing_m[worst].norm();
  const double exposure_s = subject.options.exposure_s.value_or(1.0 / *subject.fps);
  const double blur_m = std::min(speed_m_s * exposure_s, 2.0 * subject.swing_m[worst].norm());
  const double longest_s = kBlurOfMarker * marker.size_m / speed_m_s;
  const bool sharp = blur_m <= kBlurOfMarker * marker.size_m;
  add(findings,
      "blur",
      sharp ? CheckVerdict::Ok : CheckVerdict::Warning,
      fmt::format(
          "'{}' moves by up to {} during an exposure of 1/{:.0f} s, {:.0f} % of its size{}",
          marker.id,
          millimetres(blur_m),
          1.0 / exposure_s,
          100.0 * blur_m / marker.size_m,
          sharp ? "."
                : fmt::format("; expose for 1/{:.0f} s or less.", std::ceil(1.0 / longest_s))));
}

}  // namespace

void check_frequency(const CheckSubject& subject, Findings& findings) {
  const ExpectedMotion& motion = subject.motion;
  if (motion.frequency_hz.empty()) {
    add(findings,
        "frequency",
        CheckVerdict::Warning,
        (motion.unknown_because.empty() ? "The first frequency is not known"
                                        : motion.unknown_because) +
            ".");
    return;
  }
  if (subject.rig.clamps.empty()) {
    add(findings,
        "clamp",
        CheckVerdict::Warning,
        "The rig has no [[clamp]]: the frequencies are those of the free part.");
  }
  if (!motion.modulus_known) {
    check_range_of_moduli(subject, findings);
    return;
  }
  check_known_frequency(subject, findings);
  if (subject.fps) check_aliases(subject, findings);
}

void check_swing(const CheckSubject& subject, Findings& findings) {
  if (subject.swing_m.empty()) {
    add(findings,
        "swing",
        CheckVerdict::Warning,
        subject.rig.release
            ? "The swing is not predicted."
            : "The rig has no [release], so swing and motion blur are not predicted.");
    return;
  }
  const std::size_t before = findings.size();
  if (subject.film != nullptr && !subject.film->markers.empty()) {
    check_swing_in_picture(subject, findings);
  }
  if (findings.size() == before) {
    add(findings,
        "swing",
        CheckVerdict::Ok,
        fmt::format("Markers swing by up to {} either way.",
                    millimetres(subject.largest_swing_m())));
  }
  check_blur(subject, findings);
}

void check_observable(const CheckSubject& subject, Findings& findings) {
  const Rig& rig = subject.rig;
  if (!rig.observable) {
    add(findings,
        "observable",
        CheckVerdict::Warning,
        "The rig has no [observable]: films of it can be tracked but not calibrated.");
    return;
  }
  const ObservableDefinition& definition = *rig.observable;
  if (definition.kind == ObservableKind::Displacement) {
    const Eigen::Vector3d normal = rig.camera->image_right.cross(rig.camera->image_down);
    const double hidden = std::abs(normal.dot(definition.direction.normalized()));
    if (hidden > kOutOfPlane) {
      const bool blind = hidden > 1.0 - kUnseen;
      add(findings,
          "observable",
          blind ? CheckVerdict::Problem : CheckVerdict::Warning,
          blind ? "The observable's direction points at the camera, which does not see motion "
                  "along it."
                : fmt::format("The observable's direction leaves the picture's plane by {:.0f} "
                              "degrees: that part of the motion is not seen.",
                              std::asin(std::min(1.0, hidden)) / kRadiansPerDegree));
      return;
    }
  }
  const auto& share = subject.motion.observable_share;
  if (!share.empty() && share.front() < kUnseen) {
    add(findings,
        "observable",
        CheckVerdict::Problem,
        "The first mode does not move the observable: choose another marker or direction.");
    return;
  }
  add(findings,
      "observable",
      CheckVerdict::Ok,
      !share.empty()
          ? fmt::format("The observable shows {:.0f} % of its markers' motion in the first mode.",
                        100.0 * share.front())
          : "The observable lies in the picture's plane.");
}

}  // namespace twang::detail
