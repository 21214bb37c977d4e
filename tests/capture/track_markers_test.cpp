// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/track_markers.hpp"

#include "capture/render_film.hpp"
#include "capture/video_writer.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "tests/capture/filmed_rig.hpp"
#include "tests/capture/filmed_strip.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

constexpr double kTip_m = 76e-3;

struct Tracked {
  FilmTruth truth;
  TrackResult result;
};

class TrackMarkers : public ::testing::Test {
 protected:
  static FilmOptions short_film() {
    FilmOptions options;
    options.duration_s = 0.3;
    options.noise = 2.0;
    options.crf = 18;
    return options;
  }

  FilmTruth film(const Rig& rig, const FilmOptions& options, const StripMotion& motion = {}) {
    return render_film(
        rig, [&](double time_s) { return motion.state_at(rig, time_s); }, path(), options);
  }
  Tracked track(const Rig& rig, const FilmOptions& options, const StripMotion& motion = {}) {
    Tracked tracked;
    tracked.truth = film(rig, options, motion);
    tracked.result = track_markers(rig, path());
    return tracked;
  }
  /// Paints a grey box over some frames of the film.
  fs::path cover(std::size_t first, std::size_t last, const Eigen::Vector2d& middle, int half) {
    const fs::path covered = m_folder.path() / "covered.mkv";
    std::vector<Image> images = read_film(path());
    VideoWriter writer(covered, images[0].width_px, images[0].height_px, {.fps = 240.0});
    for (std::size_t n = 0; n < images.size(); ++n) {
      for (int dy = -half; n >= first && n < last && dy <= half; ++dy) {
        for (int dx = -half; dx <= half; ++dx) {
          const int x = static_cast<int>(middle.x()) + dx;
          const int y = static_cast<int>(middle.y()) + dy;
          images[n].pixels[static_cast<std::size_t>(y * images[n].width_px + x)] = 110;
        }
      }
      writer.write(images[n]);
    }
    writer.finish();
    return covered;
  }
  [[nodiscard]] fs::path path() const { return m_folder.path() / "film.mkv"; }

  TemporaryFolder m_folder;
};

/// What the camera sees of the tip's deflection: the mean over the exposure [mm].
double exposed_deflection_mm(const StripMotion& motion, const FilmOptions& options, double time_s) {
  constexpr int kParts = 40;
  double sum = 0.0;
  for (int i = 0; i < kParts; ++i) {
    const double within = options.exposure / options.fps * ((i + 0.5) / kParts - 0.5);
    sum += motion.end_at(time_s + within) * motion.shape(kTip_m) / kParts;
  }
  return kMillimetresPerMetre * sum;
}

/// rms difference of the observable from what the camera saw, without its mean [mm].
double observable_error_mm(const Tracked& tracked,
                           const FilmOptions& options,
                           const StripMotion& motion = {}) {
  const Channel& observable = *tracked.result.trace.find("observable_mm");
  double sum = 0.0;
  double square = 0.0;
  double count = 0.0;
  for (std::size_t n = 0; n < observable.values.size(); ++n) {
    if (!std::isfinite(observable.values[n])) continue;
    const double error =
        observable.values[n] - exposed_deflection_mm(motion, options, tracked.truth.time_s[n]);
    sum += error;
    square += error * error;
    count += 1.0;
  }
  EXPECT_GT(count, 0.5 * static_cast<double>(observable.values.size()));
  return std::sqrt(square / count - std::pow(sum / count, 2));
}

TEST_F(TrackMarkers, FollowsAPluckedStripToAFewHundredthsOfAPixel) {
  const FilmOptions options = short_film();
  const Tracked tracked = track(strip_rig(), options);
  const TrackResult& result = tracked.result;
  ASSERT_EQ(result.trace.num_samples(), tracked.truth.time_s.size());
  for (const MarkerTrack& marker : result.tracks) EXPECT_EQ(marker.frames_lost, 0) << marker.id;
  EXPECT_NEAR(result.mm_per_px, tracked.truth.mm_per_px, 1e-3 * tracked.truth.mm_per_px);
  // Without compression 0.01 px; H.264 at this rate factor makes it 0.03.
  EXPECT_LT(observable_error_mm(tracked, options) / result.mm_per_px, 0.04);
  // Steady markers: their mean is the compressed first picture's.
  for (std::size_t i = 1; i < result.tracks.size(); ++i) {
    const Eigen::Vector2d error =
        result.tracks[i].position_px[40] - tracked.truth.position_px[40][i];
    EXPECT_LT(error.norm(), 0.05) << result.tracks[i].id;
  }
}

TEST_F(TrackMarkers, LosslessFilmIsFollowedToAHundredth) {
  FilmOptions options = short_film();
  options.crf = 0;
  const Tracked tracked = track(strip_rig(), options);
  EXPECT_LT(observable_error_mm(tracked, options) / tracked.result.mm_per_px, 0.015);
}

TEST_F(TrackMarkers, SigmaIsHonestForAMovingMarker) {
  FilmOptions options = short_film();
  options.exposure = 0.0;  // the truth is a moment, not a mean
  const Tracked tracked = track(strip_rig(), options);
  const MarkerTrack& tip = tracked.result.tracks[0];
  double in_sigmas = 0.0;
  for (std::size_t n = 0; n < tip.position_px.size(); ++n) {
    in_sigmas += (tip.position_px[n] - tracked.truth.position_px[n][0]).squaredNorm() / 2.0 /
                 std::pow(tip.sigma_px[n], 2) / static_cast<double>(tip.position_px.size());
  }
  // Compression errs by its own rules: within a factor 1.6 of the truth either way.
  EXPECT_GT(in_sigmas, 0.4);
  EXPECT_LT(in_sigmas, 2.5);
}

TEST_F(TrackMarkers, TiltRollAndShakeAreTakenOut) {
  FilmOptions options = short_film();
  options.tilt_deg = 12.0;
  options.roll_deg = -6.0;
  options.shake_px = 1.5;
  const Tracked tracked = track(strip_rig(), options);
  // The map of each frame adds the noise of four dots, the tilt takes some of the scale.
  EXPECT_LT(observable_error_mm(tracked, options) / tracked.result.mm_per_px, 0.06);
}

TEST_F(TrackMarkers, FlickerAndStrongMotionBlurDoNotMislead) {
  FilmOptions options = short_film();
  options.flicker = 0.15;
  options.exposure = 0.9;
  const Tracked tracked = track(strip_rig(), options);
  EXPECT_EQ(tracked.result.tracks[0].frames_lost, 0);
  EXPECT_LT(observable_error_mm(tracked, options) / tracked.result.mm_per_px, 0.07);
}

TEST_F(TrackMarkers, RepeatedFramesAreLeftOut) {
  FilmOptions options = short_film();
  options.doubled = 0.1;
  const Tracked tracked = track(strip_rig(), options);
  const Channel& observable = *tracked.result.trace.find("observable_mm");
  int repeats = 0;
  for (std::size_t n = 0; n < observable.values.size(); ++n) {
    const bool left_out = std::isnan(observable.values[n]);
    if (!tracked.truth.doubled[n]) {
      EXPECT_FALSE(left_out) << n;
    } else if (n >= 14) {  // after the release: before, a compressed film does not show them
      EXPECT_TRUE(left_out) << n;
      ++repeats;
    }
  }
  EXPECT_GT(repeats, 2);
  EXPECT_GE(tracked.result.time_base.doubled, repeats);
  EXPECT_LT(observable_error_mm(tracked, options) / tracked.result.mm_per_px, 0.05);
}

TEST_F(TrackMarkers, NoFrameOfAnOrdinaryFilmIsCalledRepeated) {
  EXPECT_EQ(track(strip_rig(), short_film()).result.time_base.doubled, 0);
}

TEST_F(TrackMarkers, HiddenMarkerIsLostAndFoundAgain) {
  const FilmTruth truth = film(strip_rig(), short_film());
  const fs::path covered = cover(30, 38, truth.position_px[0][0], 45);
  const TrackResult result = track_markers(strip_rig(), covered);
  const MarkerTrack& tip = result.tracks[0];
  const Channel& observable = *result.trace.find("observable_mm");
  for (std::size_t n = 30; n < 38; ++n) {
    EXPECT_FALSE(tip.position_px[n].allFinite()) << n;
    EXPECT_TRUE(std::isnan(observable.values[n])) << n;
  }
  EXPECT_EQ(tip.frames_lost, 8);
  EXPECT_FALSE(tip.lost_because.empty());
  EXPECT_LT((tip.position_px[39] - truth.position_px[39][0]).norm(), 0.3);  // motion blur included
}

TEST_F(TrackMarkers, HiddenMarkerIsNotReplacedByALookAlike) {
  // Beside the tip stands its double, which the rig does not know, within the swing's reach.
  Rig filmed = strip_rig();
  Marker twin = filmed.markers[0];
  twin.id = "twin";
  twin.position.x() -= 11e-3;
  filmed.markers.push_back(twin);
  const FilmTruth truth = film(filmed, short_film());
  const fs::path covered = cover(30, 60, truth.position_px[0][0], 28);
  TrackOptions options;
  options.start_px["tip"] = truth.position_px[0][0];
  const TrackResult result = track_markers(strip_rig(), covered, options);
  for (std::size_t n = 0; n < result.tracks[0].position_px.size(); ++n) {
    const Eigen::Vector2d& found = result.tracks[0].position_px[n];
    if (found.allFinite()) {
      EXPECT_LT((found - truth.position_px[n][0]).norm(), 1.0) << n;
    }
  }
  EXPECT_GT(result.tracks[0].frames_lost, 10);
}

TEST_F(TrackMarkers, FilmWithoutMarkersIsRefused) {
  {
    VideoWriter writer(path(), 320, 180, {.fps = 30.0});
    const Image grey{320, 180, 1, std::vector<std::uint8_t>(320 * 180, 120)};
    for (int n = 0; n < 5; ++n) writer.write(grey);
    writer.finish();
  }
  const std::string message =
      refusal_of([&] { static_cast<void>(track_markers(strip_rig(), path())); });
  EXPECT_TRUE(holds(message, path().string()));
  EXPECT_TRUE(holds(message, "was not found"));
}

TEST_F(TrackMarkers, RateOfTheOptionBeatsTheRigWhichBeatsTheFile) {
  FilmOptions options = short_film();
  options.duration_s = 0.05;
  Rig rig = strip_rig();
  film(rig, options);
  const auto summary = [&](const TrackOptions& track_options) {
    return track_markers(rig, path(), track_options).time_base;
  };
  TrackOptions stated;
  stated.capture_fps = 960.0;
  EXPECT_EQ(summary(stated).capture_fps, 960.0);
  EXPECT_EQ(summary(stated).source, "--capture-fps");
  rig.camera->capture_fps = 480.0;
  EXPECT_EQ(summary({}).capture_fps, 480.0);
  EXPECT_EQ(summary({}).source, "rig");
  rig.camera->capture_fps.reset();
  EXPECT_NEAR(summary({}).capture_fps, 240.0, 1e-9);
  EXPECT_EQ(summary({}).source, "container");
}

TEST_F(TrackMarkers, ChannelsAreTheAxesTheImageShows) {
  FilmOptions options = short_film();
  options.duration_s = 0.05;
  Rig rig = strip_rig();
  rig.camera->readout_s = 4e-3;
  const Tracked tracked = track(rig, options);
  const Trace& trace = tracked.result.trace;
  EXPECT_NE(trace.find("tip.x_mm"), nullptr);
  EXPECT_EQ(trace.find("tip.y_mm"), nullptr);
  EXPECT_NE(trace.find("tip.z_mm"), nullptr);
  ASSERT_NE(trace.find("tip.sigma_mm"), nullptr);
  EXPECT_NEAR(trace.find("tip.sigma_mm")->values[0],
              tracked.result.tracks[0].sigma_px[0] * tracked.result.mm_per_px,
              1e-4);  // a similarity's scale is the same everywhere
  ASSERT_NE(trace.find("tip.time_offset_s"), nullptr);
  EXPECT_NEAR(trace.find("tip.time_offset_s")->values[0],
              4e-3 * tracked.truth.position_px[0][0].y() / (options.height_px - 1),
              1e-6);
  EXPECT_NEAR(trace.find("bench_2.x_mm")->values[3], 87.0, 0.02);
  EXPECT_NEAR(trace.find("bench_2.z_mm")->values[3], 25.0, 0.02);
}

TEST_F(TrackMarkers, AngleIsPositiveAnticlockwiseAsSeen) {
  Rig rig = strip_rig();
  Marker middle = rig.markers[0];
  middle.id = "middle";
  middle.position.x() = 46e-3;
  rig.markers.push_back(middle);
  rig.observable = ObservableDefinition{ObservableKind::Angle, {"middle", "tip"}, {0.0, 0.0, 0.0}};
  FilmOptions options = short_film();
  options.duration_s = 0.05;
  const StripMotion motion;
  const Tracked tracked = track(rig, options, motion);
  const Channel* angle = tracked.result.trace.find("observable_rad");
  ASSERT_NE(angle, nullptr);
  // Held down, the line from the middle to the tip is turned clockwise.
  const double rise = motion.end_at(0.0) * (motion.shape(kTip_m) - motion.shape(46e-3));
  EXPECT_NEAR(angle->values[2], std::atan(rise / 30e-3), 5e-4);  // 0.05 px over a base of 170 px
  // Two ends move the line, each by its sigma over the line's length.
  const Trace& trace = tracked.result.trace;
  ASSERT_NE(trace.sigma_of("observable_rad"), nullptr);
  const double both_mm =
      std::hypot(trace.find("middle.sigma_mm")->values[2], trace.find("tip.sigma_mm")->values[2]);
  const double line_mm = std::hypot(30.0, 1e3 * rise);
  EXPECT_NEAR(trace.sigma_of("observable_rad")->values[2], both_mm / line_mm, 1e-3 * both_mm);
}

TEST_F(TrackMarkers, OverlayAppearsWholeOrNotAtAll) {
  FilmOptions options = short_film();
  options.duration_s = 0.05;
  film(strip_rig(), options);
  TrackOptions with_overlay;
  with_overlay.overlay = m_folder.path() / "overlay.mp4";
  with_overlay.progress = [](const Progress& progress) { return progress.stage == "tracking"; };
  EXPECT_THROW(static_cast<void>(track_markers(strip_rig(), path(), with_overlay)), Cancelled);
  EXPECT_FALSE(fs::exists(with_overlay.overlay));
  with_overlay.progress = {};
  const TrackResult result = track_markers(strip_rig(), path(), with_overlay);
  const std::vector<Image> drawn = read_film(with_overlay.overlay);
  const std::vector<Image> plain = read_film(path());
  ASSERT_EQ(drawn.size(), plain.size());
  // The crosshair lies on the tip: the ink there is no longer black.
  const Eigen::Vector2d tip = result.tracks[0].position_px[6];
  const int x = static_cast<int>(std::lround(tip.x()));
  const int y = static_cast<int>(std::lround(tip.y()));
  EXPECT_GT(pixel_at(drawn[6], x, y), pixel_at(plain[6], x, y) + 40);
}

TEST_F(TrackMarkers, PicturesShowTheFirstFrame) {
  FilmOptions options = short_film();
  options.duration_s = 0.02;
  const Tracked tracked = track(strip_rig(), options);
  EXPECT_EQ(tracked.result.first_frame.channels, 1);
  EXPECT_EQ(tracked.result.first_frame_with_tracks.channels, 3);
  EXPECT_EQ(tracked.result.first_frame_with_tracks.pixels.size(),
            3 * tracked.result.first_frame.pixels.size());
}

TEST_F(TrackMarkers, RefusesARateThatIsNone) {
  TrackOptions options;
  options.capture_fps = 0.0;
  EXPECT_TRUE(
      holds(refusal_of([&] { static_cast<void>(track_markers(strip_rig(), path(), options)); }),
            "capture_fps is 0, must be > 0"));
}

TEST_F(TrackMarkers, RefusesARigWithoutMarkersOrCamera) {
  Rig rig = strip_rig();
  rig.camera.reset();
  EXPECT_TRUE(
      holds(refusal_of([&] { static_cast<void>(track_markers(rig, path())); }), "[camera]"));
  rig = strip_rig();
  rig.markers.clear();
  EXPECT_TRUE(
      holds(refusal_of([&] { static_cast<void>(track_markers(rig, path())); }), "[[marker]]"));
}

}  // namespace
}  // namespace twang::test
