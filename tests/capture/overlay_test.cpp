// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/overlay.hpp"

#include "capture/video_writer.hpp"
#include "core/constants.hpp"
#include "tests/capture/filmed_rig.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

namespace twang::test {
namespace {

constexpr int kGrey = 60;
constexpr int kSize_px = 24;  // of the marker
// An overlay is compressed to be looked at; flat grey comes back within this.
constexpr int kRounding = 4;

/// A grey film with one marker at (60, 70) that is lost in frames 2 and 3 and then at (100, 40);
/// frame 4 is repeated.
class Overlay : public ::testing::TestWithParam<int> {  // width of the film
 protected:
  void SetUp() override {
    const int width = GetParam();
    VideoWriter writer(film(), width, 121, {.fps = 30.0, .crf = 0});
    const Image grey{
        width, 121, 1, std::vector<std::uint8_t>(static_cast<std::size_t>(width) * 121, kGrey)};
    for (int n = 0; n < 5; ++n) writer.write(grey);
    writer.finish();
    const Eigen::Vector2d lost = Eigen::Vector2d::Constant(kNaN);
    const Eigen::Vector2d first(60.0, 70.0);
    m_drawing.tracks = {MarkerTrack{}};
    m_drawing.tracks[0].id += 'm';
    m_drawing.tracks[0].position_px = {first, first, lost, lost, {100.0, 40.0}};
    m_drawing.tracks[0].frames_lost = 2;
    m_drawing.tracks[0].lost_because.append("hidden");
    m_drawing.size_px = {kSize_px};
    m_drawing.doubled = {false, false, false, false, true};
    write_overlay(film(), m_folder.path() / "overlay.mkv", m_drawing, 30.0);
    m_drawn = read_film(m_folder.path() / "overlay.mkv");
  }
  [[nodiscard]] std::filesystem::path film() const { return m_folder.path() / "film.mkv"; }
  [[nodiscard]] bool is_drawn_at(std::size_t frame, int x, int y) const {
    return std::abs(pixel_at(m_drawn[frame], x, y) - kGrey) > kRounding;
  }

  TemporaryFolder m_folder;
  TrackDrawing m_drawing;
  std::vector<Image> m_drawn;
};

TEST_P(Overlay, ShowsACrosshairOnTheMarkerAndLeavesTheRestAlone) {
  ASSERT_EQ(m_drawn.size(), 5U);
  EXPECT_TRUE(is_drawn_at(0, 60, 70));
  EXPECT_TRUE(is_drawn_at(0, 60 - kSize_px / 2, 70));
  EXPECT_TRUE(is_drawn_at(0, 60, 70 + kSize_px / 2));
  EXPECT_FALSE(is_drawn_at(0, 100, 40));
  EXPECT_FALSE(is_drawn_at(0, 20, 100));
  EXPECT_FALSE(is_drawn_at(0, 0, 0));
}

TEST_P(Overlay, ShowsALostMarkerLostWhereItWasSeenLast) {
  for (const std::size_t frame : {2U, 3U}) {
    // Crossed out from corner to corner within a ring.
    EXPECT_TRUE(is_drawn_at(frame, 60 + 6, 70 + 6)) << frame;
    EXPECT_TRUE(is_drawn_at(frame, 60 - 18, 70)) << frame;
    EXPECT_FALSE(is_drawn_at(frame, 60, 70 + kSize_px / 2)) << frame;
  }
  EXPECT_TRUE(is_drawn_at(4, 100, 40));
  EXPECT_FALSE(is_drawn_at(4, 60 + 6, 70 + 6));
}

TEST_P(Overlay, FramesARepeat) {
  EXPECT_TRUE(is_drawn_at(4, 1, 60));
  EXPECT_TRUE(is_drawn_at(4, GetParam() - 2, 60));
  EXPECT_FALSE(is_drawn_at(3, 1, 60));
}

// H.264 pairs pixels: the overlay of an odd film is one larger.
INSTANTIATE_TEST_SUITE_P(Widths, Overlay, ::testing::Values(160, 161));

}  // namespace
}  // namespace twang::test
