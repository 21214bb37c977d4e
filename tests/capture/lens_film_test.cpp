// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/lens.hpp"
#include "capture/render_film.hpp"
#include "capture/track_markers.hpp"
#include "core/units.hpp"
#include "tests/capture/filmed_strip.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBarrel =
    "%YAML:1.0\n---\nimage_width: 1280\nimage_height: 720\n"
    "camera_matrix: [1280, 0, 640, 0, 1280, 352, 0, 0, 1]\n"
    "distortion_coefficients: [-0.2, 0.02, 0.001, -0.0005, 0.0]\n";

class BentFilm : public ::testing::Test {
 protected:
  FilmOptions options() const {
    FilmOptions film;
    film.duration_s = 0.25;
    film.exposure = 0.0;
    film.crf = 0;
    return film;
  }
  /// rms of the tip's position in the plane against the truth, over the film [mm].
  double error_mm(const TrackResult& result,
                  const FilmTruth& truth,
                  const StripMotion& motion,
                  bool at_row_time) const {
    const Channel& x = *result.trace.find("tip.x_mm");
    const Channel& z = *result.trace.find("tip.z_mm");
    const Channel* offset = result.trace.find("tip.time_offset_s");
    double square = 0.0;
    double count = 0.0;
    for (std::size_t n = 0; n < x.values.size(); ++n) {
      if (!std::isfinite(x.values[n])) continue;
      const double time_s = truth.time_s[n] + (at_row_time ? offset->values[n] : 0.0);
      const double rise = motion.end_at(time_s) * motion.shape(76e-3);
      square += std::pow(x.values[n] - 76.0, 2) +
                std::pow(z.values[n] - 1.0 - kMillimetresPerMetre * rise, 2);
      count += 2.0;
    }
    EXPECT_GT(count, 100.0);
    return std::sqrt(square / count);
  }
  [[nodiscard]] fs::path film() const { return m_folder / "film.mkv"; }
  TemporaryFolder m_folder;
};

TEST_F(BentFilm, LensFileTakesABarrelOut) {
  const fs::path lens = m_folder.write("phone.yml", kBarrel);
  FilmOptions bent = options();
  bent.lens = read_lens(lens);
  bent.shake_px = 1.0;
  const Rig rig = strip_rig();
  const StripMotion motion;
  const FilmTruth truth = render_film(
      rig, [&](double t) { return motion.state_at(rig, t); }, film(), bent);
  TrackOptions without;
  TrackOptions with;
  with.lens = lens;
  const TrackResult straight = track_markers(rig, film(), with);
  const double straight_px = error_mm(straight, truth, motion, false) / straight.mm_per_px;
  const TrackResult plain = track_markers(rig, film(), without);
  const double plain_mm = error_mm(plain, truth, motion, false);
  RecordProperty("without_lens_mm", std::to_string(plain_mm));
  RecordProperty("with_lens_px", std::to_string(straight_px));
  EXPECT_GT(plain_mm, 0.1);      // what a person would publish without noticing
  EXPECT_LT(straight_px, 0.03);  // the bound asked for
  // Tracks stay in the picture as it is.
  EXPECT_LT((straight.tracks[0].position_px[20] - truth.position_px[20][0]).norm(), 0.1);
  EXPECT_NEAR(straight.mm_per_px, truth.mm_per_px, 2e-3 * truth.mm_per_px);
}

TEST_F(BentFilm, CameraFileOfAnotherProportionIsRefused) {
  FilmOptions tiny = options();
  tiny.duration_s = 0.02;
  Rig rig = strip_rig();
  const StripMotion motion;
  static_cast<void>(render_film(
      rig, [&](double t) { return motion.state_at(rig, t); }, film(), tiny));
  std::string square = kBarrel;
  square.replace(square.find("1280\n"), 4, "960");
  rig.camera->lens = m_folder.write("square.yml", square);
  const std::string message = refusal_of([&] { static_cast<void>(track_markers(rig, film())); });
  EXPECT_TRUE(holds(message, "film.mkv: the camera file is for pictures of 960 x 720 px"));
}

TEST_F(BentFilm, RowTimesMakeARollingShuttersPositionsTrue) {
  FilmOptions rolled = options();
  rolled.fps = 120.0;
  rolled.duration_s = 0.5;
  rolled.readout_s = 8e-3;
  Rig rig = strip_rig();
  rig.camera->capture_fps = 120.0;
  rig.camera->readout_s = 8e-3;
  StripMotion motion;
  motion.frequency_hz = 18.0;
  const FilmTruth truth = render_film(
      rig, [&](double t) { return motion.state_at(rig, t); }, film(), rolled);
  const TrackResult result = track_markers(rig, film());
  const double with_px = error_mm(result, truth, motion, true) / result.mm_per_px;
  const double without_px = error_mm(result, truth, motion, false) / result.mm_per_px;
  RecordProperty("with_row_times_px", std::to_string(with_px));
  RecordProperty("without_row_times_px", std::to_string(without_px));
  EXPECT_GT(without_px, 1.0);
  EXPECT_LT(with_px, 0.03);  // as good as any film's
  // The observable carries its marker's row time.
  const Channel* offset = result.trace.time_offset_of("observable_mm");
  ASSERT_NE(offset, nullptr);
  EXPECT_EQ(offset->values[20], result.trace.find("tip.time_offset_s")->values[20]);
}

}  // namespace
}  // namespace twang::test
