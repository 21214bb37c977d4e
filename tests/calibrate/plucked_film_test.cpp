// SPDX-License-Identifier: GPL-3.0-or-later
// One film in which a strip is plucked several times, from rendering to the repeats.
#include "calibrate/calibrate.hpp"
#include "calibrate/render_rig.hpp"
#include "core/error.hpp"
#include "rigs/load_rig.hpp"
#include "tests/support/rigs.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace twang {
namespace {

TEST(PluckedFilm, GivesEachReleaseAsARepeat) {
  const test::TemporaryFolder folder;
  Rig rig = load_rig(std::string(TWANG_SOURCE_DIR) + "/rigs/strip.toml",
                     {.part = true, .clamp = true, .film = true});
  constexpr double kFps = 120.0;
  rig.camera->capture_fps = kFps;
  rig.tolerance = {};
  ElasticMaterial material = test::elastic(5e8, 0.45, 1180.0);  // 33 Hz
  material.damping_stiffness_b_s = 6e-4;                        // 13 1/s
  RenderOptions render;
  render.plucks = 3;
  render.film.fps = kFps;
  render.film.duration_s = 2.4;
  render.film.width_px = 320;
  render.film.height_px = 180;
  render.ladder.max_dofs = 10000;
  render.ladder.coarse_dx_m = 5e-3;
  const RenderTruth truth = render_rig(rig, material, folder / "film.mp4", render);
  ASSERT_EQ(truth.releases_s.size(), 3U);

  CalibrationOptions options;
  options.each_release = true;
  options.validate = false;
  options.ladder = render.ladder;
  const Calibration found = calibrate_from_films(rig, {folder / "film.mp4"}, options);
  ASSERT_EQ(found.repeats.size(), 3U);
  for (std::size_t n = 0; n < 3; ++n) {
    ASSERT_TRUE(found.repeats[n].inversion.release_s);
    // a frame or two: what is filmed at the release is smeared over the exposure
    EXPECT_NEAR(*found.repeats[n].inversion.release_s, truth.releases_s[n], 2.5 / kFps);
  }
  const Material& back = found.material;
  EXPECT_NEAR(back.youngs_modulus_identified_pa / truth.youngs_modulus_limit_pa, 1.0, 0.02);
  EXPECT_NEAR(back.damping_stiffness_b_s / material.damping_stiffness_b_s, 1.0, 0.05);
  EXPECT_GT(back.uncertainty.repeats, 0.0);
  EXPECT_LT(back.uncertainty.repeats, 0.005) << "the plucks are alike but for noise";
}

TEST(PluckedFilm, RefusesMorePlucksThanItHasTimeFor) {
  RenderOptions render;
  render.plucks = 8;  // 0.19 s each
  EXPECT_THROW(render.check(), InputError);
  render.plucks = 0;
  EXPECT_THROW(render.check(), InputError);
  render.plucks = 3;
  EXPECT_NO_THROW(render.check());
}

}  // namespace
}  // namespace twang
