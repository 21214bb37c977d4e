// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "fem/detail/raw_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <string_view>
#include <unordered_map>

namespace twang {
namespace {

/// Gmsh's numbers of element types.
constexpr int kHex8 = 5;
constexpr int kHex20 = 17;

struct SkippedType {
  int type;
  int nodes;
};
/// Points, lines and faces of first and second order: they are no part of the body.
constexpr std::array kSkipped = {SkippedType{15, 1},
                                 SkippedType{1, 2},
                                 SkippedType{2, 3},
                                 SkippedType{3, 4},
                                 SkippedType{8, 3},
                                 SkippedType{9, 6},
                                 SkippedType{10, 9},
                                 SkippedType{16, 8}};

/// Gmsh's place of VTK's node i of a hex20.
constexpr std::array<std::size_t, 20> kGmshFromVtk = {0,  1, 2,  3,  4,  5,  6,  7,  8,  11,
                                                      13, 9, 16, 18, 19, 17, 10, 12, 14, 15};

/// The words of a file, one after the other, with the line they stand in.
class Words {
 public:
  Words(const std::string& file, std::string_view text) : m_file(file), m_rest(text) {}

  [[noreturn]] void fail(const std::string& complaint) const {
    throw InputError(fmt::format("{}:{}: {}", m_file, m_line, complaint));
  }
  /// The next word, empty at the end of the file; a name in quotes is one word without them.
  std::string_view next_or_end() {
    skip_blank();
    if (m_rest.empty()) return {};
    const bool quoted = m_rest.front() == '"';
    if (quoted) m_rest.remove_prefix(1);
    const std::size_t length =
        std::min(m_rest.find_first_of(quoted ? "\"\n" : " \t\r\n"), m_rest.size());
    const std::string_view word = m_rest.substr(0, length);
    m_rest.remove_prefix(std::min(length + (quoted ? 1 : 0), m_rest.size()));
    return word;
  }
  std::string_view next(const char* what) {
    const std::string_view word = next_or_end();
    if (word.empty()) fail(fmt::format("ends where {} should stand", what));
    return word;
  }
  template <typename Number>
  Number number(const char* what) {
    const std::string_view word = next(what);
    Number value{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) {
      fail(fmt::format("'{}' stands where {} should", word, what));
    }
    return value;
  }
  long whole(const char* what) { return number<long>(what); }
  /// A number of things that follow, each of which takes a character at least.
  long count(const char* what) {
    const long value = whole(what);
    if (value < 0 || static_cast<unsigned long>(value) > m_rest.size()) {
      fail(fmt::format("{} is {}, which the file cannot hold", what, value));
    }
    return value;
  }
  Eigen::Vector3d point() {
    Eigen::Vector3d x;
    for (double& value : x) value = number<double>("a coordinate");
    if (!x.allFinite()) fail("a coordinate is not finite, must be");
    return x;
  }
  void skip(long words) {
    for (long i = 0; i < words; ++i) (void)next("a number");
  }
  void skip_section(std::string_view end) {
    while (next("the end of a section") != end) {
    }
  }
  void expect(std::string_view word) {
    const std::string_view found = next("the end of a section");
    if (found != word) fail(fmt::format("'{}' stands where {} should", found, word));
  }

 private:
  void skip_blank() {
    std::size_t at = 0;
    for (; at < m_rest.size() &&
           (m_rest[at] == ' ' || m_rest[at] == '\t' || m_rest[at] == '\r' || m_rest[at] == '\n');
         ++at) {
      if (m_rest[at] == '\n') ++m_line;
    }
    m_rest.remove_prefix(at);
  }
  const std::string& m_file;
  std::string_view m_rest;
  int m_line = 1;
};

class MshParser {
 public:
  MshParser(const std::string& file, const std::string& content) : m_words(file, content) {}

  RawMesh parse() {
    read_format();
    for (std::string_view section = m_words.next_or_end(); !section.empty();
         section = m_words.next_or_end()) {
      if (section == "$PhysicalNames") {
        read_names();
      } else if (section == "$Entities") {
        read_entities();
      } else if (section == "$Nodes") {
        m_is_new ? read_new_nodes() : read_old_nodes();
      } else if (section == "$Elements") {
        m_is_new ? read_new_elements() : read_old_elements();
      } else if (section.starts_with('$')) {
        m_words.skip_section("$End" + std::string(section.substr(1)));
        continue;
      } else {
        m_words.fail(fmt::format("'{}' stands where a section should begin", section));
      }
      m_words.expect("$End" + std::string(section.substr(1)));
    }
    return std::move(m_mesh);
  }

 private:
  void read_format() {
    m_words.expect("$MeshFormat");
    const std::string_view version = m_words.next("the version of the format");
    m_is_new = version == "4.1";
    if (!m_is_new && version != "2.2") {
      m_words.fail(fmt::format("is of the format {}, must be 2.2 or 4.1", version));
    }
    if (m_words.whole("the kind of file") != 0) {
      m_words.fail("is binary, must be ASCII (Mesh.Binary = 0 in Gmsh)");
    }
    m_words.skip(1);
    m_words.expect("$EndMeshFormat");
  }

  void read_names() {
    const long count = m_words.count("the number of names");
    for (long i = 0; i < count; ++i) {
      const long dimension = m_words.whole("a dimension");
      const long tag = m_words.whole("a number of a group");
      const std::string_view name = m_words.next("the name of a group");
      if (dimension == 3) m_names[tag] = std::string(name);
    }
  }

  /// Which physical group each volume is in.
  void read_entities() {
    const long points = m_words.count("the number of points");
    const long curves = m_words.count("the number of curves");
    const long faces = m_words.count("the number of surfaces");
    const long volumes = m_words.count("the number of volumes");
    for (long i = 0; i < points; ++i) {
      m_words.skip(4);
      m_words.skip(m_words.count("a number of groups"));
    }
    for (long i = 0; i < curves + faces + volumes; ++i) {
      const long tag = m_words.whole("a number of an entity");
      m_words.skip(6);
      const long groups = m_words.count("a number of groups");
      for (long g = 0; g < groups; ++g) {
        const long group = m_words.whole("a number of a group");
        if (g == 0 && i >= curves + faces) m_group_of_volume[tag] = group;
      }
      m_words.skip(m_words.count("a number of boundaries"));
    }
  }

  void add_node(long tag, const Eigen::Vector3d& x) {
    if (!m_node_of_tag.emplace(tag, static_cast<int>(m_mesh.nodes.size())).second) {
      m_words.fail(fmt::format("node {} is there twice, must be once", tag));
    }
    m_mesh.nodes.push_back(x);
  }

  void read_old_nodes() {
    const long count = m_words.count("the number of nodes");
    for (long i = 0; i < count; ++i) {
      const long tag = m_words.whole("the number of a node");
      add_node(tag, m_words.point());
    }
  }

  void read_new_nodes() {
    const long blocks = m_words.count("the number of blocks");
    m_words.skip(3);
    std::vector<long> tags;
    for (long b = 0; b < blocks; ++b) {
      const long dimension = m_words.whole("a dimension");
      m_words.skip(1);
      const bool parametric = m_words.whole("whether parameters follow") != 0;
      tags.resize(static_cast<std::size_t>(m_words.count("the number of nodes")));
      for (long& tag : tags) tag = m_words.whole("the number of a node");
      for (const long tag : tags) {
        add_node(tag, m_words.point());
        if (parametric) m_words.skip(dimension);
      }
    }
  }

  void add_element(long type, long group, bool has_group) {
    for (const SkippedType& skipped : kSkipped) {
      if (skipped.type != type) continue;
      m_words.skip(skipped.nodes);
      return;
    }
    if (type != kHex8 && type != kHex20) {
      m_words.fail(
          fmt::format("holds an element of Gmsh's type {}, solid ones must be hexahedra of 8 "
                      "or 20 nodes (types 5 and 17)",
                      type));
    }
    const ElementKind kind = type == kHex8 ? ElementKind::Hex8 : ElementKind::Hex20;
    std::vector<int> read(static_cast<std::size_t>(nodes_per_element(kind)));
    for (int& node : read) {
      const long tag = m_words.whole("a node of an element");
      const auto found = m_node_of_tag.find(tag);
      if (found == m_node_of_tag.end()) {
        m_words.fail(fmt::format("an element has node {}, which does not exist", tag));
      }
      node = found->second;
    }
    std::vector<int> nodes = read;
    for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] = read[kGmshFromVtk[i]];
    std::string name;
    if (has_group) {
      const auto named = m_names.find(group);
      name = named != m_names.end() ? named->second : std::to_string(group);
    }
    const std::string fault = m_mesh.add(kind, std::move(nodes), std::move(name));
    if (!fault.empty()) m_words.fail(fault);
  }

  void read_old_elements() {
    const long count = m_words.count("the number of elements");
    for (long i = 0; i < count; ++i) {
      m_words.skip(1);
      const long type = m_words.whole("the type of an element");
      const long tags = m_words.count("a number of tags");
      const long group = tags > 0 ? m_words.whole("the group of an element") : 0;
      m_words.skip(std::max(tags - 1, 0L));
      add_element(type, group, group != 0);
    }
  }

  void read_new_elements() {
    const long blocks = m_words.count("the number of blocks");
    m_words.skip(3);
    for (long b = 0; b < blocks; ++b) {
      m_words.skip(1);
      const auto volume = m_group_of_volume.find(m_words.whole("a number of an entity"));
      const long type = m_words.whole("the type of an element");
      const long count = m_words.count("the number of elements");
      const bool has_group = volume != m_group_of_volume.end();
      for (long i = 0; i < count; ++i) {
        m_words.skip(1);
        add_element(type, has_group ? volume->second : 0, has_group);
      }
    }
  }

  Words m_words;
  bool m_is_new = false;
  std::map<long, std::string> m_names;     ///< of physical volumes
  std::map<long, long> m_group_of_volume;  ///< format 4.1
  std::unordered_map<long, int> m_node_of_tag;
  RawMesh m_mesh;
};

}  // namespace

RawMesh parse_msh(const std::string& file, const std::string& content) {
  return MshParser(file, content).parse();
}

}  // namespace twang
