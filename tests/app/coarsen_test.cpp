// SPDX-License-Identifier: GPL-3.0-or-later
// `twang coarsen` as a user meets it: the ladder, and the measurement without a film.
#include "core/material_file.hpp"
#include "tests/support/command.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>

namespace twang::test {
namespace {

class Coarsen : public ::testing::Test {
 protected:
  /// A cube-like block on its foot, of material "m".
  std::string rig(const std::string& of_material, const std::string& more = "") {
    return folder
        .write("rig.toml",
               "format = \"twang-rig/1\"\nname = \"block\"\n[materials.m]\n"
               "density_kg_m3 = 1e3\npoissons_ratio = 0.3\n" +
                   of_material +
                   "[[part]]\nmaterial = \"m\"\nshape = \"box\"\nmin_mm = [0.0, 0.0, 0.0]\n"
                   "max_mm = [10.0, 10.0, 20.0]\n" +
                   more + "[[clamp]]\nmin_mm = [0.0, 0.0, 0.0]\nmax_mm = [10.0, 10.0, 0.0]\n")
        .string();
  }
  void expect_refused(const std::vector<std::string>& arguments, const std::string& said) {
    const CommandOutcome outcome = run_twang(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_TRUE(holds(outcome.err, said));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  TemporaryFolder folder;
};

constexpr const char* kStated = "youngs_modulus_pa = 2e9\n";

TEST_F(Coarsen, WritesTheVirtualMeasurementOfAStatedModulus) {
  const std::string out = (folder / "out").string();
  const CommandOutcome outcome = run_twang({"coarsen",
                                            rig(kStated),
                                            "--out",
                                            out,
                                            "--damping-b",
                                            "2e-5",
                                            "--element",
                                            "hex8e",
                                            "--json",
                                            "-"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json ladder = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(ladder["chosen"]["element"], "hex8e");
  EXPECT_EQ(ladder["beside"]["element"], "hex8");
  const Material material = read_material(folder / "out" / "material.json");
  EXPECT_EQ(material.youngs_modulus_identified_pa, 2e9);
  EXPECT_NEAR(material.youngs_modulus_identified_pa / material.youngs_modulus_numerical_pa,
              ladder["chosen"]["modulus_identified_over_numerical"].get<double>(),
              1e-12);
  EXPECT_EQ(material.damping_stiffness_b_s, 2e-5);
  EXPECT_EQ(material.numerical_element, "hex8e");
  EXPECT_TRUE(std::filesystem::exists(folder / "out" / "table.csv"));
  EXPECT_TRUE(std::filesystem::exists(folder / "out" / "ladder.json"));
  EXPECT_EQ(run_twang({"table", out}).exit_code, 0);
}

TEST_F(Coarsen, PrintsTheFrequenciesBeforeAndAfterTheRescaleOfBothElements) {
  const CommandOutcome outcome = run_twang({"coarsen", rig("")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(holds(outcome.out, "error before -> after"));
  EXPECT_TRUE(holds(outcome.out, "hex8e"));
  EXPECT_TRUE(holds(outcome.out, "E / E_n = "));
}

TEST_F(Coarsen, OfSeveralMaterialsWritesOneFileEach) {
  const std::string two =
      "[materials.n]\ndensity_kg_m3 = 1e3\npoissons_ratio = 0.3\n"
      "youngs_modulus_pa = 1e9\n[[part]]\nmaterial = \"n\"\nshape = \"box\"\n"
      "min_mm = [0.0, 0.0, 10.0]\nmax_mm = [10.0, 10.0, 20.0]\n";
  const CommandOutcome outcome =
      run_twang({"coarsen", rig(kStated, two), "--out", (folder / "out").string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(holds(outcome.out, "at the moduli stated"));
  EXPECT_EQ(read_material(folder / "out" / "material_1.json").material, "m");
  EXPECT_EQ(read_material(folder / "out" / "material_2.json").material, "n");
  expect_refused({"coarsen", rig("", two)}, "\"m\" states no youngs_modulus_pa");
}

TEST_F(Coarsen, RefusesWhatItCannotDo) {
  const std::string out = (folder / "out").string();
  expect_refused({"coarsen", rig(""), "--out", out}, "materials.m states no youngs_modulus_pa");
  expect_refused({"coarsen", rig(kStated), "--element", "hex20"},
                 "coarse_element is hex20, must be hex8 or hex8e");
  expect_refused({"coarsen", rig(kStated), "--modes", "0"}, "num_modes is 0");
  expect_refused({"coarsen", rig(kStated), "--damping-b", "1e-5"}, "must come with --out");
  expect_refused({"coarsen", rig(kStated), "--out", out, "--damping-b", "-1"}, "must be >= 0 s");
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace twang::test
