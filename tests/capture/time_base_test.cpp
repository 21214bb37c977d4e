// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/time_base.hpp"

#include "core/constants.hpp"
#include "tests/support/expect_refusal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace twang::test {
namespace {

constexpr double kTick = 1.0 / 15360.0;  // [s]
constexpr double kMillisecond = 1e-3;    // a Matroska file's tick [s]

/// Stamps of frames number `numbers` at a rate, rounded to ticks, from `start_s`.
std::vector<double> stamps_of(const std::vector<int>& numbers,
                              double fps,
                              double tick_s,
                              double start_s = 0.0) {
  std::vector<double> stamps;
  for (const int n : numbers) stamps.push_back(std::round((start_s + n / fps) / tick_s) * tick_s);
  return stamps;
}

std::vector<int> up_to(int count) {
  std::vector<int> numbers;
  for (int n = 0; n < count; ++n) numbers.push_back(n);
  return numbers;
}

TEST(TimeBase, RegularStampsBecomeFrameNumberOverRate) {
  const auto base =
      correct_time_base(stamps_of(up_to(360), 240.0, kMillisecond, 0.7), kMillisecond, 240.0, {});
  ASSERT_EQ(base.time_s.size(), 360U);
  for (int n = 0; n < 360; ++n) EXPECT_EQ(base.time_s[static_cast<std::size_t>(n)], n / 240.0);
  EXPECT_EQ(base.summary.file_fps, 240.0);
  EXPECT_EQ(base.summary.capture_fps, 240.0);
  EXPECT_EQ(base.summary.source, "container");
  EXPECT_EQ(base.summary.frames, 360);
  EXPECT_EQ(base.summary.gaps, 0);
}

TEST(TimeBase, AGapShiftsWhatFollows) {
  std::vector<int> numbers = {0, 1, 2, 3, 6, 7, 8, 10, 11};
  // Ticks that a frame is no whole number of: a stamp is not yet n / 240.
  const auto base =
      correct_time_base(stamps_of(numbers, 240.0, kMillisecond), kMillisecond, 240.0, {});
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    EXPECT_EQ(base.time_s[i], numbers[i] / 240.0);
  }
  EXPECT_EQ(base.summary.gaps, 3);
}

TEST(TimeBase, StatedRateOverrulesTheFile) {
  // Slow motion: filmed at 240 frames a second, stored to be shown at 30.
  const auto slow =
      correct_time_base(stamps_of(up_to(100), 30.0, kTick), kTick, 30.0, StatedRate{240.0, "rig"});
  for (int n = 0; n < 100; ++n) EXPECT_EQ(slow.time_s[static_cast<std::size_t>(n)], n / 240.0);
  EXPECT_EQ(slow.summary.file_fps, 30.0);
  EXPECT_EQ(slow.summary.capture_fps, 240.0);
  EXPECT_EQ(slow.summary.source, "rig");
  // A toy tower's film: 22.674 frames a second by the stopwatch in it, 30 by the container.
  const auto tower = correct_time_base(
      stamps_of(up_to(582), 30.0, kTick), kTick, 30.0, StatedRate{22.674, "--capture-fps"});
  EXPECT_DOUBLE_EQ(tower.time_s.back(), 581 / 22.674);
}

TEST(TimeBase, StatedRateScalesTheGapsToo) {
  const auto base = correct_time_base(
      stamps_of({0, 1, 4, 5}, 30.0, kTick), kTick, 30.0, StatedRate{240.0, "rig"});
  EXPECT_EQ(base.time_s, (std::vector<double>{0.0, 1 / 240.0, 4 / 240.0, 5 / 240.0}));
}

TEST(TimeBase, WrongDeclarationGivesWayToTheStamps) {
  // The file says 30, its stamps run at 29.5: after a second they are half a frame apart.
  const std::vector<double> stamps = stamps_of(up_to(90), 29.5, kTick);
  const auto base = correct_time_base(stamps, kTick, 30.0, {});
  EXPECT_EQ(base.summary.source, "stamps");
  // A line through 90 stamps, each rounded by up to half a tick.
  EXPECT_NEAR(base.summary.file_fps, 29.5, 1e-3);
  EXPECT_EQ(base.time_s, stamps);
}

TEST(TimeBase, VariableRateKeepsItsStamps) {
  std::vector<double> stamps;
  for (int n = 0; n < 200; ++n) stamps.push_back(5.0 + n / 30.0 + 0.008 * std::sin(0.31 * n));
  const auto base = correct_time_base(stamps, kTick, 30.0, {});
  EXPECT_EQ(base.summary.source, "stamps");
  for (std::size_t i = 0; i < stamps.size(); ++i) EXPECT_EQ(base.time_s[i], stamps[i] - 5.0);
  // The wobble of 8 ms hardly tilts a line of 6.6 s: below 0.008 / 6.6.
  EXPECT_NEAR(base.summary.file_fps, 30.0, 0.03);
  // A stated rate stretches them all alike.
  const auto slow = correct_time_base(stamps, kTick, 30.0, StatedRate{240.0, "rig"});
  const double stretch = base.summary.file_fps / 240.0;
  EXPECT_NEAR(slow.time_s[150], (stamps[150] - stamps[0]) * stretch, 1e-12);  // rounding
}

TEST(TimeBase, JitterBeyondATickIsKept) {
  std::vector<double> stamps = stamps_of(up_to(50), 240.0, kTick);
  for (std::size_t i = 1; i < stamps.size(); i += 2) stamps[i] += 3.0 * kTick;
  const auto base = correct_time_base(stamps, kTick, 240.0, {});
  EXPECT_EQ(base.summary.source, "stamps");
  EXPECT_EQ(base.time_s, stamps);
}

TEST(TimeBase, ARateThatTheDeclarationRoundsIsNotDriftedAlong) {
  // 240 declared, 239.76 stamped: 0.1 % is six ticks of 1 ms after the six seconds of the film.
  const auto base =
      correct_time_base(stamps_of(up_to(1440), 239.76, kMillisecond), kMillisecond, 240.0, {});
  EXPECT_EQ(base.summary.source, "stamps");
  // Rounding of 1440 stamps to 1 ms over 6 s: far below 1e-5.
  EXPECT_NEAR(base.summary.file_fps / 239.76, 1.0, 1e-5);
}

TEST(TimeBase, MissingStampsAreCountedAtTheRate) {
  const std::vector<double> none(5, kNaN);
  const auto declared = correct_time_base(none, kTick, 25.0, {});
  EXPECT_EQ(declared.time_s, (std::vector<double>{0.0, 0.04, 0.08, 0.12, 0.16}));
  EXPECT_EQ(declared.summary.source, "container");
  const auto stated = correct_time_base(none, kTick, {}, StatedRate{50.0, "tag"});
  EXPECT_EQ(stated.time_s, (std::vector<double>{0.0, 0.02, 0.04, 0.06, 0.08}));
  EXPECT_EQ(stated.summary.source, "tag");
  EXPECT_EQ(stated.summary.file_fps, 50.0);
}

TEST(TimeBase, AStampMissingHereAndThereIsFilledIn) {
  std::vector<double> stamps = stamps_of(up_to(10), 240.0, kTick);
  stamps[0] = stamps[4] = stamps[5] = stamps[9] = kNaN;
  const auto base = correct_time_base(stamps, kTick, 240.0, {});
  for (int n = 0; n < 10; ++n) EXPECT_EQ(base.time_s[static_cast<std::size_t>(n)], n / 240.0);
}

TEST(TimeBase, OneFrameStandsAtZero) {
  const auto base = correct_time_base({3.2}, kTick, 30.0, {});
  EXPECT_EQ(base.time_s, std::vector<double>{0.0});
}

TEST(TimeBase, RefusesStampsThatDoNotIncrease) {
  const auto equal = refusal_of([] { (void)correct_time_base({0.0, 0.1, 0.1}, kTick, 10.0, {}); });
  EXPECT_TRUE(holds(equal, "frame 3"));
  const auto back = refusal_of([] {
    (void)correct_time_base({0.0, 0.2, kNaN, 0.1}, 1e-3, {}, {});
  });
  EXPECT_TRUE(holds(back, "frame 4"));
}

TEST(TimeBase, RefusesAFilmWithoutAnyTime) {
  (void)refusal_of([] { (void)correct_time_base({kNaN, kNaN}, kTick, {}, {}); });
  (void)refusal_of([] { (void)correct_time_base({kNaN, kNaN}, kTick, 0.0, {}); });
  (void)refusal_of([] { (void)correct_time_base({}, kTick, 30.0, {}); });
  const auto rate = refusal_of([] {
    (void)correct_time_base({0.0, 0.1}, kTick, 10.0, StatedRate{-1.0, "rig"});
  });
  EXPECT_TRUE(holds(rate, "rig"));
}

}  // namespace
}  // namespace twang::test
