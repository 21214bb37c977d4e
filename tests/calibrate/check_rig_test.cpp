// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/check_rig.hpp"

#include "calibrate/detail/checks.hpp"
#include "capture/find_layout.hpp"
#include "core/constants.hpp"
#include "core/units.hpp"
#include "rigs/load_rig.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/file_rig.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace twang {
namespace {

namespace fs = std::filesystem;

/// 80 x 10 x 2 mm, marker "tip", four dots on the bench, of 1.9 GPa.
Rig strip() {
  Rig rig = load_rig(fs::path(TWANG_SOURCE_DIR) / "rigs" / "strip.toml",
                     {.part = true, .clamp = true, .film = true, .observable = true});
  rig.materials[0].reported_youngs_modulus_pa = 1.9e9;
  return rig;
}

const CheckFinding* find(const RigCheck& check, const std::string& subject) {
  const auto it =
      std::find_if(check.findings.begin(), check.findings.end(), [&](const CheckFinding& finding) {
        return finding.subject == subject;
      });
  return it == check.findings.end() ? nullptr : &*it;
}

void expect_finding(const RigCheck& check,
                    const std::string& subject,
                    CheckVerdict verdict,
                    const std::string& part) {
  const CheckFinding* finding = find(check, subject);
  ASSERT_NE(finding, nullptr) << subject;
  EXPECT_EQ(to_string(finding->verdict), to_string(verdict)) << finding->sentence;
  EXPECT_TRUE(test::holds(finding->sentence, part));
}

/// A film of the strip, faultless where a test does not say otherwise.
FilmInspection good_film(const Rig& rig) {
  FilmInspection film;
  film.film = "strip.mp4";
  film.width_px = 1280;
  film.height_px = 720;
  film.time_base.file_fps = film.time_base.capture_fps = 240.0;
  film.time_base.source = "rig";
  film.time_base.frames = 480;
  film.least_interval_s = film.largest_interval_s = 1.0 / 240.0;
  film.px_per_m = 9000.0;
  for (const Marker& marker : rig.markers) {
    const Eigen::Vector2d plane = plane_position(*rig.camera, marker.position);
    film.markers.push_back({marker.id,
                            Eigen::Vector2d(280.0, 360.0) + film.px_per_m * plane,
                            film.px_per_m * marker.size_m,
                            0.8,
                            160.0,
                            40.0});
  }
  film.noise = 1.5;
  film.shake_px = 0.01;
  return film;
}

TEST(ExpectMotion, PredictsACantileversFirstFrequencyAndSwing) {
  const Rig rig = strip();
  const ExpectedMotion motion = expect_motion(rig);
  ASSERT_FALSE(motion.frequency_hz.empty());
  EXPECT_TRUE(motion.modulus_known);
  // Euler's cantilever; width and nu = 0.45 stiffen it by some per cent
  const double beam =
      1.875104 * 1.875104 / kTwoPi * std::sqrt(1.9e9 * 4e-6 / (12.0 * 1180.0)) / (0.08 * 0.08);
  EXPECT_NEAR(motion.frequency_hz.front() / beam, 1.02, 0.03);
  ASSERT_EQ(motion.amplitude_m.size(), rig.markers.size());
  // the curve under an end load at 76 of 80 mm: s²(3 - s)/2 = 0.9262
  const double release = rig.release->displacement->z();
  EXPECT_NEAR(motion.amplitude_m[0].z() / release, 0.926, 0.02);
  EXPECT_EQ(motion.amplitude_m[1].norm(), 0.0) << "the bench stands";
  EXPECT_GT(motion.observable_share.at(0), 0.99);
}

TEST(ExpectMotion, SaysWhyNothingIsKnown) {
  Rig rig = strip();
  rig.parts.clear();
  const ExpectedMotion motion = expect_motion(rig);
  EXPECT_TRUE(motion.frequency_hz.empty());
  EXPECT_TRUE(test::holds(motion.unknown_because, "no [[part]]"));
}

TEST(CheckRig, AGoodRigIsFitToBeFilmed) {
  Rig at_another_rate = strip();
  at_another_rate.camera->capture_fps = 250.0;  // at 240 the first torsion folds onto 68 Hz
  const RigCheck check = check_rig(at_another_rate);
  EXPECT_TRUE(check.can_be_filmed());
  for (const char* subject :
       {"frequency", "alias", "swing", "observable", "markers", "layout", "scale", "clock"}) {
    expect_finding(check, subject, CheckVerdict::Ok, "");
  }
  const Rig rig = strip();
  const FilmInspection film = good_film(rig);
  const RigCheck filmed = check_rig(rig, {}, &film);
  for (const char* subject : {"markers", "clock", "light", "focus", "noise", "shake"}) {
    expect_finding(filmed, subject, CheckVerdict::Ok, "");
  }
}

TEST(CheckRig, AMeshFileMovesAsTheSolidDoes) {
  const test::FileRig file(strip(), 2e-3);
  const RigCheck of_file = check_rig(file.rig);
  const RigCheck of_solid = check_rig(strip());
  ASSERT_FALSE(of_file.motion.frequency_hz.empty()) << of_file.motion.unknown_because;
  EXPECT_NEAR(of_file.motion.frequency_hz[0] / of_solid.motion.frequency_hz.at(0), 1.0, 1e-3);
}

TEST(CheckRig, ComparesTheFrequencyWithTheFrameRate) {
  Rig rig = strip();  // 65 Hz
  rig.camera->capture_fps = 120.0;
  const RigCheck aliased = check_rig(rig);
  expect_finding(aliased, "frequency", CheckVerdict::Problem, "alias");
  EXPECT_FALSE(aliased.can_be_filmed());
  rig.camera->capture_fps = 150.0;
  expect_finding(check_rig(rig), "frequency", CheckVerdict::Warning, "an alias is not excluded");
  CheckOptions options;
  options.capture_fps = 240.0;
  expect_finding(check_rig(rig, options), "frequency", CheckVerdict::Ok, "240 frames/s");
  rig.camera->capture_fps.reset();
  const RigCheck unknown = check_rig(rig);
  expect_finding(unknown, "frequency", CheckVerdict::Warning, "film at");
  expect_finding(unknown, "clock", CheckVerdict::Warning, "capture_fps");
}

TEST(CheckRig, SaysWhichModuliSuitWhereNoneIsStated) {
  Rig rig = strip();
  rig.materials[0].reported_youngs_modulus_pa.reset();
  const RigCheck check = check_rig(rig);
  expect_finding(check, "frequency", CheckVerdict::Warning, "for E below 4.0");
  // f = 0.4 x 240 Hz at that modulus
  const double limit_pa = std::pow(0.4 * 240.0 / check.motion.frequency_hz.front(), 2);
  EXPECT_NEAR(limit_pa, 4.08e9, 0.06e9);
  EXPECT_EQ(find(check, "alias"), nullptr);
}

TEST(CheckRig, WarnsOfModesThatFoldOntoTheFirst) {
  Rig rig = strip();
  const ExpectedMotion motion = expect_motion(rig);
  ASSERT_GE(motion.frequency_hz.size(), 4U);
  // the second bending, past the sideways one, at the rate at which it looks like the first
  std::size_t second = 1;
  while (second + 1 < motion.observable_share.size() && motion.observable_share[second] < 0.5) {
    ++second;
  }
  EXPECT_GT(second, 1U) << "sideways the strip is five times as stiff: that mode comes first";
  rig.camera->capture_fps = motion.frequency_hz[second] + motion.frequency_hz[0];
  expect_finding(check_rig(rig), "alias", CheckVerdict::Warning, "near the first");
  // the sideways mode, which the film does not show, alarms nobody
  rig.camera->capture_fps = motion.frequency_hz[1] + motion.frequency_hz[0];
  expect_finding(check_rig(rig), "alias", CheckVerdict::Ok, "No higher mode");
}

TEST(CheckRig, WarnsOfBlurAndSaysTheExposureThatAvoidsIt) {
  Rig rig = strip();
  rig.release->displacement = Eigen::Vector3d(0.0, 0.0, -6e-3);
  expect_finding(check_rig(rig), "blur", CheckVerdict::Warning, "expose for 1/");
  CheckOptions options;
  options.exposure_s = 1.0 / 4000.0;
  expect_finding(check_rig(rig, options), "blur", CheckVerdict::Ok, "1/4000 s");
}

TEST(CheckRig, SeesASwingThatLeavesThePicture) {
  const Rig rig = strip();
  FilmInspection film = good_film(rig);
  film.height_px = 375;  // the tip stands at 360 - 9
  expect_finding(check_rig(rig, {}, &film), "swing", CheckVerdict::Problem, "'tip' may leave");
}

TEST(CheckRig, JudgesTheMarkersSize) {
  Rig rig = strip();
  rig.markers[0].size_m = 1e-3;
  expect_finding(check_rig(rig), "markers", CheckVerdict::Warning, "'tip'");
  FilmInspection film = good_film(strip());
  film.markers[2].size_px = 12.0;
  expect_finding(
      check_rig(strip(), {}, &film), "markers", CheckVerdict::Warning, "'bench_2', is 12 px");
  film.markers[2].size_px = 5.0;
  expect_finding(check_rig(strip(), {}, &film), "markers", CheckVerdict::Problem, "is 5 px");
  film.hidden = {"bench_4"};
  film.markers[2].size_px = 30.0;
  expect_finding(
      check_rig(strip(), {}, &film), "markers", CheckVerdict::Warning, "'bench_4' is not");
  film.markers.clear();
  film.not_found = "marker 'tip' was not found";
  expect_finding(check_rig(strip(), {}, &film), "markers", CheckVerdict::Problem, "was not found.");
}

TEST(CheckRig, SaysWhatTheFixedMarkersAllow) {
  Rig rig = strip();
  for (Marker& marker : rig.markers)
    marker.position.z() = marker.fixed ? 0.02 : marker.position.z();
  expect_finding(check_rig(rig), "scale", CheckVerdict::Warning, "nearly on a line");
  rig = strip();
  rig.markers.pop_back();
  expect_finding(check_rig(rig), "scale", CheckVerdict::Warning, "3 fixed markers");
  rig.markers.resize(1);
  expect_finding(check_rig(rig), "scale", CheckVerdict::Warning, "the marker's size alone");
  rig = strip();
  for (Marker& marker : rig.markers) {
    if (marker.fixed) marker.position.y() += 0.03;
  }
  expect_finding(check_rig(rig), "depth", CheckVerdict::Warning, "mm before or behind");
}

TEST(CheckRig, SeesThatTheObservableIsNotShown) {
  Rig rig = strip();
  rig.observable->direction = {0.0, 1.0, 0.0};
  expect_finding(check_rig(rig), "observable", CheckVerdict::Problem, "points at the camera");
  rig.observable->direction = {0.0, 1.0, 1.0};
  expect_finding(check_rig(rig), "observable", CheckVerdict::Warning, "by 45 degrees");
  rig.observable->direction = {1.0, 0.0, 0.0};
  expect_finding(check_rig(rig), "observable", CheckVerdict::Problem, "does not move");
}

TEST(CheckRig, SeesMarkersThatOverlapOrCoverEachOther) {
  Rig rig = strip();
  rig.markers[1].position = rig.markers[0].position + Eigen::Vector3d(0.0, 0.0, 4e-3);
  expect_finding(check_rig(rig), "layout", CheckVerdict::Problem, "overlap in the picture");
  rig.markers[1].position = rig.markers[0].position + Eigen::Vector3d(0.0, 0.0, 7e-3);
  expect_finding(check_rig(rig), "layout", CheckVerdict::Warning, "cover each other");
}

TEST(LayoutSymmetry, FindsTurnsAndMirrorImages) {
  const auto square = [](double width, double height) {
    return std::vector<Eigen::Vector2d>{{0, 0}, {width, 0}, {width, height}, {0, height}};
  };
  Rig rig;
  for (int i = 0; i < 4; ++i) {
    Marker marker;
    marker.id = std::to_string(i);
    marker.size_m = 5e-3;
    rig.markers.push_back(marker);
  }
  const auto of = [&](const std::vector<Eigen::Vector2d>& places) {
    return detail::layout_symmetries(rig, places, 1e-3);
  };
  // of a square three turns and four mirror images, of a rectangle one and two
  EXPECT_EQ(of(square(0.1, 0.1)).size(), 7U);
  const auto rectangle = of(square(0.1, 0.06));
  ASSERT_EQ(rectangle.size(), 3U);
  EXPECT_FALSE(rectangle[0].mirrored);
  EXPECT_NEAR(std::abs(rectangle[0].turn_rad), kPi, 1e-9);
  EXPECT_TRUE(of({{0, 0}, {0.1, 0.01}, {0.09, 0.05}, {0.02, 0.07}}).empty());
  // one of another kind leaves but the mirror through it
  rig.markers[0].kind = MarkerKind::Ring;
  EXPECT_EQ(of(square(0.1, 0.1)).size(), 1U);
  EXPECT_TRUE(of(square(0.1, 0.1))[0].mirrored);
  EXPECT_TRUE(of(square(0.1, 0.06)).empty());
}

TEST(CheckRig, JudgesAFirstFilm) {
  const Rig rig = strip();
  FilmInspection film = good_film(rig);
  film.markers[0].contrast = 30.0;
  film.markers[1].blur_px = 9.0;
  film.noise = 12.0;
  film.shake_px = 3.0;
  film.capture_fps_tag = 120.0;
  film.largest_interval_s = 2.0 / 240.0;
  const RigCheck check = check_rig(rig, {}, &film);
  expect_finding(check, "light", CheckVerdict::Warning, "'tip' stands out by 30 grey levels");
  expect_finding(check, "focus", CheckVerdict::Warning, "'bench_1' are blurred by 9");
  expect_finding(check, "noise", CheckVerdict::Warning, "12");
  expect_finding(check, "shake", CheckVerdict::Warning, "tripod");
  expect_finding(check, "clock", CheckVerdict::Warning, "contradict");
  EXPECT_TRUE(check.can_be_filmed()) << "warnings do not stand in the way";
  film.markers[0].contrast = 8.0;
  EXPECT_FALSE(check_rig(rig, {}, &film).can_be_filmed());
}

TEST(CheckOptions, RefusesWhatIsOutOfRange) {
  CheckOptions options;
  EXPECT_NO_THROW(options.check());
  options.capture_fps = 0.0;
  EXPECT_THROW(options.check(), InputError);
  options = {};
  options.exposure_s = -1.0;
  EXPECT_THROW(options.check(), InputError);
  options = {};
  options.max_dofs = 0;
  EXPECT_THROW(options.check(), InputError);
  Rig rig = strip();
  rig.camera.reset();
  EXPECT_THROW((void)check_rig(rig), InputError);
}

}  // namespace
}  // namespace twang
