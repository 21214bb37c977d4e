// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/closed_surface.hpp"

#include "core/error.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/surfaces.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

namespace twang {
namespace {

using Eigen::Vector3d;
using test::holds;

const Box kCube = {Vector3d(0, 0, 0), Vector3d(1, 1, 1)};
const Box kBeside = {Vector3d(3, 0, 0), Vector3d(4, 1, 1)};
const Box kWithin = {Vector3d(0.25, 0.25, 0.25), Vector3d(0.75, 0.75, 0.75)};

std::string refusal(const SurfaceMesh& mesh) {
  return test::refusal_of([&] { (void)close_surface(mesh, "part.stl"); });
}

/// Each triangle with three vertices of its own, as an STL file has them.
SurfaceMesh apart(const SurfaceMesh& mesh) {
  SurfaceMesh soup;
  soup.vertices.resize(3, 3 * mesh.triangles.cols());
  soup.triangles.resize(3, mesh.triangles.cols());
  for (int t = 0; t < mesh.triangles.cols(); ++t) {
    for (int i = 0; i < 3; ++i)
      soup.vertices.col(3 * t + i) = mesh.vertices.col(mesh.triangles(i, t));
    soup.triangles.col(t) = Eigen::Vector3i(3 * t, 3 * t + 1, 3 * t + 2);
  }
  return soup;
}

TEST(CloseSurface, MergesTheCornersOfAnStlFile) {
  const SurfaceMesh torus = test::torus(Vector3d(1, 2, 3), 4.0, 1.0, 30, 20);
  const ClosedSurface closed = close_surface(apart(torus), "part.stl");
  EXPECT_EQ(closed.mesh.vertices.cols(), torus.vertices.cols());
  EXPECT_EQ(closed.mesh.triangles.cols(), torus.triangles.cols());
  EXPECT_EQ(closed.num_shells, 1);
  EXPECT_TRUE(closed.notes.empty());
  // 1e-12: the rounding of a sum of 1200 volumes
  EXPECT_NEAR(closed.volume_m3 / test::torus_volume(4.0, 1.0, 30, 20), 1.0, 1e-12);
}

TEST(CloseSurface, JoinsCornersThatRoundingMovedApartAndSaysSo) {
  SurfaceMesh soup = apart(test::box_surface(kCube));
  soup.vertices(0, 0) += 3e-7;
  soup.vertices(1, 5) -= 3e-7;
  const ClosedSurface closed = close_surface(soup, "part.stl");
  EXPECT_EQ(closed.mesh.vertices.cols(), 8);
  ASSERT_EQ(closed.notes.size(), 1U);
  EXPECT_TRUE(holds(closed.notes[0], "were joined"));
  EXPECT_NEAR(closed.volume_m3, 1.0, 1e-6);  // what the corners were moved by
}

TEST(CloseSurface, LeavesOutTrianglesWithoutThreeCorners) {
  SurfaceMesh mesh = test::box_surface(kCube);
  mesh.triangles.conservativeResize(3, 14);
  mesh.triangles.col(12) = Eigen::Vector3i(3, 3, 5);
  mesh.triangles.col(13) = Eigen::Vector3i(2, 6, 2);
  const ClosedSurface closed = close_surface(mesh, "part.stl");
  EXPECT_EQ(closed.mesh.triangles.cols(), 12);
  EXPECT_NEAR(closed.volume_m3, 1.0, 1e-15);
}

TEST(CloseSurface, TurnsAnInsideOutSurfaceAndSaysSo) {
  const ClosedSurface closed =
      close_surface(test::inside_out(test::box_surface(kCube)), "part.stl");
  EXPECT_NEAR(closed.volume_m3, 1.0, 1e-15);
  ASSERT_EQ(closed.notes.size(), 1U);
  EXPECT_TRUE(holds(closed.notes[0], "part.stl: is inside out"));
}

TEST(CloseSurface, TurnsSingleTrianglesThatDisagreeWithTheirNeighbours) {
  SurfaceMesh mesh = test::sphere(Vector3d::Zero(), 1.0, 10);
  const double volume = enclosed_volume(mesh);
  for (const int t : {3, 40, 41, 100}) std::swap(mesh.triangles(0, t), mesh.triangles(1, t));
  const ClosedSurface closed = close_surface(mesh, "part.stl");
  EXPECT_NEAR(closed.volume_m3 / volume, 1.0, 1e-14);
  ASSERT_EQ(closed.notes.size(), 1U);
  EXPECT_TRUE(holds(closed.notes[0], "4 of 360 triangles"));
}

TEST(CloseSurface, KeepsACavityButTurnsAShellThatStandsFreeInsideOut) {
  const SurfaceMesh cube = test::box_surface(kCube);
  const SurfaceMesh cavity = test::inside_out(test::box_surface(kWithin));
  const SurfaceMesh beside = test::inside_out(test::box_surface(kBeside));
  const ClosedSurface hollow = close_surface(test::together({cube, cavity}), "part.stl");
  EXPECT_EQ(hollow.num_shells, 2);
  EXPECT_TRUE(hollow.notes.empty());
  EXPECT_NEAR(hollow.volume_m3, 1.0 - 0.125, 1e-15);
  const ClosedSurface all_out =
      close_surface(test::inside_out(test::together({cube, cavity})), "part.stl");
  EXPECT_NEAR(all_out.volume_m3, 1.0 - 0.125, 1e-15);
  const ClosedSurface mixed = close_surface(test::together({cube, cavity, beside}), "part.stl");
  EXPECT_NEAR(mixed.volume_m3, 2.0 - 0.125, 1e-15);
  ASSERT_EQ(mixed.notes.size(), 1U);
  EXPECT_TRUE(holds(mixed.notes[0], "1 of its 3 shells"));
}

TEST(CloseSurface, TurnsABodyAndItsCavityButNotTheHollowBodyWithin) {
  // Four shells, one in another: what the file has wrong about the outer body says nothing of the
  // inner one's cavity.
  const auto scaled = [](double scale) {
    const Vector3d middle = 0.5 * (kWithin.min + kWithin.max);
    const Vector3d half = 0.5 * scale * (kWithin.max - kWithin.min);
    return test::box_surface({middle - half, middle + half});
  };
  const SurfaceMesh outer =
      test::together({test::box_surface(kCube), test::inside_out(test::box_surface(kWithin))});
  const SurfaceMesh inner = test::together({scaled(0.8), test::inside_out(scaled(0.4))});
  const ClosedSurface closed =
      close_surface(test::together({test::inside_out(outer), inner}), "part.stl");
  EXPECT_NEAR(closed.volume_m3, 1.0 - 0.125 + 0.125 * (0.512 - 0.064), 1e-15);
  ASSERT_EQ(closed.notes.size(), 1U);
  EXPECT_TRUE(holds(closed.notes[0], "2 of its 4 shells"));
}

TEST(CloseSurface, TakesTwoBodiesThatShareAFace) {
  const Box next = {Vector3d(1, 0, 0), Vector3d(2, 1, 1)};
  const SurfaceMesh both =
      apart(test::together({test::box_surface(kCube), test::box_surface(next)}));
  const ClosedSurface closed = close_surface(both, "part.stl");
  EXPECT_NEAR(closed.volume_m3, 2.0, 1e-15);
  EXPECT_TRUE(closed.notes.empty());
}

TEST(CloseSurface, RefusesHolesWallsAndWhatHasNoInside) {
  const SurfaceMesh cube = test::box_surface(kCube);
  const std::string hole = refusal(test::without_triangles(cube, 4, 1));
  EXPECT_TRUE(holds(hole, "part.stl: is not a closed surface: 3 edges have only one triangle"));
  EXPECT_TRUE(holds(hole, "(1000, "));  // where, in millimetres
  SurfaceMesh walled = cube;            // a wall along a diagonal of the cube
  walled.triangles.conservativeResize(3, 14);
  walled.triangles.col(12) = Eigen::Vector3i(0, 3, 7);
  walled.triangles.col(13) = Eigen::Vector3i(0, 7, 4);
  EXPECT_TRUE(holds(refusal(walled), "three triangles or another odd number"));
  SurfaceMesh sheet = test::without_triangles(cube, 2, 10);  // one face, given from both sides
  sheet = test::together({sheet, test::inside_out(sheet)});
  EXPECT_TRUE(holds(refusal(sheet), "encloses nothing"));
  // A Klein bottle: closed, every edge of two triangles, and one-sided.
  constexpr int n = 12;
  SurfaceMesh bottle = test::torus(Vector3d::Zero(), 4.0, 1.0, n, n);
  for (Eigen::Index t = 0; t < bottle.triangles.cols(); ++t) {
    for (int i = 0; i < 3; ++i) {
      int& v = bottle.triangles(i, t);
      // the last column joins the first upside down
      if (t / 2 % n == n - 1 && v % n == 0) v = (n - v / n) % n * n;
    }
  }
  EXPECT_TRUE(holds(refusal(bottle), "has one side only"));
}

TEST(WriteStl, ReadsBackAsWritten) {
  const test::TemporaryFolder folder;
  const SurfaceMesh torus = test::torus(Vector3d(0.1, 0.2, 0.3), 0.05, 0.01, 24, 16);
  write_stl(folder / "torus.stl", torus);
  SurfaceFile file;
  file.file = folder / "torus.stl";
  const ClosedSurface closed = read_closed_surface(file);
  EXPECT_EQ(closed.mesh.vertices.cols(), torus.vertices.cols());
  EXPECT_TRUE(closed.notes.empty());
  // single precision: 6e-8 of coordinates up to six times the ring's radius
  EXPECT_NEAR(closed.volume_m3 / test::torus_volume(0.05, 0.01, 24, 16), 1.0, 2e-6);
}

}  // namespace
}  // namespace twang
