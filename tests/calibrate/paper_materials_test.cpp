// SPDX-License-Identifier: GPL-3.0-or-later
// The materials that the paper identified [Fig. 20], as films of a strip made of each: a
// calibration of the film must give them back.
#include "calibrate/calibrate.hpp"
#include "calibrate/render_rig.hpp"
#include "core/units.hpp"
#include "rigs/load_rig.hpp"
#include "tests/support/rigs.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <ostream>
#include <string>

namespace twang {
namespace {

struct PaperMaterial {
  const char* name;
  double identified_pa;
  double b_s;
  double fps;         // of the film
  double duration_s;  // of the film
};

void PrintTo(const PaperMaterial& material, std::ostream* out) { *out << material.name; }

class MaterialOfThePaper : public testing::TestWithParam<PaperMaterial> {};

/// The strip of rigs/strip.toml, shortened so that TangoBlackPlus vibrates at 1.3 Hz.
Rig strip(double fps) {
  Rig rig = load_rig(std::string(TWANG_SOURCE_DIR) + "/rigs/strip.toml",
                     {.part = true, .clamp = true, .film = true});
  constexpr double kLength_mm = 75.0;
  rig.parts[0].shape = test::box_mm({0, 0, 0}, {kLength_mm, 10, 2});
  rig.markers[0].position.x() = (kLength_mm - 4.0) * kMetresPerMillimetre;
  rig.release->at.x() = kLength_mm * kMetresPerMillimetre;
  rig.camera->capture_fps = fps;
  rig.tolerance = {};  // what is filmed has exactly the rig's dimensions
  return rig;
}

TEST_P(MaterialOfThePaper, ComesBackFromItsFilm) {
  const PaperMaterial& paper = GetParam();
  const test::TemporaryFolder folder;
  const Rig rig = strip(paper.fps);
  ElasticMaterial material = test::elastic(paper.identified_pa, 0.45, 1180.0);
  material.damping_stiffness_b_s = paper.b_s;
  LadderOptions ladder;
  ladder.max_dofs = 30000;
  ladder.coarse_dx_m = 5e-3;
  RenderOptions render;
  render.ladder = ladder;
  render.film.fps = paper.fps;
  render.film.duration_s = paper.duration_s;
  render.film.width_px = 480;
  render.film.height_px = 270;
  const RenderTruth truth = render_rig(rig, material, folder / "film.mp4", render);
  CalibrationOptions options;
  options.ladder = ladder;
  const Calibration found = calibrate_from_films(rig, {folder / "film.mp4"}, options);

  const Material& back = found.material;
  const double E_error = back.youngs_modulus_identified_pa / truth.youngs_modulus_limit_pa - 1.0;
  const double b_error = back.damping_stiffness_b_s / paper.b_s - 1.0;
  const double E_sigma = back.youngs_modulus_identified_sigma_pa / truth.youngs_modulus_limit_pa;
  const double b_sigma = back.damping_stiffness_b_sigma_s / paper.b_s;
  std::printf(
      "%s: f %.3f Hz, damping ratio %.3f; E %+.2f +- %.2f %%, b %+.2f +- %.2f %%; "
      "simulated over tracked: rms %.2f %%, f %+.2f %%, d %+.2f %%\n",
      paper.name,
      back.frequency_hz,
      0.5 * back.tan_delta,
      100.0 * E_error,
      100.0 * E_sigma,
      100.0 * b_error,
      100.0 * b_sigma,
      100.0 * back.validation.rms_rel,
      100.0 * back.validation.frequency_error_rel,
      100.0 * back.validation.decay_error_rel);
  if (!std::isfinite(back.validation.rms_rel)) {
    for (const std::string& warning : found.warnings) ADD_FAILURE() << warning;
  }
  // The figures of merit of a calibration on a clean film.
  EXPECT_LT(std::abs(E_error), 0.02);
  EXPECT_LT(std::abs(b_error), 0.05);
  EXPECT_LT(std::abs(E_error), 3.0 * E_sigma);
  EXPECT_LT(std::abs(b_error), 3.0 * b_sigma);
  EXPECT_LT(back.validation.rms_rel, 0.03);
  EXPECT_EQ(back.eigenmode, 1);
}

INSTANTIATE_TEST_SUITE_P(
    Fig20,
    MaterialOfThePaper,
    testing::Values(PaperMaterial{"Rigur, vertical", 1.66e9, 1.64e-4, 240.0, 0.5},
                    PaperMaterial{"Rigur, horizontal", 2.06e9, 1.40e-4, 240.0, 0.5},
                    PaperMaterial{"DM4825, horizontal", 1.57e9, 2.55e-4, 240.0, 0.5},
                    PaperMaterial{"TangoBlackPlus", 6.32e5, 9.10e-2, 60.0, 2.6}));

}  // namespace
}  // namespace twang
