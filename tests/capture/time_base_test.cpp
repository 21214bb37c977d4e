// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/time_base.hpp"

#include "core/constants.hpp"
#include "tests/support/expect_refusal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
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

/// Whether one of the sentences about a time base holds a text.
::testing::AssertionResult says(const TimeBase& base, const std::string& part) {
  std::string all;
  for (const Note& note : describe_time_base(base.summary)) all += note.text + " ";
  return holds(all, part);
}

/// Every stamp is frame number over rate, to the arithmetic's rounding.
void expect_even(const TimeBase& base, const std::vector<int>& numbers, double fps) {
  ASSERT_EQ(base.time_s.size(), numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    ASSERT_NEAR(base.time_s[i], (numbers[i] - numbers[0]) / fps, 1e-9) << i;
  }
  EXPECT_TRUE(base.summary.even);
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
  ASSERT_EQ(base.time_s.size(), stamps.size());
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    EXPECT_NEAR(base.time_s[i], stamps[i], 0.6 * kTick);  // the file's rounding is taken out
    // A line through 90 stamps is off by far less than the half tick of each.
    EXPECT_NEAR(base.time_s[i], static_cast<double>(i) / 29.5, 0.2 * kTick);
  }
  EXPECT_TRUE(says(base, "The container declares 30 frames/s, its stamps say 29.5"));
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

// What telephones and cutting programs write.

TEST(TimeBase, DurationsOfTwoAndThreeTicksAreAnEvenClock) {
  // An iPhone's slow motion: ticks of 1/600 s, 240 frames a second, 2.5 ticks each.
  constexpr double kAppleTick = 1.0 / 600.0;
  for (const double start : {0.0, 1.0 / 1200.0, 0.7e-3}) {
    const auto base =
        correct_time_base(stamps_of(up_to(2000), 240.0, kAppleTick, start), kAppleTick, 240.0, {});
    expect_even(base, up_to(2000), 240.0);
    EXPECT_EQ(base.summary.kind, TimeBaseKind::Constant);
    EXPECT_EQ(base.summary.gaps, 0);
    EXPECT_GT(base.summary.jitter_s, 0.2 * kAppleTick);  // half the stamps lie on a tick,
    EXPECT_LT(base.summary.jitter_s, 0.4 * kAppleTick);  // half of them between two
  }
}

TEST(TimeBase, AnEvenClockIsFoundInCoarseTicksWithoutAndAgainstTheDeclaration) {
  constexpr double kAppleTick = 1.0 / 600.0;
  const auto stamps = stamps_of(up_to(2000), 240.0, kAppleTick);
  expect_even(correct_time_base(stamps, kAppleTick, {}, {}), up_to(2000), 240.0);
  // The declaration counts an edit list's cut as film.
  const auto base = correct_time_base(stamps, kAppleTick, 231.4, {});
  expect_even(base, up_to(2000), 240.0);
  EXPECT_EQ(base.summary.source, "stamps");
  EXPECT_TRUE(says(base, "declares 231.4 frames/s, its stamps say 240"));
}

TEST(TimeBase, FramesDroppedInCoarseTicksAreCounted) {
  constexpr double kAppleTick = 1.0 / 600.0;
  std::vector<int> numbers;
  for (int n = 0; n < 1000; ++n) {
    if (n != 100 && n != 101 && n != 500) numbers.push_back(n);
  }
  for (const std::optional<double> declared : {std::optional(240.0), std::optional<double>()}) {
    const auto base =
        correct_time_base(stamps_of(numbers, 240.0, kAppleTick), kAppleTick, declared, {});
    expect_even(base, numbers, 240.0);
    EXPECT_EQ(base.summary.gaps, 3);
    EXPECT_TRUE(says(base, "3 frames are missing"));
  }
}

TEST(TimeBase, CoarseTicksDoNotHideAnUnevenClock) {
  // Durations of 1 and 4 ticks: no rounding of an even clock makes them.
  std::vector<double> stamps;
  for (int n = 0; n < 200; ++n) stamps.push_back((5 * (n / 2) + n % 2) / 600.0);
  const auto base = correct_time_base(stamps, 1.0 / 600.0, 240.0, {});
  EXPECT_EQ(base.summary.kind, TimeBaseKind::Variable);
  EXPECT_EQ(base.time_s, stamps);
}

TEST(TimeBase, ACopyKeepsTheRoundingOfTheFileBefore) {
  // Stamps of a Matroska file, whole milliseconds, copied into an MP4 with ticks of 62.5 us.
  constexpr double kFineTick = 1.0 / 16000.0;
  std::vector<double> stamps = stamps_of(up_to(500), 240.0, kMillisecond, 0.033);
  const auto base = correct_time_base(stamps, kFineTick, 240.0, {});
  expect_even(base, up_to(500), 240.0);
  EXPECT_EQ(base.summary.tick_s, kMillisecond);
  // And those of an iPhone's film copied into a Matroska file.
  stamps = stamps_of(up_to(500), 240.0, 1.0 / 600.0);
  for (double& stamp : stamps) stamp = std::round(stamp * 90000.0) / 90000.0;
  expect_even(correct_time_base(stamps, 1.0 / 90000.0, 240.0, {}), up_to(500), 240.0);
}

TEST(TimeBase, MicrosecondsOfJitterAreKeptAndSaid) {
  // A telephone's time stamps of each exposure at 90 kHz, 30 us rms about 239.98 frames a second.
  constexpr double kFineTick = 1.0 / 90000.0;
  std::mt19937 random(3);
  std::normal_distribution<double> jitter(0.0, 30e-6);
  std::vector<double> stamps;
  for (int n = 0; n < 1500; ++n) {
    stamps.push_back(std::round((n / 239.98 + jitter(random)) / kFineTick) * kFineTick);
  }
  const auto base = correct_time_base(stamps, kFineTick, 239.96, {}, 240.0);
  EXPECT_EQ(base.summary.kind, TimeBaseKind::Variable);
  EXPECT_EQ(base.summary.source, "stamps");
  EXPECT_FALSE(base.summary.even);
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    EXPECT_NEAR(base.time_s[i], stamps[i] - stamps[0], 1e-12);  // not bent to the nominal tag
  }
  // 1500 frames of 30 us each: the rate to 1e-6, the rms to 2 % of itself (one sigma).
  EXPECT_NEAR(base.summary.file_fps, 239.98, 0.002);
  EXPECT_NEAR(base.summary.jitter_s, 30e-6, 2e-6);
  EXPECT_TRUE(says(base, "Variable rate: 1500 frames at 239.98 frames/s on average"));
}

TEST(TimeBase, LowLightMakesTheRateVariableAndDropsNothing) {
  // A telephone that exposes longer in the dark: 30 frames a second, then 24.
  std::vector<double> stamps;
  for (int n = 0; n < 100; ++n) stamps.push_back(n / 30.0);
  for (int n = 1; n < 60; ++n) stamps.push_back(99 / 30.0 + n / 24.0);
  const auto base = correct_time_base(stamps, kTick, 27.5, {}, 30.0);
  EXPECT_EQ(base.summary.kind, TimeBaseKind::Variable);
  EXPECT_EQ(base.summary.gaps, 0);
  EXPECT_EQ(base.time_s, stamps);
  EXPECT_TRUE(says(base, "The camera's tag says 30 frames/s"));
}

TEST(TimeBase, StampsOf240BeatADeclarationOf30) {
  const auto base = correct_time_base(stamps_of(up_to(700), 240.0, kTick), kTick, 30.0, {});
  expect_even(base, up_to(700), 240.0);
  EXPECT_EQ(base.summary.kind, TimeBaseKind::Constant);
  EXPECT_TRUE(says(base, "The container declares 30 frames/s, its stamps say 240"));
  // A tag of a time lapse that no film of this rate is.
  const auto tagged =
      correct_time_base(stamps_of(up_to(700), 240.0, kTick), kTick, 240.0, {}, 30.0);
  expect_even(tagged, up_to(700), 240.0);
  EXPECT_TRUE(says(tagged, "The camera's tag says 30 frames/s, the stamps say 240"));
}

TEST(TimeBase, ATagMakesSlowMotion) {
  const auto base = correct_time_base(stamps_of(up_to(300), 30.0, kTick), kTick, 30.0, {}, 240.0);
  expect_even(base, up_to(300), 240.0);
  EXPECT_EQ(base.summary.kind, TimeBaseKind::SlowMotion);
  EXPECT_EQ(base.summary.source, "tag");
  EXPECT_TRUE(says(base,
                   "Slow motion: 300 frames filmed at 240 frames/s (tag); the file plays "
                   "them at 30, 8 times slower."));
}

TEST(TimeBase, AStatedRateBeatsTheTagAndSaysSo) {
  const auto base = correct_time_base(
      stamps_of(up_to(300), 30.0, kTick), kTick, 30.0, StatedRate{240.0, "rig"}, 120.0);
  expect_even(base, up_to(300), 240.0);
  EXPECT_TRUE(says(base, "The camera's tag says 120 frames/s, the rig says 240: the rig was"));
}

TEST(TimeBase, SlowMotionOfVariableRateStretchesEveryStamp) {
  std::vector<double> stamps;
  for (int n = 0; n < 200; ++n) stamps.push_back(n / 30.0 + 0.004 * std::sin(0.7 * n));
  const auto base = correct_time_base(stamps, kTick, 30.0, {}, 240.0);
  EXPECT_EQ(base.summary.kind, TimeBaseKind::SlowMotion);
  EXPECT_FALSE(base.summary.even);
  const double stretch = base.summary.file_fps / 240.0;
  EXPECT_NEAR(base.time_s[150], stamps[150] * stretch, 1e-12);  // rounding
  EXPECT_TRUE(says(base, "times slower; the stamps are"));
}

TEST(TimeBase, TelevisionRatesAreNamed) {
  // In milliseconds, declared as 240: the stamps tell after a second.
  const double fps = 240.0 / 1.001;
  const auto base =
      correct_time_base(stamps_of(up_to(1440), fps, kMillisecond), kMillisecond, 240.0, {});
  expect_even(base, up_to(1440), fps);
  EXPECT_TRUE(says(base, "are 240 / 1.001, a television rate"));
  const auto slow = correct_time_base(
      stamps_of(up_to(600), 30.0 / 1.001, kTick), kTick, 30.0 / 1.001, StatedRate{240.0, "rig"});
  expect_even(slow, up_to(600), 240.0);
  EXPECT_TRUE(says(slow, "29.97 frames/s are 30 / 1.001"));
  EXPECT_TRUE(says(slow, "it filmed at 239.76 and not at 240"));
  const auto plain = correct_time_base(stamps_of(up_to(600), 240.0, kTick), kTick, 240.0, {});
  EXPECT_FALSE(says(plain, "television"));
}

TEST(TimeBase, AStatedRateNearTheStampsIsObeyedAndSaid) {
  const auto base = correct_time_base(
      stamps_of(up_to(600), 239.0, kTick), kTick, 239.0, StatedRate{240.0, "rig"});
  expect_even(base, up_to(600), 240.0);
  EXPECT_EQ(base.summary.kind, TimeBaseKind::Constant);
  EXPECT_TRUE(says(base, "The rig says 240 frames/s, the stamps 239, +0.42 %: the rig was"));
}

TEST(TimeBase, AFilmShownFasterThanFilmedIsFastMotion) {
  const auto base = correct_time_base(stamps_of(up_to(300), 30.0, kTick), kTick, 30.0, {}, 5.0);
  expect_even(base, up_to(300), 5.0);
  EXPECT_EQ(word_for(base.summary.kind), "fast motion");
  EXPECT_TRUE(says(base, "the file plays them at 30, 6 times faster"));
}

TEST(TimeBase, ThousandsOfFramesASecondFitMilliseconds) {
  const auto base =
      correct_time_base(stamps_of(up_to(3000), 960.0, kMillisecond), kMillisecond, 960.0, {});
  expect_even(base, up_to(3000), 960.0);
}

TEST(TimeBase, AGapIsSeenWhereAFrameIsATick) {
  // As AVI counts.
  const std::vector<int> numbers = {0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 13, 14};
  const auto base = correct_time_base(stamps_of(numbers, 240.0, 1 / 240.0), 1 / 240.0, 240.0, {});
  expect_even(base, numbers, 240.0);
  EXPECT_EQ(base.summary.gaps, 3);
}

TEST(TimeBase, ADeclarationOfFieldsIsHalved) {
  // H.264 copied into AVI: ticks and declared rate are those of fields, the last stamps are lost.
  std::vector<double> stamps;
  for (int n = 0; n < 100; ++n) stamps.push_back(n < 98 ? n / 240.0 : kNaN);
  const auto base = correct_time_base(stamps, 1 / 480.0, 480.0, StatedRate{240.0, "rig"});
  expect_even(base, up_to(100), 240.0);
  EXPECT_EQ(base.summary.file_fps, 240.0);
  EXPECT_EQ(base.summary.gaps, 0);
  EXPECT_EQ(base.summary.kind, TimeBaseKind::Constant);
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
