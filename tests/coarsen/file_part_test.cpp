// SPDX-License-Identifier: GPL-3.0-or-later
// Ladders of rigs whose part is a mesh file.
#include "coarsen/detail/file_part.hpp"

#include "coarsen/mesh_ladder.hpp"
#include "coarsen/virtual_measurement.hpp"
#include "fem/read_mesh.hpp"
#include "fem/refine_mesh.hpp"
#include "tests/coarsen/rigs_of_tests.hpp"
#include "tests/support/file_rig.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace twang {
namespace {

using test::FileRig;
using test::mm;

LadderOptions file_ladder() {
  LadderOptions options;
  options.max_dofs = 20000;
  options.num_frequencies = 6;
  return options;
}

TEST(RefineUniformly, OfVoxelsGivesVoxelsOfHalfTheSize) {
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20}) {
    const Rig rig = test::l_rig();
    const HexMesh coarse = mesh_part(rig, 1.5e-3, kind);
    const HexMesh fine = refine_uniformly(coarse);
    const HexMesh voxels = mesh_part(rig, 0.75e-3, kind);
    EXPECT_EQ(fine.kind, kind);
    EXPECT_EQ(fine.num_elements(), 8 * coarse.num_elements());
    EXPECT_EQ(fine.num_nodes(), voxels.num_nodes());          // what is shared stays shared
    EXPECT_NEAR(fine.volume() / voxels.volume(), 1.0, 1e-9);  // round-off
    EXPECT_EQ(surface_faces(fine).size(), surface_faces(voxels).size());
    EXPECT_EQ(fine.material_of_element.size(), static_cast<std::size_t>(fine.num_elements()));
  }
}

TEST(RefineUniformly, FollowsTheCurvesOfQuadraticElements) {
  HexMesh bent = mesh_part(test::beam(mm(10, 10, 10), 0.3, 1000.0), 10e-3, ElementKind::Hex20);
  ASSERT_EQ(bent.num_elements(), 1);
  const int middle = bent.elements(8, 0);  // of the edge from corner 0 to 1
  bent.nodes.col(middle) += mm(0, 0, 1);
  const HexMesh fine = refine_uniformly(bent);
  double nearest = 1.0;
  for (int n = 0; n < fine.num_nodes(); ++n) {
    nearest = std::min(nearest, (fine.nodes.col(n) - bent.nodes.col(middle)).norm());
  }
  EXPECT_LT(nearest, 1e-15);
}

TEST(FileLadder, OfABeamsMeshIsThatOfTheBeam) {
  const Rig solid = test::beam(mm(40, 10, 5), 0.3, 1000.0);
  const FileRig file(solid, 5e-3);
  const MeshLadder of_file = build_mesh_ladder(file.rig, file_ladder());
  const MeshLadder of_solid = build_mesh_ladder(solid, file_ladder());
  ASSERT_GE(of_file.reference.size(), 2U);
  EXPECT_EQ(of_file.reference.front().mesh.kind, ElementKind::Hex20);
  // The same meshes by another way; what the eigensolver leaves.
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(
        of_file.reference[i].modes.lambda_per_s2(0) / of_solid.reference[i].modes.lambda_per_s2(0),
        1.0,
        1e-8);
  }
  ASSERT_EQ(of_file.candidates.size(), of_solid.candidates.size());
  for (std::size_t i = 0; i < of_file.candidates.size(); ++i) {
    EXPECT_EQ(of_file.candidates[i].num_elements, of_solid.candidates[i].num_elements);
    EXPECT_EQ(of_file.candidates[i].passes, of_solid.candidates[i].passes);
  }
  EXPECT_NEAR(of_file.identified_over_numerical() / of_solid.identified_over_numerical(),
              1.0,
              3.0 * (of_file.limit.relative_sigma + of_solid.limit.relative_sigma));
  const MeshLadder again = choose_again(file.rig, of_file, file_ladder());
  EXPECT_EQ(again.choice, of_file.choice);
}

TEST(FileLadder, OfTwoMaterialsKnowsTheirBorder) {
  Rig solid = test::beam(mm(40, 10, 5), 0.3, 1000.0);
  solid.materials.push_back(solid.materials.front());
  solid.materials[0].youngs_modulus_pa = 2e9;
  solid.materials[1].name = "soft";
  solid.materials[1].youngs_modulus_pa = 5e8;
  solid.parts.push_back({"soft", Box{mm(25, 0, 0), mm(40, 10, 5)}});
  FileRig file(solid, 5e-3);
  file.rig.meshing.file->material_of_group = {{"0", "part"}, {"1", "soft"}};
  const Rig surfaces = with_surfaces_of(file.rig, read_mesh_of(file.rig, ElementKind::Hex8));
  ASSERT_EQ(surfaces.parts.size(), 2U);
  EXPECT_EQ(count_mixed_cells(surfaces, 5e-3).num_mixed, 0);
  EXPECT_EQ(count_mixed_cells(surfaces, 10e-3).num_mixed,
            count_mixed_cells(solid, 10e-3).num_mixed);
  EXPECT_GT(count_mixed_cells(solid, 10e-3).num_mixed, 0);
  const MeshLadder ladder = build_mesh_ladder(file.rig, file_ladder());
  EXPECT_TRUE(ladder.stated_moduli);
  EXPECT_EQ(ladder.chosen().num_mixed_cells, 0);
  const std::vector<Material> materials = measure_virtually(file.rig, ladder);
  ASSERT_EQ(materials.size(), 2U);
  EXPECT_EQ(materials[1].material, "soft");
}

}  // namespace
}  // namespace twang
