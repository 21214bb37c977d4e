// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/progress_line.hpp"

#include <gtest/gtest.h>

namespace twang::app {
namespace {

TEST(ProgressLine, SaysFilmRateAndTimeLeft) {
  EXPECT_EQ(
      progress_line("film 2 of 5", {"tracking", 300.0, 1200.0, "frames"}, 2.0),
      "film 2 of 5  tracking             [######..................]  25 %  150 frames/s  0:06 "
      "left");
  EXPECT_EQ(progress_line("", {"tracking", 1.0, 7322.0, "frames"}, 1.0),
            "tracking             [........................]   0 %  1 frames/s  2:02:01 left");
}

TEST(ProgressLine, CountsWhereTheEndIsNotKnown) {
  EXPECT_EQ(progress_line("", {"tracking", 90.0, 0.0, "frames"}, 3.0),
            "tracking             90 frames  30 frames/s");
}

TEST(ProgressLine, GivesNoRateOfWhatIsNotCountedOrHasJustBegun) {
  EXPECT_EQ(progress_line("", {"eigenmodes", 1.0, 2.0}, 60.0),
            "eigenmodes           [############............]  50 %");
  EXPECT_EQ(progress_line("", {"tracking", 12.0, 24.0, "frames"}, 0.1),
            "tracking             [############............]  50 %");
}

TEST(ProgressLine, StaysWithinItsBar) {
  // containers that count fewer pictures than they hold
  EXPECT_EQ(progress_line("", {"tracking", 30.0, 24.0, "frames"}, 1.0),
            "tracking             [########################] 100 %  30 frames/s");
}

}  // namespace
}  // namespace twang::app
