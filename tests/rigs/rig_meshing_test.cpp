// SPDX-License-Identifier: GPL-3.0-or-later
// The table [mesh] of a rig file.
#include "rigs/load_rig.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

namespace twang {
namespace {

using test::holds;

const std::string kHead =
    "format = \"twang-rig/1\"\nname = \"x\"\n"
    "[materials.soft]\ndensity_kg_m3 = 1e3\npoissons_ratio = 0.3\n"
    "[materials.stiff]\ndensity_kg_m3 = 2e3\npoissons_ratio = 0.2\n";
const std::string kBox =
    "[[part]]\nmaterial = \"soft\"\nshape = \"box\"\nmin_mm = [0, 0, 0]\nmax_mm = [1, 2, 3]\n";

class RigMeshing : public ::testing::Test {
 protected:
  Rig load(const std::string& rest, const RigNeeds& needs = {}) {
    return load_rig(folder.write("rig.toml", kHead + rest), needs);
  }
  std::string refusal(const std::string& rest, const RigNeeds& needs = {}) {
    return test::refusal_of([&] { (void)load(rest, needs); });
  }
  test::TemporaryFolder folder;
};

TEST_F(RigMeshing, IsByCentresUnlessSaidOtherwise) {
  EXPECT_EQ(load(kBox).meshing.partial_cells, PartialCells::None);
  for (const PartialCells rule :
       {PartialCells::None, PartialCells::Mass, PartialCells::MassAndStiffness}) {
    const std::string name(to_string(rule));
    EXPECT_EQ(load(kBox + "[mesh]\npartial_cells = \"" + name + "\"\n").meshing.partial_cells,
              rule);
    EXPECT_EQ(partial_cells_from(name), rule);
  }
  EXPECT_TRUE(holds(refusal(kBox + "[mesh]\npartial_cells = \"masses\"\n"),
                    "rig.toml:15: mesh.partial_cells is 'masses'"));
  EXPECT_TRUE(holds(test::refusal_of([] { (void)partial_cells_from("half"); }), "\"half\""));
}

TEST_F(RigMeshing, TakesAFileWithItsUnitPlaceAndGroups) {
  folder.write("shapes/part.msh", "");
  const Rig rig = load(
      "[mesh]\nfile = \"shapes/part.msh\"\nunit_mm = 25\nat_mm = [1, 2, 3]\n"
      "groups = { core = \"stiff\", 7 = \"soft\" }\n",
      {.mesh = true});
  ASSERT_TRUE(rig.meshing.file);
  EXPECT_EQ(rig.meshing.file->file, folder / "shapes/part.msh");
  EXPECT_DOUBLE_EQ(rig.meshing.file->metres_per_unit, 0.025);
  EXPECT_TRUE(rig.meshing.file->at.isApprox(Eigen::Vector3d(0.001, 0.002, 0.003)));
  EXPECT_EQ(rig.meshing.file->material_of_group,
            (std::map<std::string, std::string>{{"core", "stiff"}, {"7", "soft"}}));
}

TEST_F(RigMeshing, RefusesWhatDoesNotGoTogether) {
  folder.write("part.vtu", "");
  const std::string file = "[mesh]\nfile = \"part.vtu\"\n";
  EXPECT_TRUE(holds(refusal(kBox + file), "rig.toml:15: mesh.file stands beside [[part]]"));
  EXPECT_TRUE(holds(refusal("[mesh]\nfile = \"part.step\"\n"), "a Gmsh .msh or VTK .vtu file"));
  EXPECT_TRUE(holds(refusal("[mesh]\nfile = \"lost.vtu\"\n"), "a file that exists"));
  EXPECT_TRUE(holds(refusal(file + "partial_cells = \"mass\"\n"), "mesh.partial_cells does not"));
  EXPECT_TRUE(
      holds(refusal(kBox + "[mesh]\nunit_mm = 2\n"), "mesh.unit_mm belongs to a mesh file"));
  EXPECT_TRUE(holds(refusal(file + "unit_mm = 0\n"), "mesh.unit_mm is 0"));
  EXPECT_TRUE(holds(refusal(file + "groups = { a = \"hard\" }\n"), "mesh.groups.a is 'hard'"));
  EXPECT_TRUE(holds(refusal(file + "grups = {}\n"), "nearest: groups"));
  // what needs solids does not take a mesh in their place
  EXPECT_TRUE(holds(refusal(file, {.part = true}), "[[part]] is missing"));
  EXPECT_TRUE(holds(refusal("", {.mesh = true}), "[mesh] with a file"));
}

}  // namespace
}  // namespace twang
