// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/render_film.hpp"

#include "core/constants.hpp"
#include "core/units.hpp"
#include "tests/capture/filmed_rig.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iterator>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

// Half the width of a window that holds a marker's ink and ends on its paper, over its size.
constexpr double kWindow = 0.58;
// Of a centroid: grey levels are whole numbers, and the marker's picture is affine where the
// camera's is projective.
constexpr double kCentroidTolerance = 0.01;  // [px]

struct Filmed {
  FilmTruth truth;
  std::vector<Image> images;
};

class RenderFilm : public ::testing::Test {
 protected:
  Filmed film(const Rig& rig,
              const std::function<FilmedState(double)>& state_at,
              const FilmOptions& options) {
    const fs::path path = m_folder.path() / "film.mkv";
    Filmed result{render_film(rig, state_at, path, options), read_film(path)};
    EXPECT_EQ(result.truth.time_s.size(), result.images.size());
    return result;
  }
  Filmed still_film(const Rig& rig, const FilmOptions& options) {
    return film(
        rig, [&](double) { return at_rest(rig); }, options);
  }
  static void expect_ink_at_truth(const Rig& rig, const Filmed& filmed, std::size_t frame) {
    for (std::size_t i = 0; i < rig.markers.size(); ++i) {
      const Eigen::Vector2d truth = filmed.truth.position_px[frame][i];
      const double half =
          kWindow * rig.markers[i].size_m * kMillimetresPerMetre / filmed.truth.mm_per_px;
      const Eigen::Vector2d seen = ink_moments(filmed.images[frame], truth, half).centre_px;
      EXPECT_NEAR(seen.x(), truth.x(), kCentroidTolerance) << rig.markers[i].id;
      EXPECT_NEAR(seen.y(), truth.y(), kCentroidTolerance) << rig.markers[i].id;
    }
  }
  TemporaryFolder m_folder;
};

TEST_F(RenderFilm, InkIsCentredOnTheTruth) {
  for (const MarkerKind kind :
       {MarkerKind::Dot, MarkerKind::Cross, MarkerKind::Ring, MarkerKind::Checker}) {
    const Rig rig = bench_with(kind);
    expect_ink_at_truth(rig, still_film(rig, clean_film(1)), 0);
  }
}

TEST_F(RenderFilm, InkIsCentredOnTheTruthInATiltedShakenView) {
  const Rig rig = bench_with(MarkerKind::Dot);
  FilmOptions options = clean_film(3);
  options.defocus_px = 0.6;  // so that nearly all ink lies in the window
  options.tilt_deg = 18.0;
  options.roll_deg = -7.0;
  options.shake_px = 3.0;
  const Filmed filmed = still_film(rig, options);
  for (std::size_t frame = 0; frame < 3; ++frame) expect_ink_at_truth(rig, filmed, frame);
}

TEST_F(RenderFilm, ScaleIsTheTruths) {
  const Rig rig = bench_with(MarkerKind::Dot);
  const FilmTruth truth = still_film(rig, clean_film(1)).truth;
  const Eigen::Vector2d seen = truth.position_px[0][2] - truth.position_px[0][4];
  const Eigen::Vector3d real = rig.markers[2].position - rig.markers[4].position;
  // Without tilt the view is a similarity: exact up to rounding.
  EXPECT_NEAR(seen.x() * truth.mm_per_px, 1e3 * real.x(), 1e-9);
  EXPECT_NEAR(seen.y() * truth.mm_per_px, -1e3 * real.z(), 1e-9);
}

TEST_F(RenderFilm, TiltIsAHomographyOfTheRigsPlane) {
  const Rig rig = bench_with(MarkerKind::Dot);
  FilmOptions options = clean_film(1);
  options.tilt_deg = 20.0;
  const auto seen = still_film(rig, options).truth.position_px[0];
  // From the four fixed markers: x (g u + h v + 1) = a u + b v + c, and y likewise.
  Eigen::Matrix<double, 8, 8> A = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 8, 1> right;
  for (int i = 0; i < 4; ++i) {
    const Marker& marker = rig.markers[static_cast<std::size_t>(i + 1)];
    const Eigen::RowVector3d plane(marker.position.x(), -marker.position.z(), 1.0);
    const Eigen::Vector2d px = seen[static_cast<std::size_t>(i + 1)];
    A.block<1, 3>(2 * i, 0) = plane;
    A.block<1, 3>(2 * i + 1, 3) = plane;
    A.block<1, 2>(2 * i, 6) = -px.x() * plane.head<2>();
    A.block<1, 2>(2 * i + 1, 6) = -px.y() * plane.head<2>();
    right.segment<2>(2 * i) = px;
  }
  const Eigen::Matrix<double, 8, 1> h = A.fullPivLu().solve(right);
  const Eigen::Vector3d middle(rig.markers[0].position.x(), -rig.markers[0].position.z(), 1.0);
  const double w = h.segment<2>(6).dot(middle.head<2>()) + 1.0;
  EXPECT_NEAR(h.segment<3>(0).dot(middle) / w, seen[0].x(), 1e-7);  // rounding of the solve
  EXPECT_NEAR(h.segment<3>(3).dot(middle) / w, seen[0].y(), 1e-7);
  // The side that the tilt brings nearer is larger: by about the sine of the tilt times the
  // distance between left and right over that of the camera.
  const double left = (seen[1] - seen[4]).norm() / 40.3;
  const double right_side = (seen[2] - seen[3]).norm() / 40.2;
  EXPECT_GT(left / right_side, 1.02);
  EXPECT_LT(left / right_side, 1.06);
}

TEST_F(RenderFilm, TurnsMarkersAnticlockwise) {
  const Rig rig = bench_with(MarkerKind::Checker);
  FilmedState state = at_rest(rig);
  state.markers[0].turn_rad = kPi / 3.0;
  const Filmed filmed = film(
      rig, [&](double) { return state; }, clean_film(1));
  const double reach = 0.3 * 8.0 / filmed.truth.mm_per_px;
  const auto level = [&](double angle_rad) {
    const Eigen::Vector2d at = filmed.truth.position_px[0][0] +
                               reach * Eigen::Vector2d(std::cos(angle_rad), -std::sin(angle_rad));
    return pixel_at(filmed.images[0],
                    static_cast<int>(std::lround(at.x())),
                    static_cast<int>(std::lround(at.y())));
  };
  // The middle of the upper left quadrant lies at 135 degrees before the turn.
  const double ink = 0.75 * kPi + kPi / 3.0;
  EXPECT_LT(level(ink), 40);
  EXPECT_LT(level(ink + kPi), 40);
  EXPECT_GT(level(ink + 0.5 * kPi), 210);
  EXPECT_GT(level(ink - 0.5 * kPi), 210);
}

TEST_F(RenderFilm, MotionBlurSpreadsTheInkEvenlyAroundTheTruth) {
  const Rig rig = bench_with(MarkerKind::Dot);
  FilmOptions options = clean_film(3);
  options.defocus_px = 0.6;   // so that nearly all ink lies in the window
  const double speed = 0.25;  // [m/s]
  const auto moving = [&](double time_s) {
    FilmedState state = at_rest(rig);
    state.markers[0].position.x() += speed * (time_s - 1.0 / options.fps);
    return state;
  };
  options.exposure = 0.0;
  const Filmed sharp = film(rig, moving, options);
  options.exposure = 0.8;
  const Filmed blurred = film(rig, moving, options);
  const double path_px = 1e3 * speed * 0.8 / options.fps / blurred.truth.mm_per_px;
  ASSERT_GT(path_px, 2.0);  // so that there is something to see
  const double half = kWindow * 8.0 / blurred.truth.mm_per_px;
  const Eigen::Vector2d truth = blurred.truth.position_px[1][0];
  const InkMoments before = ink_moments(sharp.images[1], truth, half);
  const InkMoments after = ink_moments(blurred.images[1], truth, half);
  EXPECT_NEAR(after.centre_px.x(), truth.x(), kCentroidTolerance);
  EXPECT_NEAR(after.centre_px.y(), truth.y(), kCentroidTolerance);
  // The variance of an even spread over the path; sub-exposures make it a comb of at least 16
  // teeth, 1 / 16² narrower, and grey levels are whole numbers.
  const double spread = path_px * path_px / 12.0;
  EXPECT_NEAR(after.variance_px2.x() - before.variance_px2.x(), spread, 0.02 * spread + 0.02);
  EXPECT_NEAR(after.variance_px2.y() - before.variance_px2.y(), 0.0, 0.02);
}

TEST_F(RenderFilm, SilhouetteCoversThePartsArea) {
  const Rig rig = bench_with(MarkerKind::Dot);
  FilmedState with_part = at_rest(rig);
  // A parallelogram of 30 x 9 mm below the marker, seen twice over: front and back.
  for (const double y : {0.0, 10e-3}) {
    with_part.part_faces.push_back({Eigen::Vector3d(-20e-3, y, -18e-3),
                                    Eigen::Vector3d(10e-3, y, -17e-3),
                                    Eigen::Vector3d(12e-3, y, -8e-3),
                                    Eigen::Vector3d(-18e-3, y, -9e-3)});
  }
  const double area_mm2 = 30.0 * 9.0 - 2.0 * 1.0;
  FilmOptions options = clean_film(1);
  options.defocus_px = 0.0;
  const Filmed bare = still_film(rig, options);
  const Filmed filmed = film(
      rig, [&](double) { return with_part; }, options);
  constexpr double kPart = 120.0;
  double covered_px = 0.0;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < bare.images[0].pixels.size(); ++i) {
    const double bench = bare.images[0].pixels[i];
    if (filmed.images[0].pixels[i] == bare.images[0].pixels[i]) continue;
    const double cover = (bench - filmed.images[0].pixels[i]) / (bench - kPart);
    covered_px += cover;
    const auto width = static_cast<std::size_t>(options.width_px);
    centre +=
        cover * Eigen::Vector2d(static_cast<double>(i % width), static_cast<double>(i / width));
  }
  // Grey levels are whole numbers: up to 1/130 of a pixel each.
  EXPECT_NEAR(covered_px * std::pow(filmed.truth.mm_per_px, 2), area_mm2, 0.005 * area_mm2);
  // Its centre lies 7 mm left of and 14.7 mm below the middle marker; four samples a pixel and
  // direction leave a few hundredths of a pixel.
  const Eigen::Vector2d expected =
      filmed.truth.position_px[0][0] + Eigen::Vector2d(-7.0, 14.7) / filmed.truth.mm_per_px;
  EXPECT_NEAR(centre.x() / covered_px, expected.x(), 0.1);
  EXPECT_NEAR(centre.y() / covered_px, expected.y(), 0.1);
}

TEST_F(RenderFilm, NoiseHasTheStatedSpread) {
  const Rig rig = bench_with(MarkerKind::Dot);
  FilmOptions options = clean_film(2);
  const Filmed clean = still_film(rig, options);
  options.noise = 3.0;
  const Filmed noisy = still_film(rig, options);
  double sum = 0.0;
  double squares = 0.0;
  const auto count = static_cast<double>(clean.images[0].pixels.size());
  for (std::size_t i = 0; i < clean.images[0].pixels.size(); ++i) {
    const double error = noisy.images[1].pixels[i] - clean.images[1].pixels[i];
    sum += error;
    squares += error * error;
  }
  // 57600 samples: standard errors of 0.013 for the mean and 0.009 for the spread; two roundings
  // add 1/12 each to the variance.
  EXPECT_NEAR(sum / count, 0.0, 0.06);
  EXPECT_NEAR(std::sqrt(squares / count), std::sqrt(9.0 + 2.0 / 12.0), 0.05);
  EXPECT_NE(noisy.images[0].pixels, noisy.images[1].pixels);
}

TEST_F(RenderFilm, SameSeedSameFilm) {
  const Rig rig = bench_with(MarkerKind::Dot);
  FilmOptions options = clean_film(2);
  options.noise = 2.0;
  options.shake_px = 1.0;
  const Filmed first = still_film(rig, options);
  const Filmed again = still_film(rig, options);
  options.seed = 2;
  const Filmed other = still_film(rig, options);
  EXPECT_EQ(first.images[1].pixels, again.images[1].pixels);
  EXPECT_NE(first.images[1].pixels, other.images[1].pixels);
  EXPECT_NE(first.truth.position_px[1][0], other.truth.position_px[1][0]);
}

TEST_F(RenderFilm, DoubledFramesRepeatTheOneBefore) {
  const Rig rig = bench_with(MarkerKind::Dot);
  FilmOptions options = clean_film(40);
  options.width_px = 128;
  options.height_px = 72;
  options.noise = 2.0;
  options.doubled = 0.25;
  const Filmed filmed = still_film(rig, options);
  int doubled = 0;
  EXPECT_FALSE(filmed.truth.doubled[0]);
  for (std::size_t n = 1; n < filmed.images.size(); ++n) {
    const bool same = filmed.images[n].pixels == filmed.images[n - 1].pixels;
    EXPECT_EQ(same, filmed.truth.doubled[n]) << n;
    doubled += same;
  }
  // 39 trials at 1/4: 10 expected, standard deviation 2.7.
  EXPECT_GT(doubled, 2);
  EXPECT_LT(doubled, 19);
}

TEST_F(RenderFilm, FlickerFollowsTheMains) {
  const Rig rig = bench_with(MarkerKind::Dot);
  FilmOptions options = clean_film(12);
  options.flicker = 0.1;
  const Filmed filmed = still_film(rig, options);
  const auto mean = [](const Image& image) {
    double sum = 0.0;
    for (const auto pixel : image.pixels) sum += pixel;
    return sum / static_cast<double>(image.pixels.size());
  };
  for (std::size_t n = 1; n < 12; ++n) {
    const double ratio = mean(filmed.images[n]) / mean(filmed.images[0]);
    // Grey levels are whole numbers: the mean of very many is off by far less than 0.1 %.
    EXPECT_NEAR(ratio, 1.0 + 0.1 * std::sin(kTwoPi * 100.0 * filmed.truth.time_s[n]), 1e-3) << n;
  }
}

TEST_F(RenderFilm, EverythingFitsIntoThePicture) {
  const Rig rig = bench_with(MarkerKind::Dot);
  const auto swinging = [&](double time_s) {
    FilmedState state = at_rest(rig);
    state.markers[0].position.z() += 45e-3 * std::sin(kTwoPi * 30.0 * time_s);  // off the bench
    return state;
  };
  FilmOptions options = clean_film(16);
  options.tilt_deg = -25.0;
  options.roll_deg = 11.0;
  options.shake_px = 2.0;
  options.exposure = 0.0;
  const FilmTruth truth = film(rig, swinging, options).truth;
  const double reach = 0.75 * 8.0 / truth.mm_per_px;  // half a paper
  Eigen::Vector2d low(1e9, 1e9);
  Eigen::Vector2d high(-1e9, -1e9);
  for (const auto& frame : truth.position_px) {
    for (const Eigen::Vector2d& centre : frame) {
      low = low.cwiseMin(centre);
      high = high.cwiseMax(centre);
    }
  }
  EXPECT_GT(low.x() - reach, 0.0);
  EXPECT_GT(low.y() - reach, 0.0);
  EXPECT_LT(high.x() + reach, 319.0);
  EXPECT_LT(high.y() + reach, 179.0);
  // And fills it: what is left over is the margin for the border and the shake.
  EXPECT_GT(
      std::max((high.x() - low.x() + 2 * reach) / 320, (high.y() - low.y() + 2 * reach) / 180),
      0.8);
}

TEST_F(RenderFilm, RefusesWhatItCannotFilm) {
  const fs::path path = m_folder.path() / "film.mp4";
  const auto refusal = [&](const Rig& rig, const FilmedState& state) {
    return refusal_of([&] {
      (void)render_film(
          rig, [&](double) { return state; }, path, clean_film(1));
    });
  };
  Rig rig = bench_with(MarkerKind::Dot);
  const FilmedState state = at_rest(rig);
  FilmedState short_state = state;
  short_state.markers.pop_back();
  EXPECT_TRUE(holds(refusal(rig, short_state), "has 4 markers, must have the rig's 5"));
  rig.camera.reset();
  EXPECT_TRUE(holds(refusal(rig, state), "no camera"));
  rig = bench_with(MarkerKind::ArUco);
  EXPECT_TRUE(holds(refusal(rig, state), "marker 'middle': dictionary is ''"));
  rig.markers.clear();
  EXPECT_TRUE(holds(refusal(rig, {}), "no marker"));
  EXPECT_TRUE(fs::is_empty(m_folder.path()));
}

TEST_F(RenderFilm, StopsWhenAskedAndLeavesNothing) {
  const Rig rig = bench_with(MarkerKind::Dot);
  FilmOptions options = clean_film(10);
  options.progress = [](const Progress& progress) { return progress.done < 4; };
  EXPECT_THROW((void)render_film(
                   rig, [&](double) { return at_rest(rig); }, m_folder.path() / "a.mp4", options),
               Cancelled);
  EXPECT_TRUE(fs::is_empty(m_folder.path()));
}

TEST(FilmOptions, DefaultsPass) { EXPECT_NO_THROW(FilmOptions().check()); }

TEST(FilmOptions, EachBoundIsChecked) {
  const auto refusal = [](const std::function<void(FilmOptions&)>& spoil) {
    FilmOptions options;
    spoil(options);
    return refusal_of([&] { options.check(); });
  };
  const double nan = kNaN;
  EXPECT_TRUE(holds(refusal([](auto& o) { o.width_px = 15; }), "width_px is 15"));
  EXPECT_TRUE(holds(refusal([](auto& o) { o.height_px = 9000; }), "height_px is 9000"));
  EXPECT_TRUE(holds(refusal([](auto& o) { o.fps = 0.0; }), "fps is 0"));
  EXPECT_TRUE(holds(refusal([](auto& o) { o.duration_s = 0.0; }), "duration_s is 0"));
  EXPECT_TRUE(holds(refusal([](auto& o) { o.noise = -1.0; }), "noise is -1"));
  EXPECT_TRUE(holds(refusal([](auto& o) { o.exposure = 1.5; }), "exposure is 1.5"));
  EXPECT_TRUE(holds(refusal([](auto& o) { o.tilt_deg = 61.0; }), "tilt_deg is 61"));
  EXPECT_TRUE(holds(refusal([&](auto& o) { o.roll_deg = nan; }), "roll_deg is nan"));
  EXPECT_TRUE(holds(refusal([](auto& o) { o.shake_px = -0.1; }), "shake_px is -0.1"));
  EXPECT_TRUE(holds(refusal([](auto& o) { o.flicker = 1.1; }), "flicker is 1.1"));
  EXPECT_TRUE(holds(refusal([](auto& o) { o.doubled = 1.0; }), "doubled is 1"));
  EXPECT_TRUE(holds(refusal([](auto& o) { o.defocus_px = -0.5; }), "defocus_px is -0.5"));
  EXPECT_TRUE(holds(refusal([](auto& o) { o.crf = 52; }), "crf is 52"));
}

}  // namespace
}  // namespace twang::test
