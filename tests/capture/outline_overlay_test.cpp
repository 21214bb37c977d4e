// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/outline_overlay.hpp"

#include "capture/video_writer.hpp"
#include "core/error.hpp"
#include "tests/capture/filmed_rig.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

namespace twang::test {
namespace {

constexpr int kGroundGrey = 60;  // grey of the film
constexpr int kInkedBy = 20;     // at the least, by a line of one pixel
constexpr int kLeftWithin = 6;   // a flat picture, compressed to be looked at
constexpr double kPerPx_m = 1e-4;
constexpr std::size_t kFramesOfGrey = 5;

/// A square with a square hole, in tenths of a millimetre: eight corners, four faces around.
BodyDrawing frame_of_a_window() {
  BodyDrawing body;
  body.faces = {{0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  Eigen::Matrix2Xf corners(2, 8);
  corners << 0, 60, 60, 0, 20, 40, 40, 20,  //
      0, 0, 60, 60, 20, 20, 40, 40;
  corners *= static_cast<float>(kPerPx_m);
  body.first_frame = 1;
  for (int n = 0; n < 3; ++n) {
    body.corners.push_back(corners);
    body.corners.back().row(0).array() += static_cast<float>(10.0 * n * kPerPx_m);
  }
  // a pixel is a tenth of a millimetre, the plane's origin at (50, 40) px
  body.map.plane_from_px = {Homography::Identity()};
  body.map.plane_from_px[0].topRows<2>() *= kPerPx_m;
  body.map.plane_from_px[0].topRightCorner<2, 1>() = kPerPx_m * Eigen::Vector2d(-50.0, -40.0);
  return body;
}

class OutlineOverlay : public ::testing::Test {
 protected:
  void SetUp() override {
    VideoWriter writer(m_film, 200, 140, {.fps = 30.0, .crf = 0});
    const Image grey{200, 140, 1, std::vector<std::uint8_t>(200 * 140, kGroundGrey)};
    for (std::size_t n = 0; n < kFramesOfGrey; ++n) writer.write(grey);
    writer.finish();
  }
  [[nodiscard]] std::vector<Image> drawn(const BodyDrawing& body) const {
    write_outline_overlay(m_film, m_overlay, body, 30.0);
    return read_film(m_overlay);
  }
  static int change(const Image& picture, int x, int y) {
    return std::abs(pixel_at(picture, x, y) - kGroundGrey);
  }

  TemporaryFolder m_folder;
  std::filesystem::path m_film = m_folder.path() / "film.mkv";
  std::filesystem::path m_overlay = m_folder.path() / "overlay.mkv";
};

TEST_F(OutlineOverlay, IsTheBorderOfAllFacesTogetherAndOfTheirHoles) {
  const std::vector<Image> pictures = drawn(frame_of_a_window());
  ASSERT_EQ(pictures.size(), 3U);
  for (int n = 0; n < 3; ++n) {
    const Image& picture = pictures[static_cast<std::size_t>(n)];
    const int x0 = 50 + 10 * n;
    // outside left and top, inside of the hole left
    EXPECT_GT(change(picture, x0, 70), kInkedBy) << n;
    EXPECT_GT(change(picture, x0 + 30, 40), kInkedBy) << n;
    EXPECT_GT(change(picture, x0 + 60, 70), kInkedBy) << n;
    EXPECT_GT(change(picture, x0 + 20, 70), kInkedBy) << n;
    // within a face, within the hole, far away, on the seam of two faces
    EXPECT_LT(change(picture, x0 + 10, 70), kLeftWithin) << n;
    EXPECT_LT(change(picture, x0 + 30, 70), kLeftWithin) << n;
    EXPECT_LT(change(picture, 195, 135), kLeftWithin) << n;
    EXPECT_LT(change(picture, x0 + 10, 50), kLeftWithin) << n;
  }
}

TEST_F(OutlineOverlay, FollowsTheMapOfEachFrame) {
  BodyDrawing body = frame_of_a_window();
  body.corners.resize(2, body.corners.front());
  body.corners[1] = body.corners[0];
  body.map.plane_from_px.resize(kFramesOfGrey, body.map.plane_from_px.front());
  body.map.plane_from_px[2](1, 2) -= 15.0 * kPerPx_m;  // that frame is the second drawn
  const std::vector<Image> pictures = drawn(body);
  ASSERT_EQ(pictures.size(), 2U);
  EXPECT_GT(change(pictures[0], 80, 40), kInkedBy);
  EXPECT_LT(change(pictures[1], 80, 40), kLeftWithin);
  EXPECT_GT(change(pictures[1], 80, 55), kInkedBy);
}

TEST_F(OutlineOverlay, OfMoreFramesThanTheFilmHasIsRefusedAndLeavesNoFile) {
  BodyDrawing body = frame_of_a_window();
  body.corners.resize(kFramesOfGrey, body.corners.front());
  EXPECT_THROW(write_outline_overlay(m_film, m_overlay, body, 30.0), InputError);
  EXPECT_FALSE(std::filesystem::exists(m_overlay));
}

TEST(PictureMap, TakesWhatIsInThePlaneToWhereALensOnOblongPixelsShowsIt) {
  PictureMap map;
  map.plane_from_px = {
      (Homography() << 1e-4, 2e-5, -0.03, -1e-5, 1.1e-4, -0.02, 1e-4, 2e-4, 1.0).finished()};
  map.pixel_aspect = 4.0 / 3.0;
  Lens lens;
  lens.width_px = 640;
  lens.height_px = 480;
  lens.focal_px = {600.0, 600.0};
  lens.centre_px = {320.0, 240.0};
  lens.coefficients[0] = -0.2;
  map.lens = lens;
  for (const Eigen::Vector2d& seen :
       {Eigen::Vector2d(100.0, 90.0), Eigen::Vector2d(500.0, 400.0)}) {
    Eigen::Vector2d straight = lens.undistorted(seen);
    straight.x() *= map.pixel_aspect;
    const Eigen::Vector2d plane = map_point(map.plane_from_px.front(), straight);
    EXPECT_LT((map.seen_at(7, plane) - seen).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace twang::test
