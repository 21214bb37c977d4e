// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/track_markers.hpp"
#include "core/error.hpp"
#include "core/trace_file.hpp"
#include "rigs/load_rig.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/real_recordings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

// The film's edit list takes its first three pictures away; the reference counts them.
constexpr std::size_t kCutAway = 3;
// The reference was taken at twice the film's scale.
constexpr double kReferenceScale = 2.0;

class RealFilm : public ::testing::Test {
 protected:
  void SetUp() override {
    m_folder = real_recordings() / "knex_tower";
    if (!fs::exists(m_folder / "tower.mp4")) {
      GTEST_SKIP() << "the real recordings are not beside the checkout";
    }
  }
  [[nodiscard]] fs::path film() const { return m_folder / "tower.mp4"; }
  static Rig rig() {
    return load_rig(fs::path(TWANG_SOURCE_DIR) / "rigs" / "knex_tower.toml", {.film = true});
  }
  /// One dot in the middle of each of four rows of seven that look alike.
  static TrackOptions middle_column() {
    TrackOptions options;
    options.start_px = {{"top", {312.0, 227.0}},
                        {"storey_2", {314.0, 466.0}},
                        {"storey_1", {318.0, 707.0}},
                        {"base", {320.0, 955.0}}};
    return options;
  }
  fs::path m_folder;
};

/// rms difference of a track from the reference, means removed [px of the film].
double difference_px(const MarkerTrack& track, const Channel& reference) {
  double sum = 0.0;
  double square = 0.0;
  double count = 0.0;
  for (std::size_t n = 0; n < track.position_px.size(); ++n) {
    const double difference =
        track.position_px[n].x() - reference.values[n + kCutAway] / kReferenceScale;
    if (!std::isfinite(difference)) continue;
    sum += difference;
    square += difference * difference;
    count += 1.0;
  }
  EXPECT_GT(count, 500.0);
  return std::sqrt(square / count - std::pow(sum / count, 2));
}

TEST_F(RealFilm, TracksAgreeWithAnIndependentTracker) {
  const TrackResult result = track_markers(rig(), film(), middle_column());
  const Trace reference = read_trace_csv(m_folder / "tower_rows_px.csv", "t_s");
  ASSERT_EQ(result.tracks.size(), 4U);
  // 0.05, 0.04 and 0.08 px where last measured; the reference is the mean of a row of seven.
  EXPECT_LT(difference_px(result.tracks[0], *reference.find("base_dx_px")), 0.15);
  EXPECT_LT(difference_px(result.tracks[1], *reference.find("storey1_dx_px")), 0.15);
  EXPECT_LT(difference_px(result.tracks[2], *reference.find("storey2_dx_px")), 0.15);
  // In the jump of a release two dots of a row may both be the one: then it is left out.
  for (std::size_t i = 0; i < 3; ++i) EXPECT_LE(result.tracks[i].frames_lost, 2);
}

TEST_F(RealFilm, TopIsNeverMistakenForItsNeighbours) {
  const TrackResult result = track_markers(rig(), film(), middle_column());
  const MarkerTrack& top = result.tracks[3];
  const MarkerTrack& below = result.tracks[2];
  // The tower bends in one shape: the top moves 1.41 times as far as the storey below. The next
  // dots are 80 px away.
  for (std::size_t n = 0; n < top.position_px.size(); ++n) {
    const double expected =
        top.position_px[0].x() + 1.41 * (below.position_px[n].x() - below.position_px[0].x());
    if (top.position_px[n].allFinite() && std::isfinite(expected)) {
      EXPECT_NEAR(top.position_px[n].x(), expected, 6.0) << n;
    }
  }
  // It jumps by up to 75 px between frames; now and then two dots are within its reach.
  EXPECT_LT(top.frames_lost, 20);
}

TEST_F(RealFilm, AskedWithoutStartsItSaysThatRowsAreAlike) {
  EXPECT_TRUE(holds(refusal_of([&] { static_cast<void>(track_markers(rig(), film())); }),
                    "could be one of"));
}

}  // namespace
}  // namespace twang::test
