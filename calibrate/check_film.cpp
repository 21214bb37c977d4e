// SPDX-License-Identifier: GPL-3.0-or-later
// What a first film shows of clock, light, sharpness and steadiness.
#include "calibrate/detail/checks.hpp"
#include "core/constants.hpp"
#include "core/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang::detail {
namespace {

constexpr double kSameRate = 0.01;
constexpr double kEven = 0.05;           // of an interval: spread that is no jitter
constexpr double kClipped = 0.05;        // of the pixels
constexpr double kLeastContrast = 15.0;  // grey levels
constexpr double kGoodContrast = 50.0;   // grey levels
constexpr double kPaperClipped = 250.0;  // grey level of the paper
constexpr double kNoisy = 6.0;           // grey levels
constexpr double kSoft = 0.12;           // blur over marker size
constexpr double kSteady_px = 0.05;
constexpr double kShaky_px = 2.0;

void check_light(const FilmInspection& film, Findings& findings) {
  const auto least =
      std::min_element(film.markers.begin(), film.markers.end(), [](const auto& a, const auto& b) {
        return a.contrast < b.contrast;
      });
  if (least == film.markers.end()) return;
  const double paper = least->ink + least->contrast;
  if (least->contrast < kGoodContrast) {
    add(findings,
        "light",
        least->contrast < kLeastContrast ? CheckVerdict::Problem : CheckVerdict::Warning,
        fmt::format("'{}' stands out by {:.0f} grey levels of 255 only: more light.",
                    least->id,
                    least->contrast));
  } else if (paper > kPaperClipped || film.white_part > kClipped) {
    add(findings,
        "light",
        CheckVerdict::Warning,
        fmt::format("{:.0f} % of the picture is saturated white, which moves the edges of markers: "
                    "less light or a shorter exposure.",
                    100.0 * film.white_part));
  } else {
    add(findings,
        "light",
        CheckVerdict::Ok,
        fmt::format(
            "Paper stands out from ink by {:.0f} grey levels of 255 or more; {:.1f} % of the "
            "picture is saturated.",
            least->contrast,
            100.0 * (film.white_part + film.black_part)));
  }
}

void check_sharpness(const FilmInspection& film, Findings& findings) {
  const auto softest =
      std::max_element(film.markers.begin(), film.markers.end(), [](const auto& a, const auto& b) {
        return a.blur_px / a.size_px < b.blur_px / b.size_px;
      });
  if (softest == film.markers.end()) return;
  const bool soft = softest->blur_px > kSoft * softest->size_px;
  add(findings,
      "focus",
      soft ? CheckVerdict::Warning : CheckVerdict::Ok,
      fmt::format("The edges of '{}' are blurred by {} px (one sigma){}",
                  softest->id,
                  rounded_text(softest->blur_px, 2),
                  soft ? ": focus by hand, in the plane of the markers." : "."));
}

void check_steadiness(const CheckSubject& subject, Findings& findings) {
  const FilmInspection& film = *subject.film;
  if (!film.shake_px) return;
  const double shake = *film.shake_px;
  const auto num_fixed = std::count_if(subject.rig.markers.begin(),
                                       subject.rig.markers.end(),
                                       [](const Marker& marker) { return marker.fixed; });
  const bool corrected = num_fixed >= 2;
  const bool warn = shake > kShaky_px || (shake > kSteady_px && !corrected);
  add(findings,
      "shake",
      warn ? CheckVerdict::Warning : CheckVerdict::Ok,
      fmt::format("The fixed markers move together by {} px (rms){}",
                  rounded_text(shake, 2),
                  shake <= kSteady_px ? ": the camera stands."
                  : !warn             ? ", which is taken out."
                  : corrected         ? ": the camera should stand on a tripod."
                                      : ": put the camera on a tripod or add fixed markers."));
}

}  // namespace

void check_clock(const CheckSubject& subject, Findings& findings) {
  const FilmInspection* film = subject.film;
  const bool stated = subject.rig.camera->capture_fps || subject.options.capture_fps;
  if (film == nullptr) {
    add(findings,
        "clock",
        stated ? CheckVerdict::Ok : CheckVerdict::Warning,
        stated ? fmt::format("Frame rate of the camera: {:g} frames/s, as stated.", *subject.fps)
               : std::string("The rig states no capture_fps: the film's own rate will be believed, "
                             "which slow-motion films often belie."));
    return;
  }
  const TimeBaseSummary& time = film->time_base;
  const bool tag_differs = stated && film->capture_fps_tag &&
                           std::abs(*film->capture_fps_tag / time.capture_fps - 1.0) > kSameRate;
  const double nominal_s = 1.0 / time.capture_fps;
  const bool uneven = film->largest_interval_s - film->least_interval_s > kEven * nominal_s;
  std::string sentence = fmt::format("{} frames at {:.6g} frames/s ({}); the file plays at {:.6g}",
                                     time.frames,
                                     time.capture_fps,
                                     time.source,
                                     time.file_fps);
  if (film->capture_fps_tag) {
    sentence += fmt::format(", the camera's tag says {:.6g}", *film->capture_fps_tag);
  }
  if (uneven) {
    sentence += fmt::format("; from frame to frame {} to {} ms, {} missing",
                            rounded_text(1e3 * film->least_interval_s, 3),
                            rounded_text(1e3 * film->largest_interval_s, 3),
                            time.gaps);
  }
  const bool unsure = !stated && !film->capture_fps_tag;
  if (tag_differs) sentence += ": the two contradict each other";
  if (unsure) sentence += "; the rig states no capture_fps and the camera left no tag";
  add(findings,
      "clock",
      tag_differs || uneven || unsure ? CheckVerdict::Warning : CheckVerdict::Ok,
      sentence + ".");
}

void check_picture(const CheckSubject& subject, Findings& findings) {
  const FilmInspection& film = *subject.film;
  check_light(film, findings);
  check_sharpness(film, findings);
  add(findings,
      "noise",
      film.noise > kNoisy ? CheckVerdict::Warning : CheckVerdict::Ok,
      fmt::format("Noise of {} grey levels from frame to frame{}",
                  rounded_text(film.noise, 2),
                  film.noise > kNoisy ? ": more light, a lower ISO setting." : "."));
  check_steadiness(subject, findings);
}

}  // namespace twang::detail
