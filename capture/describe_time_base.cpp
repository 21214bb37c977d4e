// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/frame_clock.hpp"
#include "capture/time_base.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <utility>

namespace twang {
namespace {

// Nearer, two rates say the same; cameras' clocks differ by less [relative].
constexpr double kSameRate = 3e-4;

bool differ(double a, double b) { return std::abs(a / b - 1.0) > kSameRate; }

std::string rate_text(double fps) { return fmt::format("{:.6g}", fps); }

bool other_speed(const TimeBaseSummary& time) {
  return time.kind == TimeBaseKind::SlowMotion || time.kind == TimeBaseKind::FastMotion;
}

/// How far the stamps are from an even clock, as a clause.
std::string uneven_text(const TimeBaseSummary& time) {
  return fmt::format("the stamps are {:.3g} ms rms from an even clock and are kept as they are",
                     1e3 * time.jitter_s);
}

std::string main_sentence(const TimeBaseSummary& time) {
  const std::string capture = rate_text(time.capture_fps);
  if (other_speed(time)) {
    const bool slow = time.kind == TimeBaseKind::SlowMotion;
    const double factor =
        slow ? time.capture_fps / time.file_fps : time.file_fps / time.capture_fps;
    return fmt::format(
        "{}: {} frames filmed at {} frames/s ({}); the file plays them at {}, {:.5g} times {}{}.",
        slow ? "Slow motion" : "Fast motion",
        time.frames,
        capture,
        time.source,
        rate_text(time.file_fps),
        factor,
        slow ? "slower" : "faster",
        time.even ? "" : "; " + uneven_text(time));
  }
  if (time.even) {
    return fmt::format(
        "Constant rate: {} frames at {} frames/s ({}).", time.frames, capture, time.source);
  }
  return fmt::format("Variable rate: {} frames at {} frames/s on average ({}); {}.",
                     time.frames,
                     capture,
                     time.source,
                     uneven_text(time));
}

/// Nothing to say of a rate that is none of television's.
std::optional<Note> television_note(const TimeBaseSummary& time) {
  const auto file = detail::ntsc_multiple(time.file_fps);
  if (!file) return std::nullopt;
  const std::string is = fmt::format(
      "The file's {} frames/s are {} / 1.001, a television rate", rate_text(time.file_fps), *file);
  const double whole = std::round(time.capture_fps);
  const bool stated_whole = std::abs(time.capture_fps / whole - 1.0) < 1e-6;
  if (!stated_whole) return Note(is + ".");
  return Note(
      fmt::format("{}; if the camera counts like this, it filmed at {} and not at {}: 0.1 % "
                  "of a frequency, 0.2 % of a modulus.",
                  is,
                  rate_text(whole / 1.001),
                  rate_text(whole)),
      Severity::Warning);
}

/// What stamps, container and tag say against each other, the first that is so.
void add_contradictions(const TimeBaseSummary& time, std::vector<Note>& notes) {
  if (time.declared_fps && differ(*time.declared_fps, time.file_fps)) {
    notes.emplace_back(
        fmt::format(
            "The container declares {} frames/s, its stamps say {}: the stamps were believed.",
            rate_text(*time.declared_fps),
            rate_text(time.file_fps)),
        Severity::Warning);
  }
  if (time.tag_fps && time.source != "tag" && differ(*time.tag_fps, time.capture_fps)) {
    const bool stated = time.source != "stamps" && time.source != "container";
    notes.emplace_back(fmt::format("The camera's tag says {} frames/s, the {} {}: the {} believed.",
                                   rate_text(*time.tag_fps),
                                   stated ? time.source + " says" : "stamps say",
                                   rate_text(time.capture_fps),
                                   stated ? time.source + " was" : "stamps were"),
                       Severity::Warning);
  } else if (!other_speed(time) && differ(time.capture_fps, time.file_fps)) {
    notes.emplace_back(
        fmt::format("The {} says {} frames/s, the stamps {}, {:+.2f} %: the {} was believed.",
                    time.source,
                    rate_text(time.capture_fps),
                    rate_text(time.file_fps),
                    100.0 * (time.capture_fps / time.file_fps - 1.0),
                    time.source),
        Severity::Warning);
  }
}

}  // namespace

std::vector<Note> describe_time_base(const TimeBaseSummary& summary) {
  std::vector<Note> notes = {main_sentence(summary)};
  if (summary.gaps > 0) {
    notes.emplace_back(fmt::format("{} frame{} missing from the film by its stamps (dropped); time "
                                   "goes on across the gaps.",
                                   summary.gaps,
                                   summary.gaps == 1 ? " is" : "s are"),
                       Severity::Warning);
  }
  if (std::optional<Note> television = television_note(summary)) {
    notes.push_back(std::move(*television));
  }
  add_contradictions(summary, notes);
  return notes;
}

}  // namespace twang
