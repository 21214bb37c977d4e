// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/constants.hpp"
#include "fem/eigenmodes.hpp"
#include "fem/hex_mesh.hpp"
#include "rigs/closed_surface.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/rigs.hpp"
#include "tests/support/surfaces.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

namespace twang {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::box_mm;
using test::holds;

/// A rig of surfaces, each in a file of its own.
class SurfaceRig {
 public:
  explicit SurfaceRig(std::initializer_list<SurfaceMesh> surfaces) : rig(test::make_rig({})) {
    for (const SurfaceMesh& surface : surfaces) add(surface);
  }
  void add(const SurfaceMesh& surface) {
    SurfaceFile file;
    file.file = m_folder / ("solid_" + std::to_string(rig.parts.size()) + ".stl");
    write_stl(file.file, surface);
    rig.parts.push_back({"part", file});
  }
  Rig rig;

 private:
  test::TemporaryFolder m_folder;
};

Vector3d mm(double x, double y, double z) { return Vector3d(x, y, z) * kMetresPerMillimetre; }

double filled_volume(const HexMesh& mesh) { return mesh.mass_fill.sum() * mesh.actual_dx_m.prod(); }

/// Second moments of the mass about the origin, each element's mass spread evenly over it.
Matrix3d second_moments(const HexMesh& mesh) {
  Matrix3d sum = Matrix3d::Zero();
  for (int e = 0; e < mesh.num_elements(); ++e) {
    const Vector3d centre =
        0.5 * (mesh.nodes.col(mesh.elements(0, e)) + mesh.nodes.col(mesh.elements(6, e)));
    const double mass =
        mesh.actual_dx_m.prod() * (mesh.mass_fill.size() > 0 ? mesh.mass_fill[e] : 1.0);
    sum += mass * (centre * centre.transpose());
    sum.diagonal() += mass / 12.0 * mesh.actual_dx_m.cwiseAbs2();
  }
  return sum;
}

TEST(SurfacePart, IsTheSameMeshAsTheBoxWhoseSurfaceItIs) {
  // The second box spans the centres of cells exactly.
  const Box base = box_mm({0, 0, 0}, {60, 24, 3});
  const Box block = box_mm({3, 3, 3}, {33, 15, 18});
  const Rig boxes = test::make_rig({base, block}, {box_mm({0, 0, 0}, {60, 24, 0})});
  SurfaceRig surfaces({test::box_surface(base), test::box_surface(block)});
  surfaces.rig.clamps = boxes.clamps;
  for (const double dx_mm : {1.5, 2.0, 3.0}) {
    const HexMesh expected = mesh_part(boxes, dx_mm * 1e-3, ElementKind::Hex8);
    const HexMesh mesh = mesh_part(surfaces.rig, dx_mm * 1e-3, ElementKind::Hex8);
    ASSERT_EQ(mesh.elements, expected.elements) << dx_mm;
    EXPECT_TRUE(mesh.nodes.isApprox(expected.nodes, 1e-14)) << dx_mm;  // round-off
    EXPECT_NEAR(mesh.part_volume_m3 / expected.part_volume_m3, 1.0, 1e-12);
    const auto lambda = [&](const Rig& rig, const HexMesh& of) {
      const ElasticBody body(of, {test::elastic(1e9, 0.45, 1180.0)}, ConstitutiveModel::Linear);
      return compute_eigenmodes(body, clamped_nodes(of, rig)).lambda_per_s2(0);
    };
    if (dx_mm < 3.0) continue;
    EXPECT_NEAR(lambda(surfaces.rig, mesh) / lambda(boxes, expected), 1.0, 1e-9);  // the solver's
  }
}

TEST(SurfacePart, LowerFacesAreInsideAndUpperAreNotAlongEveryAxis) {
  // Cells of 2 mm over 0..10: an inlay spans the centres of the cells 1 and 3 exactly.
  for (int axis = 0; axis < 3; ++axis) {
    Vector3d high = mm(2, 2, 2);
    high[axis] = 0.010;
    Vector3d from = mm(0, 0, 0);
    Vector3d to = high;
    from[axis] = 0.003;
    to[axis] = 0.007;
    SurfaceRig inlaid({test::box_surface({Vector3d::Zero(), high}), test::box_surface({from, to})});
    inlaid.rig.materials.push_back(inlaid.rig.materials[0]);
    inlaid.rig.materials[1].name = "inlay";
    inlaid.rig.parts[1].material = "inlay";
    const HexMesh mesh = mesh_part(inlaid.rig, 2e-3, ElementKind::Hex8);
    EXPECT_EQ(mesh.material_of_element, (std::vector<int>{0, 1, 1, 0, 0})) << axis;
  }
}

TEST(SurfacePart, EveryLineThroughEdgesAndCornersLeavesAsOftenAsItEnters) {
  // Corners on the lines through the cells' centres, edges along them, all faces on them: an
  // octahedron and a torus of few sides whose corners are multiples of half a cell.
  SurfaceMesh octahedron;
  octahedron.vertices.resize(3, 6);
  octahedron.vertices << 8, -8, 0, 0, 0, 0, 0, 0, 8, -8, 0, 0, 0, 0, 0, 0, 8, -8;
  octahedron.vertices *= 1e-3;
  octahedron.triangles.resize(3, 8);
  octahedron.triangles << 0, 2, 1, 3, 2, 1, 3, 0,  //
      2, 1, 3, 0, 0, 2, 1, 3,                      //
      4, 4, 4, 4, 5, 5, 5, 5;
  SurfaceRig rig({octahedron});
  for (const int cells : {1, 3, 4, 5, 8, 16, 32}) {
    const HexMesh mesh = mesh_part(rig.rig, 0.016 / cells, ElementKind::Hex8);
    // |x| + |y| + |z| <= 8 for the centres, counted by hand
    long inside = 0;
    for (int i = 0; i < cells; ++i) {
      for (int j = 0; j < cells; ++j) {
        for (int k = 0; k < cells; ++k) {
          const auto at = [&](int c) { return 16.0 * (c + 0.5) / cells - 8.0; };
          const double sum = std::abs(at(i)) + std::abs(at(j)) + std::abs(at(k));
          // a centre on a face counts as just beyond it, up along each axis
          const double beyond = (at(i) < 0 ? -1 : 1) + (at(j) < 0 ? -1 : 1) + (at(k) < 0 ? -1 : 1);
          if (sum + 1e-9 * beyond <= 8.0) ++inside;
        }
      }
    }
    EXPECT_EQ(mesh.num_elements(), inside) << cells;
  }
}

TEST(SurfacePart, ApproachesTheVolumeAndInertiaOfATorus) {
  const SurfaceMesh torus = test::torus(mm(1, 2, 3), 0.020, 0.006, 100, 50);
  SurfaceRig rig({torus});
  const HexMesh mesh = mesh_part(rig.rig, 8e-4, ElementKind::Hex8);
  const double exact = test::torus_volume(0.020, 0.006, 100, 50);
  EXPECT_NEAR(exact / (2.0 * kPi * kPi * 0.020 * 0.006 * 0.006), 1.0, 4e-3);  // 100 and 50 chords
  // Cells at the surface are off by half at most and at random: 1 / sqrt(8,000) of a half.
  EXPECT_NEAR(mesh.volume() / exact, 1.0, 1e-2);
  // About the axis of the ring: integral of x² + y² = V (R² + 3 r² / 4).
  Matrix3d moments = second_moments(mesh);
  const Vector3d centre = mm(1, 2, 3);
  moments -= mesh.volume() * (centre * centre.transpose());
  EXPECT_NEAR((moments(0, 0) + moments(1, 1)) / (exact * (0.020 * 0.020 + 0.75 * 0.006 * 0.006)),
              1.0,
              1e-2);
  EXPECT_NEAR(mesh.part_volume_m3 / exact, 1.0, 1e-6);  // single precision of the file
}

TEST(SurfacePart, HasTheSolidsVolumeInPartialCellsAtEveryDx) {
  const SurfaceMesh torus = test::torus(mm(0, 0, 0), 0.020, 0.006, 60, 30);
  const SurfaceMesh ball = test::sphere(mm(40, 1, 2), 0.0125, 40);
  const SurfaceMesh stick = test::box_surface(box_mm({26.2, -2.1, -1.7}, {27.3, 1.3, 2.9}));
  SurfaceRig rig({torus, ball, stick});
  rig.rig.parts.push_back({"part", Cylinder{mm(-35, 1, 1), mm(-28, 2, 4), 0.0031}});
  rig.rig.meshing.partial_cells = PartialCells::Mass;
  const double exact[4] = {enclosed_volume(torus),
                           enclosed_volume(ball),
                           enclosed_volume(stick),
                           kPi * 0.0031 * 0.0031 * mm(7, 1, 3).norm()};
  const auto expect_volume = [](const Rig& part, double dx_mm, double volume) {
    const HexMesh mesh = mesh_part(part, dx_mm * 1e-3, ElementKind::Hex8);
    // 2e-6: single precision of the file
    EXPECT_NEAR(filled_volume(mesh) / volume, 1.0, 2e-6) << dx_mm;
    EXPECT_NEAR(mesh.volume() / volume, 1.0, 2e-6) << dx_mm;
    EXPECT_NEAR(mesh.part_volume_m3 / volume, 1.0, 2e-6) << dx_mm;
    EXPECT_TRUE(mesh.notes.empty()) << mesh.notes[0];
  };
  for (std::size_t p = 0; p < 4; ++p) {
    Rig alone = rig.rig;
    alone.parts = {rig.rig.parts[p]};
    for (const double dx_mm : {1.5, 4.0, 11.0, 60.0}) expect_volume(alone, dx_mm, exact[p]);
  }
  // They stand apart, but cells of these sizes hold the ends of two: without an overlap exact.
  for (const double dx_mm : {4.0, 11.0, 60.0}) {
    expect_volume(rig.rig, dx_mm, exact[0] + exact[1] + exact[2] + exact[3]);
  }
}

TEST(SurfacePart, SaysWhatWasTurnedAndWhatIsEnclosedTwice) {
  const SurfaceMesh one = test::box_surface(box_mm({0, 0, 0}, {10, 10, 10}));
  const SurfaceMesh two = test::box_surface(box_mm({6, 0, 0}, {16, 10, 10}));
  const HexMesh turned =
      mesh_part(SurfaceRig({test::inside_out(one)}).rig, 2e-3, ElementKind::Hex8);
  EXPECT_EQ(turned.num_elements(), 125);
  ASSERT_EQ(turned.notes.size(), 1U);
  EXPECT_TRUE(holds(turned.notes[0], "is inside out"));
  const HexMesh overlap =
      mesh_part(SurfaceRig({test::together({one, two})}).rig, 1e-3, ElementKind::Hex8);
  EXPECT_EQ(overlap.num_elements(), 1600);
  ASSERT_EQ(overlap.notes.size(), 1U);
  EXPECT_TRUE(holds(overlap.notes[0], "400 mm³ lie inside more than once"));
  // Off the cells' faces, the volume of the union is that of the lines through it.
  const SurfaceMesh odd = test::box_surface(box_mm({3.7, -1.3, 2.2}, {13.9, 8.6, 8.1}));
  SurfaceRig shifted({test::together({one, odd})});
  shifted.rig.meshing.partial_cells = PartialCells::Mass;
  const HexMesh mesh = mesh_part(shifted.rig, 2.7e-3, ElementKind::Hex8);
  const double both = 1000.0 + 10.2 * 9.9 * 5.9 - 6.3 * 8.6 * 5.9;
  EXPECT_NEAR(
      filled_volume(mesh) / (both * 1e-9), 1.0, 1e-3);  // lines through cells with an overlap
  // A tube twisted by half a turn crosses itself: half of it winds the wrong way.
  SurfaceMesh crossed = one;
  for (const int v : {4, 5, 6, 7}) crossed.vertices(0, v) = 0.010 - crossed.vertices(0, v);
  const HexMesh twisted =
      mesh_part(SurfaceRig({test::together({crossed, two})}).rig, 1e-3, ElementKind::Hex8);
  ASSERT_FALSE(twisted.notes.empty());
  EXPECT_TRUE(holds(twisted.notes[0], "crosses itself"));
}

TEST(SurfacePart, RefusesOneThatIsNotClosed) {
  const SurfaceMesh ball = test::sphere(mm(0, 0, 0), 0.01, 20);
  SurfaceRig open({test::without_triangles(ball, 100, 2)});
  const std::string message =
      test::refusal_of([&] { (void)mesh_part(open.rig, 1e-3, ElementKind::Hex8); });
  EXPECT_TRUE(holds(message, "solid_0.stl: is not a closed surface: "));
}

TEST(SurfacePart, RefusesBodiesThatDoNotTouch) {
  SurfaceRig two({test::together({test::box_surface(box_mm({0, 0, 0}, {4, 4, 4})),
                                  test::box_surface(box_mm({8, 0, 0}, {12, 4, 4}))})});
  const std::string message =
      test::refusal_of([&] { (void)mesh_part(two.rig, 2e-3, ElementKind::Hex8); });
  EXPECT_TRUE(holds(message, "part 1 of 1 (solid_0.stl"));
  EXPECT_TRUE(holds(message, "not connected"));
}

TEST(SurfacePart, CountsThinFeaturesThatAreLost) {
  // A block with a blade 0.4 mm thick between the centres of its cells of 2 mm.
  const Box block = box_mm({0, 0, 0}, {10, 10, 10});
  const Box blade = box_mm({10, 0, 5.2}, {30, 10, 5.6});
  SurfaceRig rig({test::together({test::box_surface(block), test::box_surface(blade)})});
  const HexMesh mesh = mesh_part(rig.rig, 2e-3, ElementKind::Hex8);
  EXPECT_EQ(mesh.num_elements(), 125);
  ASSERT_EQ(mesh.notes.size(), 1U);
  EXPECT_TRUE(holds(mesh.notes[0], "7.4 % less volume"));  // 80 of 1080 mm³
  EXPECT_TRUE(holds(mesh.notes[0], "45 cells"));  // 10 x 5, those beside the block not alone
  rig.rig.meshing.partial_cells = PartialCells::MassAndStiffness;
  const HexMesh whole = mesh_part(rig.rig, 2e-3, ElementKind::Hex8);
  EXPECT_EQ(whole.num_elements(), 125 + 50);
  EXPECT_TRUE(whole.notes.empty());
  EXPECT_NEAR(whole.stiffness_fill.minCoeff(), 0.2, 1e-6);  // single precision of the file
}

TEST(SurfacePart, TakesOneCellWhereDxIsLargerThanThePart) {
  SurfaceRig ball({test::sphere(mm(0, 0, 0), 0.01, 20)});
  EXPECT_EQ(mesh_part(ball.rig, 1.0, ElementKind::Hex8).num_elements(), 1);
  ball.rig.meshing.partial_cells = PartialCells::Mass;
  const HexMesh mesh = mesh_part(ball.rig, 1.0, ElementKind::Hex8);
  ASSERT_EQ(mesh.num_elements(), 1);
  EXPECT_NEAR(mesh.mass_fill[0], kPi / 6.0, 0.01);  // sphere over cube, 20 latitudes
}

TEST(PartialCells, KeepMassWhereMaterialsOfTwoDensitiesMeetInACell) {
  Rig rig = test::make_rig({box_mm({0, 0, 0}, {10, 4, 4}), box_mm({7.3, 0, 0}, {12.1, 4, 4})});
  rig.materials.push_back(rig.materials[0]);
  rig.materials[1].name = "steel";
  rig.materials[1].density_kg_m3 = 7800.0;
  rig.parts[1].material = "steel";
  rig.meshing.partial_cells = PartialCells::Mass;
  for (const double dx_mm : {0.5, 1.0, 3.0, 20.0}) {
    if (dx_mm == 20.0) {  // one cell, mostly not steel
      EXPECT_TRUE(
          holds(test::refusal_of([&] { (void)mesh_part(rig, dx_mm * 1e-3, ElementKind::Hex8); }),
                "no cell is mostly of its material"));
      continue;
    }
    const HexMesh mesh = mesh_part(rig, dx_mm * 1e-3, ElementKind::Hex8);
    ElasticMaterial light = test::elastic(1e9, 0.3, 1180.0);
    ElasticMaterial steel = test::elastic(2e11, 0.3, 7800.0);
    const ElasticBody body(mesh, {light, steel}, ConstitutiveModel::Linear);
    const Eigen::VectorXd along_x = Vector3d::UnitX().replicate(mesh.num_nodes(), 1);
    const double mass = along_x.dot(body.mass() * along_x);
    EXPECT_NEAR(mass / (16e-9 * (7.3 * 1180.0 + 4.8 * 7800.0)), 1.0, 1e-9) << dx_mm;
  }
}

TEST(PartialCells, ScaleTheStiffnessIfWanted) {
  // A bar of half cells: with the stiffness scaled its eigenvalues are those of the full bar; with
  // the mass alone they are twice as high.
  Rig rig = test::make_rig({box_mm({0, 0, 0}, {20, 4, 1}), box_mm({0, 0, 0}, {1, 1, 2})});
  rig.parts.pop_back();
  rig.meshing.partial_cells = PartialCells::Mass;
  HexMesh mesh = mesh_part(rig, 1e-3, ElementKind::Hex8);
  mesh.mass_fill.setConstant(0.5);
  const auto lambda = [&] {
    const ElasticBody body(mesh, {test::elastic(1e9, 0.3, 1000.0)}, ConstitutiveModel::Linear);
    Rig held = rig;
    held.clamps = {box_mm({0, 0, 0}, {0, 4, 1})};
    return compute_eigenmodes(body, clamped_nodes(mesh, held)).lambda_per_s2(0);
  };
  const double mass_alone = lambda();
  mesh.stiffness_fill = mesh.mass_fill;
  const double both = lambda();
  EXPECT_NEAR(mass_alone / both, 2.0, 1e-8);  // the eigenvalue solver's tolerance
  mesh.mass_fill.resize(0);
  mesh.stiffness_fill.resize(0);
  EXPECT_NEAR(lambda() / both, 1.0, 1e-8);
}

TEST(PartialCells, OverlapsCountOnceAndTheLaterMaterialHoldsThem) {
  // Boxes are exact; a cylinder inside a box takes what it holds.
  Rig rig =
      test::make_rig({box_mm({0, 0, 0}, {10.3, 10.3, 10}), box_mm({2.2, 2.2, 0}, {5.1, 12.4, 10})});
  rig.meshing.partial_cells = PartialCells::Mass;
  const double boxes = (10.3 * 10.3 + 2.9 * 2.1) * 10e-9;
  for (const double dx_mm : {0.9, 2.0, 7.0}) {
    const HexMesh mesh = mesh_part(rig, dx_mm * 1e-3, ElementKind::Hex8);
    EXPECT_NEAR(filled_volume(mesh) / boxes, 1.0, 1e-9) << dx_mm;
  }
  rig.parts[1].shape =
      Cylinder{mm(8, 5, 0), mm(8, 5, 15), 0.004};  // sticks out at a side and on top
  // circle of radius 4 around x = 8 beyond the plane x = 10.3
  const double h = 2.3, r = 4.0;
  const double segment = r * r * std::acos(h / r) - h * std::sqrt(r * r - h * h);
  const double both = (10.3 * 10.3 * 10 + segment * 10 + kPi * r * r * 5) * 1e-9;
  for (const double dx_mm : {2.0, 7.0}) {
    const HexMesh mesh = mesh_part(rig, dx_mm * 1e-3, ElementKind::Hex8);
    EXPECT_NEAR(filled_volume(mesh) / both, 1.0, 1e-3) << dx_mm;  // overlaps are sampled
  }
}

TEST(MixedCells, AreThoseThatHoldTwoMaterials) {
  Rig rig = test::make_rig({box_mm({0, 0, 0}, {12, 4, 4}), box_mm({6, 0, 0}, {12, 4, 4})});
  rig.materials.push_back(rig.materials[0]);
  rig.materials[1].name = "soft";
  EXPECT_EQ(count_mixed_cells(rig, 4e-3).num_mixed, 0);  // both of one material
  rig.parts[1].material = "soft";
  EXPECT_EQ(count_mixed_cells(rig, 2e-3).num_mixed, 0);
  const MaterialMixing mixing = count_mixed_cells(rig, 4e-3);
  EXPECT_EQ(mixing.num_cells, 3);
  EXPECT_EQ(mixing.num_mixed, 1);
  EXPECT_TRUE(mixing.actual_dx_m.isApprox(mm(4, 4, 4)));
}

}  // namespace
}  // namespace twang
