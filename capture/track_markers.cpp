// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/track_markers.hpp"

#include "capture/detail/doubled_frames.hpp"
#include "capture/detail/find_repeats.hpp"
#include "capture/detail/first_layout.hpp"
#include "capture/detail/follow_layout.hpp"
#include "capture/detail/lost_stretches.hpp"
#include "capture/detail/noise_floor.hpp"
#include "capture/detail/picture_shape.hpp"
#include "capture/detail/trace_of_tracks.hpp"
#include "capture/detail/track_noise.hpp"
#include "capture/detail/unseen_markers.hpp"
#include "capture/find_layout.hpp"
#include "capture/lens.hpp"
#include "capture/overlay.hpp"
#include "capture/plane_map.hpp"
#include "capture/video_reader.hpp"
#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace twang {
namespace {

constexpr double kOverlayFps = 30.0;  // at most: a film to be watched

Image copy_of(const LumaFrame& frame) {
  Image image{frame.width_px, frame.height_px, 1, {}};
  image.pixels.reserve(static_cast<std::size_t>(frame.width_px) *
                       static_cast<std::size_t>(frame.height_px));
  for (int y = 0; y < frame.height_px; ++y) {
    const std::uint8_t* row = frame.pixels + y * frame.stride;
    image.pixels.insert(image.pixels.end(), row, row + frame.width_px);
  }
  return image;
}

std::optional<StatedRate> stated_rate(const Rig& rig, const TrackOptions& options) {
  if (options.capture_fps) return StatedRate{*options.capture_fps, "--capture-fps"};
  if (rig.camera->capture_fps) return StatedRate{*rig.camera->capture_fps, "rig"};
  return std::nullopt;
}

/// A film being tracked: everything that is gathered frame by frame.
class Tracking {
 public:
  Tracking(const Rig& rig, const std::filesystem::path& video, const TrackOptions& options)
      : m_rig(rig), m_video(video), m_options(options) {
    const std::filesystem::path& lens = options.lens.empty() ? rig.camera->lens : options.lens;
    if (!lens.empty()) m_lens = read_lens(lens);
  }

  TrackResult run() {
    detail::FirstLayout first =
        detail::find_first_layout(m_rig, m_video, m_options.start_px, m_options.progress);
    for (const Marker& marker : m_rig.markers)
      m_result.tracks.push_back({marker.id, {}, {}, 0, "", {}});
    m_result.layout_frame = first.frame;
    if (first.reader) {
      m_reader = std::move(first.reader);
      begin(first.shown, std::move(first.layout));
    } else {
      m_reader = std::make_unique<VideoReader>(m_video);
    }
    while (const auto frame = m_reader->read()) {
      if (m_stamps_s.size() < first.frame) {
        wait(*frame);
      } else if (!m_follower) {
        begin(*frame, std::move(first.layout));
      } else {
        add(m_follower->follow(*frame));
        note_frame(*frame);
      }
    }
    return finish();
  }

 private:
  void wait(const LumaFrame& frame);
  void begin(const LumaFrame& frame, PartialLayout layout);
  void add(const std::vector<detail::MarkerSample>& samples);
  void judge_seen();
  void note_frame(const LumaFrame& frame);
  [[nodiscard]] Lens lens_of_film(const Lens& lens, const LumaFrame& frame) const;
  TrackResult finish();
  void widen_sigmas(const std::vector<bool>& doubled);
  [[nodiscard]] PlaneMap find_plane(const std::vector<MarkerTrack>& straight) const;
  void find_noise_floors(const std::vector<MarkerTrack>& straight,
                         const PlaneMap& map,
                         const std::vector<bool>& doubled);
  void add_notes(const std::vector<bool>& doubled);
  void hold_against_light(TimeBase& time, const std::vector<bool>& doubled);

  const Rig& m_rig;
  const std::filesystem::path& m_video;
  const TrackOptions& m_options;
  std::unique_ptr<VideoReader> m_reader;
  std::optional<detail::LayoutFollower> m_follower;
  std::vector<double> m_size_px;
  std::vector<bool> m_seen;  // a marker each: in any frame
  std::vector<Note> m_unseen_notes;
  detail::DoubledFrames m_doubled;
  std::vector<double> m_stamps_s;
  std::vector<double> m_brightness;  // of the light, one a frame, if there is one
  TrackResult m_result;
  std::optional<Lens> m_lens;
};

void Tracking::note_frame(const LumaFrame& frame) {
  m_stamps_s.push_back(frame.stamp_s);
  if (m_options.clock) m_brightness.push_back(mean_brightness(frame, *m_options.clock));
  m_doubled.add(frame);
  report_progress(m_options.progress,
                  {"tracking",
                   static_cast<double>(m_stamps_s.size()),
                   static_cast<double>(m_reader->info().declared_frames.value_or(0)),
                   "frames"});
}

Lens Tracking::lens_of_film(const Lens& lens, const LumaFrame& frame) const {
  try {
    return lens_for_size(lens, frame.width_px, frame.height_px);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", m_video.string(), error.what()));
  }
}

/// A frame before the layout is known.
void Tracking::wait(const LumaFrame& frame) {
  const Eigen::Vector2d nowhere = Eigen::Vector2d::Constant(kNaN);
  add(std::vector<detail::MarkerSample>(m_rig.markers.size(),
                                        {nowhere, kNaN, "too few markers are in plain view"}));
  note_frame(frame);
}

/// The first usable frame: where everything is.
void Tracking::begin(const LumaFrame& frame, PartialLayout layout) {
  m_result.first_frame = copy_of(frame);
  if (m_lens) m_lens = lens_of_film(*m_lens, frame);
  m_follower.emplace(frame, m_rig, std::move(layout));
  add(m_follower->first());
  note_frame(frame);
}

void Tracking::add(const std::vector<detail::MarkerSample>& samples) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    MarkerTrack& track = m_result.tracks[i];
    track.position_px.push_back(samples[i].position_px);
    track.sigma_px.push_back(samples[i].sigma_px);
    const std::size_t n = m_stamps_s.size();
    if (!samples[i].lost_because.empty()) {
      detail::note_lost(track, n, samples[i].lost_because);
    } else if (!track.lost.empty()) {
      LostStretch& last = track.lost.back();
      if (last.first_frame + last.num_frames == n) last.found_again = true;
    }
  }
}

void Tracking::judge_seen() {
  for (std::size_t i = 0; i < m_rig.markers.size(); ++i) {
    m_size_px.push_back(m_follower->size_px(i));
    m_seen.push_back(m_follower->seen(i));
  }
  m_unseen_notes = detail::judge_unseen_markers(m_rig, m_seen, m_video.string(), m_stamps_s.size());
}

/// A repeated picture is no measurement: it does not count as scatter.
void Tracking::widen_sigmas(const std::vector<bool>& doubled) {
  std::vector<std::vector<Eigen::Vector2d>> measured;
  for (const MarkerTrack& track : m_result.tracks) {
    auto& positions = measured.emplace_back(track.position_px);
    for (std::size_t n = 0; n < positions.size(); ++n) {
      if (doubled[n]) positions[n].setConstant(kNaN);
    }
  }
  std::vector<const std::vector<Eigen::Vector2d>*> position_px;
  std::vector<std::vector<double>*> sigma_px;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    position_px.push_back(&measured[i]);
    sigma_px.push_back(&m_result.tracks[i].sigma_px);
  }
  std::vector<bool> cut_out;
  for (const Marker& marker : m_rig.markers) cut_out.push_back(marker.kind == MarkerKind::Patch);
  const std::vector<double> added = detail::widen_by_scatter(position_px, sigma_px, cut_out);
  for (std::size_t i = 0; i < added.size(); ++i) m_result.tracks[i].coding_px = added[i];
}

PlaneMap Tracking::find_plane(const std::vector<MarkerTrack>& straight) const {
  std::vector<PlaneMarker> markers;
  for (std::size_t i = 0; i < m_rig.markers.size(); ++i) {
    const Marker& marker = m_rig.markers[i];
    const MarkerTrack& track = straight[i];
    const auto first_px = std::find_if(track.position_px.begin(),
                                       track.position_px.end(),
                                       [](const auto& px) { return px.allFinite(); });
    const double bent = m_lens && first_px != track.position_px.end()
                            ? std::sqrt(m_lens->distortion_jacobian(*first_px).determinant())
                            : 1.0;
    markers.push_back({marker.id,
                       marker.fixed && m_seen[i],
                       plane_position(*m_rig.camera, marker.position),
                       marker.size_m,
                       m_size_px[i] / bent * std::sqrt(m_reader->info().pixel_aspect),
                       &track.position_px,
                       &track.sigma_px});
  }
  try {
    return map_plane(markers);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", m_video.string(), error.what()));
  }
}

/// In the plane, where the camera's motion is out of the positions, but said in pixels.
void Tracking::find_noise_floors(const std::vector<MarkerTrack>& straight,
                                 const PlaneMap& map,
                                 const std::vector<bool>& doubled) {
  const double px_per_m = kMillimetresPerMetre / map.mm_per_px;
  std::vector<bool> fixed;
  for (std::size_t i = 0; i < straight.size(); ++i) {
    std::vector<Eigen::Vector2d> steady = straight[i].position_px;
    for (std::size_t n = 0; n < steady.size(); ++n) {
      steady[n] = px_per_m * map_point(map.at(n), steady[n]);
      if (doubled[n]) steady[n].setConstant(kNaN);
    }
    m_result.tracks[i].noise_floor_px = detail::scatter_while_still(steady, straight[i].sigma_px);
    fixed.push_back(m_rig.markers[i].fixed);
  }
  std::string note = detail::describe_noise_floors(m_result.tracks, fixed, m_result.mm_per_px);
  if (!note.empty()) m_result.notes.emplace_back(std::move(note));
}

void Tracking::add_notes(const std::vector<bool>& doubled) {
  for (Note& note : describe_time_base(m_result.time_base)) {
    m_result.notes.push_back(std::move(note));
  }
  for (Note& note : detail::notes_on_pictures(m_reader->info())) {
    m_result.notes.push_back(std::move(note));
  }
  if (m_result.clock) {
    m_result.notes.push_back(m_result.clock->message);
    if (!m_result.clock->warning.empty()) {
      m_result.notes.emplace_back(m_result.clock->warning, Severity::Warning);
    }
  }
  const auto num_doubled = std::count(doubled.begin(), doubled.end(), true);
  if (num_doubled > 0) {
    m_result.notes.push_back(fmt::format(
        "{} the one before and {} left out.",
        num_doubled == 1 ? "1 frame repeats" : fmt::format("{} frames repeat", num_doubled),
        num_doubled == 1 ? "was" : "were"));
  }
  m_result.notes.insert(m_result.notes.end(), m_unseen_notes.begin(), m_unseen_notes.end());
  for (std::size_t i = 0; i < m_result.tracks.size(); ++i) {
    if (!m_seen[i]) continue;
    const std::vector<Note> losses = detail::notes_on_losses(m_result.tracks[i]);
    m_result.notes.insert(m_result.notes.end(), losses.begin(), losses.end());
  }
}

void Tracking::hold_against_light(TimeBase& time, const std::vector<bool>& doubled) {
  for (std::size_t n = 0; n < doubled.size(); ++n) {
    if (doubled[n]) m_brightness[n] = kNaN;
  }
  try {
    m_result.clock = check_clock(time.time_s, m_brightness, m_options.clock->rate_hz);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", m_video.string(), error.what()));
  }
  if (m_options.clock_correct) correct_by_light(time, *m_result.clock);
}

TrackResult Tracking::finish() {
  judge_seen();
  const VideoInfo& info = m_reader->info();
  TimeBase time;
  try {
    time = correct_time_base(m_stamps_s,
                             info.tick_s,
                             info.declared_fps,
                             stated_rate(m_rig, m_options),
                             info.capture_fps_tag);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", m_video.string(), error.what()));
  }
  const std::vector<bool> doubled =
      detail::find_repeats(m_result.tracks,
                           m_doubled.decide(),
                           m_doubled.light(),
                           detail::repeat_evidence(m_doubled.coded()));
  time.summary.doubled = static_cast<int>(std::count(doubled.begin(), doubled.end(), true));
  if (m_options.clock) hold_against_light(time, doubled);
  m_result.time_base = time.summary;
  widen_sigmas(doubled);
  std::vector<MarkerTrack> straight =
      m_lens ? detail::straightened(m_result.tracks, *m_lens) : m_result.tracks;
  detail::make_square(straight, info.pixel_aspect);
  const PlaneMap map = find_plane(straight);
  m_result.trace = detail::trace_of_tracks(m_rig,
                                           {m_result.tracks,
                                            straight,
                                            map,
                                            time.time_s,
                                            doubled,
                                            {info.width_px, info.height_px},
                                            {info.turned_right.y(), info.turned_down.y()}});
  m_result.mm_per_px = map.mm_per_px;
  m_result.plane_residual_px = map.residual_px;
  m_result.plane_residual_mm = map.residual_mm;
  m_result.scale_sigma_rel = map.scale_sigma_rel;
  m_result.notes = map.notes;
  m_result.map = {map.plane_from_px, info.pixel_aspect, m_lens};
  find_noise_floors(straight, map, doubled);
  add_notes(doubled);

  const TrackDrawing drawing{m_result.tracks, m_size_px, doubled};
  m_result.first_frame_with_tracks =
      draw_tracks(m_result.first_frame, drawing, m_result.layout_frame);
  if (!m_options.overlay.empty()) {
    write_overlay(m_video,
                  m_options.overlay,
                  drawing,
                  std::min(kOverlayFps, time.summary.file_fps),
                  m_options.progress);
  }
  m_result.size_px = m_size_px;
  m_result.doubled = doubled;
  return std::move(m_result);
}

}  // namespace

void TrackOptions::check() const {
  if (capture_fps && !(std::isfinite(*capture_fps) && *capture_fps > 0.0)) {
    throw InputError(fmt::format("capture_fps is {}, must be > 0", *capture_fps));
  }
  if (clock) clock->check();
  if (clock_correct && !clock) {
    throw InputError("clock_correct is set, must come with a clock to correct by");
  }
  for (const auto& [id, px] : start_px) {
    if (!px.allFinite()) {
      throw InputError(
          fmt::format("start_px of '{}' is ({}, {}), must be finite", id, px.x(), px.y()));
    }
  }
}

TrackResult track_markers(const Rig& rig,
                          const std::filesystem::path& video,
                          const TrackOptions& options) {
  options.check();
  if (rig.markers.empty() || !rig.camera) {
    throw InputError(fmt::format("{}: has no {}, must have [[marker]] and [camera] to be tracked",
                                 rig.file.empty() ? "rig '" + rig.name + "'" : rig.file.string(),
                                 rig.markers.empty() ? "[[marker]]" : "[camera]"));
  }
  return Tracking(rig, video, options).run();
}

}  // namespace twang
