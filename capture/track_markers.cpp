// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/track_markers.hpp"

#include "capture/detail/doubled_frames.hpp"
#include "capture/detail/follow_marker.hpp"
#include "capture/detail/noise_floor.hpp"
#include "capture/detail/trace_of_tracks.hpp"
#include "capture/find_layout.hpp"
#include "capture/lens.hpp"
#include "capture/overlay.hpp"
#include "capture/plane_map.hpp"
#include "capture/video_reader.hpp"
#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang {
namespace {

constexpr double kOverlayFps = 30.0;     // at most: a film to be watched
constexpr double kReachOfRelease = 1.2;  // a marker may stand on a longer lever than the release

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

std::optional<StatedRate> stated_rate(const Rig& rig,
                                      const VideoInfo& info,
                                      const TrackOptions& options) {
  if (options.capture_fps) return StatedRate{*options.capture_fps, "--capture-fps"};
  if (rig.camera->capture_fps) return StatedRate{*rig.camera->capture_fps, "rig"};
  if (info.capture_fps_tag) return StatedRate{*info.capture_fps_tag, "tag"};
  return std::nullopt;
}

/// A film being tracked: everything that is gathered frame by frame.
class Tracking {
 public:
  Tracking(const Rig& rig, const std::filesystem::path& video, const TrackOptions& options)
      : m_rig(rig), m_video(video), m_options(options), m_reader(video) {
    const std::filesystem::path& lens = options.lens.empty() ? rig.camera->lens : options.lens;
    if (!lens.empty()) m_lens = read_lens(lens);
  }

  TrackResult run() {
    begin();
    while (const auto frame = m_reader.read()) follow(*frame);
    return finish();
  }

 private:
  void begin();
  void follow(const LumaFrame& frame);
  void note_frame(const LumaFrame& frame);
  [[nodiscard]] Lens lens_of_film(const Lens& lens, const LumaFrame& frame) const;
  TrackResult finish();
  [[nodiscard]] std::vector<bool> find_doubled() const;
  [[nodiscard]] PlaneMap find_plane(const std::vector<MarkerTrack>& straight) const;
  void find_noise_floors(const std::vector<MarkerTrack>& straight,
                         const PlaneMap& map,
                         const std::vector<bool>& doubled);
  void add_notes(const std::vector<bool>& doubled);

  const Rig& m_rig;
  const std::filesystem::path& m_video;
  const TrackOptions& m_options;
  VideoReader m_reader;
  std::vector<detail::MarkerFollower> m_followers;
  std::vector<double> m_size_px;
  detail::DoubledFrames m_doubled;
  std::vector<double> m_stamps_s;
  TrackResult m_result;
  std::optional<Lens> m_lens;
};

void Tracking::note_frame(const LumaFrame& frame) {
  m_stamps_s.push_back(frame.stamp_s);
  m_doubled.add(frame);
  report_progress(m_options.progress,
                  {"tracking",
                   static_cast<double>(m_stamps_s.size()),
                   static_cast<double>(m_reader.info().declared_frames.value_or(0))});
}

Lens Tracking::lens_of_film(const Lens& lens, const LumaFrame& frame) const {
  try {
    return lens_for_size(lens, frame.width_px, frame.height_px);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", m_video.string(), error.what()));
  }
}

/// The first frame: where everything is.
void Tracking::begin() {
  const auto frame = m_reader.read();
  if (!frame) {
    throw InputError(fmt::format("{}: holds no picture, must hold a film", m_video.string()));
  }
  m_result.first_frame = copy_of(*frame);
  if (m_lens) m_lens = lens_of_film(*m_lens, *frame);
  Layout layout = find_layout(*frame, m_rig, m_options.start_px, m_video.string());
  for (std::size_t i = 0; i < m_rig.markers.size(); ++i) {
    const Marker& marker = m_rig.markers[i];
    const MarkerAlignment& found = layout.markers[i].alignment;
    detail::MarkerBackground background;
    background.rest_px = layout.to_px(plane_position(*m_rig.camera, marker.position));
    if (!marker.fixed && m_rig.release && m_rig.release->displacement) {
      const Eigen::Vector2d far = plane_position(
          *m_rig.camera, marker.position + kReachOfRelease * *m_rig.release->displacement);
      background.reach_px = (layout.to_px(far) - background.rest_px).norm();
    }
    m_result.tracks.push_back({marker.id, {found.placement.position_px}, {found.sigma_px}, 0, ""});
    m_size_px.push_back(placed_size_px(found.placement));
    m_followers.emplace_back(*frame, std::move(layout.markers[i]), background);
  }
  note_frame(*frame);
}

void Tracking::follow(const LumaFrame& frame) {
  std::vector<Eigen::Vector2d> taken;
  for (std::size_t i = 0; i < m_followers.size(); ++i) {
    MarkerTrack& track = m_result.tracks[i];
    const detail::MarkerSample sample = m_followers[i].follow(frame, taken);
    track.position_px.push_back(sample.position_px);
    track.sigma_px.push_back(sample.sigma_px);
    if (sample.lost_because.empty()) {
      taken.push_back(sample.position_px);
      continue;
    }
    if (track.frames_lost++ == 0) track.lost_because = sample.lost_because;
  }
  note_frame(frame);
}

/// By the pictures, and in slow motion, which these do not show clearly, by the markers: some stand
/// where they should have moved, and none moved.
std::vector<bool> Tracking::find_doubled() const {
  auto [doubled, changed] = m_doubled.decide();
  std::vector<int> stand(doubled.size(), 0);
  std::vector<int> move(doubled.size(), 0);
  for (const MarkerTrack& track : m_result.tracks) {
    const std::vector<int> verdict =
        detail::stands_against_motion(track.position_px, track.sigma_px);
    for (std::size_t n = 0; n < verdict.size(); ++n) {
      stand[n] += verdict[n] > 0 ? 1 : 0;
      move[n] += verdict[n] < 0 ? 1 : 0;
    }
  }
  for (std::size_t n = 0; n < doubled.size(); ++n) {
    if (stand[n] > 0 && move[n] == 0 && !changed[n]) doubled[n] = true;
  }
  return doubled;
}

PlaneMap Tracking::find_plane(const std::vector<MarkerTrack>& straight) const {
  std::vector<PlaneMarker> markers;
  for (std::size_t i = 0; i < m_rig.markers.size(); ++i) {
    const Marker& marker = m_rig.markers[i];
    const MarkerTrack& track = straight[i];
    const Eigen::Vector2d& first_px = track.position_px.front();
    const double bent = m_lens && first_px.allFinite()
                            ? std::sqrt(m_lens->distortion_jacobian(first_px).determinant())
                            : 1.0;
    markers.push_back({marker.id,
                       marker.fixed,
                       plane_position(*m_rig.camera, marker.position),
                       marker.size_m,
                       m_size_px[i] / bent,
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
      steady[n] = doubled[n] ? Eigen::Vector2d::Constant(kNaN)
                             : Eigen::Vector2d(px_per_m * map_point(map.at(n), steady[n]));
    }
    m_result.tracks[i].noise_floor_px = detail::scatter_while_still(steady, straight[i].sigma_px);
    fixed.push_back(m_rig.markers[i].fixed);
  }
  std::string note = detail::describe_noise_floors(m_result.tracks, fixed, m_result.mm_per_px);
  if (!note.empty()) m_result.notes.push_back(std::move(note));
}

void Tracking::add_notes(const std::vector<bool>& doubled) {
  const std::size_t num_frames = m_stamps_s.size();
  const TimeBaseSummary& time = m_result.time_base;
  m_result.notes.push_back(fmt::format("{} frames at {:g} frames/s ({}); the file plays at {:g}.",
                                       num_frames,
                                       time.capture_fps,
                                       time.source,
                                       time.file_fps));
  const auto num_doubled = std::count(doubled.begin(), doubled.end(), true);
  if (num_doubled > 0) {
    m_result.notes.push_back(
        fmt::format("{} frames repeat the one before and were left out.", num_doubled));
  }
  for (const MarkerTrack& track : m_result.tracks) {
    if (track.frames_lost == 0) continue;
    m_result.notes.push_back(fmt::format("Marker '{}' was lost in {} of {} frames ({}).",
                                         track.id,
                                         track.frames_lost,
                                         num_frames,
                                         track.lost_because));
  }
}

TrackResult Tracking::finish() {
  const VideoInfo& info = m_reader.info();
  TimeBase time;
  try {
    time = correct_time_base(
        m_stamps_s, info.tick_s, info.declared_fps, stated_rate(m_rig, info, m_options));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", m_video.string(), error.what()));
  }
  const std::vector<bool> doubled = find_doubled();
  time.summary.doubled = static_cast<int>(std::count(doubled.begin(), doubled.end(), true));
  m_result.time_base = time.summary;
  const std::vector<MarkerTrack> straight =
      m_lens ? detail::straightened(m_result.tracks, *m_lens) : m_result.tracks;
  const PlaneMap map = find_plane(straight);
  m_result.trace = detail::trace_of_tracks(
      m_rig,
      {m_result.tracks, straight, map, time.time_s, doubled, m_result.first_frame.height_px});
  m_result.mm_per_px = map.mm_per_px;
  m_result.plane_residual_px = map.residual_px;
  m_result.plane_residual_mm = map.residual_mm;
  m_result.scale_sigma_rel = map.scale_sigma_rel;
  m_result.notes = map.notes;
  find_noise_floors(straight, map, doubled);
  add_notes(doubled);

  const TrackDrawing drawing{m_result.tracks, m_size_px, doubled};
  m_result.first_frame_with_tracks = draw_tracks(m_result.first_frame, drawing, 0);
  if (!m_options.overlay.empty()) {
    write_overlay(m_video,
                  m_options.overlay,
                  drawing,
                  std::min(kOverlayFps, time.summary.file_fps),
                  m_options.progress);
  }
  return std::move(m_result);
}

}  // namespace

void TrackOptions::check() const {
  if (capture_fps && !(std::isfinite(*capture_fps) && *capture_fps > 0.0)) {
    throw InputError(fmt::format("capture_fps is {}, must be > 0", *capture_fps));
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
