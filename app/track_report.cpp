// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/track_report.hpp"

#include "capture/contact_sheet.hpp"
#include "capture/png.hpp"
#include "capture/track_summary.hpp"
#include "core/atomic_file.hpp"
#include "core/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang::app {
namespace {

nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

std::string line_of(const MarkerSummary& marker, std::size_t name_width) {
  std::string line = fmt::format("  {:<{}}  {} frames, sigma {} px",
                                 marker.id,
                                 name_width,
                                 marker.frames_seen,
                                 rounded_text(marker.sigma_px, 2));
  if (std::isfinite(marker.noise_floor_px)) {
    line += fmt::format(", noise floor {} px", rounded_text(marker.noise_floor_px, 2));
  }
  line +=
      marker.fixed ? ", fixed" : fmt::format(", travels {} mm", rounded_text(marker.travel_mm, 3));
  if (marker.frames_lost > 0) {
    line += fmt::format(", lost in {} frames from {} s ({})",
                        marker.frames_lost,
                        rounded_text(marker.lost.front().start_s, 4),
                        marker.lost.front().stretch.reason);
  }
  return line;
}

}  // namespace

std::string track_summary_text(const Rig& rig, const TrackResult& result) {
  const TimeBaseSummary& time = result.time_base;
  std::string text = fmt::format("{} frames at {} frames/s ({}",
                                 time.frames,
                                 fmt::format("{:.6g}", time.capture_fps),
                                 time.source);
  constexpr double kSameRate = 1e-3;
  if (std::abs(time.file_fps / time.capture_fps - 1.0) > kSameRate) {
    text += fmt::format("; the file plays at {}", fmt::format("{:.6g}", time.file_fps));
  }
  text += fmt::format("), {} repeated, {} missing; {} mm/px",
                      time.doubled,
                      time.gaps,
                      rounded_text(result.mm_per_px, 4));
  constexpr double kExact_px = 1e-9;  // four points fit a homography but for round-off
  if (result.plane_residual_px > kExact_px) {
    text += fmt::format("; fixed markers within {} px", rounded_text(result.plane_residual_px, 2));
  }
  text += '\n';
  const std::vector<MarkerSummary> markers = summarize_markers(rig, result);
  std::size_t name_width = 0;
  for (const MarkerSummary& marker : markers) name_width = std::max(name_width, marker.id.size());
  for (const MarkerSummary& marker : markers) text += line_of(marker, name_width) + '\n';
  for (const std::string& sentence : sentences_of(result.notes, Severity::Warning)) {
    text += "  warning: " + sentence + '\n';
  }
  for (const std::string& sentence : sentences_of(result.notes, Severity::Remark)) {
    text += "  note: " + sentence + '\n';
  }
  text.pop_back();
  return text;
}

nlohmann::ordered_json track_summary_json(const Rig& rig,
                                          const std::filesystem::path& film,
                                          const TrackResult& result) {
  const TimeBaseSummary& time = result.time_base;
  std::vector<std::string> notes;  // all of them
  for (const Note& note : result.notes) notes.push_back(note.text);
  nlohmann::ordered_json json = {
      {"film", film.string()},
      {"time_base",
       {{"frames", time.frames},
        {"capture_fps", number(time.capture_fps)},
        {"source", time.source},
        {"file_fps", number(time.file_fps)},
        {"duration_s", number(result.trace.time_s.empty() ? 0.0 : result.trace.time_s.back())},
        {"doubled", time.doubled},
        {"missing", time.gaps}}},
      {"layout_frame", result.layout_frame},
      {"mm_per_px", number(result.mm_per_px)},
      {"plane_residual_px", number(result.plane_residual_px)},
      {"plane_residual_mm", number(result.plane_residual_mm)},
      {"markers", nlohmann::ordered_json::array()},
      {"notes", std::move(notes)},
      {"warnings", sentences_of(result.notes, Severity::Warning)}};
  for (const MarkerSummary& marker : summarize_markers(rig, result)) {
    nlohmann::ordered_json lost = nlohmann::ordered_json::array();
    for (const TimedLoss& loss : marker.lost) {
      lost.push_back({{"first_frame", loss.stretch.first_frame},
                      {"frames", loss.stretch.num_frames},
                      {"start_s", number(loss.start_s)},
                      {"end_s", number(loss.end_s)},
                      {"reason", loss.stretch.reason},
                      {"found_again", loss.stretch.found_again}});
    }
    json["markers"].push_back({{"id", marker.id},
                               {"fixed", marker.fixed},
                               {"frames_seen", marker.frames_seen},
                               {"frames_lost", marker.frames_lost},
                               {"sigma_px", number(marker.sigma_px)},
                               {"sigma_mm", number(marker.sigma_mm)},
                               {"noise_floor_px", number(marker.noise_floor_px)},
                               {"travel_mm", number(marker.travel_mm)},
                               {"lost", std::move(lost)}});
  }
  return json;
}

void write_contact_sheet(const std::filesystem::path& target,
                         const Rig& rig,
                         const std::filesystem::path& film,
                         const TrackResult& result) {
  const std::vector<std::uint8_t> png =
      encode_png(draw_contact_sheet(rig, film.filename().string(), result));
  write_file_atomically(target, {reinterpret_cast<const char*>(png.data()), png.size()});
}

}  // namespace twang::app
