// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/vtu.hpp"

#include "core/atomic_file.hpp"
#include "tests/fem/distorted_mesh.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>

namespace twang {
namespace {

/// The values of the array `name`: its offset read from the XML, its bytes from the appended data.
template <class Value>
std::vector<Value> array_of(const std::string& file, const std::string& name) {
  const std::size_t named = file.find("Name=\"" + name + "\"");
  if (named == std::string::npos) return {};
  const std::string key = "offset=\"";
  const std::size_t offset = std::stoul(file.substr(file.find(key, named) + key.size(), 20));
  const std::size_t data =
      file.find("encoding=\"raw\">") + std::string("encoding=\"raw\">\n_").size();
  const std::size_t at = data + offset;
  std::uint64_t length = 0;
  std::memcpy(&length, file.data() + at, sizeof length);
  std::vector<Value> values(length / sizeof(Value));
  std::memcpy(values.data(), file.data() + at + sizeof length, length);
  return values;
}

TEST(WriteVtu, HoldsNodesCellsMaterialsAndFields) {
  for (const ElementKind kind : {ElementKind::Hex8, ElementKind::Hex20}) {
    HexMesh mesh = test::distorted_mesh(kind, 0.1);
    mesh.material_of_element.back() = 3;
    const Eigen::VectorXd field = test::random_vector(mesh.num_dofs(), 1.0, 1);
    const test::TemporaryFolder folder;
    write_vtu(folder.path() / "mesh.vtu", mesh, {{"mode_1", field}, {"rest", 0.0 * field}});
    const std::string file = read_file(folder.path() / "mesh.vtu");
    EXPECT_TRUE(test::holds(file, "NumberOfPoints=\"" + std::to_string(mesh.num_nodes()) + "\""));
    EXPECT_TRUE(test::holds(file, "NumberOfCells=\"12\""));

    const auto positions = array_of<double>(file, "position_m");
    EXPECT_EQ(positions,
              std::vector<double>(mesh.nodes.data(), mesh.nodes.data() + mesh.nodes.size()));
    const auto connectivity = array_of<std::int64_t>(file, "connectivity");
    EXPECT_EQ(connectivity,
              std::vector<std::int64_t>(mesh.elements.data(),
                                        mesh.elements.data() + mesh.elements.size()));
    const auto offsets = array_of<std::int64_t>(file, "offsets");
    ASSERT_EQ(offsets.size(), 12U);
    EXPECT_EQ(offsets.front(), nodes_per_element(kind));
    EXPECT_EQ(offsets.back(), 12 * nodes_per_element(kind));
    const std::uint8_t type = kind == ElementKind::Hex8 ? 12 : 25;
    EXPECT_EQ(array_of<std::uint8_t>(file, "types"), std::vector<std::uint8_t>(12, type));
    EXPECT_EQ(array_of<std::int32_t>(file, "material").back(), 3);
    EXPECT_EQ(array_of<double>(file, "mode_1"),
              std::vector<double>(field.data(), field.data() + field.size()));
    EXPECT_EQ(array_of<double>(file, "rest").size(), static_cast<std::size_t>(field.size()));
  }
}

TEST(WriteVtu, RefusesAFieldOfTheWrongSizeAndLeavesNothing) {
  const HexMesh mesh = test::distorted_mesh(ElementKind::Hex8, 0.0);
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "mesh.vtu";
  const std::string message = test::refusal_of([&] {
    write_vtu(path, mesh, {{"u", Eigen::VectorXd::Zero(5)}});
  });
  EXPECT_TRUE(test::holds(message, "\"u\" has 5 values"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace twang
