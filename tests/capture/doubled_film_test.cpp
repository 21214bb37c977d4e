// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/render_film.hpp"
#include "capture/track_markers.hpp"
#include "rigs/load_rig.hpp"
#include "tests/capture/filmed_strip.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <vector>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

// A repeat that hides less than this, four standard errors of a marker in a strongly compressed
// film, need not be found: it harms as little. One of a part that is still held hides nothing at
// all, and where compression took the noise away nothing in the film tells it. [px]
constexpr double kSeen_px = 0.3;

/// How the repeats of a film were told.
struct Score {
  int found = 0;
  int missed = 0;   // though motion or noise gave them away
  int hidden = 0;   // compressed, and nothing moved
  int falsely = 0;  // called so

  void add(const FilmTruth& truth, const TrackResult& result, bool noise_survives) {
    const Channel& observable = *result.trace.find("observable_mm");
    std::size_t shown = 0;
    for (std::size_t n = 0; n < truth.doubled.size(); ++n) {
      const bool called = std::isnan(observable.values[n]);
      if (!truth.doubled[n]) {
        shown = n;
        falsely += called ? 1 : 0;
        continue;
      }
      const double step_px = (truth.position_px[n][0] - truth.position_px[shown][0]).norm();
      if (called) {
        ++found;
      } else if (noise_survives || step_px > kSeen_px) {
        ++missed;
      } else {
        ++hidden;
      }
    }
  }
};

class DoubledFilm : public ::testing::Test {
 protected:
  static FilmOptions small_film() {
    FilmOptions options;
    options.width_px = 480;
    options.height_px = 270;
    options.duration_s = 0.4;
    options.doubled = 0.05;
    return options;
  }
  void film(Score& score, const FilmOptions& options, const StripMotion& motion, bool noise) {
    const fs::path path = m_folder.path() / "film.mkv";
    const Rig rig = strip_rig();
    const FilmTruth truth = render_film(
        rig, [&](double time_s) { return motion.state_at(rig, time_s); }, path, options);
    score.add(truth, track_markers(rig, path), noise);
  }
  void print(const Score& score) {
    RecordProperty("found", score.found);
    RecordProperty("missed", score.missed);
    RecordProperty("hidden", score.hidden);
    RecordProperty("falsely", score.falsely);
    std::printf("repeats: %d found, %d missed, %d hide too little, %d called falsely\n",
                score.found,
                score.missed,
                score.hidden,
                score.falsely);
  }
  TemporaryFolder m_folder;
};

TEST_F(DoubledFilm, NoiseTellsEveryRepeatOfALosslessFilm) {
  Score score;
  for (const unsigned seed : {1U, 2U}) {
    FilmOptions options = small_film();
    options.crf = 0;
    options.seed = seed;
    film(score, options, {.frequency_hz = 30.0 + 17.0 * seed}, true);
  }
  print(score);
  EXPECT_GT(score.found, 5);
  EXPECT_EQ(score.missed, 0);
  EXPECT_EQ(score.falsely, 0);
}

TEST_F(DoubledFilm, SlowMotionOfATenthOfAPixelAFrameIsEnough) {
  Score score;
  FilmOptions options = small_film();
  options.crf = 14;
  film(score, options, {.amplitude_m = 0.5e-3, .frequency_hz = 3.0, .decay_per_s = 1.0}, true);
  print(score);
  EXPECT_GT(score.found, 2);
  EXPECT_EQ(score.missed, 0);
  EXPECT_EQ(score.falsely, 0);
}

TEST_F(DoubledFilm, StrongCompressionBlurTiltShakeAndFlickerHideNone) {
  Score score;
  for (const unsigned seed : {1U, 2U}) {
    FilmOptions options = small_film();
    options.crf = 27;
    options.noise = 4.0;
    options.exposure = 0.5;
    options.tilt_deg = 8.0;
    options.shake_px = seed % 2 == 1 ? 1.0 : 0.0;
    options.flicker = 0.1;
    options.seed = seed;
    film(score, options, {.frequency_hz = 24.0 + 9.0 * seed, .decay_per_s = 4.0}, true);
  }
  print(score);
  EXPECT_GT(score.found, 4);
  EXPECT_EQ(score.missed, 0);
  EXPECT_EQ(score.falsely, 0);
}

TEST_F(DoubledFilm, SymmetricFramesOfACompressedFilmAreNotTakenForRepeats) {
  Score score;
  FilmOptions options = small_film();
  options.crf = 20;
  options.exposure = 0.25;
  // Three periods are eleven frames.
  film(score, options, {.frequency_hz = 65.47, .decay_per_s = 8.0}, false);
  print(score);
  EXPECT_GT(score.found, 1);
  EXPECT_EQ(score.missed, 0);
  EXPECT_EQ(score.falsely, 0);
}

TEST_F(DoubledFilm, SixFramesAPeriodAreNotTakenForACadence) {
  Score score;
  FilmOptions options = small_film();
  options.duration_s = 0.8;
  options.crf = 22;
  film(score, options, {}, false);
  print(score);
  EXPECT_GT(score.found, 4);
  EXPECT_EQ(score.missed, 0);
  EXPECT_EQ(score.falsely, 0);
}

TEST(SampleFilm, HasNoRepeats) {
  const fs::path root = TWANG_SOURCE_DIR;
  for (const char* name : {"strip", "lrig"}) {
    const Rig rig = load_rig(root / "rigs" / (std::string(name) + ".toml"), {.film = true});
    const TrackResult result =
        track_markers(rig, root / "videos_sample" / (std::string(name) + ".mp4"));
    EXPECT_EQ(result.time_base.doubled, 0) << name;
  }
}

}  // namespace
}  // namespace twang::test
