// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/find_tags.hpp"

#include "capture/fit_marker.hpp"
#include "core/constants.hpp"
#include "tests/capture/synthetic_marker.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace twang::test {
namespace {

MarkerPattern tag(MarkerKind kind, const std::string& dictionary, int number) {
  Marker marker;
  marker.id = "tag";
  marker.kind = kind;
  marker.dictionary = dictionary;
  marker.tag = number;
  return MarkerPattern(marker);
}

/// A tag in a picture of 60 x 60 pixels with a little defocus and noise.
struct Painted {
  PaintedMarker marker;
  Image image;
};

Painted paint_tag(const MarkerPattern& pattern, double size_px, double turn_rad) {
  constexpr int kSide_px = 60;
  Painted painted;
  painted.marker.pattern = pattern;
  painted.marker.position_px = {29.3, 30.8};
  painted.marker.px_from_pattern =
      upright_marker(painted.marker.position_px, size_px, turn_rad).px_from_pattern;
  painted.marker.px_from_pattern.row(0) *= 0.9;  // seen from the side
  painted.marker.blur_px = 0.6;
  painted.marker.noise = 2.0;
  painted.image = paint(painted.marker, kSide_px, kSide_px, 1);
  return painted;
}

TEST(FindTags, FindsTagsOfEverySortInAnyTurn) {
  double turn_rad = 0.2;
  for (const MarkerPattern& pattern : {tag(MarkerKind::ArUco, "DICT_4X4_50", 7),
                                       tag(MarkerKind::ArUco, "DICT_5X5_1000", 901),
                                       tag(MarkerKind::ArUco, "DICT_6X6_250", 23),
                                       tag(MarkerKind::ArUco, "DICT_7X7_1000", 999),
                                       tag(MarkerKind::ArUco, "DICT_ARUCO_ORIGINAL", 77),
                                       tag(MarkerKind::AprilTag, "tag16h5", 3),
                                       tag(MarkerKind::AprilTag, "tag25h9", 34),
                                       tag(MarkerKind::AprilTag, "tag36h10", 2000),
                                       tag(MarkerKind::AprilTag, "tag36h11", 586)}) {
    turn_rad += 0.7;
    const Painted painted = paint_tag(pattern, 18.0, turn_rad);
    const auto found =
        detail::find_tags(luma_view(painted.image), {MarkerPattern(MarkerKind::Dot), pattern});
    ASSERT_EQ(found.size(), 1U) << turn_rad;
    EXPECT_EQ(found[0].pattern, 1U);
    const MarkerPlacement& placement = found[0].placement;
    // Its corners are found to a few tenths of a pixel.
    EXPECT_LT((placement.position_px - painted.marker.position_px).norm(), 0.3) << turn_rad;
    // The turn included: a quarter turn would make this 1.4.
    EXPECT_LT((placement.px_from_pattern - painted.marker.px_from_pattern).norm() /
                  painted.marker.px_from_pattern.norm(),
              0.08)
        << turn_rad;
  }
}

TEST(FindTags, FindsTagsTurnedByExactlyQuarters) {
  for (const MarkerPattern& pattern :
       {tag(MarkerKind::ArUco, "DICT_4X4_50", 7), tag(MarkerKind::AprilTag, "tag36h11", 17)}) {
    for (int quarter = 0; quarter < 4; ++quarter) {
      const Painted painted = paint_tag(pattern, 26.0, 0.5 * kPi * quarter);
      const auto found = detail::find_tags(luma_view(painted.image), {pattern});
      ASSERT_EQ(found.size(), 1U) << quarter;
      const Eigen::Matrix2d& truth = painted.marker.px_from_pattern;
      EXPECT_LT((found[0].placement.px_from_pattern - truth).norm() / truth.norm(), 0.08);
      // The alignment that follows keeps the turn and finds the place.
      const FittedMarker fitted =
          fit_marker(luma_view(painted.image), pattern, found[0].placement, 5.0);
      ASSERT_TRUE(fitted.alignment.converged) << quarter;
      const MarkerPlacement& placement = fitted.alignment.placement;
      EXPECT_LT((placement.position_px - painted.marker.position_px).norm(), 0.03) << quarter;
      EXPECT_LT((placement.px_from_pattern - truth).norm() / truth.norm(), 0.02) << quarter;
      EXPECT_GT(fitted.alignment.score, 0.98) << quarter;
    }
  }
}

TEST(FindTags, PassesOverTagsThatAreNotSought) {
  for (int number = 0; number < 6; ++number) {
    const Painted painted =
        paint_tag(tag(MarkerKind::ArUco, "DICT_4X4_50", number), 30.0, 0.3 * number);
    std::vector<MarkerPattern> others;
    for (int other = 0; other < 50; ++other) {
      if (other != number) others.push_back(tag(MarkerKind::ArUco, "DICT_4X4_50", other));
    }
    EXPECT_TRUE(detail::find_tags(luma_view(painted.image), others).empty()) << number;
  }
}

TEST(FindTags, LooksForNothingWhereNothingIsSought) {
  const Painted painted = paint_tag(tag(MarkerKind::ArUco, "DICT_4X4_50", 0), 30.0, 0.0);
  EXPECT_TRUE(detail::find_tags(luma_view(painted.image), {}).empty());
  EXPECT_TRUE(
      detail::find_tags(luma_view(painted.image), {MarkerPattern(MarkerKind::Ring)}).empty());
  const Image tiny{3, 3, 1, std::vector<std::uint8_t>(9, 100)};
  EXPECT_TRUE(
      detail::find_tags(luma_view(tiny), {tag(MarkerKind::ArUco, "DICT_4X4_50", 0)}).empty());
}

}  // namespace
}  // namespace twang::test
