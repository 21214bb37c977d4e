// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/track_markers.hpp"
#include "core/error.hpp"
#include "tests/capture/filmed_crossing.hpp"
#include "tests/capture/filmed_strip.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

/// Films whose markers are not all in plain view all the time.
class LateMarkers : public ::testing::Test {
 protected:
  FilmTruth film(const Rig& rig, const StripMotion& motion = {}, double duration_s = 0.25) {
    FilmOptions options;
    options.width_px = 480;
    options.height_px = 270;
    options.duration_s = duration_s;
    return render_film(
        rig, [&](double time_s) { return motion.state_at(rig, time_s); }, plain(), options);
  }
  [[nodiscard]] fs::path plain() const { return m_folder.path() / "plain.mkv"; }
  [[nodiscard]] fs::path changed() const { return m_folder.path() / "changed.mkv"; }
  static bool told(const TrackResult& result, const std::string& sentence) {
    return std::any_of(result.notes.begin(), result.notes.end(), [&](const Note& note) {
      return holds(note.text, sentence);
    });
  }
  TemporaryFolder m_folder;
};

/// Grey of a hand in front of the rig.
constexpr int kHand = 110;
constexpr std::size_t kHandLeaves = 16;  // four frames after the release

TEST_F(LateMarkers, HandOverTheTipUntilAfterTheReleaseHidesItAndNothingElse) {
  for (const unsigned pass : {0U, 1U}) {
    const Rig rig = strip_rig();
    StripMotion motion;
    motion.frequency_hz = pass == 0 ? 40.0 : 23.0;
    const FilmTruth truth = film(rig, motion);
    change_film(plain(), changed(), [&](std::size_t n, Image& image) {
      if (n < kHandLeaves) paint_box(image, truth.position_px[0][0], 40, kHand);
    });
    const TrackResult result = track_markers(rig, changed());
    const Fidelity tip = fidelity(
        result.tracks[0], truth.position_px, 0, [](std::size_t n) { return n >= kHandLeaves; });
    EXPECT_EQ(tip.wrong, 0) << "at worst " << tip.worst_px;
    EXPECT_LE(tip.missed, 2);
    for (std::size_t n = 0; n < kHandLeaves; ++n) {
      EXPECT_FALSE(result.tracks[0].position_px[n].allFinite()) << n;
      EXPECT_TRUE(std::isnan(result.trace.find("observable_mm")->values[n])) << n;
    }
    for (std::size_t i = 1; i < rig.markers.size(); ++i) {
      EXPECT_EQ(result.tracks[i].frames_lost, 0) << rig.markers[i].id;
    }
    ASSERT_FALSE(result.tracks[0].lost.empty());
    EXPECT_EQ(result.tracks[0].lost[0].first_frame, 0U);
    EXPECT_TRUE(result.tracks[0].lost[0].found_again);
    EXPECT_TRUE(told(result, "Marker 'tip' was first seen in frame 1"));
  }
}

TEST_F(LateMarkers, HandThatDrawsAwaySlowlyIsNeverTakenForTheMarker) {
  // A rim of the hand with a dark spot the size of the marker passes the tip.
  const Rig rig = strip_rig();
  const FilmTruth truth = film(rig);
  change_film(plain(), changed(), [&](std::size_t n, Image& image) {
    const double away = std::max(0.0, 2.0 * (static_cast<double>(n) - 8.0));
    if (n >= 40) return;
    const Eigen::Vector2d hand = truth.position_px[0][0] + Eigen::Vector2d(away, away);
    paint_box(image, hand, 30, kHand);
    paint_box(image, hand - Eigen::Vector2d(18.0, 18.0), 9, 40);
    paint_box(image, hand - Eigen::Vector2d(18.0, 18.0), 3, 190);
  });
  const TrackResult result = track_markers(rig, changed());
  const Fidelity tip =
      fidelity(result.tracks[0], truth.position_px, 0, [](std::size_t n) { return n >= 40; });
  EXPECT_EQ(tip.wrong, 0) << "at worst " << tip.worst_px;
  EXPECT_LE(tip.missed, 1);
}

TEST_F(LateMarkers, FramesBeforeThePictureIsThereAreLeftOut) {
  constexpr std::size_t kBlack = 10;
  constexpr std::size_t kSharp = 16;
  const Rig rig = strip_rig();
  const FilmTruth truth = film(rig);
  change_film(plain(), changed(), [&](std::size_t n, Image& image) {
    if (n < kBlack) std::fill(image.pixels.begin(), image.pixels.end(), std::uint8_t{16});
    if (n < kBlack || n >= kSharp) return;
    // Out of focus: a mean over 25 pixels, along both axes.
    for (const int step : {1, image.width_px}) {
      const std::vector<std::uint8_t> sharp = image.pixels;
      const auto size = static_cast<int>(sharp.size());
      for (int k = 0; k < size; ++k) {
        int sum = 0;
        for (int d = -12; d <= 12; ++d) {
          sum += sharp[static_cast<std::size_t>(std::clamp(k + d * step, 0, size - 1))];
        }
        image.pixels[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(sum / 25);
      }
    }
  });
  const TrackResult result = track_markers(rig, changed());
  EXPECT_EQ(result.layout_frame, kSharp);
  ASSERT_EQ(result.trace.num_samples(), truth.time_s.size());
  for (std::size_t i = 0; i < rig.markers.size(); ++i) {
    const Fidelity got =
        fidelity(result.tracks[i], truth.position_px, i, [](std::size_t n) { return n >= kSharp; });
    EXPECT_EQ(got.wrong, 0) << rig.markers[i].id;
    EXPECT_EQ(got.missed, 0) << rig.markers[i].id;
    EXPECT_EQ(result.tracks[i].frames_lost, static_cast<int>(kSharp));
  }
  // The picture of the report is the one with the layout in it, not the black one.
  EXPECT_GT(*std::max_element(result.first_frame.pixels.begin(), result.first_frame.pixels.end()),
            180);
}

TEST_F(LateMarkers, MarkerThatIsNeverSeenIsNamed) {
  Rig filmed = strip_rig();
  filmed.markers.erase(filmed.markers.begin());
  film(filmed, {}, 0.05);
  const std::string message =
      refusal_of([&] { static_cast<void>(track_markers(strip_rig(), plain())); });
  EXPECT_TRUE(holds(message, "marker 'tip' was not found in any of 12 frames")) << message;
}

TEST_F(LateMarkers, MarkerThatIsNeverSeenNorNeededIsAColumnOfNanWithAWarning) {
  Rig rig = strip_rig();
  film(rig);
  const TrackResult without = track_markers(rig, plain());
  Marker middle = rig.markers[0];
  middle.id = "middle";
  middle.position.x() = 40e-3;
  rig.markers.insert(rig.markers.begin() + 1, middle);
  Marker fifth = rig.markers[2];
  fifth.id = "bench_5";
  fifth.position.x() = 40e-3;
  rig.markers.push_back(fifth);
  const TrackResult result = track_markers(rig, plain());
  for (const char* id : {"middle", "bench_5"}) {
    for (const char* column : {".x_mm", ".z_mm", ".sigma_mm"}) {
      const Channel* channel = result.trace.find(std::string(id) + column);
      ASSERT_NE(channel, nullptr) << id << column;
      EXPECT_TRUE(std::all_of(channel->values.begin(),
                              channel->values.end(),
                              [](double value) { return std::isnan(value); }))
          << id << column;
    }
    EXPECT_EQ(std::count_if(result.notes.begin(),
                            result.notes.end(),
                            [&](const Note& note) {
                              return note.severity == Severity::Warning &&
                                     holds(note.text,
                                           std::string("Marker '") + id +
                                               "' was not found in any of 60 frames: its columns "
                                               "are nan");
                            }),
              1);
    EXPECT_FALSE(told(result, std::string("Marker '") + id + "' was lost"));
  }
  EXPECT_TRUE(told(result, "come from 4 fixed markers instead of 5"));
  // All else is as if they were not in the rig.
  const auto& a = without.trace.find("observable_mm")->values;
  const auto& b = result.trace.find("observable_mm")->values;
  for (std::size_t n = 0; n < a.size(); ++n) EXPECT_NEAR(a[n], b[n], 1e-9) << n;  // rounding
}

TEST_F(LateMarkers, UnusableFilmIsRefusedWithItsBestFrame) {
  // Two of five markers are there, and in frames 20 to 24 alone.
  const Rig rig = strip_rig();
  const FilmTruth truth = film(rig, {}, 0.2);
  change_film(plain(), changed(), [&](std::size_t n, Image& image) {
    for (std::size_t i = 0; i < 5; ++i) {
      if (i < 3 || n < 20 || n > 24) paint_box(image, truth.position_px[0][i], 34, kHand);
    }
  });
  const std::string message = refusal_of([&] { static_cast<void>(track_markers(rig, changed())); });
  EXPECT_TRUE(holds(message, "was not found in frame 2")) << message;
  EXPECT_TRUE(holds(message, "with 2 of 5 markers")) << message;
}

TEST_F(LateMarkers, SearchForTheFirstUsableFrameCanBeInterrupted) {
  {
    VideoWriter writer(plain(), 320, 180, {.fps = 30.0});
    const Image grey{320, 180, 1, std::vector<std::uint8_t>(320 * 180, 120)};
    for (int n = 0; n < 200; ++n) writer.write(grey);
    writer.finish();
  }
  int asked = 0;
  TrackOptions options;
  options.progress = [&](const Progress&) { return ++asked < 50; };
  EXPECT_THROW(static_cast<void>(track_markers(strip_rig(), plain(), options)), Cancelled);
  EXPECT_EQ(asked, 50);
}

/// A marker that swings out of the picture below its lower edge, and back.
class LeavingMarker : public LateMarkers, public ::testing::WithParamInterface<Swing> {};

TEST_P(LeavingMarker, IsLostOutsideAndFoundWhenItReturns) {
  Rig rig;
  rig.name = "bench";
  rig.camera = Camera{};
  rig.markers = {dot("tip", 5.0, 0.0, false),
                 dot("bench_1", -30.0, 24.0, true),
                 dot("bench_2", 31.0, 26.0, true),
                 dot("bench_3", -28.0, 2.0, true),
                 dot("bench_4", 33.0, 0.0, true)};
  const Eigen::Vector2d reach = 1e-3 * GetParam().amplitude_mm;
  rig.release = Release{{5e-3, 0.0, 0.0}, Eigen::Vector3d(reach.x(), 0.0, reach.y()), std::nullopt};
  FilmOptions options;
  options.width_px = 360;
  options.height_px = 300;
  options.duration_s = 0.5;
  const FilmTruth truth = render_film(
      rig, [&](double time_s) { return swinging(rig, {GetParam()}, time_s); }, plain(), options);
  const double px_per_mm = 1.0 / truth.mm_per_px;
  // Rest lies this far above the edge, and the amplitude is larger.
  const int height = 2 * static_cast<int>(0.5 * (truth.position_px[0][3].y() + 9.0 * px_per_mm));
  change_film(plain(), changed(), [&](std::size_t, Image& image) {
    image.height_px = height;
    image.pixels.resize(static_cast<std::size_t>(height * image.width_px));
  });
  const TrackResult result = track_markers(rig, changed());
  const double half_px = 0.5 * 4.0 * px_per_mm;
  int outside = 0;
  const Fidelity tip = fidelity(result.tracks[0], truth.position_px, 0, [&](std::size_t n) {
    const double y = truth.position_px[n][0].y();
    outside += y > height ? 1 : 0;
    return y < height - 1.6 * half_px;  // with its rim of paper
  });
  EXPECT_GT(outside, 8);
  EXPECT_EQ(tip.wrong, 0) << "at worst " << tip.worst_px;
  EXPECT_GE(tip.found(), 0.95) << tip.missed << " of " << tip.due;
  bool left = false;
  for (const LostStretch& stretch : result.tracks[0].lost) {
    left |= stretch.reason == "it left the picture";
  }
  EXPECT_TRUE(left) << result.tracks[0].lost_because;
}

INSTANTIATE_TEST_SUITE_P(Swings,
                         LeavingMarker,
                         ::testing::Values(Swing{{2.0, 18.0}, 5.0, 1.0, 0.02, 0.0},
                                           Swing{{-3.0, 20.0}, 9.0, 2.0, 0.0, 0.5},
                                           Swing{{0.0, 22.0}, 14.0, 2.0, 0.05, 0.0}),
                         [](const auto& tested) {
                           return "At" + std::to_string(int(tested.param.frequency_hz)) + "Hz";
                         });

}  // namespace
}  // namespace twang::test
