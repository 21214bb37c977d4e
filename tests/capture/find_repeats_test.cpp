// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/find_repeats.hpp"

#include "capture/detail/coded_size.hpp"
#include "capture/detail/find_cadence.hpp"
#include "capture/detail/local_fit.hpp"
#include "core/constants.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <utility>
#include <vector>

namespace twang::test {
namespace {

using detail::Likeness;

constexpr int kFrames = 200;
constexpr double kNoise_px = 0.02;
// Pictures whose markers moved by less look alike in a film without noise.
constexpr double kSeen_px = 0.25;

/// What a camera saw of a path: frame n shows the moment `shown(n)`.
struct Filmed {
  std::vector<MarkerTrack> tracks;
  std::vector<Likeness> likeness;
  std::vector<bool> repeats;
};

Filmed film(const std::function<double(int)>& path_px,
            const std::function<int(int)>& shown,
            unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> error(0.0, kNoise_px);
  Filmed filmed;
  MarkerTrack still{"still", {}, {}, 0, "", {}, 0.0};
  MarkerTrack moving{"moving", {}, {}, 0, "", {}, 0.0};
  for (int n = 0; n < kFrames; ++n) {
    const double now = path_px(shown(n));
    const double before = path_px(shown(std::max(0, n - 1)));
    still.position_px.emplace_back(20.0 + error(random), 30.0 + error(random));
    moving.position_px.emplace_back(90.0 + error(random), 50.0 + now + error(random));
    filmed.repeats.push_back(n > 0 && shown(n) == shown(n - 1));
    filmed.likeness.push_back(n > 0 && std::abs(now - before) < kSeen_px ? Likeness::Alike
                                                                         : Likeness::Different);
  }
  for (MarkerTrack* track : {&still, &moving}) {
    track->sigma_px.assign(kFrames, kNoise_px);
    filmed.tracks.push_back(std::move(*track));
  }
  return filmed;
}

/// A free vibration after a release at a frame, filmed at 240 frames/s.
std::function<double(int)> vibration(double frequency_hz, int release, double phase = 0.0) {
  return [=](int n) {
    const double t = std::max(0, n - release) / 240.0;
    return 20.0 * std::exp(-4.0 * t) * std::cos(kTwoPi * frequency_hz * t + phase);
  };
}

int as_filmed(int n) { return n; }

long num_alike(const Filmed& filmed) {
  return std::count(filmed.likeness.begin(), filmed.likeness.end(), Likeness::Alike);
}

long num_found(const Filmed& filmed) {
  const std::vector<bool> found = detail::find_repeats(filmed.tracks, filmed.likeness);
  return std::count(found.begin(), found.end(), true);
}

/// None is found that is none; found is each that hides motion twice as large as can be seen.
void expect_found(const Filmed& filmed, const std::function<double(int)>& hidden_px) {
  const std::vector<bool> found = detail::find_repeats(filmed.tracks, filmed.likeness);
  int sure = 0;
  // At the very end too little follows to tell a repeat from a symmetric frame beside it.
  for (int n = 0; n < kFrames - 8; ++n) {
    const auto i = static_cast<std::size_t>(n);
    if (!filmed.repeats[i]) {
      EXPECT_FALSE(found[i]) << n;
    } else if (std::abs(hidden_px(n)) > 2.0 * kSeen_px) {
      EXPECT_TRUE(found[i]) << n;
      ++sure;
    }
  }
  EXPECT_GT(sure, 3);
}

TEST(FindRepeats, FrameSymmetricAboutATurningPointIsNone) {
  // Eleven frames are three periods: frames beside turning points come again and again.
  for (const double phase : {0.0, 0.4, 0.857}) {
    const Filmed filmed = film(vibration(65.4545, 0, phase), as_filmed);
    EXPECT_GT(num_alike(filmed), 3) << phase;
    EXPECT_EQ(num_found(filmed), 0) << phase;
  }
}

TEST(FindRepeats, RepeatThatTookAFramesPlaceIsFoundAmongSymmetricFrames) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    std::mt19937 random(seed);
    std::bernoulli_distribution repeats(0.05);
    std::vector<int> shown(kFrames, 0);
    for (std::size_t n = 1; n < shown.size(); ++n) {
      shown[n] = repeats(random) ? shown[n - 1] : static_cast<int>(n);
    }
    const auto path = vibration(52.0 + 6.7 * seed, 0, 0.3);
    const auto shown_at = [&](int n) { return shown[static_cast<std::size_t>(n)]; };
    SCOPED_TRACE(seed);
    expect_found(film(path, shown_at, seed), [&](int n) { return path(n) - path(shown_at(n)); });
  }
}

TEST(FindRepeats, RepeatRightAfterTheReleaseIsFound) {
  for (const int repeat : {33, 34, 36}) {
    const auto path = vibration(30.0, 30);
    const auto shown = [&](int n) { return n == repeat ? n - 1 : n; };
    const Filmed filmed = film(path, shown);
    const std::vector<bool> found = detail::find_repeats(filmed.tracks, filmed.likeness);
    EXPECT_TRUE(found[static_cast<std::size_t>(repeat)]) << repeat;
    EXPECT_EQ(std::count(found.begin(), found.end(), true), 1) << repeat;
  }
}

TEST(FindRepeats, EveryFifthPutInBetweenIsFound) {
  // 24 pictures a second made 30.
  const auto shown = [](int n) { return n - n / 5; };
  for (const double frequency_hz : {31.0, 65.47}) {
    const auto path = vibration(frequency_hz, 0, 0.5);
    SCOPED_TRACE(frequency_hz);
    expect_found(film(path, shown), [&](int n) { return path(shown(n) + 1) - path(shown(n)); });
  }
}

TEST(FindRepeats, PicturesShownTwiceOrThriceAreFound) {
  for (const int times : {2, 3}) {
    const auto shown = [=](int n) { return n / times; };
    const auto path = vibration(31.0, 0, 0.5);
    SCOPED_TRACE(times);
    expect_found(film(path, shown), [&](int n) { return path(shown(n) + 1) - path(shown(n)); });
  }
}

TEST(FindRepeats, StillPartBeforeTheReleaseRepeatsNothing) {
  for (const int release : {3, 25, 31, 60}) {
    const Filmed filmed = film(vibration(40.0, release), as_filmed);
    EXPECT_GE(num_alike(filmed), release - 1);
    EXPECT_EQ(num_found(filmed), 0) << release;
  }
}

TEST(FindRepeats, WhatThePictureSaysNeedsNoMotion) {
  Filmed filmed = film([](int) { return 0.0; }, as_filmed);
  filmed.likeness[40] = Likeness::Same;
  const std::vector<bool> found = detail::find_repeats(filmed.tracks, filmed.likeness);
  EXPECT_EQ(std::count(found.begin(), found.end(), true), 1);
  EXPECT_TRUE(found[40]);
}

TEST(FindRepeats, LostMarkersSayNothing) {
  Filmed filmed = film(vibration(40.0, 0), [](int n) { return n == 50 ? 49 : n; });
  EXPECT_EQ(num_found(filmed), 1);
  for (MarkerTrack& track : filmed.tracks) {
    for (std::size_t n = 45; n < 55; ++n) track.position_px[n].setConstant(kNaN);
  }
  EXPECT_EQ(num_found(filmed), 0);
}

TEST(FindRepeats, RippleOfTheLightTellsARepeatWhereNothingMoves) {
  // 100 Hz at 240 frames a second: twelve frames are five periods, two steps of twelve are null.
  Filmed filmed = film([](int) { return 0.0; }, as_filmed);
  for (const int repeat : {40, 90, 125}) {
    std::vector<double> light;
    for (int n = 0; n < kFrames; ++n) {
      const int shown = n == repeat ? n - 1 : n;
      light.push_back(150.0 + 12.0 * std::sin(kTwoPi * 100.0 / 240.0 * shown + 0.9));
    }
    // Nothing moves: all pictures are alike.
    const std::vector<bool> found = detail::find_repeats(filmed.tracks, filmed.likeness, light);
    EXPECT_TRUE(found[static_cast<std::size_t>(repeat)]) << repeat;
    EXPECT_EQ(std::count(found.begin(), found.end(), true), 1) << repeat;
  }
}

TEST(FindRepeats, FramesAlikeInARhythmAreNoCadenceWhereMarkersMove) {
  // Six frames a period: of three steps one is twice as large as the two others.
  const auto path = [](int n) { return 0.42 * std::cos(kTwoPi / 6.0 * n); };
  Filmed filmed = film(path, as_filmed);
  for (std::size_t n = 1; n < filmed.likeness.size(); ++n) {
    filmed.likeness[n] = n % 3 == 2 ? Likeness::Different : Likeness::Alike;
  }
  EXPECT_EQ(num_found(filmed), 0);
}

TEST(FindRepeats, FourFramesAPeriodAreNoCadence) {
  // A little less than four: for half a second every other frame is like the one before.
  for (const double frequency_hz : {58.6, 59.0, 59.5}) {
    const Filmed filmed = film(vibration(frequency_hz, 20, 0.25 * kPi), as_filmed);
    EXPECT_GE(num_alike(filmed), 20) << frequency_hz;
    EXPECT_EQ(num_found(filmed), 0) << frequency_hz;
  }
}

TEST(FindCadence, IsOneOnlyIfTheFilmKeepsItWhereverAnythingMoves) {
  // Every other picture is like the one before, in a stretch or all along.
  for (const std::size_t last : {std::size_t{90}, std::size_t{kFrames}}) {
    std::vector<Likeness> likeness(kFrames, Likeness::Different);
    detail::Path path{{}, 0.015, 0.3, 0.3};
    for (std::size_t n = 0; n < kFrames; ++n) {
      const bool stands = n % 2 == 1 && n < last;
      if (stands) likeness[n] = Likeness::Alike;
      path.y.push_back(stands ? path.y.back() : 5.0 * std::sin(0.9 * static_cast<double>(n)));
    }
    const std::vector<bool> found = detail::find_cadence(likeness, {path});
    const long expected = last == kFrames ? kFrames / 2 : 0;
    EXPECT_NEAR(static_cast<double>(std::count(found.begin(), found.end(), true)),
                static_cast<double>(expected),
                last == kFrames ? 1.0 : 0.0);
  }
}

TEST(FindRepeats, RepeatOfTheLastHeldFrameIsFound) {
  const auto shown = [](int n) { return n == 31 ? 30 : n; };
  const Filmed filmed = film(vibration(40.0, 30), shown);
  const std::vector<bool> found = detail::find_repeats(filmed.tracks, filmed.likeness);
  EXPECT_TRUE(found[31]);
  EXPECT_EQ(std::count(found.begin(), found.end(), true), 1);
}

TEST(FindRepeats, WhatACoderLeftStandingByLittleIsNone) {
  // Where the path creeps the coder keeps what was there: an eighth of a pixel is missing.
  const auto path = [](int n) { return 0.9 * std::sin(kTwoPi / 20.0 * n); };
  Filmed filmed = film(path, as_filmed);
  MarkerTrack& moving = filmed.tracks.back();
  constexpr std::size_t kLeft = 104;  // near a turning point
  const double step = std::abs(path(104) - path(103));
  ASSERT_GT(step, 5.0 * kNoise_px);
  ASSERT_LT(step, 0.3);
  moving.position_px[kLeft] = moving.position_px[kLeft - 1];
  filmed.likeness[kLeft] = Likeness::Alike;
  EXPECT_EQ(num_found(filmed), 0);
}

TEST(FindRepeats, OneThatHidesAQuarterOfAPixelIsFound) {
  const auto path = [](int n) { return 0.9 * std::sin(kTwoPi / 20.0 * n); };
  constexpr int kRepeat = 110;
  const Filmed filmed = film(path, [](int n) { return n == kRepeat ? n - 1 : n; });
  ASSERT_NEAR(std::abs(path(kRepeat) - path(kRepeat - 1)), 0.28, 0.01);
  EXPECT_TRUE(detail::find_repeats(filmed.tracks, filmed.likeness)[kRepeat]);
  EXPECT_EQ(num_found(filmed), 1);
}

TEST(FindRepeats, TwoInARowThatHideLittleEachAreFound) {
  const auto path = [](int n) { return 0.5 * std::sin(kTwoPi / 20.0 * n); };
  constexpr int kLast = 111;
  const Filmed filmed = film(path, [](int n) { return n == kLast - 1 || n == kLast ? 109 : n; });
  EXPECT_TRUE(detail::find_repeats(filmed.tracks, filmed.likeness)[kLast]);
}

TEST(FindRepeats, TwoPeriodsInFiveFramesAreNoRepeatsOfASlowerMotion) {
  // Two of five pictures are alike, and of the coder the markers there are off by more; the other
  // three fit a motion of five frames a period as well.
  const auto path = [](int n) { return 0.75 * std::sin((kTwoPi * 0.4 - 0.0025) * n + 2.2); };
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Filmed filmed = film(path, as_filmed, seed);
    for (std::size_t n = 1; n < kFrames; ++n) {
      const double step = path(static_cast<int>(n)) - path(static_cast<int>(n) - 1);
      if (std::abs(step) > 0.6) continue;
      filmed.likeness[n] = Likeness::Alike;
      filmed.tracks.back().position_px[n].y() -= 0.25 * step;
    }
    ASSERT_GT(num_alike(filmed), kFrames / 5);
    EXPECT_EQ(num_found(filmed), 0) << seed;
  }
}

TEST(FindRepeats, LampTellsOneFromTheFirstFrameOnAndClearsWhatItSeesChange) {
  // A lamp on 50 Hz mains; nothing moves in the film, or a marker is left where it was.
  const auto light = [](int n) { return 120.0 + 6.0 * std::sin(kTwoPi * 100.0 / 240.0 * n); };
  std::vector<double> lights;
  for (int n = 0; n < kFrames; ++n) lights.push_back(light(n == 1 ? 0 : n));
  const Filmed still = film([](int) { return 0.0; }, [](int n) { return n == 1 ? 0 : n; });
  const std::vector<bool> found = detail::find_repeats(still.tracks, still.likeness, lights);
  EXPECT_TRUE(found[1]);
  EXPECT_EQ(std::count(found.begin(), found.end(), true), 1);

  Filmed copied = film([](int n) { return 0.9 * std::sin(kTwoPi / 20.0 * n); }, as_filmed);
  copied.tracks.back().position_px[110] = copied.tracks.back().position_px[109];
  copied.likeness[110] = Likeness::Alike;
  EXPECT_EQ(num_found(copied), 1);
  lights[1] = light(1);
  const std::vector<bool> cleared = detail::find_repeats(copied.tracks, copied.likeness, lights);
  EXPECT_EQ(std::count(cleared.begin(), cleared.end(), true), 0);
}

TEST(LocalFit, OfSamplesOfOneMomentIsNone) {
  detail::Samples samples;
  samples.t.assign(20, 3.0);
  for (int i = 0; i < 20; ++i) samples.y.push_back(0.1 * i);
  EXPECT_FALSE(detail::best_fit(samples, 0.015, detail::LocalFit::kMostDropped));
}

TEST(FindRepeats, CodersWordTipsTheScalesButNotAlone) {
  // A step of a few errors of the tracking is missing.
  const auto path = [](int n) { return 0.35 * std::sin(kTwoPi / 20.0 * n); };
  const Filmed filmed = film(path, [](int n) { return n == 100 ? 99 : n; });
  const auto found_with = [&](double odds) {
    return detail::find_repeats(
        filmed.tracks, filmed.likeness, {}, std::vector<double>(kFrames, odds));
  };
  EXPECT_TRUE(found_with(5.0)[100]);
  const std::vector<bool> against = found_with(-3.0);
  EXPECT_EQ(std::count(against.begin(), against.end(), true), 0);
  const Filmed still = film([](int) { return 0.0; }, as_filmed);
  const auto in_still =
      detail::find_repeats(still.tracks, still.likeness, {}, std::vector<double>(kFrames, 5.0));
  EXPECT_EQ(std::count(in_still.begin(), in_still.end(), true), 0);
}

TEST(RepeatEvidence, ComesFromOneOfTwoCostingNextToNothing) {
  std::vector<detail::CodedPicture> coded;
  for (int n = 0; n < 60; ++n) coded.push_back({1000 + 10 * (n % 7), 'P'});
  coded[30].bytes = 60;
  const std::vector<double> evidence = detail::repeat_evidence(coded);
  EXPECT_GT(evidence[30], 3.0);
  EXPECT_GT(evidence[31], 3.0);  // which of two, and of which two, is not said
  EXPECT_LT(evidence[20], 0.0);
}

TEST(RepeatEvidence, IsNoneWhereTypesDifferOrCostsAreUnknown) {
  std::vector<detail::CodedPicture> coded;
  for (int n = 0; n < 60; ++n) {
    coded.push_back(n % 4 == 0 ? detail::CodedPicture{4000, 'P'} : detail::CodedPicture{300, 'B'});
  }
  for (const double odds : detail::repeat_evidence(coded)) EXPECT_LE(odds, 0.0);
  const std::vector<detail::CodedPicture> unknown(60);
  for (const double odds : detail::repeat_evidence(unknown)) EXPECT_EQ(odds, 0.0);
}

TEST(RepeatEvidence, IsLittleWhereACoderSpendsLittle) {
  const auto evidence_at_30 = [](long bytes, int blocks, char next = 'P') {
    std::vector<detail::CodedPicture> coded(60, {bytes, 'P', blocks});
    coded[30].bytes = bytes / 4;
    coded[31].as = next;
    return detail::repeat_evidence(coded)[30];
  };
  const double plenty = evidence_at_30(1000, 500);
  EXPECT_GT(plenty, 4.0);
  EXPECT_LT(evidence_at_30(48, 500), 0.6 * plenty);      // some bytes more or less are an accident
  EXPECT_LT(evidence_at_30(1000, 20000), plenty - 3.0);  // what moved by little is left out
  // Nothing refers to a picture before one that is coded by itself.
  EXPECT_LT(evidence_at_30(1000, 500, 'I'), -5.0);
}

}  // namespace
}  // namespace twang::test
