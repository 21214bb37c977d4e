// SPDX-License-Identifier: GPL-3.0-or-later
// Recordings nobody here made, by the commands a user would type.
#include "tests/support/real_recordings.hpp"

#include "core/atomic_file.hpp"
#include "core/material_file.hpp"
#include "tests/support/command.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

const std::string kRigs = std::string(TWANG_SOURCE_DIR) + "/rigs/";

class RealRecording : public testing::Test {
 protected:
  void SetUp() override {
    real = real_recordings();
    if (real.empty())
      GTEST_SKIP() << "the real recordings are not beside this checkout (TWANG_REAL_DATA names "
                      "their folder)";
  }
  nlohmann::json invert(const std::vector<std::string>& arguments) {
    std::vector<std::string> all = {"invert"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    all.insert(all.end(), {"--json", "-"});
    const CommandOutcome outcome = run_twang(all);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  }
  fs::path real;
  TemporaryFolder folder;
};

TEST_F(RealRecording, SiliconeBeamsGravityReleasesGiveItsModulus) {
  const fs::path beam = real / "silicone_beam";
  const std::string a = (beam / "beam_gravity_V2_a.csv").string();
  const std::string b = (beam / "beam_gravity_V2_b.csv").string();
  // an independent least-squares fit of this channel: 7.75 Hz, 2.43 to 2.49 1/s
  for (const std::string& trace : {a, b}) {
    const auto modes = invert({trace, "--column", "m0x_m"}).at("modes");
    ASSERT_FALSE(modes.empty()) << trace;
    EXPECT_NEAR(modes[0].at("frequency_hz").get<double>(), 7.75, 0.05) << trace;
    EXPECT_NEAR(modes[0].at("decay_per_s").get<double>(), 2.45, 0.1) << trace;
  }
  const CommandOutcome outcome = run_twang({"calibrate",
                                            kRigs + "silicone_beam.toml",
                                            "--trace",
                                            a,
                                            "--trace",
                                            b,
                                            "--column",
                                            "m0x_m",
                                            "--dx",
                                            "10",
                                            "--out",
                                            (folder / "out").string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Material material = read_material(folder / "out" / "material.json");
  EXPECT_NEAR(material.frequency_hz, 7.75, 0.05);
  EXPECT_NEAR(material.decay_per_s, 2.45, 0.1);
  // CalculiX' C3D20 meshes converge to 292 kPa for that frequency: 290.6 at its finest, still
  // rising
  EXPECT_NEAR(material.youngs_modulus_identified_pa / 292e3, 1.0, 0.03);
  const auto ladder = nlohmann::json::parse(read_file(folder / "out" / "ladder.json"));
  EXPECT_TRUE(ladder.at("convergent").get<bool>()) << "next to incompressibility";
  EXPECT_NE(outcome.out.find("from the reported one"), std::string::npos)
      << "the distance to the authors' modulus is said";
  std::printf("%s", outcome.out.c_str());

  // The same beam with 52 g at its tip, foretold by that material.
  const CommandOutcome loaded = run_twang({"predict",
                                           kRigs + "silicone_beam_52g.toml",
                                           "--material",
                                           (folder / "out").string(),
                                           "--trace",
                                           (beam / "beam_load52_V2_a.csv").string(),
                                           "--column",
                                           "m0x_m",
                                           "--out",
                                           (folder / "loaded").string()});
  ASSERT_EQ(loaded.exit_code, 0) << loaded.err;
  const auto prediction = nlohmann::json::parse(read_file(folder / "loaded" / "prediction.json"));
  // an independent fit of the trace: 4.36 Hz, 1.65 1/s
  EXPECT_NEAR(prediction.at("tracked").at("frequency_hz").get<double>(), 4.36, 0.02);
  EXPECT_LT(std::abs(prediction.at("frequency_error_rel").get<double>()), 0.02);
  // b by that fit: 2 d / lambda = 4.4 ms here, 2.06 ms without the weight.
  EXPECT_NEAR(prediction.at("tracked_over_material_b").get<double>(), 2.1, 0.1);
  EXPECT_NE(loaded.out.find("b depends on frequency"), std::string::npos)
      << "that the decay misses, and why, is said";
  std::printf("%s", loaded.out.c_str());
}

TEST_F(RealRecording, JumperRigOfThePaper) {
  for (const char* file :
       {"jumper_rigur_dots_angle_1khz.csv", "jumper_rigur_dots_angle_240hz.csv"}) {
    const auto modes = invert({(real / "chen2017_rig" / file).string()}).at("modes");
    ASSERT_FALSE(modes.empty()) << file;
    const double f = modes[0].at("frequency_hz");
    const double d = modes[0].at("decay_per_s");
    EXPECT_NEAR(f / 48.53, 1.0, 0.002) << file;
    EXPECT_NEAR(d / 7.66, 1.0, 0.01) << file;
    const double lambda = std::pow(2.0 * M_PI * f, 2) + d * d;
    EXPECT_NEAR(2.0 * d / lambda / 1.64e-4, 1.0, 0.02) << file << ": the paper's b";
    std::printf("%s: f %.4f Hz, d %.4f 1/s, b %.4g s\n", file, f, d, 2.0 * d / lambda);
  }
}

TEST_F(RealRecording, TowerFilmFromFourClicks) {
  const std::string trace = (folder / "tower.csv").string();
  const CommandOutcome outcome = run_twang({"track",
                                            kRigs + "knex_tower.toml",
                                            (real / "knex_tower" / "tower.mp4").string(),
                                            "-o",
                                            trace,
                                            "--capture-fps",
                                            "22.674",
                                            "--marker",
                                            "top=311,228",
                                            "--marker",
                                            "storey_2=314,467",
                                            "--marker",
                                            "storey_1=317,709",
                                            "--marker",
                                            "base=320,953"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  // the release near frame 147 and the free motion before the next pull
  const auto modes = invert({trace, "--start", "6.38", "--end", "8.5"}).at("modes");
  ASSERT_FALSE(modes.empty());
  EXPECT_NEAR(modes[0].at("frequency_hz").get<double>(), 6.97, 0.15);
  EXPECT_NEAR(modes[0].at("damping_ratio").get<double>(), 0.086, 0.02);
  std::printf("tower: f %.3f Hz, damping ratio %.4f\n",
              modes[0].at("frequency_hz").get<double>(),
              modes[0].at("damping_ratio").get<double>());
}

}  // namespace
}  // namespace twang::test
