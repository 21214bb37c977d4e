// SPDX-License-Identifier: GPL-3.0-or-later
// `twang rheology`: calibrations of one material, from their folders to table and plot.
#include "core/atomic_file.hpp"
#include "core/constants.hpp"
#include "core/material_file.hpp"
#include "tests/support/command.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

/// The folder of a calibration at a frequency, E = 1 MPa f^0.06.
std::string calibration(const TemporaryFolder& folder, const std::string& name, double f) {
  fs::create_directories(folder / name);
  Material material;
  material.material = "silicone";
  material.youngs_modulus_identified_pa = 1e6 * std::pow(f, 0.06);
  material.youngs_modulus_identified_sigma_pa = 0.01 * material.youngs_modulus_identified_pa;
  material.uncertainty.statistical = 0.002;
  material.youngs_modulus_numerical_pa = 5e5;
  material.numerical_element = "hex8";
  material.numerical_dx_mm = 2.0;
  material.numerical_elements = 40;
  material.poissons_ratio = 0.49;
  material.density_kg_m3 = 1070.0;
  material.frequency_hz = f;
  material.frequency_sigma_hz = 1e-3 * f;
  material.decay_per_s = 0.05 * kTwoPi * f;
  material.decay_sigma_per_s = 0.02 * material.decay_per_s;
  material.lambda_per_s2 = std::pow(kTwoPi * f, 2) + std::pow(material.decay_per_s, 2);
  material.damping_stiffness_b_s = 2.0 * material.decay_per_s / material.lambda_per_s2;
  material.damping_stiffness_b_sigma_s = 0.02 * material.damping_stiffness_b_s;
  material.tan_delta = material.damping_stiffness_b_s * std::sqrt(material.lambda_per_s2);
  write_material(folder / name / "material.json", material);
  return (folder / name).string();
}

TEST(RheologyCommand, WritesTablePlotAndSentences) {
  const TemporaryFolder folder;
  const CommandOutcome outcome = run_twang({"rheology",
                                            calibration(folder, "heavy, with a \"comma\"", 4.0),
                                            calibration(folder, "bare", 40.0),
                                            calibration(folder, "half", 12.0),
                                            "--out",
                                            (folder / "out").string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("E changes with frequency"), std::string::npos) << outcome.out;
  const auto json = nlohmann::json::parse(read_file(folder / "out" / "rheology.json"));
  EXPECT_EQ(json.at("format"), "twang-rheology/1");
  ASSERT_EQ(json.at("points").size(), 3U);
  EXPECT_EQ(json.at("points")[0].at("frequency_hz"), 4.0) << "ascending";
  EXPECT_NEAR(json.at("modulus_power_law").at("exponent").get<double>(), 0.06, 1e-9);
  EXPECT_TRUE(json.at("modulus_changes").get<bool>());
  const std::string csv = read_file(folder / "out" / "rheology.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4) << csv;
  EXPECT_NE(csv.find("heavy, with a \"\"comma\"\"\""), std::string::npos) << csv;
  const std::string page = read_file(folder / "out" / "rheology.html");
  EXPECT_NE(page.find("\"bars\":[["), std::string::npos) << "error bars";
  EXPECT_NE(page.find("tan delta"), std::string::npos);
}

TEST(RheologyCommand, RefusesBrokenFoldersAndOtherMaterialsInOneSentence) {
  const TemporaryFolder folder;
  const std::string good = calibration(folder, "good", 4.0);
  const std::string other = calibration(folder, "other", 40.0);
  std::string text = read_file(fs::path(other) / "material.json");
  text.replace(text.find("silicone"), 8, "rubber");
  write_file_atomically(fs::path(other) / "material.json", text);
  fs::create_directories(folder / "empty");
  for (const std::string& second : {other, (folder / "empty").string(), std::string("nowhere")}) {
    const CommandOutcome outcome =
        run_twang({"rheology", good, second, "--out", (folder / "out").string()});
    EXPECT_EQ(outcome.exit_code, 2) << second;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_NE(outcome.err.find(second), std::string::npos) << outcome.err;
    EXPECT_FALSE(fs::exists(folder / "out"));
  }
  const CommandOutcome alone = run_twang({"rheology", good, "--out", (folder / "out").string()});
  EXPECT_EQ(alone.exit_code, 2);
}

}  // namespace
}  // namespace twang::test
