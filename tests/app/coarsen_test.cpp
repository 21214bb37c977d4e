// SPDX-License-Identifier: GPL-3.0-or-later
// `twang coarsen` as a user meets it: the ladder, and the measurement without a film.
#include "core/atomic_file.hpp"
#include "core/material_file.hpp"
#include "tests/support/command.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace twang::test {
namespace {

class Coarsen : public ::testing::Test {
 protected:
  /// A cube-like block on its foot, of material "m".
  std::string rig(const std::string& of_material,
                  const std::string& more = "",
                  const std::string& part = kBlock) {
    return folder
        .write("rig.toml",
               "format = \"twang-rig/1\"\nname = \"block\"\n[materials.m]\n"
               "density_kg_m3 = 1e3\npoissons_ratio = 0.3\n" +
                   of_material + part + more +
                   "[[clamp]]\nmin_mm = [0.0, 0.0, 0.0]\nmax_mm = [10.0, 10.0, 0.0]\n")
        .string();
  }
  static constexpr const char* kBlock =
      "[[part]]\nmaterial = \"m\"\nshape = \"box\"\nmin_mm = [0.0, 0.0, 0.0]\n"
      "max_mm = [10.0, 10.0, 20.0]\n";
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

TEST_F(Coarsen, APartFromAMeshFileIsCalibratedAsTheSolidItIsAMeshOf) {
  std::string trace = "time_s,tip_mm\n";
  for (int i = 0; i < 400; ++i) {
    const double t = i * 1e-5;
    trace += fmt::format("{:.6f},{:.9f}\n", t, std::exp(-300.0 * t) * std::sin(2e4 * t + 0.3));
  }
  folder.write("trace.csv", trace);
  const auto calibrated = [&](const std::string& path, const char* out, const char* mode) {
    const CommandOutcome outcome = run_twang({"calibrate",
                                              path,
                                              "--trace",
                                              (folder / "trace.csv").string(),
                                              "--no-validation",
                                              "--mode",
                                              mode,
                                              "--out",
                                              (folder / out).string()});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return read_material(folder / out / "material.json");
  };
  const std::string tolerance = "[tolerance]\ndimension_mm = 0.05\n";
  const std::string solid = rig("", tolerance);
  const Material expected = calibrated(solid, "of_solid", "3");
  // The report plots the mode that was chosen.
  EXPECT_TRUE(holds(read_file(folder / "of_solid" / "report.html"),
                    "frequency of eigenmode 3 at the identified E"));

  const std::string mesh = (folder / "mesh").string();
  ASSERT_EQ(run_twang({"modes", solid, "--dx", "10", "--vtu", mesh}).exit_code, 0);
  const Material found = calibrated(
      rig("", tolerance, "[mesh]\nfile = \"mesh/mode_01.vtu\"\nunit_mm = 1000\n"), "of_file", "3");
  // Both ladders halve the same cells of 10 mm.
  EXPECT_NEAR(
      found.youngs_modulus_identified_pa / expected.youngs_modulus_identified_pa, 1.0, 1e-6);
  EXPECT_NEAR(found.youngs_modulus_numerical_pa / expected.youngs_modulus_numerical_pa, 1.0, 1e-6);
  // The same faces grow, of one on the finest mesh, of the other on the coarsest accurate one.
  EXPECT_NEAR(found.uncertainty.dimension / expected.uncertainty.dimension, 1.0, 0.05);
  ASSERT_EQ(found.provenance.inputs.size(), 3U);
  EXPECT_EQ(found.provenance.inputs[1].file, "mode_01.vtu");
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
