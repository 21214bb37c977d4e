// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/read_mesh.hpp"

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "fem/eigenmodes.hpp"
#include "fem/mapped_block.hpp"
#include "fem/vtu.hpp"
#include "tests/fem/gmsh_text.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/rigs.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <sstream>

namespace twang {
namespace {

using Eigen::Vector3d;
using test::holds;
using test::msh_2;
using test::msh_4;

/// A block of 12 elements with curved edges, the last four of another material.
HexMesh example(ElementKind kind) {
  MappedBlock block;
  block.cells = {2, 2, 3};
  block.map = [](const Vector3d& s) {
    return Vector3d(
        2.0 * s.x() + 0.3 * s.z() * s.z(), 3.0 * s.y() + 0.2 * s.x() * s.x(), 4.0 * s.z());
  };
  HexMesh mesh = mesh_block(block, kind);
  for (std::size_t e = 8; e < 12; ++e) mesh.material_of_element[e] = 1;
  mesh.material_names = {"lower", "upper"};
  return mesh;
}

class Files {
 public:
  [[nodiscard]] MeshFile file(const std::string& name, const std::string& content) const {
    MeshFile mesh;
    mesh.file = m_folder.write(name, content);
    mesh.metres_per_unit = 1.0;
    return mesh;
  }
  [[nodiscard]] std::filesystem::path path(const std::string& name) const {
    return m_folder / name;
  }

 private:
  test::TemporaryFolder m_folder;
};

/// Same elements in the same order with nodes in the same places.
void expect_same(const HexMesh& mesh, const HexMesh& expected) {
  ASSERT_EQ(mesh.kind, expected.kind);
  ASSERT_EQ(mesh.num_nodes(), expected.num_nodes());
  ASSERT_EQ(mesh.num_elements(), expected.num_elements());
  for (int e = 0; e < mesh.num_elements(); ++e) {
    for (int a = 0; a < mesh.elements.rows(); ++a) {
      ASSERT_EQ(mesh.nodes.col(mesh.elements(a, e)), expected.nodes.col(expected.elements(a, e)))
          << e << " " << a;
    }
  }
}

TEST(ReadMesh, ReadsBothFormatsOfGmshWithTheirGroups) {
  const Files files;
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20}) {
    const HexMesh expected = example(kind);
    for (const std::string& content : {msh_2(expected), msh_4(expected)}) {
      const HexMesh mesh = read_mesh(files.file("part.msh", content));
      expect_same(mesh, expected);
      EXPECT_EQ(mesh.material_names, (std::vector<std::string>{"3", "lower"}));
      EXPECT_EQ(std::count(mesh.material_of_element.begin(), mesh.material_of_element.end(), 1), 8);
      EXPECT_EQ(mesh.material_of_element[0], 1);
    }
  }
}

TEST(ReadMesh, ScalesAndMoves) {
  const Files files;
  MeshFile file = files.file("part.msh", msh_2(example(ElementKind::Hex8)));
  file.metres_per_unit = 1e-3;
  file.at = Vector3d(1, 2, 3);
  const HexMesh mesh = read_mesh(file);
  EXPECT_TRUE(mesh.nodes.rowwise().minCoeff().isApprox(Vector3d(1, 2, 3)));
  EXPECT_NEAR(mesh.volume() / (24e-9), 1.0, 1e-9);  // 2 x 3 x 4 sheared, in mm
}

TEST(ReadMesh, ReadsWhatWriteVtuWrote) {
  const Files files;
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20}) {
    const HexMesh expected = example(kind);
    write_vtu(files.path("part.vtu"), expected, {});
    MeshFile file;
    file.file = files.path("part.vtu");
    file.metres_per_unit = 1.0;
    const HexMesh mesh = read_mesh(file);
    expect_same(mesh, expected);
    EXPECT_EQ(mesh.material_names, (std::vector<std::string>{"0", "1"}));
    EXPECT_EQ(mesh.material_of_element, expected.material_of_element);
  }
}

std::string base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k > bytes.size() ? '=' : kDigits[bits >> (18 - 6 * k) & 63];
    }
  }
  return text;
}

template <typename Value>
std::string bytes_of(const std::vector<Value>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value)};
}

std::string header(const std::vector<std::size_t>& values) {
  std::vector<std::uint32_t> words(values.begin(), values.end());
  return bytes_of(words);
}

/// What an array's text is in each of VTK's ways: as text, in base64, and compressed in two blocks.
enum class Way { Text, Base64, Zlib };
template <typename Value>
std::string inside(Way way, const std::vector<Value>& values) {
  if (way == Way::Text) {
    std::ostringstream text;
    text.precision(17);
    for (const Value value : values) text << +value << "\n";
    return text.str();
  }
  const std::string bytes = bytes_of(values);
  if (way == Way::Base64) return "\n  " + base64(header({bytes.size()}) + bytes) + "\n";
  const std::size_t half = bytes.size() / 2 + 1;
  std::vector<std::size_t> lengths = {2, half, bytes.size() - half};
  std::string packed;
  for (const std::string& block : {bytes.substr(0, half), bytes.substr(half)}) {
    std::string out(compressBound(block.size()), '\0');
    uLongf size = out.size();
    EXPECT_EQ(compress(reinterpret_cast<Bytef*>(out.data()),
                       &size,
                       reinterpret_cast<const Bytef*>(block.data()),
                       block.size()),
              Z_OK);
    packed += out.substr(0, size);
    lengths.push_back(size);
  }
  return "\n  " + base64(header(lengths)) + base64(packed) + "\n";
}

/// A cube as a voxel cell with a face and a vertex beside it, in group 4.
std::string voxel_vtu(Way way) {
  const std::string format = way == Way::Text ? "ascii" : "binary";
  const std::string compressor = way == Way::Zlib ? " compressor=\"vtkZLibDataCompressor\"" : "";
  const auto array = [&](const char* type, const char* name, const std::string& text) {
    return std::string("<DataArray type=\"") + type + "\" Name=\"" + name + "\" format=\"" +
           format + "\">" + text + "</DataArray>\n";
  };
  std::vector<float> x;
  for (int v = 0; v < 8; ++v) {
    for (const int bit : {1, 2, 4}) x.push_back((v & bit) != 0 ? 1.0F : 0.0F);
  }
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" "
         "byte_order=\"LittleEndian\"" +
         compressor +
         ">\n<UnstructuredGrid><Piece NumberOfPoints=\"8\" NumberOfCells=\"3\">\n<Points>" +
         array("Float32", "Points", inside(way, x)) + "</Points>\n<Cells>" +
         array("Int32",
               "connectivity",
               inside(way, std::vector<std::int32_t>{0, 1, 3, 2, 5, 0, 1, 2, 3, 4, 5, 6, 7})) +
         array("Int64", "offsets", inside(way, std::vector<std::int64_t>{4, 5, 13})) +
         array("UInt8", "types", inside(way, std::vector<std::uint8_t>{9, 1, 11})) +
         "</Cells>\n<CellData>" +
         array("Float64", "MaterialIds", inside(way, std::vector<double>{1, 2, 4})) +
         "</CellData>\n</Piece></UnstructuredGrid></VTKFile>\n";
}

TEST(ReadMesh, ReadsVtkArraysAsTextInBase64AndCompressed) {
  const Files files;
  for (const Way way : {Way::Text, Way::Base64, Way::Zlib}) {
    const HexMesh mesh = read_mesh(files.file("cube.vtu", voxel_vtu(way)));
    ASSERT_EQ(mesh.num_elements(), 1) << static_cast<int>(way);
    EXPECT_NEAR(mesh.volume(), 1.0, 1e-14);  // round-off
    EXPECT_EQ(mesh.nodes.col(mesh.elements(2, 0)), Vector3d(1, 1, 0));
    EXPECT_EQ(mesh.material_names, std::vector<std::string>{"4"});
  }
}

TEST(ReadMesh, RefusesWhatIsCutShortAtAnyPlace) {
  const Files files;
  const HexMesh mesh = example(ElementKind::Hex8);
  for (const std::string& whole : {msh_2(mesh), msh_4(mesh)}) {
    for (std::size_t length = 0; length + 13 < whole.size(); length += 149) {
      EXPECT_THROW((void)read_mesh(files.file("cut.msh", whole.substr(0, length))), InputError)
          << length;
    }
  }
  write_vtu(files.path("whole.vtu"), mesh, {});
  const std::string raw = read_file(files.path("whole.vtu"));
  const std::size_t tail = std::string("\n  </AppendedData>\n</VTKFile>\n").size();
  for (const std::string& whole :
       {raw.substr(0, raw.size() - tail), voxel_vtu(Way::Text), voxel_vtu(Way::Zlib)}) {
    const bool is_raw = whole.size() == raw.size() - tail;
    const std::size_t last = is_raw ? whole.size() : whole.find("</Cells>") - 14;
    for (std::size_t length = 0; length < last; length += 127) {
      EXPECT_THROW((void)read_mesh(files.file("cut.vtu", whole.substr(0, length))), InputError)
          << length;
    }
  }
}

TEST(ReadMesh, RefusesWhatIsNoMeshOfHexahedra) {
  const Files files;
  const std::string good = msh_2(example(ElementKind::Hex8));
  const auto refusal = [&](const std::string& content) {
    return test::refusal_of([&] { (void)read_mesh(files.file("part.msh", content)); });
  };
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return refusal(text);
  };
  EXPECT_TRUE(holds(changed("2.2 0 8", "2.2 1 8"), "part.msh:2: is binary"));
  EXPECT_TRUE(holds(changed("2.2 0 8", "4.0 0 8"), "format 4.0, must be 2.2 or 4.1"));
  EXPECT_TRUE(holds(changed("3 5 2 7 1", "3 4 2 7 1"), "Gmsh's type 4"));
  EXPECT_TRUE(holds(changed("46 0 0 0", "46 nan 0 0"), "not finite"));
  EXPECT_TRUE(holds(changed("46 0 0 0", "45 0 0 0"), "is there twice"));
  EXPECT_TRUE(holds(changed("46 0 0 0", "146 0 0 0"), "has node 46, which does not exist"));
  EXPECT_TRUE(holds(changed("$Nodes\n36", "$Nodes\n3600000000"), "the file cannot hold"));
  EXPECT_TRUE(holds(refusal("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"), "has no hexahedron"));
  HexMesh turned = example(ElementKind::Hex8);
  turned.elements.col(5).head(4).swap(turned.elements.col(5).tail(4));
  EXPECT_TRUE(holds(refusal(msh_2(turned)), "hexahedron 6 of 12 is flat or turned inside out"));
  HexMesh apart = example(ElementKind::Hex8);
  apart.nodes.conservativeResize(3, 72);
  apart.nodes.rightCols(36) = apart.nodes.leftCols(36);
  apart.nodes.rightCols(36).row(0).array() += 10.0;
  apart.elements.col(11).array() += 36;
  EXPECT_TRUE(holds(refusal(msh_2(apart)), "hexahedron 12 of 12 shares no node"));
  const auto vtu_refusal = [&](const std::string& content) {
    return test::refusal_of([&] { (void)read_mesh(files.file("part.vtu", content)); });
  };
  std::string vtu = voxel_vtu(Way::Text);
  vtu.replace(vtu.find("9\n1\n11"), 6, "9\n1\n10");
  EXPECT_TRUE(holds(vtu_refusal(vtu), "VTK's type 10"));
  EXPECT_TRUE(holds(vtu_refusal("<VTKFile type=\"PolyData\">"), "UnstructuredGrid"));
}

TEST(ReadMesh, ChangesTheKindOfElements) {
  const HexMesh eight = example(ElementKind::Hex8);
  const HexMesh twenty = with_kind(eight, ElementKind::Hex20);
  EXPECT_EQ(twenty.num_nodes(), example(ElementKind::Hex20).num_nodes());
  EXPECT_NEAR(twenty.volume() / eight.volume(), 1.0, 1e-12);
  for (int a = 8; a < 20; ++a) {  // where the shape functions of the trilinear element put it
    const Eigen::VectorXd N = shape_functions(ElementKind::Hex8, reference_node(a));
    Vector3d x = Vector3d::Zero();
    for (int b = 0; b < 8; ++b) x += N[b] * eight.nodes.col(eight.elements(b, 3));
    EXPECT_LT((twenty.nodes.col(twenty.elements(a, 3)) - x).norm(), 1e-14) << a;
  }
  const HexMesh enhanced = with_kind(eight, ElementKind::Hex8e);
  EXPECT_EQ(enhanced.kind, ElementKind::Hex8e);
  EXPECT_EQ(enhanced.elements, eight.elements);
  EXPECT_EQ(with_kind(twenty, ElementKind::Hex8e).elements, eight.elements);
  EXPECT_EQ(mesh_block({{1, 1, 1}, [](const Vector3d& s) { return s; }, {}}, ElementKind::Hex8e)
                .num_nodes(),
            8);
  const HexMesh back = with_kind(twenty, ElementKind::Hex8);
  EXPECT_EQ(back.elements, eight.elements);
  EXPECT_EQ(back.nodes, eight.nodes);
}

TEST(ReadMesh, GivesARigTheFrequencyOfItsVoxels) {
  const Files files;
  Rig solid = test::beam_rig();
  const HexMesh voxels = mesh_part(solid, 2.5e-3, ElementKind::Hex8);
  write_vtu(files.path("beam.vtu"), voxels, {});
  Rig rig = solid;
  rig.parts.clear();
  rig.meshing.file = MeshFile{};
  rig.meshing.file->file = files.path("beam.vtu");
  rig.meshing.file->metres_per_unit = 1.0;
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20}) {
    const auto lambda = [&](const Rig& of) {
      const HexMesh mesh = mesh_part(of, 2.5e-3, kind);
      const ElasticBody body(mesh, {test::elastic(1e9, 0.3, 1180.0)}, ConstitutiveModel::Linear);
      return compute_eigenmodes(body, clamped_nodes(mesh, of)).lambda_per_s2(0);
    };
    EXPECT_NEAR(lambda(rig) / lambda(solid), 1.0, 1e-8);  // the solver's
  }
}

TEST(ReadMesh, GivesGroupsTheirMaterials) {
  const Files files;
  Rig rig = test::make_rig({});
  rig.meshing.file = files.file("part.msh", msh_2(example(ElementKind::Hex8)));
  // one material needs no groups
  EXPECT_EQ(mesh_part(rig, 1.0, ElementKind::Hex8).material_names,
            std::vector<std::string>{"part"});
  rig.materials.push_back(rig.materials[0]);
  rig.materials[1].name = "lower";
  EXPECT_TRUE(holds(test::refusal_of([&] { (void)mesh_part(rig, 1.0, ElementKind::Hex8); }),
                    "the group \"3\" has no material"));
  rig.meshing.file->material_of_group = {{"3", "part"}};
  const HexMesh mesh = mesh_part(rig, 1.0, ElementKind::Hex8);
  EXPECT_EQ(mesh.material_names, (std::vector<std::string>{"part", "lower"}));
  EXPECT_EQ(std::count(mesh.material_of_element.begin(), mesh.material_of_element.end(), 0), 4);
  rig.meshing.file->material_of_group = {{"3", "part"}, {"middle", "part"}};
  EXPECT_TRUE(holds(test::refusal_of([&] { (void)mesh_part(rig, 1.0, ElementKind::Hex8); }),
                    "no group \"middle\", it has \"3\", \"lower\""));
}

}  // namespace
}  // namespace twang
