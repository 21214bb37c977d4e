// SPDX-License-Identifier: GPL-3.0-or-later
// Which eigenmode a recording shows. Shapes and frequencies of the strip come from its mesh, the
// modulus that must come back from beam theory.
#include "calibrate/choose_mode.hpp"

#include "calibrate/calibrate.hpp"
#include "calibrate/render_rig.hpp"
#include "core/error.hpp"
#include "core/trace_file.hpp"
#include "rigs/load_rig.hpp"
#include "tests/support/rigs.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <random>

namespace twang {
namespace {

namespace fs = std::filesystem;

constexpr double kModulus_pa = 2e9;

Marker marker_at(const char* id, const Eigen::Vector3d& position_mm) {
  Marker marker;
  marker.id = id;
  marker.size_m = 4e-3;
  marker.position = position_mm * kMetresPerMillimetre;
  return marker;
}

/// A strip of 80 x 10 x 2 mm along x, held at x = 0, nu 0: bends as a beam of Euler's does.
Rig strip(const Eigen::Vector3d& direction) {
  Rig rig =
      test::make_rig({test::box_mm({0, 0, 0}, {80, 10, 2})}, {test::box_mm({0, 0, 0}, {0, 10, 2})});
  rig.materials[0].poissons_ratio = 0.0;
  rig.markers = {marker_at("tip", {76, 5, 1}), marker_at("middle", {38, 5, 1})};
  rig.observable = ObservableDefinition{ObservableKind::Displacement, {"tip"}, direction};
  return rig;
}

const MeshRung& strip_rung() {
  static const MeshRung rung = compute_rung(strip({0, 0, 1}), 5e-3, ElementKind::Hex20, 8);
  return rung;
}

/// Frequency of a strip's bending mode by Euler's beam, thickness along the bending [Hz].
double euler_hz(double beta_l, double thickness_m) {
  return beta_l * beta_l / (kTwoPi * 0.08 * 0.08) *
         std::sqrt(kModulus_pa * thickness_m * thickness_m / (12.0 * 1180.0));
}

/// The mesh's mode nearest to a frequency at kModulus_pa.
int mode_near(double hz) {
  int nearest = 0;
  for (int i = 0; i < strip_rung().modes.count(); ++i) {
    const auto off = [&](int mode) {
      const double mesh_hz = strip_rung().modes.natural_frequency_hz(mode) * std::sqrt(kModulus_pa);
      return std::abs(mesh_hz / hz - 1.0);
    };
    if (off(i) < off(nearest)) nearest = i;
  }
  return nearest;
}

const double kFirst_hz = euler_hz(1.875104, 2e-3);
const double kSecond_hz = euler_hz(4.694091, 2e-3);
const double kEdgewise_hz = euler_hz(1.875104, 10e-3);

DampedSinusoid sinusoid(double hz, double amplitude) {
  DampedSinusoid mode;
  mode.frequency_hz = hz;
  mode.decay_per_s = 5.0;
  mode.channels.push_back({"observable_mm", amplitude, 0.0});
  return mode;
}

ModeQuestion question(const Rig& rig, std::vector<DampedSinusoid> sinusoids) {
  ModeQuestion question;
  question.rig = &rig;
  question.rung = &strip_rung();
  question.sinusoids = std::move(sinusoids);
  question.columns = {"observable_mm"};
  return question;
}

TEST(ChooseMode, TakesALoneSinusoidForTheLowestModeThatShows) {
  const Rig flatwise = strip({0, 0, 1});
  const ModeChoice first = choose_mode(question(flatwise, {sinusoid(kFirst_hz, 1.0)}));
  EXPECT_EQ(first.mode, 0);
  EXPECT_TRUE(first.doubt.empty()) << first.doubt;
  // Sideways the first mode does not move the tip: the first that does is the edgewise one.
  const Rig edgewise = strip({0, 1, 0});
  const ModeChoice sideways = choose_mode(question(edgewise, {sinusoid(kEdgewise_hz, 1.0)}));
  EXPECT_EQ(sideways.mode, mode_near(kEdgewise_hz));
  EXPECT_GT(sideways.mode, 0);
  EXPECT_TRUE(sideways.doubt.empty()) << sideways.doubt;
  EXPECT_NE(sideways.reason.find("mode 1 moves it"), std::string::npos) << sideways.reason;
}

TEST(ChooseMode, ReadsTheModeOffTheRatioOfTwoFrequencies) {
  const Rig rig = strip({0, 0, 1});
  // 6.27 apart, whichever is the stronger: the second over the first.
  const ModeChoice second =
      choose_mode(question(rig, {sinusoid(kSecond_hz, 1.0), sinusoid(kFirst_hz, 0.3)}));
  EXPECT_EQ(second.mode, mode_near(kSecond_hz));
  EXPECT_GT(second.mode, 0);
  EXPECT_TRUE(second.doubt.empty()) << second.doubt;
  const ModeChoice first =
      choose_mode(question(rig, {sinusoid(kFirst_hz, 1.0), sinusoid(kSecond_hz, 0.3)}));
  EXPECT_EQ(first.mode, 0);
  EXPECT_TRUE(first.doubt.empty()) << first.doubt;
}

TEST(ChooseMode, IsNotMisledByADisturbanceBelowTheFirst) {
  const Rig rig = strip({0, 0, 1});
  // a bench that sways at a frequency that belongs to no mode
  const ModeChoice choice =
      choose_mode(question(rig, {sinusoid(kFirst_hz, 1.0), sinusoid(0.3 * kFirst_hz, 0.1)}));
  EXPECT_EQ(choice.mode, 0);
}

/// What the camera sees of one mode at both markers.
std::vector<MarkerMotion> motion_of(const Rig& rig, int mode, double sigma_rel) {
  std::vector<MarkerMotion> motion;
  for (const Marker& marker : rig.markers) {
    for (const int axis : {0, 2}) {
      const MeshPoint point = locate(strip_rung().mesh, marker.position);
      const double moved = interpolate(point, strip_rung().modes.shapes.col(mode))[axis];
      motion.push_back({marker.id, axis, std::polar(1e-4 * moved, 0.7), 1e-4 * sigma_rel});
    }
  }
  return motion;
}

TEST(ChooseMode, ReadsTheModeOffTheMotionOfTheMarkers) {
  const Rig rig = strip({0, 0, 1});
  for (const double hz : {kFirst_hz, kSecond_hz}) {
    const int mode = mode_near(hz);
    ModeQuestion asked = question(rig, {sinusoid(hz, 1.0)});  // alone: no ratio tells it
    asked.motion = motion_of(rig, mode, 0.1);
    const ModeChoice choice = choose_mode(asked);
    EXPECT_EQ(choice.mode, mode);
    EXPECT_NE(choice.reason.find("correlation 1.000"), std::string::npos) << choice.reason;
    // Noise larger than the motion tells nothing.
    asked.motion = motion_of(rig, mode, 1e3);
    EXPECT_EQ(choose_mode(asked).mode, 0);
  }
}

TEST(ChooseMode, SaysWhereItIsInDoubtAndObeysWhatIsStated) {
  const Rig rig = strip({0, 0, 1});
  ModeQuestion asked = question(rig, {sinusoid(kSecond_hz, 1.0)});
  asked.reported_modulus_pa = kModulus_pa;  // which fits the second alone
  const ModeChoice left = choose_mode(asked);
  EXPECT_EQ(left.mode, 0);
  EXPECT_NE(left.doubt.find("reported"), std::string::npos) << left.doubt;
  EXPECT_NE(left.doubt.find("--mode"), std::string::npos) << left.doubt;
  asked.stated = mode_near(kSecond_hz);
  const ModeChoice stated = choose_mode(asked);
  EXPECT_EQ(stated.mode, *asked.stated);
  EXPECT_TRUE(stated.stated);
  asked.stated = strip_rung().modes.count();
  EXPECT_THROW((void)choose_mode(asked), InputError);
}

/// The strip's tip in one or two sinusoids.
fs::path write_trace(const test::TemporaryFolder& folder,
                     const std::vector<DampedSinusoid>& sinusoids) {
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  Trace trace;
  trace.channels.push_back({"observable_mm", {}});
  for (int n = 0; n < 1200; ++n) {
    const double t = n / 2000.0;
    double y = 0.002 * normal(generator);
    for (const DampedSinusoid& one : sinusoids) {
      y += one.channels[0].amplitude * std::exp(-one.decay_per_s * t) *
           std::cos(kTwoPi * one.frequency_hz * t);
    }
    trace.time_s.push_back(t);
    trace.channels[0].values.push_back(y);
  }
  write_trace_csv(folder / "tip.csv", trace);
  return folder / "tip.csv";
}

CalibrationOptions quick() {
  CalibrationOptions options;
  options.ladder.max_dofs = 10000;
  options.ladder.coarse_dx_m = 2e-3;
  return options;
}

TEST(CalibrateMode, GivesTheModulusBackFromASecondModeThatDominates) {
  const test::TemporaryFolder folder;
  const fs::path trace = write_trace(folder, {sinusoid(kSecond_hz, 1.0), sinusoid(kFirst_hz, 0.3)});
  CalibrationOptions options = quick();
  const Calibration found = calibrate_from_traces(strip({0, 0, 1}), {trace}, options);
  // Euler's beam neglects shear and rotary inertia: 0.5 % of E for the second mode of this strip;
  // taken for the first, E would be 39 times as large.
  EXPECT_NEAR(found.material.youngs_modulus_identified_pa / kModulus_pa, 1.0, 0.015);
  EXPECT_EQ(found.material.eigenmode, mode_near(kSecond_hz) + 1);
  EXPECT_EQ(found.material.eigenmode_reason, found.mode.reason);
  EXPECT_NE(std::find(found.remarks.begin(), found.remarks.end(), found.mode.reason),
            found.remarks.end());
  // The coarse mesh with E_n moves at that frequency too, in its own mode of that shape.
  ASSERT_TRUE(found.validation && found.validation->run.usable());
  EXPECT_LT(std::abs(found.material.validation.frequency_error_rel), 0.01);

  options.validate = false;
  options.mode = 0;
  const Calibration overruled = calibrate_from_traces(strip({0, 0, 1}), {trace}, options);
  EXPECT_NEAR(overruled.material.youngs_modulus_identified_pa / kModulus_pa,
              std::pow(4.694091 / 1.875104, 4),
              1.0);
  EXPECT_EQ(overruled.material.provenance.options.at("mode"), "1");
  EXPECT_FALSE(overruled.mode.doubt.empty());
}

TEST(CalibrateMode, StaysWithTheFirstWhereTheFirstDominates) {
  const test::TemporaryFolder folder;
  CalibrationOptions options = quick();
  options.validate = false;
  const Calibration found = calibrate_from_traces(
      strip({0, 0, 1}),
      {write_trace(folder, {sinusoid(kFirst_hz, 1.0), sinusoid(kSecond_hz, 0.3)})},
      options);
  EXPECT_NEAR(found.material.youngs_modulus_identified_pa / kModulus_pa, 1.0, 0.015);
  EXPECT_EQ(found.material.eigenmode, 1);
}

/// A strip held at both ends whose middle is seen to turn: of its bending modes the second turns
/// it, the first does not.
Rig bridge() {
  Rig rig =
      test::make_rig({test::box_mm({0, 0, 0}, {80, 10, 2})},
                     {test::box_mm({0, 0, 0}, {0, 10, 2}), test::box_mm({80, 0, 0}, {80, 10, 2})});
  rig.materials[0].poissons_ratio = 0.3;
  rig.markers = {marker_at("left", {28, 0, 1}), marker_at("right", {52, 0, 1})};
  const std::array<Eigen::Vector3d, 4> bench = {Eigen::Vector3d(-4, 0, 17),
                                                Eigen::Vector3d(83, 0, 20),
                                                Eigen::Vector3d(80, 0, -17),
                                                Eigen::Vector3d(-6, 0, -15)};
  for (std::size_t i = 0; i < bench.size(); ++i) {
    rig.markers.push_back(marker_at(("bench_" + std::to_string(i)).c_str(), bench[i]));
    rig.markers.back().size_m = 5e-3;
    rig.markers.back().fixed = true;
  }
  rig.observable =
      ObservableDefinition{ObservableKind::Angle, {"left", "right"}, Eigen::Vector3d::Zero()};
  rig.release = Release{Eigen::Vector3d(22, 5, 2) * 1e-3, Eigen::Vector3d(0, 0, -1.5e-3), {}};
  rig.camera = Camera{};
  return rig;
}

TEST(CalibrateMode, OfAFilmWhoseObservableTheFirstModeDoesNotMove) {
  const test::TemporaryFolder folder;
  const Rig rig = bridge();
  RenderOptions render;
  render.dx_m = 5e-3;
  render.film.duration_s = 0.6;
  render.film.width_px = 480;
  render.film.height_px = 270;
  render.ladder.max_dofs = 10000;
  const RenderTruth truth =
      render_rig(rig, test::elastic(5e6, 0.3, 1180.0), folder / "film.mp4", render);
  CalibrationOptions options = quick();
  options.validate = false;
  const Calibration found = calibrate_from_films(rig, {folder / "film.mp4"}, options);
  EXPECT_GT(found.material.eigenmode, 1) << found.mode.reason;
  EXPECT_NEAR(found.material.frequency_hz / truth.frequency_hz, 2.757, 0.03)
      << "(7.8532 / 4.7300)², less a per cent of shear";
  // The film's mesh is coarse: the limit mesh needs a little more for the same frequency.
  const MeshRung filmed = compute_rung(rig, 5e-3, ElementKind::Hex20, found.material.eigenmode);
  const double limit_pa =
      5e6 * filmed.modes.lambda_per_s2[found.mode.mode] / found.limit.lambda_per_s2;
  EXPECT_NEAR(found.material.youngs_modulus_identified_pa / limit_pa, 1.0, 0.02);
  EXPECT_NE(found.mode.reason.find("mode 1 moves it"), std::string::npos) << found.mode.reason;
}

}  // namespace
}  // namespace twang
