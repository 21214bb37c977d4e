// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/render_film.hpp"

#include "capture/detail/film_camera.hpp"
#include "capture/detail/film_scene.hpp"
#include "capture/detail/rolling_shutter.hpp"
#include "capture/marker_pattern.hpp"
#include "capture/video_writer.hpp"
#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string_view>

namespace twang {
namespace {

using namespace detail;

constexpr int kMinSize = 16;       // of the picture [px]
constexpr int kMaxSize = 8192;     // [px]
constexpr double kMaxTilt = 60.0;  // [deg]
constexpr double kMaxFrames = 1e6;
constexpr double kFlickerHz = 100.0;  // lamps on 50 Hz mains
constexpr double kMargin = 0.05;      // free border over the picture's height [-]
constexpr int kProbes = 64;           // moments at which the extent of the motion is looked up
constexpr int kMinExposures = 8;      // sub-exposures of a frame in which anything moves visibly
constexpr int kMaxExposures = 16;
constexpr double kExposureStep = 0.1;  // motion between two sub-exposures [px]
constexpr double kStill = 0.02;        // motion within an exposure that one sub-exposure shows [px]

void check_range(std::string_view field, double value, double low, double high) {
  if (value >= low && value <= high) return;  // false for nan
  throw InputError(fmt::format("{} is {}, must be {} to {}", field, value, low, high));
}

/// A slow hand-held motion: a few sinusoids of random frequency and phase in each direction.
class Shake {
 public:
  Shake(double sigma_px, unsigned seed) : m_amplitude(sigma_px * std::sqrt(2.0 / kWaves)) {
    std::seed_seq sequence{seed, 1U};
    std::mt19937 random(sequence);
    std::uniform_real_distribution<double> frequency(0.3, 5.0);  // [Hz]
    std::uniform_real_distribution<double> phase(0.0, kTwoPi);
    for (auto& direction : m_waves) {
      for (Wave& wave : direction) wave = {frequency(random), phase(random)};
    }
  }
  [[nodiscard]] bool any() const { return m_amplitude > 0.0; }
  [[nodiscard]] Eigen::Vector2d at(double time_s) const {
    Eigen::Vector2d shift = Eigen::Vector2d::Zero();
    for (int axis = 0; axis < 2; ++axis) {
      for (const Wave& wave : m_waves[static_cast<std::size_t>(axis)]) {
        shift[axis] += m_amplitude * std::sin(kTwoPi * wave.hz * time_s + wave.phase);
      }
    }
    return shift;
  }

 private:
  static constexpr int kWaves = 5;
  struct Wave {
    double hz, phase;
  };
  double m_amplitude;
  std::array<std::array<Wave, kWaves>, 2> m_waves;
};

/// A state as seen by the camera.
struct Projection {
  std::vector<ProjectedMarker> markers;  // those that are not fixed
  std::vector<ProjectedFace> faces;
};

/// Paints frames: what stands still once, what moves in each sub-exposure.
class FilmSet {
 public:
  FilmSet(const Rig& rig,
          const std::function<FilmedState(double)>& state_at,
          const FilmOptions& options)
      : m_rig(rig),
        m_state_at(state_at),
        m_options(options),
        m_row_s(options.readout_s / (options.height_px - 1)),
        m_shake(options.shake_px, options.seed),
        m_camera(*rig.camera, visible_points(), view()),
        m_still(options.width_px, options.height_px),
        m_scratch(options.width_px, options.height_px) {
    for (const Marker& marker : rig.markers) m_patterns.emplace_back(marker);
    paint_still(0.0);
  }

  [[nodiscard]] const FilmCamera& camera() const { return m_camera; }

  /// True marker centres at a frame's time [px].
  [[nodiscard]] std::vector<Eigen::Vector2d> marker_centres(double time_s) const {
    std::vector<Eigen::Vector2d> centres;
    const FilmedState seen = state(time_s);
    for (std::size_t i = 0; i < m_rig.markers.size(); ++i) {
      centres.push_back(projected(i, seen, {time_s, time_s}).centre_px);
    }
    return centres;
  }

  /// The picture before noise, exposed around `time_s`.
  [[nodiscard]] Canvas expose(double time_s) {
    if (m_shake.any()) paint_still(time_s);
    Canvas picture = m_still;
    const double open_s = m_options.exposure / m_options.fps;
    const std::vector<Projection> moments = sub_exposures(time_s, open_s);
    PixelBox box;
    for (const Projection& moment : moments) {
      box = box.united(box_of(moment.faces, picture));
      for (const ProjectedMarker& marker : moment.markers) {
        box = box.united(box_of(marker, picture));
      }
    }
    for (int y = box.y0; y < box.y1; ++y) {
      std::fill(picture.row(y) + box.x0, picture.row(y) + box.x1, 0.0F);
    }
    const float weight = 1.0F / static_cast<float>(moments.size());
    for (const Projection& moment : moments) {
      for (int y = box.y0; y < box.y1; ++y) {
        std::copy(m_still.row(y) + box.x0, m_still.row(y) + box.x1, m_scratch.row(y) + box.x0);
      }
      paint_silhouette(m_scratch, moment.faces, m_mask);
      for (const ProjectedMarker& marker : moment.markers) paint_marker(m_scratch, marker, soft());
      for (int y = box.y0; y < box.y1; ++y) {
        for (int x = box.x0; x < box.x1; ++x) picture.row(y)[x] += weight * m_scratch.row(y)[x];
      }
    }
    const double square = m_options.defocus_px * m_options.defocus_px;
    defocus(picture, soft() ? std::sqrt(square - kSoftVariance_px2) : m_options.defocus_px);
    return picture;
  }

 private:
  [[nodiscard]] FilmedState state(double time_s) const {
    FilmedState result = m_state_at(std::max(0.0, time_s));
    if (result.markers.size() != m_rig.markers.size()) {
      throw InputError(fmt::format("a filmed state has {} markers, must have the rig's {}",
                                   result.markers.size(),
                                   m_rig.markers.size()));
    }
    return result;
  }

  [[nodiscard]] bool soft() const {
    return m_options.defocus_px * m_options.defocus_px >= kSoftVariance_px2;
  }

  /// Corners of all that is to be seen in the course of the film, the papers around markers too.
  [[nodiscard]] std::vector<Eigen::Vector3d> visible_points() const {
    const Camera& camera = *m_rig.camera;
    std::vector<Eigen::Vector3d> points;
    for (int probe = 0; probe <= kProbes; ++probe) {
      const FilmedState seen = state(m_options.duration_s * probe / kProbes);
      for (const auto& face : seen.part_faces)
        points.insert(points.end(), face.begin(), face.end());
      for (std::size_t i = 0; i < seen.markers.size(); ++i) {
        const double reach = kPaperSide / 2.0 * m_rig.markers[i].size_m;
        for (const double right : {-reach, reach}) {
          for (const double down : {-reach, reach}) {
            points.emplace_back(seen.markers[i].position + right * camera.image_right +
                                down * camera.image_down);
          }
        }
      }
    }
    return points;
  }

  [[nodiscard]] ViewOptions view() const {
    return {.width_px = m_options.width_px,
            .height_px = m_options.height_px,
            .tilt_rad = m_options.tilt_deg * kRadiansPerDegree,
            .roll_rad = m_options.roll_deg * kRadiansPerDegree,
            .margin_px = kMargin * m_options.height_px + 3.0 * m_options.shake_px,
            .lens = m_options.lens};
  }

  /// A moment of a frame: what moves is where it is then, the camera where it is at the frame's
  /// own time.
  struct Moment {
    double time_s;
    double frame_s;
  };

  void paint_still(double frame_s) {
    paint_bench(m_still, m_camera, m_shake.at(frame_s));
    const FilmedState rest = state(0.0);
    for (std::size_t i = 0; i < m_rig.markers.size(); ++i) {
      if (m_rig.markers[i].fixed) paint_marker(m_still, projected(i, rest, {0.0, frame_s}), soft());
    }
  }

  /// @param seen  the state at the moment, for the first row
  [[nodiscard]] ProjectedMarker projected(std::size_t marker,
                                          const FilmedState& seen,
                                          const Moment& moment) const {
    const auto seen_with = [&](const FilmedState& now, double offset_s) {
      return project_marker(m_camera,
                            m_patterns[marker],
                            m_rig.markers[marker].size_m,
                            now.markers[marker],
                            m_shake.at(moment.frame_s + offset_s));
    };
    if (m_row_s == 0.0) return seen_with(seen, 0.0);
    const auto at = [&](double offset_s) {
      return seen_with(m_rig.markers[marker].fixed ? seen : state(moment.time_s + offset_s),
                       offset_s);
    };
    const RowReading reading =
        read_by_rows([&](double offset_s) { return at(offset_s).centre_px; }, m_row_s);
    ProjectedMarker result = at(reading.offset_s);
    result.pattern_from_px = result.pattern_from_px * moving_from_seen(reading, m_row_s);
    return result;
  }

  [[nodiscard]] ProjectedFace projected(const std::array<Eigen::Vector3d, 4>& face,
                                        double frame_s) const {
    ProjectedFace corners;
    for (std::size_t c = 0; c < corners.size(); ++c) {
      corners[c] = m_camera.pixel_from_rig(face[c], m_shake.at(frame_s));
    }
    return corners;
  }

  /// The part, corner by corner at the time of its row: by a parabola through three moments of the
  /// reading, which is enough for a silhouette.
  [[nodiscard]] std::vector<ProjectedFace> projected_faces(const FilmedState& seen,
                                                           const Moment& moment) const {
    std::vector<ProjectedFace> faces;
    for (const auto& face : seen.part_faces) faces.push_back(projected(face, moment.frame_s));
    if (m_row_s == 0.0) return faces;
    const double half_s = 0.5 * m_options.readout_s;
    const FilmedState middle = state(moment.time_s + half_s);
    const FilmedState last = state(moment.time_s + 2.0 * half_s);
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const ProjectedFace b = projected(middle.part_faces[f], moment.frame_s);
      const ProjectedFace c = projected(last.part_faces[f], moment.frame_s);
      for (std::size_t k = 0; k < b.size(); ++k) {
        const Eigen::Vector2d a = faces[f][k];
        const double t = m_row_s * b[k].y() / half_s - 1.0;  // -1 first row, 1 last
        faces[f][k] = b[k] + 0.5 * t * (c[k] - a) + 0.5 * t * t * (a - 2.0 * b[k] + c[k]);
      }
    }
    return faces;
  }

  [[nodiscard]] Projection project(const Moment& moment) const {
    const FilmedState seen = state(moment.time_s);
    Projection result;
    for (std::size_t i = 0; i < m_rig.markers.size(); ++i) {
      if (!m_rig.markers[i].fixed) result.markers.push_back(projected(i, seen, moment));
    }
    result.faces = projected_faces(seen, moment);
    return result;
  }

  /// The moments whose average is the exposure: as many as the motion asks for, one where nothing
  /// moves.
  [[nodiscard]] std::vector<Projection> sub_exposures(double time_s, double open_s) const {
    std::vector<Projection> moments;
    moments.push_back(project({time_s, time_s}));
    const Projection begin = project({time_s - 0.5 * open_s, time_s});
    const Projection end = project({time_s + 0.5 * open_s, time_s});
    const double motion = largest_motion(begin, moments[0]) + largest_motion(moments[0], end);
    if (motion < kStill) return moments;
    const int count = std::clamp(
        static_cast<int>(std::ceil(motion / kExposureStep)), kMinExposures, kMaxExposures);
    moments.clear();
    for (int i = 0; i < count; ++i) {
      moments.push_back(project({time_s + open_s * ((i + 0.5) / count - 0.5), time_s}));
    }
    return moments;
  }

  static double largest_motion(const Projection& a, const Projection& b) {
    double largest = 0.0;
    for (std::size_t i = 0; i < std::min(a.markers.size(), b.markers.size()); ++i) {
      largest = std::max(largest, (a.markers[i].centre_px - b.markers[i].centre_px).norm());
    }
    for (std::size_t i = 0; i < std::min(a.faces.size(), b.faces.size()); ++i) {
      for (std::size_t c = 0; c < 4; ++c) {
        largest = std::max(largest, (a.faces[i][c] - b.faces[i][c]).norm());
      }
    }
    return largest;
  }

  const Rig& m_rig;
  const std::function<FilmedState(double)>& m_state_at;
  const FilmOptions& m_options;
  double m_row_s;  // from one row's reading to the next's
  Shake m_shake;
  FilmCamera m_camera;
  std::vector<MarkerPattern> m_patterns;  // one a marker
  Canvas m_still;                         // bench and fixed markers
  Canvas m_scratch;                       // one sub-exposure
  std::vector<std::uint8_t> m_mask;
};

void check_rig(const Rig& rig) {
  if (rig.markers.empty()) throw InputError(fmt::format("{}: has no marker to film", rig.name));
  if (!rig.camera) throw InputError(fmt::format("{}: has no camera to film with", rig.name));
  for (const Marker& marker : rig.markers) {
    (void)MarkerPattern(marker);  // throws for one that cannot be drawn
  }
}

/// What the sensor makes of the light: the lamp's ripple, noise, eight bits.
Image develop(const Canvas& light, double gain, double noise, std::mt19937& random) {
  std::normal_distribution<float> error(0.0F, static_cast<float>(std::max(noise, 1e-9)));
  Image image{light.width, light.height, 1, {}};
  image.pixels.resize(light.light.size());
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const float level =
        light.light[i] * static_cast<float>(gain) + (noise > 0.0 ? error(random) : 0.0F);
    image.pixels[i] = static_cast<std::uint8_t>(std::clamp(level + 0.5F, 0.0F, 255.0F));
  }
  return image;
}

}  // namespace

void FilmOptions::check() const {
  check_range("width_px", width_px, kMinSize, kMaxSize);
  check_range("height_px", height_px, kMinSize, kMaxSize);
  check_range("fps", fps, 1.0, 1e6);
  check_range("duration_s", duration_s, 1.0 / fps, kMaxFrames / fps);
  check_range("noise", noise, 0.0, 255.0);
  check_range("exposure", exposure, 0.0, 1.0);
  check_range("tilt_deg", tilt_deg, -kMaxTilt, kMaxTilt);
  check_range("roll_deg", roll_deg, -360.0, 360.0);
  check_range("shake_px", shake_px, 0.0, 0.1 * std::min(width_px, height_px));
  check_range("flicker", flicker, 0.0, 1.0);
  check_range("doubled", doubled, 0.0, 0.9);
  check_range("defocus_px", defocus_px, 0.0, 20.0);
  check_range("crf", crf, 0, 51);
  check_range("readout_s", readout_s, 0.0, 1.0 / fps);
}

FilmTruth render_film(const Rig& rig,
                      const std::function<FilmedState(double time_s)>& state_at,
                      const std::filesystem::path& video,
                      const FilmOptions& options) {
  options.check();
  check_rig(rig);
  VideoWriter writer(
      video, options.width_px, options.height_px, {.fps = options.fps, .crf = options.crf});
  FilmSet set(rig, state_at, options);
  std::seed_seq noise_seed{options.seed, 2U};
  std::seed_seq doubling_seed{options.seed, 3U};
  std::mt19937 noise_random(noise_seed);
  std::mt19937 doubling_random(doubling_seed);
  std::bernoulli_distribution repeats(options.doubled);

  FilmTruth truth;
  truth.mm_per_px = kMillimetresPerMetre / set.camera().scale_px_per_m();
  const int num_frames =
      std::max(1, static_cast<int>(std::lround(options.duration_s * options.fps)));
  Image image;
  for (int n = 0; n < num_frames; ++n) {
    report_progress(options.progress, {"rendering", 1.0 * n, 1.0 * num_frames});
    const double time_s = n / options.fps;
    const bool doubled = n > 0 && repeats(doubling_random);
    truth.time_s.push_back(time_s);
    truth.position_px.push_back(set.marker_centres(time_s));
    truth.doubled.push_back(doubled);
    if (!doubled) {
      const double gain = 1.0 + options.flicker * std::sin(kTwoPi * kFlickerHz * time_s);
      image = develop(set.expose(time_s), gain, options.noise, noise_random);
    }
    writer.write(image);
  }
  writer.finish();
  report_progress(options.progress, {"rendering", 1.0 * num_frames, 1.0 * num_frames});
  return truth;
}

}  // namespace twang
