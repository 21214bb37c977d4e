// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/track_summary.hpp"

#include "capture/contact_sheet.hpp"
#include "capture/detail/lost_stretches.hpp"
#include "capture/detail/sheet_canvas.hpp"
#include "core/constants.hpp"
#include "core/units.hpp"
#include "tests/capture/filmed_rig.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace twang::test {
namespace {

constexpr int kFrames = 600;
constexpr double kNoise_px = 0.02;
constexpr double kScale_mm = 0.25;  // a pixel
constexpr std::size_t kFirstLost = 100;
constexpr std::size_t kLastLost = 119;

/// A tracked film made by hand: the middle marker rests, swings by 8 px and rests again; hidden for
/// twenty frames and for one.
TrackResult tracked_bench(const Rig& rig) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, kNoise_px);
  TrackResult result;
  result.mm_per_px = kScale_mm;
  result.time_base.capture_fps = 240.0;
  result.time_base.file_fps = 30.0;
  result.time_base.frames = kFrames;
  result.time_base.source = "rig";
  result.first_frame = {640, 360, 1, std::vector<std::uint8_t>(640 * 360, 150)};
  result.doubled.assign(kFrames, false);
  for (int n = 0; n < kFrames; ++n) result.trace.time_s.push_back(n / 240.0);
  for (std::size_t i = 0; i < rig.markers.size(); ++i) {
    const Marker& marker = rig.markers[i];
    MarkerTrack track;
    track.id = marker.id;
    Channel x{marker.id + ".x_mm", {}};
    Channel z{marker.id + ".z_mm", {}};
    Channel sigma{marker.id + ".sigma_mm", {}};
    for (int n = 0; n < kFrames; ++n) {
      const bool swings = !marker.fixed && n >= 200 && n < 300;
      const Eigen::Vector2d offset_px(
          noise(random), noise(random) + (swings ? 8.0 * std::sin(0.7 * (n - 200)) : 0.0));
      const auto frame = static_cast<std::size_t>(n);
      const bool lost =
          !marker.fixed && ((frame >= kFirstLost && frame <= kLastLost) || frame == 400);
      const double hidden = lost ? kNaN : 0.0;
      track.position_px.emplace_back(Eigen::Vector2d(320.0, 180.0) + offset_px +
                                     Eigen::Vector2d::Constant(hidden));
      track.sigma_px.push_back(kNoise_px + hidden);
      x.values.push_back(kMillimetresPerMetre * marker.position.x() + kScale_mm * offset_px.x() +
                         hidden);
      z.values.push_back(kMillimetresPerMetre * marker.position.z() - kScale_mm * offset_px.y() +
                         hidden);
      sigma.values.push_back(kScale_mm * kNoise_px + hidden);
      if (lost) detail::note_lost(track, frame, "hidden behind a hand");
    }
    result.tracks.push_back(std::move(track));
    result.size_px.push_back(32.0);
    for (Channel* channel : {&x, &z, &sigma}) result.trace.channels.push_back(std::move(*channel));
  }
  return result;
}

int count_pixels(const Image& image, int red, int green, int blue) {
  int count = 0;
  for (std::size_t i = 0; i + 2 < image.pixels.size(); i += 3) {
    count += image.pixels[i] == red && image.pixels[i + 1] == green && image.pixels[i + 2] == blue;
  }
  return count;
}

TEST(TrackSummary, ListsEachStretchInWhichAMarkerWasLost) {
  const Rig rig = bench_with(MarkerKind::Cross);
  const std::vector<MarkerSummary> markers = summarize_markers(rig, tracked_bench(rig));
  ASSERT_EQ(markers.size(), 5U);
  const MarkerSummary& middle = markers[0];
  EXPECT_FALSE(middle.fixed);
  EXPECT_EQ(middle.frames_lost, 21);
  EXPECT_EQ(middle.frames_seen, kFrames - 21);
  ASSERT_EQ(middle.lost.size(), 2U);
  EXPECT_EQ(middle.lost[0].stretch.first_frame, kFirstLost);
  EXPECT_EQ(middle.lost[0].stretch.num_frames, kLastLost - kFirstLost + 1);
  EXPECT_DOUBLE_EQ(middle.lost[0].start_s, 100.0 / 240.0);
  EXPECT_DOUBLE_EQ(middle.lost[0].end_s, 119.0 / 240.0);
  EXPECT_EQ(middle.lost[0].stretch.reason, "hidden behind a hand");
  EXPECT_EQ(middle.lost[1].stretch.first_frame, 400U);
  EXPECT_EQ(middle.lost[1].start_s, middle.lost[1].end_s);
  EXPECT_TRUE(markers[1].fixed);
  EXPECT_TRUE(markers[1].lost.empty());
}

TEST(TrackSummary, CarriesSigmaAndNoiseFloorOn) {
  const Rig rig = bench_with(MarkerKind::Cross);
  TrackResult tracked = tracked_bench(rig);
  tracked.tracks[1].noise_floor_px = 0.0043;
  const std::vector<MarkerSummary> markers = summarize_markers(rig, tracked);
  EXPECT_EQ(markers[1].noise_floor_px, 0.0043);
  EXPECT_TRUE(std::isnan(markers[2].noise_floor_px)) << "a marker that was never seen to stand";
  for (const MarkerSummary& marker : markers) {
    EXPECT_NEAR(marker.sigma_px, kNoise_px, 1e-12) << marker.id;
    EXPECT_NEAR(marker.sigma_mm, kScale_mm * kNoise_px, 1e-12) << marker.id;
  }
}

TEST(TrackSummary, SaysHowFarAMarkerTravels) {
  const Rig rig = bench_with(MarkerKind::Cross);
  const std::vector<MarkerSummary> markers = summarize_markers(rig, tracked_bench(rig));
  // 8 px either way; the samples miss the crests by little, the noise adds some sigmas
  EXPECT_NEAR(markers[0].travel_mm, 16.0 * kScale_mm, 0.05);
  EXPECT_LT(markers[1].travel_mm, 10.0 * kNoise_px * kScale_mm);
}

TEST(TrackSummary, ResidualOfTheFixedMarkersIsTheirScatter) {
  const Rig rig = bench_with(MarkerKind::Cross);
  double squares = 0.0;
  const std::vector<double> residual = plane_residual_by_frame(rig, tracked_bench(rig));
  ASSERT_EQ(residual.size(), static_cast<std::size_t>(kFrames));
  for (const double value : residual) squares += value * value;
  // distance: two coordinates; 600 frames of four markers leave 1.5 %, three sigmas
  EXPECT_NEAR(std::sqrt(squares / kFrames), std::sqrt(2.0) * kNoise_px, 0.05 * kNoise_px);
  Rig two = rig;
  two.markers.resize(3);
  for (const double value : plane_residual_by_frame(two, tracked_bench(two))) {
    EXPECT_TRUE(std::isnan(value)) << "two fixed markers leave no residual";
  }
}

TEST(ContactSheet, IsAPageThatMarksLostStretches) {
  const Rig rig = bench_with(MarkerKind::Cross);
  TrackResult result = tracked_bench(rig);
  const Image with_loss = draw_contact_sheet(rig, "bench.mp4", result);
  EXPECT_EQ(with_loss.width_px, 1600);
  EXPECT_EQ(with_loss.height_px, 1130);
  EXPECT_EQ(with_loss.channels, 3);
  ASSERT_EQ(with_loss.pixels.size(), 1600U * 1130U * 3U);
  // 21 of 600 frames of two plots 480 px wide and a row high; less the curves and grid over them
  EXPECT_GT(count_pixels(with_loss, 248, 208, 204), 1500);

  const Rig steady = bench_with(MarkerKind::Cross);
  TrackResult without = tracked_bench(steady);
  without.tracks[0].lost.clear();
  EXPECT_EQ(count_pixels(draw_contact_sheet(steady, "bench.mp4", without), 248, 208, 204), 0);
}

TEST(ContactSheet, HoldsManyMarkersFewFramesAndForeignLetters) {
  Rig rig = bench_with(MarkerKind::Dot);
  rig.name = "Prüfkörper, 28 Punkte";
  for (int i = 0; i < 60; ++i) {
    Marker marker = rig.markers[1];
    marker.id = "row " + std::to_string(i);
    rig.markers.push_back(marker);
  }
  const Image many = draw_contact_sheet(rig, "viele.mp4", tracked_bench(rig));
  EXPECT_EQ(many.pixels.size(), 1600U * 1130U * 3U);

  Rig one = bench_with(MarkerKind::Dot);
  one.markers.resize(1);
  TrackResult still = tracked_bench(one);
  still.trace.time_s.resize(1);
  for (Channel& channel : still.trace.channels) channel.values.resize(1);
  still.tracks[0].position_px.resize(1);
  still.tracks[0].sigma_px.resize(1);
  still.tracks[0].lost.clear();
  EXPECT_EQ(draw_contact_sheet(one, "still.mp4", still).pixels.size(), 1600U * 1130U * 3U);
}

TEST(SheetTicks, AreRoundNumbersThatReachFarEnough) {
  EXPECT_DOUBLE_EQ(detail::tick_step(1.0, 4), 0.2);
  EXPECT_DOUBLE_EQ(detail::tick_step(25.0, 3), 5.0);
  EXPECT_DOUBLE_EQ(detail::tick_step(0.4, 3), 0.1);
  for (const double range : {1e-6, 0.03, 0.7, 1.0, 9.99, 480.0}) {
    const double step = detail::tick_step(range, 3);
    EXPECT_GE(range / step, 3.0 - 1e-9) << range;
    EXPECT_LE(range / step, 3.0 * 2.5 + 1e-9) << range;
  }
  EXPECT_EQ(detail::ticks_between(-0.25, 0.4, 0.2).size(), 4U);  // -0.2, 0, 0.2, 0.4
  EXPECT_EQ(detail::tick_text(0.30000000000000004, 0.1), "0.3");
  EXPECT_EQ(detail::tick_text(-1e-18, 0.1), "0.0");
  EXPECT_EQ(detail::tick_text(20.0, 5.0), "20");
}

}  // namespace
}  // namespace twang::test
