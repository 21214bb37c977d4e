// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/marker_pattern.hpp"

#include "core/constants.hpp"
#include "tests/support/expect_refusal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace twang::test {
namespace {

constexpr MarkerKind kDrawn[] = {
    MarkerKind::Cross, MarkerKind::Dot, MarkerKind::Ring, MarkerKind::Checker};

/// Mean of the pattern at the centres of n x n cells.
double brute_force_average(const MarkerPattern& pattern, double x, double y, double width, int n) {
  double sum = 0.0;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      sum += pattern.value(x + width * ((i + 0.5) / n - 0.5), y + width * ((j + 0.5) / n - 0.5));
    }
  }
  return sum / (n * n);
}

TEST(MarkerPattern, AreaAverageAgreesWithBruteForce) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-0.7, 0.7);
  std::uniform_real_distribution<double> size(0.02, 0.9);
  constexpr int kCells = 200;
  // Cells that an edge cuts are counted whole: at most one a row or column for each of the edges
  // (8 of a cross's in one direction, which partly cancel).
  constexpr double kTolerance = 4.0 / kCells;
  int mixed = 0;
  for (const MarkerKind kind : kDrawn) {
    for (int trial = 0; trial < 30; ++trial) {
      const double x = place(random);
      const double y = place(random);
      const double width = size(random);
      const double expected = brute_force_average(MarkerPattern(kind), x, y, width, kCells);
      EXPECT_NEAR(MarkerPattern(kind).averaged(x, y, width), expected, kTolerance)
          << to_string(kind) << " at " << x << ", " << y << " width " << width;
      mixed += expected > 0.01 && expected < 0.99;
    }
  }
  EXPECT_GT(mixed, 40);  // most of the squares do lie across an edge
}

TEST(MarkerPattern, WholeAreaIsTheClosedForm) {
  // Exact up to rounding.
  EXPECT_NEAR(MarkerPattern(MarkerKind::Cross).averaged(0, 0, 1), 1.0 - 5.0 / 9.0, 1e-12);
  EXPECT_NEAR(MarkerPattern(MarkerKind::Dot).averaged(0, 0, 1), 1.0 - kPi / 4.0, 1e-12);
  EXPECT_NEAR(MarkerPattern(MarkerKind::Ring).averaged(0, 0, 1), 1.0 - 3.0 * kPi / 16.0, 1e-12);
  EXPECT_NEAR(MarkerPattern(MarkerKind::Checker).averaged(0, 0, 1), 0.5, 1e-12);
}

TEST(MarkerPattern, QuadrantsOfADiskAddUp) {
  // A square with a corner anywhere in the disk: four of them tile the disk's square.
  const double x = 0.13;
  const double y = -0.21;
  double ink = 0.0;
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      ink += 1.0 - MarkerPattern(MarkerKind::Dot).averaged(x + sx, y + sy, 2.0);
    }
  }
  EXPECT_NEAR(4.0 * ink, kPi / 4.0, 1e-12);  // rounding
}

TEST(MarkerPattern, IsInkAndPaperWhereThePictureSaysSo) {
  EXPECT_EQ(MarkerPattern(MarkerKind::Cross).value(0.45, 0.1), 0.0);
  EXPECT_EQ(MarkerPattern(MarkerKind::Cross).value(0.45, 0.2), 1.0);
  EXPECT_EQ(MarkerPattern(MarkerKind::Ring).value(0.0, 0.2), 1.0);
  EXPECT_EQ(MarkerPattern(MarkerKind::Ring).value(0.0, 0.3), 0.0);
  EXPECT_EQ(MarkerPattern(MarkerKind::Checker).value(-0.2, -0.2), 0.0);  // upper left
  EXPECT_EQ(MarkerPattern(MarkerKind::Checker).value(0.2, -0.2), 1.0);   // upper right
  for (const MarkerKind kind : kDrawn) {
    EXPECT_EQ(MarkerPattern(kind).value(0.51, 0.0), 1.0);
    EXPECT_EQ(MarkerPattern(kind).averaged(0.8, 0.0, 0.5), 1.0);
  }
}

TEST(MarkerPattern, RepeatsAfterItsPeriodAndNotBefore) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  const auto differing = [&](MarkerKind kind, double angle) {
    int count = 0;
    for (int trial = 0; trial < 500; ++trial) {
      const double x = place(random);
      const double y = place(random);
      const double c = std::cos(angle);
      const double s = std::sin(angle);
      count += MarkerPattern(kind).value(x, y) !=
               MarkerPattern(kind).value(c * x - s * y, s * x + c * y);
    }
    return count;
  };
  for (const MarkerKind kind : {MarkerKind::Cross, MarkerKind::Checker}) {
    EXPECT_EQ(differing(kind, MarkerPattern(kind).rotational_period_rad()), 0);
    EXPECT_GT(differing(kind, MarkerPattern(kind).rotational_period_rad() / 2.0), 50);
  }
  for (const MarkerKind kind : {MarkerKind::Dot, MarkerKind::Ring}) {
    EXPECT_EQ(MarkerPattern(kind).rotational_period_rad(), 0.0);
    EXPECT_EQ(differing(kind, 0.7), 0);
  }
}

TEST(MarkerPattern, OfAMarkerIsThatOfItsKind) {
  Marker marker;
  marker.id = "tip";
  for (const MarkerKind kind : kDrawn) {
    marker.kind = kind;
    EXPECT_EQ(MarkerPattern(marker), MarkerPattern(kind));
    EXPECT_EQ(MarkerPattern(marker).kind(), kind);
    EXPECT_EQ(MarkerPattern(marker).num_cells(), 0);
  }
  EXPECT_NE(MarkerPattern(MarkerKind::Dot), MarkerPattern(MarkerKind::Ring));
}

TEST(MarkerPattern, KindAloneIsNotEnoughForATagOrAPatch) {
  for (const MarkerKind kind : {MarkerKind::ArUco, MarkerKind::AprilTag, MarkerKind::Patch}) {
    EXPECT_TRUE(
        holds(refusal_of([&] { (void)MarkerPattern(kind); }), std::string(to_string(kind))));
  }
}

MarkerPattern patch(const char* id) {
  Marker marker;
  marker.id = id;
  marker.kind = MarkerKind::Patch;
  return MarkerPattern(marker);
}

TEST(MarkerPattern, PatchIsATextureOfItsOwn) {
  EXPECT_EQ(patch("tip"), patch("tip"));
  EXPECT_NE(patch("tip"), patch("top"));
  double square = 0.0;
  double mean = 0.0;
  constexpr int kSide = 40;
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      const double value = patch("tip").value((i + 0.5) / kSide - 0.5, (j + 0.5) / kSide - 0.5);
      EXPECT_GE(value, 0.0);
      EXPECT_LE(value, 1.0);
      mean += value / (kSide * kSide);
      square += value * value / (kSide * kSide);
    }
  }
  // Six waves of an eighth: a variance of 6/128, or 0.22 of the way from ink to paper, less what is
  // cut.
  EXPECT_NEAR(std::sqrt(square - mean * mean), 0.217, 0.05);
  // The texture goes on over the paper's rim.
  EXPECT_NE(patch("tip").value(0.6, 0.0), patch("tip").value(0.7, 0.0));
}

TEST(MarkerPattern, PatchAveragesInClosedForm) {
  for (const double width : {0.03, 0.2, 0.7}) {
    // The mean at the centres of 60 x 60 cells errs by the square of a cell over the shortest wave.
    EXPECT_NEAR(patch("tip").averaged(0.11, -0.23, width),
                brute_force_average(patch("tip"), 0.11, -0.23, width, 60),
                1e-3)
        << width;
  }
}

}  // namespace
}  // namespace twang::test
