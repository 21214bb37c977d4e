// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/align_marker.hpp"

#include "capture/fit_marker.hpp"
#include "core/error.hpp"
#include "tests/capture/synthetic_marker.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace twang::test {
namespace {

constexpr int kSide_px = 60;
constexpr double kNoise = 2.0;  // grey levels
// A turn at which no edge runs along the pixels: what painting by samples does best.
constexpr double kTurn_rad = 0.1;

PaintedMarker painted(MarkerKind kind,
                      double size_px,
                      Eigen::Vector2d position_px = {29.37, 30.21}) {
  PaintedMarker marker;
  marker.pattern = MarkerPattern(kind);
  marker.position_px = position_px;
  marker.px_from_pattern = upright_marker(position_px, size_px, kTurn_rad).px_from_pattern;
  return marker;
}

Image picture(const PaintedMarker& marker) { return paint(marker, kSide_px, kSide_px, 1); }

MarkerPlacement placement_of(const PaintedMarker& marker) {
  return {marker.position_px, marker.px_from_pattern, marker.motion_px};
}

/// Starts a little beside the truth.
MarkerAlignment align(const Image& image, const PaintedMarker& marker, double blur_px = 0.0) {
  const double size_px = std::sqrt(marker.px_from_pattern.determinant());
  MarkerPlacement start = placement_of(marker);
  start.position_px += 0.04 * size_px * Eigen::Vector2d(1.0, -0.7);
  AlignOptions options;
  options.fit_motion = marker.motion_px.norm() > 0.0;
  start.motion_px *= 0.7;
  return align_marker(
      luma_view(image), MarkerTemplate(marker.pattern, size_px, blur_px), start, options);
}

Eigen::Vector2d error_of(const MarkerAlignment& found, const PaintedMarker& marker) {
  return found.placement.position_px - marker.position_px;
}

class EveryKind : public ::testing::TestWithParam<MarkerKind> {};

TEST_P(EveryKind, IsFoundWithoutBiasAtAnyShift) {
  for (const double size_px : {9.5, 30.0}) {
    for (int k = 0; k < 4; ++k) {
      const PaintedMarker marker = painted(GetParam(), size_px, {29.0 + 0.27 * k, 30.0 - 0.19 * k});
      const MarkerAlignment found = align(picture(marker), marker);
      ASSERT_TRUE(found.converged);
      // Grey levels are whole numbers; the painter has eight samples along a pixel.
      EXPECT_LT(error_of(found, marker).cwiseAbs().maxCoeff(), 0.01) << size_px << " px, " << k;
      EXPECT_GT(found.score, 0.999);
    }
  }
}

TEST_P(EveryKind, ScattersAsItsSigmaSays) {
  for (const double size_px : {9.5, 36.0}) {
    const PaintedMarker marker = painted(GetParam(), size_px);
    const Image clean = picture(marker);
    // About where it is found without noise: the painter's own few thousandths are no scatter.
    const Eigen::Vector2d offset = error_of(align(clean, marker), marker);
    double square = 0.0;
    double in_sigmas = 0.0;
    constexpr int kDraws = 20;
    for (unsigned seed = 1; seed <= kDraws; ++seed) {
      const MarkerAlignment found = align(with_noise(clean, kNoise, seed), marker);
      ASSERT_TRUE(found.converged);
      const double error = 0.5 * (error_of(found, marker) - offset).squaredNorm();
      square += error / kDraws;
      in_sigmas += error / std::pow(found.sigma_px, 2) / kDraws;
    }
    // The target for markers of 30 to 40 px; small ones reach it too without compression.
    EXPECT_LT(std::sqrt(square), 0.02) << size_px;
    // 40 coordinates: a chi-square of 1 ± 0.22 if the sigma is exact; three of these.
    EXPECT_LT(in_sigmas, 1.67) << size_px;
    EXPECT_GT(in_sigmas, 0.33) << size_px;
  }
}

TEST_P(EveryKind, MotionBlurDoesNotBiasAndItsLengthIsFound) {
  PaintedMarker marker = painted(GetParam(), 30.0);
  marker.background = 200.0;  // what the blur drags over the paper's edge is no part of this
  marker.motion_px = {3.6, 4.8};
  const MarkerAlignment found = align(picture(marker), marker);
  ASSERT_TRUE(found.converged);
  // The paper's edges, dragged into the rim, are not alike on both sides.
  EXPECT_LT(error_of(found, marker).cwiseAbs().maxCoeff(), 0.02);
  EXPECT_NEAR(found.placement.motion_px.norm(), 6.0, 0.3);
  EXPECT_GT(found.score, 0.995);
}

TEST_P(EveryKind, FitFindsSizeSlantAndDefocus) {
  PaintedMarker marker = painted(GetParam(), 24.0);
  marker.px_from_pattern.col(0) *= 0.92;  // seen from the side
  marker.blur_px = 0.8;
  const Image image = picture(marker);
  const FittedMarker fitted = fit_marker(
      luma_view(image), MarkerPattern(GetParam()), upright_marker(marker.position_px, 27.0), 10.0);
  ASSERT_TRUE(fitted.alignment.converged);
  EXPECT_LT(error_of(fitted.alignment, marker).norm(), 0.02);
  // The painter's kernel is five samples of a Gaussian: its tails are missing.
  EXPECT_NEAR(placed_size_px(fitted.alignment.placement), 24.0 * std::sqrt(0.92), 0.2);
  EXPECT_GT(fitted.marker.blur_px(), 0.5);
  EXPECT_LT(fitted.marker.blur_px(), 1.1);
}

TEST_P(EveryKind, SlopingLightOnThePaperDoesNotBias) {
  PaintedMarker marker = painted(GetParam(), 30.0);
  marker.shading = 0.3;
  EXPECT_LT(error_of(align(picture(marker), marker), marker).norm(), 0.01);
}

INSTANTIATE_TEST_SUITE_P(
    AlignMarker,
    EveryKind,
    ::testing::Values(MarkerKind::Cross, MarkerKind::Dot, MarkerKind::Ring, MarkerKind::Checker),
    [](const auto& kind) { return std::string(to_string(kind.param)); });

TEST(AlignMarker, BackgroundBeyondThePaperHasNoInfluence) {
  PaintedMarker marker = painted(MarkerKind::Cross, 28.0);
  const MarkerAlignment before = align(picture(marker), marker);
  marker.background = 10.0;
  const MarkerAlignment after = align(picture(marker), marker);
  EXPECT_EQ(before.placement.position_px, after.placement.position_px);
}

TEST(AlignMarker, LightAndContrastHaveNoInfluence) {
  PaintedMarker marker = painted(MarkerKind::Cross, 28.0);
  const MarkerAlignment bright = align(picture(marker), marker);
  marker.paper = 120.0;
  marker.ink = 50.0;
  const MarkerAlignment dim = align(picture(marker), marker);
  EXPECT_NEAR(dim.contrast, 70.0, 1.0);
  EXPECT_NEAR(dim.light[0], 50.0, 1.0);
  // Rounding to whole grey levels, a third as fine.
  EXPECT_LT((dim.placement.position_px - bright.placement.position_px).norm(), 0.005);
}

TEST(AlignMarker, LightOfAnotherPictureToStartFromHasNoInfluence) {
  PaintedMarker marker = painted(MarkerKind::Cross, 28.0);
  AlignOptions options;
  options.light = align(picture(marker), marker).light;
  marker.paper = 150.0;  // the lamp flickers by more than any does
  const Image dimmer = picture(marker);
  const MarkerTemplate drawn(marker.pattern, 28.0, 0.0);
  for (const double beside_px : {0.0, 0.008, 0.3}) {
    MarkerPlacement start = placement_of(marker);
    start.position_px.x() += beside_px;
    const MarkerAlignment from_light = align_marker(luma_view(dimmer), drawn, start, options);
    const MarkerAlignment found = align_marker(luma_view(dimmer), drawn, start);
    ASSERT_TRUE(from_light.converged);
    EXPECT_NEAR(from_light.contrast, found.contrast, 0.1);
    EXPECT_NEAR(from_light.light[0], found.light[0], 0.1);
    // Each stops at a step below a hundredth of a pixel, of which a few per cent are left.
    EXPECT_LT((from_light.placement.position_px - found.placement.position_px).norm(), 5e-4);
  }
}

TEST(MarkerFitter, FitsMarkersThatShareADrawingAsEachAlone) {
  std::vector<PaintedMarker> markers;
  for (int k = 0; k < 6; ++k) {
    const MarkerKind kind = k % 2 == 0 ? MarkerKind::Cross : MarkerKind::Dot;
    markers.push_back(painted(kind, 30.0 + 0.05 * k, {29.0 + 0.31 * k, 31.0 - 0.17 * k}));
    markers.back().blur_px = 0.5 + 0.12 * k;
  }
  Image scene{kSide_px * 6, kSide_px, 1, std::vector<std::uint8_t>(6 * kSide_px * kSide_px)};
  for (int k = 0; k < 6; ++k) {
    const Image one = picture(markers[static_cast<std::size_t>(k)]);
    for (int y = 0; y < kSide_px; ++y) {
      std::copy_n(one.pixels.begin() + y * kSide_px,
                  kSide_px,
                  scene.pixels.begin() + (y * 6 + k) * kSide_px);
    }
  }
  const LumaFrame frame = luma_view(scene);
  MarkerFitter fitter(frame);
  for (int k = 0; k < 6; ++k) {
    const PaintedMarker& marker = markers[static_cast<std::size_t>(k)];
    const Eigen::Vector2d at = marker.position_px + Eigen::Vector2d(k * kSide_px, 0.0);
    const MarkerPlacement start = upright_marker(at, 31.0);
    const FittedMarker shared = fitter.fit(marker.pattern, start, 10.0);
    const FittedMarker alone = fit_marker(frame, marker.pattern, start, 10.0);
    ASSERT_TRUE(shared.alignment.converged);
    EXPECT_LT((shared.alignment.placement.position_px - at).norm(), 0.01);
    EXPECT_LT(
        (shared.alignment.placement.position_px - alone.alignment.placement.position_px).norm(),
        2e-3);
    // A drawing serves sizes within half a per cent; blurs are found to a twentieth of a pixel.
    EXPECT_NEAR(
        placed_size_px(shared.alignment.placement), placed_size_px(alone.alignment.placement), 0.1);
    EXPECT_NEAR(shared.marker.blur_px(), alone.marker.blur_px(), 0.051);
  }
}

TEST(AlignMarker, TurnIsAnticlockwiseAsSeen) {
  const PaintedMarker marker = painted(MarkerKind::Cross, 30.0);
  const Image image = picture(marker);
  const MarkerAlignment found =
      align_marker(luma_view(image),
                   MarkerTemplate(MarkerPattern(MarkerKind::Cross), 30.0, 0.0),
                   upright_marker(marker.position_px, 30.0, kTurn_rad - 0.07));
  ASSERT_TRUE(found.converged);
  EXPECT_NEAR(found.turn_rad, 0.07, 1e-3);
  // In a picture whose y points down, the pattern's right arm points up.
  EXPECT_LT(found.placement.px_from_pattern(1, 0), 0.0);
}

TEST(AlignMarker, RoundMarkerIsNeverTurned) {
  const PaintedMarker marker = painted(MarkerKind::Dot, 20.0);
  const MarkerAlignment found = align(picture(marker), marker);
  EXPECT_EQ(found.turn_rad, 0.0);
  EXPECT_EQ(found.placement.px_from_pattern, marker.px_from_pattern);
}

TEST(AlignMarker, ScoreTellsAnotherPattern) {
  const PaintedMarker dot = painted(MarkerKind::Dot, 30.0);
  const Image image = picture(dot);
  const MarkerAlignment found =
      align_marker(luma_view(image),
                   MarkerTemplate(MarkerPattern(MarkerKind::Checker), 30.0, 0.0),
                   placement_of(dot));
  EXPECT_TRUE(!found.converged || found.score < 0.7);
}

TEST(AlignMarker, WhiteOnBlackScoresNegative) {
  PaintedMarker marker = painted(MarkerKind::Cross, 30.0);
  std::swap(marker.ink, marker.paper);
  const MarkerAlignment found = align(picture(marker), marker);
  EXPECT_LT(found.score, -0.9);
}

TEST(AlignMarker, GivesUpWhereTheMarkerLeavesThePicture) {
  const PaintedMarker marker = painted(MarkerKind::Dot, 30.0, {8.0, 30.0});
  EXPECT_FALSE(align(picture(marker), marker).converged);
}

TEST(AlignMarker, GivesUpOnAFlatPicture) {
  const Image flat{kSide_px, kSide_px, 1, std::vector<std::uint8_t>(kSide_px * kSide_px, 128)};
  const MarkerAlignment found =
      align_marker(luma_view(flat),
                   MarkerTemplate(MarkerPattern(MarkerKind::Dot), 20.0, 0.0),
                   upright_marker({30.0, 30.0}, 20.0));
  EXPECT_FALSE(found.converged);
}

TEST(AlignMarker, StaysWithinItsLeash) {
  const PaintedMarker marker = painted(MarkerKind::Dot, 20.0);
  const Image image = picture(marker);
  MarkerPlacement start = placement_of(marker);
  start.position_px.x() += 4.0;
  AlignOptions options;
  options.farthest_px = 2.0;
  EXPECT_FALSE(align_marker(luma_view(image),
                            MarkerTemplate(MarkerPattern(MarkerKind::Dot), 20.0, 0.0),
                            start,
                            options)
                   .converged);
}

TEST(MarkerTemplate, GradientIsTheDerivativeOfTheValue) {
  const MarkerTemplate marker(MarkerPattern(MarkerKind::Ring), 25.0, 1.0);
  constexpr double kStep = 0.01;  // a quarter of a pixel, two samples
  for (const auto& [u, v] : {std::pair{0.3, 0.4}, {-0.24, 0.02}, {0.1, -0.5}}) {
    const auto at = marker.at(u, v);
    // The samples are an eighth of a pixel apart and bilinear between: a few per cent of the slope.
    EXPECT_NEAR(
        at.du, (marker.at(u + kStep, v).value - marker.at(u - kStep, v).value) / (2 * kStep), 0.3);
    EXPECT_NEAR(
        at.dv, (marker.at(u, v + kStep).value - marker.at(u, v - kStep).value) / (2 * kStep), 0.3);
  }
}

}  // namespace
}  // namespace twang::test
