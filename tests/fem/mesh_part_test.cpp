// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/constants.hpp"
#include "fem/hex_mesh.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/rigs.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace twang {
namespace {

using Eigen::Vector3d;
using test::box_mm;
using test::make_rig;

Rig with_material(Rig rig, std::size_t part, const std::string& name) {
  if (rig.find_material(name) == nullptr) {
    rig.materials.push_back(rig.materials.front());
    rig.materials.back().name = name;
  }
  rig.parts[part].material = name;
  return rig;
}

std::string refusal(const Rig& rig, double dx_m) {
  return test::refusal_of([&] { (void)mesh_part(rig, dx_m, ElementKind::Hex8); });
}

TEST(MeshPart, KeepsThePartsSizeAndRoundsTheNumberOfCells) {
  // 100 / 3 = 33.3 -> 33 cells, 10 / 3 = 3.3 -> 3, 2 / 3 = 0.67 -> 1.
  const HexMesh mesh = mesh_part(test::beam_rig(), 3e-3, ElementKind::Hex8);
  EXPECT_EQ(mesh.num_elements(), 33 * 3 * 1);
  EXPECT_EQ(mesh.num_nodes(), 34 * 4 * 2);
  EXPECT_EQ(mesh.requested_dx_m, 3e-3);
  EXPECT_TRUE(mesh.actual_dx_m.isApprox(Vector3d(0.1 / 33, 0.01 / 3, 0.002), 1e-14));
  EXPECT_NEAR(mesh.volume() / 2e-6, 1.0, 1e-12);
  EXPECT_TRUE(mesh.nodes.rowwise().minCoeff().isZero(1e-17));
  EXPECT_TRUE(mesh.nodes.rowwise().maxCoeff().isApprox(Vector3d(0.1, 0.01, 0.002), 1e-14));
}

TEST(MeshPart, RoundsExactHalvesUp) {
  // 7.5 / 3 and 24 / 3 as they come out of millimetres.
  const HexMesh mesh =
      mesh_part(make_rig({box_mm({0, 0, 0}, {7.5, 24, 3})}), 3e-3, ElementKind::Hex8);
  EXPECT_EQ(mesh.num_elements(), 3 * 8 * 1);
}

TEST(MeshPart, TakesOneCellWhereDxIsLargerThanThePart) {
  const HexMesh mesh = mesh_part(test::beam_rig(), 1.0, ElementKind::Hex8);
  EXPECT_EQ(mesh.num_elements(), 1);
  EXPECT_NEAR(mesh.volume() / 2e-6, 1.0, 1e-12);
}

TEST(MeshPart, LowerFacesAreInsideAndUpperAreNot) {
  // Cells of 2 mm over 0..10; the second box spans the centres of the cells 1 and 2 exactly.
  Rig rig = make_rig({box_mm({0, 0, 0}, {10, 2, 2}), box_mm({3, 0, 0}, {7, 2, 2})});
  rig = with_material(std::move(rig), 1, "inlay");
  const HexMesh mesh = mesh_part(rig, 2e-3, ElementKind::Hex8);
  ASSERT_EQ(mesh.num_elements(), 5);
  ASSERT_EQ(mesh.material_names, (std::vector<std::string>{"part", "inlay"}));
  EXPECT_EQ(mesh.material_of_element, (std::vector<int>{0, 1, 1, 0, 0}));
}

TEST(MeshPart, ALaterSolidOverridesAnEarlierOnesMaterial) {
  Rig rig = make_rig({box_mm({0, 0, 0}, {10, 10, 10}), box_mm({0, 0, 5}, {10, 10, 15})});
  rig = with_material(std::move(rig), 1, "top");
  const HexMesh mesh = mesh_part(rig, 5e-3, ElementKind::Hex8);
  EXPECT_EQ(mesh.num_elements(), 12);
  EXPECT_EQ(std::count(mesh.material_of_element.begin(), mesh.material_of_element.end(), 1), 8);
}

TEST(MeshPart, CylindersApproachTheirVolume) {
  Rig rig = make_rig({});
  const Vector3d from(0.001, 0.002, 0.003);
  const Vector3d along = Vector3d(0.02, 0.01, -0.015);
  rig.parts.push_back({"part", Cylinder{from, from + along, 0.004}});
  const HexMesh mesh = mesh_part(rig, 4e-4, ElementKind::Hex8);
  const double exact = kPi * 0.004 * 0.004 * along.norm();
  // A surface cell is off by half a cell at most: dx A / V = 0.25, and errors cancel by far.
  EXPECT_NEAR(mesh.volume() / exact, 1.0, 0.01);
}

TEST(MeshPart, SharesNodesBetweenNeighboursAndNumbersTheLongAxisLast) {
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20}) {
    const HexMesh mesh = mesh_part(make_rig({box_mm({0, 0, 0}, {2, 8, 4})}), 1e-3, kind);
    const int corners = 3 * 9 * 5;
    const int edges = 2 * 9 * 5 + 3 * 8 * 5 + 3 * 9 * 4;
    EXPECT_EQ(mesh.num_nodes(), kind == ElementKind::Hex8 ? corners : corners + edges);
    for (int n = 1; n < mesh.num_nodes(); ++n) {
      EXPECT_GE(mesh.nodes(1, n), mesh.nodes(1, n - 1) - 1e-12);
    }
    const std::set<int> used(mesh.elements.reshaped().begin(), mesh.elements.reshaped().end());
    EXPECT_EQ(static_cast<int>(used.size()), mesh.num_nodes());
  }
}

TEST(MeshPart, PutsEveryNodeOfAnElementWhereItsShapeFunctionsExpectIt) {
  const HexMesh mesh = mesh_part(test::l_rig(), 1.5e-3, ElementKind::Hex20);
  for (int e = 0; e < mesh.num_elements(); ++e) {
    const Vector3d low = mesh.nodes.col(mesh.elements(0, e));
    for (int a = 0; a < 20; ++a) {
      const Vector3d expected =
          low + 0.5 * (reference_node(a).array() + 1.0).matrix().cwiseProduct(mesh.actual_dx_m);
      ASSERT_LT((mesh.nodes.col(mesh.elements(a, e)) - expected).norm(), 1e-15);  // round-off
    }
  }
}

TEST(MeshPart, ALegAsThinAsOneCellIsMeshed) {
  const HexMesh mesh = mesh_part(test::l_rig(), 1.5e-3, ElementKind::Hex8);
  EXPECT_EQ(mesh.num_elements(), 40 * 16 * 2 + 1 * 16 * 11 + 26 * 16 * 5);
}

TEST(MeshPart, RefusesASolidThatVanishesAndNamesADxThatDoes) {
  const std::string message = refusal(test::l_rig(), 5e-3);
  EXPECT_TRUE(test::holds(message, "part 2 of 3"));
  EXPECT_TRUE(test::holds(message, "vanishes"));
  EXPECT_TRUE(test::holds(message, "1.5 mm would do"));
  EXPECT_NO_THROW((void)mesh_part(test::l_rig(), 1.5e-3, ElementKind::Hex8));
}

TEST(MeshPart, RefusesAMaterialThatVanishesUnderLaterOnes) {
  // Of the base 1 mm is left below the block; no cell of 5 mm has its centre there.
  Rig rig = make_rig({box_mm({0, 0, 0}, {10, 10, 10}), box_mm({0, 0, 1}, {10, 10, 10})});
  rig = with_material(std::move(rig), 1, "block");
  const std::string message = refusal(rig, 5e-3);
  EXPECT_TRUE(test::holds(message, "part 1 of 2"));
  EXPECT_TRUE(test::holds(message, "under later ones"));
}

TEST(MeshPart, AcceptsASolidThatLaterOnesCoverWhole) {
  const Rig rig = make_rig({box_mm({2, 2, 2}, {8, 8, 8}), box_mm({0, 0, 0}, {10, 10, 10})});
  EXPECT_EQ(mesh_part(rig, 5e-3, ElementKind::Hex8).num_elements(), 8);
}

TEST(MeshPart, RefusesAPartThatFallsApart) {
  // Two blocks that meet along an edge.
  const std::string edge =
      refusal(make_rig({box_mm({0, 0, 0}, {4, 4, 4}), box_mm({4, 4, 0}, {8, 8, 4})}), 2e-3);
  EXPECT_TRUE(test::holds(edge, "part 2 of 2"));
  EXPECT_TRUE(test::holds(edge, "not connected"));
  // Two blocks joined by a bridge between the centres of the cells.
  const Rig bridged = make_rig({box_mm({0, 0, 0}, {4, 4, 4}),
                                box_mm({4, 0, 1.6}, {8, 4, 2.4}),
                                box_mm({8, 0, 0}, {12, 4, 4})});
  EXPECT_TRUE(test::holds(refusal(bridged, 2e-3), "part 2 of 3"));
}

TEST(MeshPart, RefusesNonsense) {
  EXPECT_TRUE(test::holds(refusal(test::beam_rig(), 0.0), "dx is 0"));
  EXPECT_TRUE(test::holds(refusal(test::beam_rig(), -1.0), "must be > 0"));
  EXPECT_TRUE(test::holds(refusal(test::beam_rig(), kNaN), "nan"));
  EXPECT_TRUE(test::holds(refusal(test::beam_rig(), 1e-5), "50 million"));
  EXPECT_TRUE(test::holds(refusal(make_rig({}), 1e-3), "no part"));
  Rig surface = test::beam_rig();
  surface.parts.push_back({"part", SurfaceFile{"arm.stl", 1e-3, Vector3d::Zero(), {}}});
  EXPECT_TRUE(test::holds(refusal(surface, 1e-3), "arm.stl"));
  EXPECT_TRUE(test::holds(refusal(surface, 1e-3), "no such file"));
}

TEST(ClampedNodes, HoldsWhatLiesInTheBoxMidEdgeNodesIncluded) {
  const Rig rig = test::beam_rig();
  EXPECT_EQ(clamped_nodes(mesh_part(rig, 2e-3, ElementKind::Hex8), rig).size(), 6U * 2U);
  const HexMesh mesh = mesh_part(rig, 2e-3, ElementKind::Hex20);
  const std::vector<int> held = clamped_nodes(mesh, rig);
  EXPECT_EQ(held.size(), 12U + 16U);  // 5 x 2 + 6 mid-edges of the face of 5 x 1 cells
  EXPECT_TRUE(std::is_sorted(held.begin(), held.end()));
  for (const int n : held) EXPECT_EQ(mesh.nodes(0, n), 0.0);
}

TEST(ClampedNodes, RefusesAClampThatHoldsNothing) {
  Rig rig = test::beam_rig();
  rig.clamps.push_back(box_mm({0.5, 0, 0}, {1.5, 10, 2}));
  const HexMesh mesh = mesh_part(rig, 2e-3, ElementKind::Hex8);
  const std::string message = test::refusal_of([&] { (void)clamped_nodes(mesh, rig); });
  EXPECT_TRUE(test::holds(message, "clamp 2 of 2"));
  EXPECT_TRUE(test::holds(message, "0.5"));
  rig.clamps.clear();
  EXPECT_TRUE(clamped_nodes(mesh, rig).empty());
}

TEST(SurfaceFaces, CloseTheMeshAndPointOutwards) {
  const HexMesh mesh = mesh_part(test::l_rig(), 1.5e-3, ElementKind::Hex20);
  // By Gauss the flux of x through the surface is three times the volume.
  double flux = 0.0;
  double area = 0.0;
  Vector3d sum = Vector3d::Zero();
  for (const auto& face : surface_faces(mesh)) {
    const Vector3d across = mesh.nodes.col(face[2]) - mesh.nodes.col(face[0]);
    const Vector3d other = mesh.nodes.col(face[3]) - mesh.nodes.col(face[1]);
    const Vector3d normal = 0.5 * across.cross(other);
    flux += 0.25 * normal.dot(mesh.nodes.col(face[0]) + mesh.nodes.col(face[1]) +
                              mesh.nodes.col(face[2]) + mesh.nodes.col(face[3]));
    area += normal.norm();
    sum += normal;
  }
  const double volume = (60 * 3 + 1.5 * 16.5 + 39 * 7.5) * 24e-9;
  EXPECT_NEAR(flux / (3.0 * volume), 1.0, 1e-12);
  EXPECT_LT(sum.norm(), 1e-12 * area);
  const double profile = (2 * 63 - 1.5) + 2 * 16.5 + (2 * 46.5 - 1.5);  // outline, mm
  const double sides = 2 * (60 * 3 + 1.5 * 16.5 + 39 * 7.5);
  EXPECT_NEAR(area / ((profile * 24 + sides) * 1e-6), 1.0, 1e-12);
}

}  // namespace
}  // namespace twang
