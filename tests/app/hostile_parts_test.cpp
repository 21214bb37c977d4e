// SPDX-License-Identifier: GPL-3.0-or-later
// Parts that cannot be computed, or hardly, by each command that meshes: one sentence and exit
// code 2, or a right answer.
#include "tests/support/command.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/surfaces.hpp"
#include "tests/support/temporary_folder.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace twang::test {
namespace {

using Eigen::Vector3d;

constexpr const char* kClamp =
    "[[clamp]]\nmin_mm = [0.0, -9.0, -9.0]\nmax_mm = [0.0, 99.0, 99.0]\n";
constexpr const char* kBox =
    "[[part]]\nmaterial = \"m\"\nshape = \"box\"\nmin_mm = [0.0, 0.0, 0.0]\n"
    "max_mm = [40.0, 10.0, 4.0]\n";
constexpr const char* kSurface =
    "[[part]]\nmaterial = \"m\"\nshape = \"mesh\"\nfile = \"part.stl\"\n";

Box bar() { return {Vector3d::Zero(), Vector3d(0.04, 0.01, 0.004)}; }

class HostileParts : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string trace = "time_s,tip\n";
    for (int i = 0; i < 480; ++i) {
      const double t = i / 240.0;
      trace += fmt::format("{:.9f},{:.9f}\n", t, std::exp(-5.0 * t) * std::sin(195.0 * t));
    }
    folder.write("trace.csv", trace);
  }
  std::string rig(const std::string& parts,
                  const std::string& clamp = kClamp,
                  const std::string& nu = "0.4",
                  const std::string& density = "1180.0") {
    return folder
        .write("rig.toml",
               "format = \"twang-rig/1\"\nname = \"x\"\n[materials.m]\ndensity_kg_m3 = " + density +
                   "\npoissons_ratio = " + nu + "\n" + parts + clamp)
        .string();
  }
  std::string rig_of(const SurfaceMesh& surface) {
    write_stl(folder / "part.stl", surface);
    return rig(kSurface);
  }
  void expect_refused(const std::string& said, const std::vector<std::string>& command) {
    const CommandOutcome outcome = run_twang(command);
    EXPECT_EQ(outcome.exit_code, 2) << command[0];
    EXPECT_TRUE(holds(outcome.err, said)) << command[0];
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  /// By all three commands that mesh a rig.
  void expect_refused_by_all(const std::string& rig_path, const std::string& said) {
    expect_refused(said, {"modes", rig_path, "--dx", "2"});
    expect_refused_by_coarsening(rig_path, said);
  }
  void expect_refused_by_coarsening(const std::string& rig_path, const std::string& said) {
    expect_refused(said, {"coarsen", rig_path});
    expect_refused(said,
                   {"calibrate",
                    rig_path,
                    "--trace",
                    (folder / "trace.csv").string(),
                    "--out",
                    (folder / "out").string()});
  }
  nlohmann::json modes(const std::string& rig_path, const std::string& dx, std::string element) {
    const CommandOutcome outcome = run_twang(
        {"modes", rig_path, "--dx", dx, "--count", "7", "--element", element, "--json", "-"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  }
  static double frequency(const nlohmann::json& json, int mode) {
    return json["modes"][static_cast<std::size_t>(mode)]["natural_frequency_hz"].get<double>();
  }

  TemporaryFolder folder;
};

TEST_F(HostileParts, AnOpenSurface) {
  expect_refused_by_all(rig_of(without_triangles(box_surface(bar()), 11, 1)),
                        "3 edges have only one triangle");
}

TEST_F(HostileParts, NoSurface) {
  folder.write("part.stl", "");
  expect_refused_by_all(rig(kSurface), "part.stl: is empty");
  folder.write("part.stl", std::string(84, '\0'));
  expect_refused_by_all(rig(kSurface), "has no triangle");
}

TEST_F(HostileParts, ASurfaceInsideOutIsTurned) {
  const double expected = frequency(modes(rig(kBox), "2", "hex8"), 0);
  const nlohmann::json json = modes(rig_of(inside_out(box_surface(bar()))), "2", "hex8");
  EXPECT_NEAR(frequency(json, 0) / expected, 1.0, 1e-7);  // the eigenvalue solver's tolerance
  EXPECT_TRUE(holds(json["notes"][0], "is inside out"));
}

TEST_F(HostileParts, ASurfaceThatCrossesItselfCountsOnce) {
  const Box other{Vector3d(0.03, 0.002, 0.0), Vector3d(0.05, 0.008, 0.004)};
  const nlohmann::json json =
      modes(rig_of(together({box_surface(bar()), box_surface(other)})), "2", "hex8");
  const std::string both = std::string(kBox) +
                           "[[part]]\nmaterial = \"m\"\nshape = \"box\"\n"
                           "min_mm = [30.0, 2.0, 0.0]\nmax_mm = [50.0, 8.0, 4.0]\n";
  EXPECT_NEAR(frequency(json, 0) / frequency(modes(rig(both), "2", "hex8"), 0), 1.0, 1e-7);
  EXPECT_TRUE(holds(json["notes"][0], "240 mm³ lie inside more than once"));
}

TEST_F(HostileParts, AMillionTriangles) {
  // A ring that so many facets leave as round as a twentieth of them do.
  const auto modes_of_ring = [&](int num_u, int num_v) {
    write_stl(folder / "part.stl", torus(Vector3d::Zero(), 0.02, 0.006, num_u, num_v));
    const std::string path = rig(kSurface, "");
    return modes(path, "2", "hex8");
  };
  const nlohmann::json fine = modes_of_ring(1000, 500);
  EXPECT_NEAR(fine["part_volume_mm3"].get<double>() / 1e9,
              torus_volume(0.02, 0.006, 1000, 500),
              1e-6 * torus_volume(0.02, 0.006, 1000, 500));  // an STL's single precision
  EXPECT_NEAR(frequency(fine, 6) / frequency(modes_of_ring(200, 100), 6), 1.0, 1e-7);
}

TEST_F(HostileParts, BodiesThatDoNotTouch) {
  const Box apart{Vector3d(0.06, 0.0, 0.0), Vector3d(0.08, 0.01, 0.004)};
  expect_refused_by_all(rig_of(together({box_surface(bar()), box_surface(apart)})),
                        "bodies that do not touch must be joined");
  expect_refused_by_all(
      rig(std::string(kBox) + "[[part]]\nmaterial = \"m\"\nshape = \"box\"\n"
                              "min_mm = [60.0, 0.0, 0.0]\nmax_mm = [80.0, 10.0, 4.0]\n"),
      "part 2 of 2");
}

TEST_F(HostileParts, ADxLargerThanThePartMakesOneCell) {
  const nlohmann::json json = modes(rig(kBox, ""), "1000", "hex8");
  EXPECT_EQ(json["elements"], 1);
  EXPECT_EQ(frequency(json, 5), 0.0);
  EXPECT_GT(frequency(json, 6), 0.0);
}

TEST_F(HostileParts, PoissonsRatiosOfNoMaterial) {
  expect_refused_by_all(rig(kBox, kClamp, "0.5"), "poissons_ratio is 0.5, must be below 0.5");
  expect_refused_by_all(rig(kBox, kClamp, "-1.0"), "poissons_ratio is -1, must be between");
}

TEST_F(HostileParts, ANearlyIncompressiblePartIsRightByTwoElementsAndSaidToLockByTheThird) {
  const std::string path = rig(kBox, kClamp, "0.499");
  const double expected = frequency(modes(path, "2", "hex20"), 0);
  // Coarse cells of three kinds: hex8e within 1 %, hex8 half as high again.
  EXPECT_NEAR(frequency(modes(path, "2", "hex8e"), 0) / expected, 1.0, 0.01);
  const nlohmann::json locked = modes(path, "2", "hex8");
  EXPECT_GT(frequency(locked, 0) / expected, 1.3);
  EXPECT_TRUE(holds(locked["notes"][0], "hex8 locks at nu = 0.499"));
  EXPECT_TRUE(modes(rig(kBox), "2", "hex8")["notes"].empty());
}

TEST_F(HostileParts, NoDensity) {
  expect_refused_by_all(rig(kBox, kClamp, "0.4", "0.0"), "density_kg_m3 is 0, must be > 0");
}

TEST_F(HostileParts, NothingHeldAndAllHeld) {
  const std::string free_rig = rig(kBox, "");
  EXPECT_EQ(frequency(modes(free_rig, "2", "hex8"), 5), 0.0);
  EXPECT_GT(frequency(modes(free_rig, "2", "hex8"), 6), 0.0);
  expect_refused_by_coarsening(free_rig, "[[clamp]] is missing");
  expect_refused_by_all(
      rig(kBox, "[[clamp]]\nmin_mm = [0.0, 0.0, 0.0]\nmax_mm = [40.0, 10.0, 4.0]\n"),
      "0 unknowns of \"x\" free to move");
  expect_refused_by_all(
      rig(kBox, "[[clamp]]\nmin_mm = [50.0, 0.0, 0.0]\nmax_mm = [60.0, 10.0, 4.0]\n"),
      "clamp.1 holds nothing");
}

}  // namespace
}  // namespace twang::test
