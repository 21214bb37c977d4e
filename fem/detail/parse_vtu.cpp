// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "fem/detail/raw_mesh.hpp"
#include "fem/detail/vtk_data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

namespace twang {
namespace {

/// VTK's numbers of cell types.
constexpr int kVoxel = 11;
constexpr int kHexahedron = 12;
constexpr int kQuadraticHexahedron = 25;
/// Points, lines and faces: they are no part of the body.
constexpr std::array kSkippedTypes = {1, 2, 3, 4, 5, 6, 7, 8, 9, 21, 22, 23, 28};
/// Cell arrays that name a region, the first found counts.
constexpr std::array<std::string_view, 3> kRegionArrays = {
    "material", "gmsh:physical", "MaterialIds"};

/// The value of an attribute of a tag, empty if it has none.
std::string_view attribute(std::string_view tag, std::string_view name) {
  for (std::size_t at = tag.find(name); at != std::string_view::npos; at = tag.find(name, at + 1)) {
    const std::size_t equals = at + name.size();
    if (at == 0 || (tag[at - 1] != ' ' && tag[at - 1] != '\n' && tag[at - 1] != '\t')) continue;
    if (equals + 1 >= tag.size() || tag[equals] != '=') continue;
    const char quote = tag[equals + 1];
    const std::size_t end = tag.find(quote, equals + 2);
    if ((quote != '"' && quote != '\'') || end == std::string_view::npos) continue;
    return tag.substr(equals + 2, end - equals - 2);
  }
  return {};
}

class VtuParser {
 public:
  VtuParser(const std::string& file, const std::string& content) : m_xml(content) {
    m_encoding.file = file;
    const std::size_t appended = m_xml.find("<AppendedData");
    if (appended == std::string_view::npos) return;
    const std::size_t begin = m_xml.find('_', m_xml.find('>', appended));
    const std::string_view tag = m_xml.substr(appended, m_xml.find('>', appended) - appended);
    if (begin != std::string_view::npos) m_appended = m_xml.substr(begin + 1);
    m_appended_is_base64 = attribute(tag, "encoding") == "base64";
    m_xml = m_xml.substr(0, appended);
  }

  RawMesh parse() {
    const std::string_view head = tag("<VTKFile", m_xml);
    if (attribute(head, "type") != "UnstructuredGrid") {
      fail("is no VTK file of type UnstructuredGrid");
    }
    if (attribute(head, "byte_order") == "BigEndian") fail("is big-endian, must be little-endian");
    m_encoding.long_headers = attribute(head, "header_type") == "UInt64";
    const std::string_view compressor = attribute(head, "compressor");
    m_encoding.zlib = compressor == "vtkZLibDataCompressor";
    if (!compressor.empty() && !m_encoding.zlib) {
      fail(fmt::format("is compressed by {}, must be by zlib or not at all", compressor));
    }
    if (m_xml.find("<Piece", m_xml.find("<Piece") + 1) != std::string_view::npos) {
      fail("is in several pieces, must be one");
    }
    read_points();
    read_cells();
    return std::move(m_mesh);
  }

 private:
  [[noreturn]] void fail(const std::string& complaint) const {
    throw InputError(fmt::format("{}: {}", m_encoding.file, complaint));
  }

  /// The first tag that begins so, with what is inside it.
  [[nodiscard]] std::string_view tag(std::string_view begin, std::string_view xml) const {
    const std::size_t at = xml.find(begin);
    if (at == std::string_view::npos) fail(fmt::format("has no {}>, must be a VTK mesh", begin));
    return xml.substr(at, xml.find('>', at) - at);
  }
  [[nodiscard]] std::string_view section(std::string_view name) const {
    const std::size_t at = m_xml.find(fmt::format("<{}", name));
    if (at == std::string_view::npos) return {};
    return m_xml.substr(at, m_xml.find(fmt::format("</{}>", name), at) - at);
  }

  /// The numbers of the array `name` of a section (any name if empty); none if it is not there.
  [[nodiscard]] std::vector<double> array(std::string_view in, std::string_view name) const {
    for (std::size_t at = in.find("<DataArray"); at != std::string_view::npos;
         at = in.find("<DataArray", at + 1)) {
      const std::size_t end = in.find('>', at);
      if (end == std::string_view::npos) break;
      const std::string_view head = in.substr(at, end - at);
      if (!name.empty() && attribute(head, "Name") != name) continue;
      const std::string_view inside = in.substr(end + 1, in.find('<', end) - end - 1);
      return values(head, inside);
    }
    return {};
  }

  [[nodiscard]] std::vector<double> values(std::string_view head, std::string_view inside) const {
    const std::string_view format = attribute(head, "format");
    if (format == "ascii") return text_numbers(inside);
    if (format == "binary") {
      return numbers_of(
          m_encoding, attribute(head, "type"), read_vtk_array(m_encoding, inside, true));
    }
    const std::string_view text = attribute(head, "offset");
    std::size_t offset = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), offset);
    if (format != "appended" || error != std::errc() || offset >= m_appended.size()) {
      fail(fmt::format("the array '{}' is not there, the file may be cut short",
                       attribute(head, "Name")));
    }
    return numbers_of(m_encoding,
                      attribute(head, "type"),
                      read_vtk_array(m_encoding, m_appended.substr(offset), m_appended_is_base64));
  }

  [[nodiscard]] std::vector<double> text_numbers(std::string_view text) const {
    std::vector<double> numbers;
    constexpr std::string_view kBlank = " \t\r\n";
    for (std::size_t begin = text.find_first_not_of(kBlank); begin != std::string_view::npos;) {
      const std::size_t end = std::min(text.find_first_of(kBlank, begin), text.size());
      double value = 0.0;
      const auto [last, error] = std::from_chars(text.data() + begin, text.data() + end, value);
      if (error != std::errc() || last != text.data() + end) {
        fail(fmt::format("'{}' stands where a number should", text.substr(begin, end - begin)));
      }
      numbers.push_back(value);
      begin = text.find_first_not_of(kBlank, end);
    }
    return numbers;
  }

  void read_points() {
    const std::vector<double> x = array(section("Points"), "");
    if (x.empty() || x.size() % 3 != 0) fail("has no points of three coordinates each");
    for (std::size_t n = 0; n < x.size() / 3; ++n) {
      m_mesh.nodes.emplace_back(x[3 * n], x[3 * n + 1], x[3 * n + 2]);
      if (!m_mesh.nodes.back().allFinite()) {
        fail(fmt::format("point {} is not finite, must be", n + 1));
      }
    }
  }

  [[nodiscard]] std::vector<double> regions(std::size_t num_cells) const {
    for (const std::string_view name : kRegionArrays) {
      std::vector<double> found = array(section("CellData"), name);
      if (found.empty()) continue;
      if (found.size() != num_cells) {
        fail(fmt::format(
            "the cell array '{}' has {} values, must have {}", name, found.size(), num_cells));
      }
      return found;
    }
    return {};
  }

  void read_cells() {
    const std::string_view cells = section("Cells");
    const std::vector<double> nodes = array(cells, "connectivity");
    const std::vector<double> ends = array(cells, "offsets");
    const std::vector<double> types = array(cells, "types");
    if (ends.size() != types.size()) {
      fail(fmt::format("has {} offsets and {} types of cells", ends.size(), types.size()));
    }
    const std::vector<double> region = regions(types.size());
    double begin = 0.0;
    for (std::size_t c = 0; c < types.size(); ++c) {
      if (!(ends[c] >= begin && ends[c] <= static_cast<double>(nodes.size()))) {
        fail(fmt::format("cell {} ends at {}, which is no place in its nodes", c + 1, ends[c]));
      }
      add_cell(c,
               static_cast<int>(types[c]),
               std::vector<double>(nodes.begin() + static_cast<std::ptrdiff_t>(begin),
                                   nodes.begin() + static_cast<std::ptrdiff_t>(ends[c])),
               region.empty() ? std::string() : fmt::format("{}", region[c]));
      begin = ends[c];
    }
  }

  void add_cell(std::size_t cell, int type, const std::vector<double>& nodes, std::string group) {
    if (std::find(kSkippedTypes.begin(), kSkippedTypes.end(), type) != kSkippedTypes.end()) return;
    const ElementKind kind = type == kQuadraticHexahedron ? ElementKind::Hex20 : ElementKind::Hex8;
    const bool known = type == kVoxel || type == kHexahedron || type == kQuadraticHexahedron;
    if (!known || nodes.size() != static_cast<std::size_t>(nodes_per_element(kind))) {
      fail(fmt::format(
          "cell {} is of VTK's type {} with {} nodes, solid ones must be hexahedra of 8 or "
          "20 nodes (types 12 and 25)",
          cell + 1,
          type,
          nodes.size()));
    }
    std::vector<int> numbers;
    for (const double node : nodes) {
      if (!(node >= 0.0 && node < static_cast<double>(m_mesh.nodes.size()))) {
        fail(fmt::format("cell {} has node {}, which does not exist", cell + 1, node));
      }
      numbers.push_back(static_cast<int>(node));
    }
    if (type == kVoxel) {
      std::swap(numbers[2], numbers[3]);
      std::swap(numbers[6], numbers[7]);
    }
    const std::string fault = m_mesh.add(kind, std::move(numbers), std::move(group));
    if (!fault.empty()) fail(fault);
  }

  std::string_view m_xml;
  std::string_view m_appended;
  bool m_appended_is_base64 = false;
  VtkEncoding m_encoding;
  RawMesh m_mesh;
};

}  // namespace

RawMesh parse_vtu(const std::string& file, const std::string& content) {
  return VtuParser(file, content).parse();
}

}  // namespace twang
