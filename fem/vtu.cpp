// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/vtu.hpp"

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/text.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>

namespace twang {
namespace {

constexpr int kVtkHexahedron = 12;
constexpr int kVtkQuadraticHexahedron = 25;

/// Binary arrays, one after the other, each behind its length in bytes: VTK's raw appended data.
class AppendedData {
 public:
  /// Adds an array and returns its offset.
  template <class Value>
  std::size_t add(std::span<const Value> values) {
    const std::size_t offset = m_bytes.size();
    const std::uint64_t length = values.size_bytes();
    append(&length, sizeof length);
    append(values.data(), values.size_bytes());
    return offset;
  }
  [[nodiscard]] const std::string& bytes() const { return m_bytes; }

 private:
  void append(const void* data, std::size_t size) {
    m_bytes.append(static_cast<const char*>(data), size);
  }
  std::string m_bytes;
};

std::string data_array(std::string_view type,
                       std::string_view name,
                       int components,
                       std::size_t offset) {
  return fmt::format(
      "        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
      "offset=\"{}\"/>\n",
      type,
      name,
      components,
      offset);
}

std::string cell_data(const HexMesh& mesh,
                      const std::vector<CellArray>& arrays,
                      AppendedData& data) {
  const auto num_elements = static_cast<std::size_t>(mesh.num_elements());
  const Eigen::MatrixXi& elements = mesh.elements;
  const std::vector<std::int64_t> connectivity(elements.data(), elements.data() + elements.size());
  std::vector<std::int64_t> offsets(num_elements);
  for (std::size_t e = 0; e < num_elements; ++e) {
    offsets[e] = static_cast<std::int64_t>(e + 1) * elements.rows();
  }
  const std::vector<std::uint8_t> types(
      num_elements, mesh.kind == ElementKind::Hex20 ? kVtkQuadraticHexahedron : kVtkHexahedron);
  std::string xml = "      <Cells>\n";
  xml += data_array("Int64", "connectivity", 1, data.add(std::span(connectivity)));
  xml += data_array("Int64", "offsets", 1, data.add(std::span(std::as_const(offsets))));
  xml += data_array("UInt8", "types", 1, data.add(std::span(types)));
  xml += "      </Cells>\n      <CellData Scalars=\"material\">\n";
  const std::vector<std::int32_t> material(mesh.material_of_element.begin(),
                                           mesh.material_of_element.end());
  xml += data_array("Int32", "material", 1, data.add(std::span(material)));
  for (const CellArray& array : arrays) {
    if (array.values.size() != static_cast<Eigen::Index>(array.components) * mesh.num_elements()) {
      throw InputError(fmt::format("the cell array \"{}\" has {} values, must have {} a cell",
                                   array.name,
                                   array.values.size(),
                                   array.components));
    }
    const std::span<const double> values(array.values.data(),
                                         static_cast<std::size_t>(array.values.size()));
    xml += data_array("Float64", escape_xml(array.name), array.components, data.add(values));
  }
  return xml + "      </CellData>\n";
}

}  // namespace

void write_vtu(const std::filesystem::path& path,
               const HexMesh& mesh,
               const std::vector<std::pair<std::string, Eigen::VectorXd>>& point_vectors,
               const std::vector<CellArray>& cell_arrays) {
  static_assert(std::endian::native == std::endian::little);
  AppendedData data;
  std::string xml = fmt::format(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n"
      "  <UnstructuredGrid>\n"
      "    <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n"
      "      <Points>\n",
      mesh.num_nodes(),
      mesh.num_elements());
  const auto values = [](const auto& matrix) {
    return std::span<const double>(matrix.data(), static_cast<std::size_t>(matrix.size()));
  };
  xml += data_array("Float64", "position_m", 3, data.add(values(mesh.nodes)));
  xml += "      </Points>\n" + cell_data(mesh, cell_arrays, data) + "      <PointData>\n";
  for (const auto& [name, field] : point_vectors) {
    if (field.size() != mesh.num_dofs()) {
      throw InputError(fmt::format("{}: the field \"{}\" has {} values, must have {}",
                                   path.string(),
                                   name,
                                   field.size(),
                                   mesh.num_dofs()));
    }
    xml += data_array("Float64", escape_xml(name), 3, data.add(values(field)));
  }
  xml +=
      "      </PointData>\n    </Piece>\n  </UnstructuredGrid>\n"
      "  <AppendedData encoding=\"raw\">\n_";
  xml += data.bytes();
  xml += "\n  </AppendedData>\n</VTKFile>\n";
  write_file_atomically(path, xml);
}

}  // namespace twang
