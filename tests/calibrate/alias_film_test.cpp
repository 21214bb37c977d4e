// SPDX-License-Identifier: GPL-3.0-or-later
// A film too slow for its rig, from its pictures to what a person is told.
#include "calibrate/calibrate.hpp"
#include "calibrate/render_rig.hpp"
#include "rigs/load_rig.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

namespace twang::test {
namespace {

constexpr double kFps = 240.0;
constexpr double kModulus_pa = 6.72e9;

bool any_holds(const std::vector<std::string>& sentences, const std::string& part) {
  return std::any_of(sentences.begin(), sentences.end(), [&](const std::string& sentence) {
    return static_cast<bool>(holds(sentence, part));
  });
}

TEST(AliasedFilm, IsWarnedOfWithItsTwinsAndNeverSilentlyBelieved) {
  const TemporaryFolder folder;
  Rig rig = load_rig(std::filesystem::path(TWANG_SOURCE_DIR) / "rigs" / "strip.toml",
                     {.part = true, .clamp = true, .film = true, .observable = true});
  RenderOptions render;
  render.element = ElementKind::Hex8;
  render.ladder.max_dofs = 6000;  // of the truth's limit mesh, which is not asked here
  render.amplitude = 0.6;
  render.film.width_px = 480;
  render.film.height_px = 270;
  render.film.duration_s = 0.6;
  const RenderTruth truth =
      render_rig(rig, {kModulus_pa, 0.45, 1180.0, 1.8e-5}, folder / "stiff.mp4", render);
  // the film is what it should be: the first mode at about 0.7 of the frame rate
  EXPECT_NEAR(truth.frequency_hz / kFps, 0.7, 0.03);
  const double folded_hz = kFps - truth.frequency_hz;

  CalibrationOptions options;
  options.ladder.max_dofs = 20000;
  options.validate = false;
  const Calibration unsuspecting = calibrate_from_films(rig, {folder / "stiff.mp4"}, options);
  EXPECT_NEAR(unsuspecting.material.frequency_hz, folded_hz, 0.1);
  EXPECT_FALSE(any_holds(unsuspecting.warnings, "The strongest sinusoid"));  // nothing tells

  rig.materials[0].reported_youngs_modulus_pa = kModulus_pa;
  const Calibration told = calibrate_from_films(rig, {folder / "stiff.mp4"}, options);
  EXPECT_NEAR(told.material.frequency_hz, folded_hz, 0.1);
  const auto warning =
      std::find_if(told.warnings.begin(), told.warnings.end(), [](const std::string& sentence) {
        return sentence.starts_with("The strongest sinusoid at ");
      });
  ASSERT_NE(warning, told.warnings.end());
  double seen_hz = 0.0;
  double twin_hz = 0.0;
  ASSERT_EQ(std::sscanf(warning->c_str(),
                        "The strongest sinusoid at %lf Hz may be the alias of one at %lf Hz,",
                        &seen_hz,
                        &twin_hz),
            2)
      << *warning;
  EXPECT_NEAR(seen_hz, folded_hz, 0.1);           // tracked in noise
  EXPECT_NEAR(twin_hz, truth.frequency_hz, 0.1);  // the true one
  EXPECT_TRUE(holds(*warning, "sampled at 240 frames/s"));

  // what is ordinary stands apart from what is to be heeded
  EXPECT_TRUE(any_holds(told.remarks, "Constant rate: 144 frames"));
  EXPECT_TRUE(any_holds(told.remarks, "Window: "));
  EXPECT_FALSE(any_holds(told.warnings, "Constant rate"));
  EXPECT_FALSE(any_holds(told.warnings, "Window: "));
}

}  // namespace
}  // namespace twang::test
