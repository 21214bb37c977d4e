// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/surface_mesh.hpp"

#include "rigs/load_rig.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <string>

namespace twang {
namespace {

using Eigen::Vector3d;
using test::holds;
using test::refusal_of;
using test::TemporaryFolder;

/// The tetrahedron 0, x = 1, y = 2, z = 3 with outward faces; its volume is 1.
const std::array<Vector3d, 4> kCorners = {
    Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 2, 0), Vector3d(0, 0, 3)};
constexpr int kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

std::string ascii_stl() {
  std::string text = "solid tetrahedron\n";
  for (const auto& face : kFaces) {
    text += " facet normal 0 0 0\n  outer loop\n";
    for (const int i : face) {
      const Vector3d& corner = kCorners[static_cast<std::size_t>(i)];
      text += "   vertex";
      for (const double x : corner) text.append(" ").append(std::to_string(x));
      text += "\r\n";
    }
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid tetrahedron\n";
}

/// Some programs begin a binary file with the word that marks an ASCII one.
std::string binary_stl() {
  std::string bytes = "solid but binary";
  bytes.resize(80, ' ');
  bytes += std::string("\4\0\0\0", 4);
  for (const auto& face : kFaces) {
    float numbers[12] = {};
    for (int v = 0; v < 3; ++v) {
      const Vector3d& corner = kCorners[static_cast<std::size_t>(face[v])];
      for (int axis = 0; axis < 3; ++axis) {
        numbers[3 + 3 * v + axis] = static_cast<float>(corner(axis));
      }
    }
    std::string record(50, '\0');
    std::memcpy(record.data(), numbers, sizeof numbers);
    bytes += record;
  }
  return bytes;
}

std::string obj() {
  return "# tetrahedron\nv 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nvn 0 0 1\n"
         "f 1 3 2\nf 1//1 2//1 4//1\nf 1/1/1 4/1/1 3/1/1\nf -3 -2 -1\n";
}

/// Volume by the divergence theorem: right only if vertices, order and indices are.
double volume_of(const SurfaceMesh& mesh) {
  double volume = 0.0;
  for (Eigen::Index t = 0; t < mesh.triangles.cols(); ++t) {
    const Vector3d a = mesh.vertices.col(mesh.triangles(0, t));
    const Vector3d b = mesh.vertices.col(mesh.triangles(1, t));
    const Vector3d c = mesh.vertices.col(mesh.triangles(2, t));
    volume += a.dot(b.cross(c)) / 6.0;
  }
  return volume;
}

struct Example {
  const char* name;
  std::string content;
};

class SurfaceFormats : public ::testing::TestWithParam<Example> {};

TEST_P(SurfaceFormats, GiveTheSameClosedSurfaceScaledAndMoved) {
  const TemporaryFolder folder;
  const Vector3d at(0.5, 0.25, -0.125);
  const SurfaceMesh mesh =
      read_surface({folder.write(GetParam().name, GetParam().content), 0.5, at, {}});
  EXPECT_EQ(mesh.triangles.cols(), 4);
  // All numbers are exact in binary; 1e-15 is the rounding of the sum.
  EXPECT_NEAR(volume_of(mesh), 0.125, 1e-15);
  EXPECT_EQ(mesh.vertices.rowwise().minCoeff(), at);
  EXPECT_EQ(mesh.vertices.rowwise().maxCoeff(), at + Vector3d(0.5, 1.0, 1.5));
}

INSTANTIATE_TEST_SUITE_P(Surface,
                         SurfaceFormats,
                         ::testing::Values(Example{"ascii.stl", ascii_stl()},
                                           Example{"binary.STL", binary_stl()},
                                           Example{"tetrahedron.obj", obj()}),
                         [](const auto& example) {
                           const std::string name = example.param.name;
                           return name.substr(0, name.find('.'));
                         });

TEST(SurfaceMesh, RefusesWhatIsNoSurface) {
  const TemporaryFolder folder;
  const auto refusal = [&](const char* name, const std::string& content) {
    const SurfaceFile surface = {folder.write(name, content), 1.0, Vector3d::Zero(), {}};
    return refusal_of([&] { (void)read_surface(surface); });
  };
  EXPECT_TRUE(holds(refusal("part.step", "x"), "must be named .stl or .obj"));
  EXPECT_TRUE(holds(refusal("short.stl", binary_stl().substr(0, 200)),
                    "is cut short, holds 200 bytes of the 284"));
  EXPECT_TRUE(holds(refusal("empty.stl", ""), "is empty"));
  EXPECT_TRUE(holds(refusal("none.stl", "solid a\nendsolid a\n"), "has no triangle"));
  EXPECT_TRUE(holds(refusal("word.stl", "solid a\nvertex 1 2 x\n"), "word.stl:2: 'x'"));
  EXPECT_TRUE(holds(refusal("two.stl", "solid a\nvertex 1 2 3\nendfacet\n"), "two.stl:3: "));
  EXPECT_TRUE(holds(refusal("cut.stl", ascii_stl().substr(0, 300)), "is cut short"));
  EXPECT_TRUE(holds(refusal("few.obj", "v 1 2\n"), "few.obj:1: has too few"));
  EXPECT_TRUE(holds(refusal("corner.obj", "v 1 2 3\nf 1 1 2\n"), "corner.obj:2: '2'"));
  EXPECT_TRUE(holds(refusal("line.obj", "v 1 2 3\nf 1 1\n"), "line.obj:2: "));
  EXPECT_TRUE(holds(refusal("inf.obj", "v 1 2 inf\nf 1 1 1\n"), "vertex 1 is not finite"));
}

TEST(SurfaceMesh, IsFoundRelativeToItsRigAndGivesTheBoundingBox) {
  const TemporaryFolder folder;
  folder.write("shapes/tetrahedron.obj", obj());
  const std::string rig_text =
      "format = \"twang-rig/1\"\nname = \"surface\"\n[materials.m]\ndensity_kg_m3 = 1e3\n"
      "poissons_ratio = 0.3\n[[part]]\nmaterial = \"m\"\nshape = \"mesh\"\n"
      "file = \"tetrahedron.obj\"\nunit_mm = 10\nat_mm = [1, 2, 3]\n"
      "[[marker]]\nid = \"far\"\nkind = \"dot\"\nsize_mm = 2\nposition_mm = [99, 0, 0]\n";
  const Rig rig = load_rig(folder.write("shapes/rig.toml", rig_text));
  const Box box = rig.bounding_box();
  EXPECT_TRUE(box.min.isApprox(Vector3d(0.001, 0.002, 0.003), 1e-15));
  EXPECT_TRUE(box.max.isApprox(Vector3d(0.011, 0.022, 0.033), 1e-15));
  EXPECT_THROW((void)contains(rig.parts[0], Vector3d::Zero()), InputError);

  const std::filesystem::path lost = folder.write("rig.toml", rig_text);
  const std::string message = refusal_of([&] { (void)load_rig(lost); });
  EXPECT_TRUE(holds(message, "rig.toml:9: part.1.file cannot be used: ")) << message;
}

}  // namespace
}  // namespace twang
