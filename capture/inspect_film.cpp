// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/inspect_film.hpp"

#include "capture/align_marker.hpp"
#include "capture/detail/first_layout.hpp"
#include "capture/find_layout.hpp"
#include "capture/video_reader.hpp"
#include "core/constants.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace twang {
namespace {

constexpr int kSteadyFrames = 240;  // in which the fixed markers are watched
constexpr int kNoiseFrames = 12;    // compared with the one before
constexpr int kEvery = 4;           // pixels along both axes are enough for a statistic
constexpr double kStillPart = 0.8;  // of the pixels: the rest may show motion
constexpr double kTrimmedRms =
    0.6616;  // of a Gaussian whose largest fifth is left out, over its rms
constexpr int kBlack = 2;
constexpr int kWhite = 253;
constexpr double kLeastScore = 0.6;

std::vector<std::uint8_t> sparse(const LumaFrame& frame) {
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < frame.height_px; y += kEvery) {
    const std::uint8_t* row = frame.pixels + y * frame.stride;
    for (int x = 0; x < frame.width_px; x += kEvery) pixels.push_back(row[x]);
  }
  return pixels;
}

/// One sigma of the noise of a pixel, from two pictures; the fifth that changed most is left out.
double noise_between(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  std::array<long, 256> histogram{};
  for (std::size_t i = 0; i < a.size(); ++i) {
    ++histogram[static_cast<std::size_t>(std::abs(int{a[i]} - int{b[i]}))];
  }
  const auto wanted = static_cast<long>(kStillPart * static_cast<double>(a.size()));
  long counted = 0;
  double squares = 0.0;
  for (std::size_t d = 0; d < histogram.size() && counted < wanted; ++d) {
    const long here = std::min(histogram[d], wanted - counted);
    squares += static_cast<double>(here) * static_cast<double>(d * d);
    counted += here;
  }
  return std::sqrt(squares / static_cast<double>(std::max(1L, counted)) / 2.0) / kTrimmedRms;
}

class Inspection {
 public:
  Inspection(const Rig& rig, const std::filesystem::path& video, const InspectOptions& options)
      : m_rig(rig), m_video(video), m_options(options), m_reader(video) {}

  FilmInspection run() {
    const VideoInfo& info = m_reader.info();
    m_result.film = m_video.string();
    m_result.width_px = info.width_px;
    m_result.height_px = info.height_px;
    m_result.declared_fps = info.declared_fps;
    m_result.capture_fps_tag = info.capture_fps_tag;
    find();
    while (const auto frame = m_reader.read()) look_at(*frame);
    if (m_stamps_s.empty()) {
      throw InputError(fmt::format("{}: holds no picture, must hold a film", m_video.string()));
    }
    read_clock();
    if (m_num_noise > 0) m_result.noise = m_noise_sum / m_num_noise;
    measure_shake();
    return std::move(m_result);
  }

 private:
  void look_at(const LumaFrame& frame);
  void find();
  void watch(const LumaFrame& frame);
  void read_clock();
  void measure_shake();

  const Rig& m_rig;
  const std::filesystem::path& m_video;
  const InspectOptions& m_options;
  VideoReader m_reader;
  FilmInspection m_result;
  std::vector<double> m_stamps_s;
  std::vector<std::uint8_t> m_before;
  double m_noise_sum = 0.0;
  int m_num_noise = 0;
  std::vector<FittedMarker> m_fixed;
  std::vector<Eigen::Vector2d> m_common_px;  // mean offset of the fixed markers, one a frame
};

void Inspection::look_at(const LumaFrame& frame) {
  const auto number = static_cast<int>(m_stamps_s.size());
  m_stamps_s.push_back(frame.stamp_s);
  report_progress(m_options.progress,
                  {"looking at the film",
                   static_cast<double>(m_stamps_s.size()),
                   static_cast<double>(m_reader.info().declared_frames.value_or(0)),
                   "frames"});
  if (number <= kNoiseFrames) {
    std::vector<std::uint8_t> pixels = sparse(frame);
    if (number == 0) {
      const auto part = [&](auto&& at_end) {
        return static_cast<double>(std::count_if(pixels.begin(), pixels.end(), at_end)) /
               static_cast<double>(pixels.size());
      };
      m_result.black_part = part([](std::uint8_t v) { return v <= kBlack; });
      m_result.white_part = part([](std::uint8_t v) { return v >= kWhite; });
    } else {
      m_noise_sum += noise_between(m_before, pixels);
      ++m_num_noise;
    }
    m_before = std::move(pixels);
  }
  const bool steady = number > m_result.frame && number < m_result.frame + kSteadyFrames;
  if (!m_fixed.empty() && steady) watch(frame);
}

void Inspection::find() {
  detail::FirstLayout first;
  try {
    first = detail::find_first_layout(m_rig, m_video, m_options.start_px, m_options.progress);
  } catch (const InputError& error) {
    m_result.not_found = error.what();
    return;
  }
  m_result.frame = static_cast<int>(first.frame);
  const auto to_px = [&](const Eigen::Vector2d& plane) {
    return map_point(first.layout.px_from_plane, plane);
  };
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < m_rig.markers.size(); ++i) {
    const Marker& marker = m_rig.markers[i];
    middle +=
        plane_position(*m_rig.camera, marker.position) / static_cast<double>(m_rig.markers.size());
    std::optional<FittedMarker>& fitted = first.layout.markers[i];
    if (!fitted) {
      m_result.hidden.push_back(marker.id);
      continue;
    }
    const MarkerAlignment& found = fitted->alignment;
    m_result.markers.push_back({marker.id,
                                found.placement.position_px,
                                placed_size_px(found.placement),
                                fitted->marker.blur_px(),
                                found.contrast,
                                found.light[0]});
    if (marker.fixed) m_fixed.push_back(std::move(*fitted));
  }
  constexpr double kStep_m = 1e-4;
  for (const Eigen::Vector2d& step :
       {Eigen::Vector2d(kStep_m, 0.0), Eigen::Vector2d(0.0, kStep_m)}) {
    m_result.px_per_m += 0.5 * (to_px(middle + step) - to_px(middle)).norm() / kStep_m;
  }
}

/// The fixed markers in a later frame: their common motion is the camera's.
void Inspection::watch(const LumaFrame& frame) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int seen = 0;
  for (const FittedMarker& fitted : m_fixed) {
    AlignOptions align;
    align.fit_turn = false;
    align.farthest_px = 0.5 * placed_size_px(fitted.alignment.placement);
    const MarkerAlignment now =
        align_marker(frame, fitted.marker, fitted.alignment.placement, align);
    if (!now.converged || now.score < kLeastScore) continue;
    sum += now.placement.position_px - fitted.alignment.placement.position_px;
    ++seen;
  }
  if (seen > 0) m_common_px.emplace_back(sum / seen);
}

void Inspection::measure_shake() {
  if (m_common_px.empty()) return;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& offset : m_common_px) {
    mean += offset / static_cast<double>(m_common_px.size());
  }
  double squares = 0.0;
  for (const Eigen::Vector2d& offset : m_common_px) squares += (offset - mean).squaredNorm();
  m_result.shake_px = std::sqrt(squares / (2.0 * static_cast<double>(m_common_px.size())));
}

void Inspection::read_clock() {
  const VideoInfo& info = m_reader.info();
  std::optional<StatedRate> stated;
  if (m_options.capture_fps) {
    stated = StatedRate{*m_options.capture_fps, "--capture-fps"};
  } else if (m_rig.camera->capture_fps) {
    stated = StatedRate{*m_rig.camera->capture_fps, "rig"};
  }
  TimeBase time;
  try {
    time =
        correct_time_base(m_stamps_s, info.tick_s, info.declared_fps, stated, info.capture_fps_tag);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", m_video.string(), error.what()));
  }
  m_result.time_base = time.summary;
  m_result.least_interval_s = kInfinity;
  for (std::size_t n = 1; n < time.time_s.size(); ++n) {
    const double interval_s = time.time_s[n] - time.time_s[n - 1];
    m_result.least_interval_s = std::min(m_result.least_interval_s, interval_s);
    m_result.largest_interval_s = std::max(m_result.largest_interval_s, interval_s);
  }
}

}  // namespace

FilmInspection inspect_film(const Rig& rig,
                            const std::filesystem::path& video,
                            const InspectOptions& options) {
  if (rig.markers.empty() || !rig.camera) {
    throw InputError(fmt::format("{}: has no {}, must have [[marker]] and [camera] to be filmed",
                                 rig.file.empty() ? "rig '" + rig.name + "'" : rig.file.string(),
                                 rig.markers.empty() ? "[[marker]]" : "[camera]"));
  }
  return Inspection(rig, video, options).run();
}

}  // namespace twang
