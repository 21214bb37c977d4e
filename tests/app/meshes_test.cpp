// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces and meshes in files, as a user meets them.
#include "rigs/closed_surface.hpp"
#include "tests/support/command.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/surfaces.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace twang::test {
namespace {

using Eigen::Vector3d;

class Meshes : public ::testing::Test {
 protected:
  /// A free rig of one material whose part `what` describes.
  std::string rig(const std::string& what) {
    return folder
        .write("rig.toml",
               "format = \"twang-rig/1\"\nname = \"x\"\n[materials.m]\ndensity_kg_m3 = 1e3\n"
               "poissons_ratio = 0.3\n" +
                   what)
        .string();
  }
  std::string rig_of(const SurfaceMesh& surface) {
    write_stl(folder / "part.stl", surface);
    return rig(kSurface);
  }
  nlohmann::json modes(const std::string& path, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {"modes", path, "--count", "7", "--json", "-"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const CommandOutcome outcome = run_twang(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  }
  void expect_refused(const std::string& path, const std::string& said) {
    const CommandOutcome outcome = run_twang({"modes", path, "--dx", "2"});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_TRUE(holds(outcome.err, said));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  static constexpr const char* kSurface =
      "[[part]]\nmaterial = \"m\"\nshape = \"mesh\"\nfile = \"part.stl\"\n";
  TemporaryFolder folder;
};

const SurfaceMesh kBall = sphere(Vector3d::Zero(), 0.01, 20);

TEST_F(Meshes, ASurfaceBecomesAMeshAndWhatWasMendedIsSaid) {
  const nlohmann::json json = modes(rig_of(inside_out(kBall)), {"--dx", "2"});
  ASSERT_EQ(json["notes"].size(), 2U);
  EXPECT_TRUE(holds(json["notes"][0], "is inside out"));
  EXPECT_TRUE(holds(json["notes"][1], "volume than the part"));
  const double volume_mm3 = 1e9 * enclosed_volume(kBall);
  EXPECT_NEAR(json["part_volume_mm3"].get<double>() / volume_mm3, 1.0, 1e-6);  // single precision
  const CommandOutcome text = run_twang({"modes", rig_of(inside_out(kBall)), "--dx", "2"});
  EXPECT_TRUE(holds(text.out, "note: "));
}

TEST_F(Meshes, PartialCellsKeepTheVolume) {
  const std::string path = rig_of(kBall);
  const double volume_mm3 = 1e9 * enclosed_volume(kBall);
  const nlohmann::json centres = modes(path, {"--dx", "7"});
  const nlohmann::json mass = modes(path, {"--dx", "7", "--partial-cells", "mass"});
  const nlohmann::json both = modes(path, {"--dx", "7", "--partial-cells", "mass_and_stiffness"});
  EXPECT_GT(std::abs(centres["mesh_volume_mm3"].get<double>() / volume_mm3 - 1.0), 0.01);
  EXPECT_NEAR(mass["mesh_volume_mm3"].get<double>() / volume_mm3, 1.0, 1e-6);  // single precision
  const auto first = [](const nlohmann::json& json) {
    return json["modes"][6]["natural_frequency_hz"].get<double>();
  };
  // the same masses on softer springs
  EXPECT_LT(first(both), 0.99 * first(mass));
  EXPECT_EQ(run_twang({"modes", path, "--dx", "7", "--partial-cells", "some"}).exit_code, 2);
}

TEST_F(Meshes, TheShapesOfAMeshCanBeReadAsAMesh) {
  const std::string solid = rig_of(kBall);
  ASSERT_EQ(
      run_twang({"modes", solid, "--dx", "4", "--count", "7", "--vtu", (folder / "out").string()})
          .exit_code,
      0);
  const nlohmann::json expected = modes(solid, {"--dx", "4"});
  const nlohmann::json json = modes(rig("[mesh]\nfile = \"out/mode_01.vtu\"\nunit_mm = 1000\n"));
  EXPECT_EQ(json["elements"], expected["elements"]);
  EXPECT_NEAR(json["modes"][6]["natural_frequency_hz"].get<double>() /
                  expected["modes"][6]["natural_frequency_hz"].get<double>(),
              1.0,
              1e-7);  // the eigenvalue solver's tolerance, at other node numbers
  EXPECT_EQ(run_twang({"coarsen", rig("[mesh]\nfile = \"out/mode_01.vtu\"\n")}).exit_code, 2);
}

TEST_F(Meshes, BadSurfacesAreRefusedInOneSentence) {
  expect_refused(rig_of(without_triangles(kBall, 50, 2)), "is not a closed surface");
  expect_refused(rig_of(together({kBall, sphere(Vector3d(0.03, 0, 0), 0.005, 20)})),
                 "is not connected by faces");
  SurfaceMesh nan = kBall;
  nan.vertices(1, 7) = std::nan("");
  expect_refused(rig_of(nan), "is not finite");
  folder.write("part.stl", "");
  expect_refused(rig(kSurface), "part.stl: is empty");
  write_stl(folder / "whole.stl", kBall);
  std::filesystem::resize_file(folder / "whole.stl", 1000);
  std::filesystem::rename(folder / "whole.stl", folder / "part.stl");
  expect_refused(rig(kSurface), "is cut short");
  expect_refused(rig("[mesh]\nfile = \"no.msh\"\n"), "mesh.file is 'no.msh'");
}

TEST_F(Meshes, ADxLargerThanThePartMakesOneCell) {
  const nlohmann::json json = modes(rig_of(kBall), {"--dx", "1000"});
  EXPECT_EQ(json["elements"], 1);
  ASSERT_EQ(json["notes"].size(), 1U);
  EXPECT_TRUE(holds(json["notes"][0], "more volume than the part"));
}

}  // namespace
}  // namespace twang::test
