// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/surface_mesh.hpp"

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace twang {
namespace {

/// Vertices and triangles as they come, in the file's unit.
struct RawSurface {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;
};

/// A line of a text file in words, with what is needed to say where it stands.
struct Line {
  const std::string& file;
  int number = 0;
  std::vector<std::string_view> words;

  [[noreturn]] void fail(const std::string& complaint) const {
    throw InputError(fmt::format("{}:{}: {}", file, number, complaint));
  }
  [[nodiscard]] Eigen::Vector3d vector_after(std::size_t first) const {
    if (words.size() < first + 3) fail("has too few numbers, must have three coordinates");
    Eigen::Vector3d vector;
    for (std::size_t i = 0; i < 3; ++i) {
      std::string_view word = words[first + i];
      if (word.starts_with('+')) word.remove_prefix(1);
      double value = 0.0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
      if (error != std::errc() || end != word.data() + word.size()) {
        fail(fmt::format("'{}' is no coordinate, must be a number", words[first + i]));
      }
      vector(static_cast<Eigen::Index>(i)) = value;
    }
    return vector;
  }
};

std::vector<std::string_view> words_of(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  std::vector<std::string_view> words;
  for (std::size_t begin = text.find_first_not_of(kBlank); begin != std::string_view::npos;) {
    const std::size_t end = text.find_first_of(kBlank, begin);
    words.push_back(text.substr(begin, end - begin));
    begin = text.find_first_not_of(kBlank, std::min(end, text.size()));
  }
  return words;
}

template <typename Action>
void for_each_line(const std::string& file, std::string_view text, Action&& action) {
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const Line line = {file, number, words_of(text.substr(0, end))};
    if (!line.words.empty()) action(line);
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  }
}

void append_triangle_of_last_three(RawSurface& surface) {
  const int count = static_cast<int>(surface.vertices.size());
  surface.triangles.emplace_back(count - 3, count - 2, count - 1);
}

RawSurface read_ascii_stl(const std::string& file, std::string_view text) {
  RawSurface surface;
  for_each_line(file, text, [&](const Line& line) {
    if (line.words[0] == "vertex") {
      surface.vertices.push_back(line.vector_after(1));
    } else if (line.words[0] == "endfacet") {
      if (surface.vertices.size() != 3 * (surface.triangles.size() + 1)) {
        line.fail("ends a facet that has not three vertices");
      }
      append_triangle_of_last_three(surface);
    }
  });
  if (surface.vertices.size() != 3 * surface.triangles.size()) {
    throw InputError(fmt::format("{}: is cut short, must end after a facet", file));
  }
  return surface;
}

constexpr std::size_t kStlHeaderBytes = 80;
constexpr std::size_t kStlTriangleBytes = 50;

std::uint32_t binary_stl_count(std::string_view bytes) {
  static_assert(std::endian::native == std::endian::little, "STL is little-endian");
  std::uint32_t count = 0;
  if (bytes.size() >= kStlHeaderBytes + sizeof count) {
    std::memcpy(&count, bytes.data() + kStlHeaderBytes, sizeof count);
  }
  return count;
}

std::size_t binary_stl_size(std::string_view bytes) {
  return kStlHeaderBytes + sizeof(std::uint32_t) + kStlTriangleBytes * binary_stl_count(bytes);
}

RawSurface read_binary_stl(std::string_view bytes) {
  RawSurface surface;
  const std::uint32_t count = binary_stl_count(bytes);
  const char* triangle = bytes.data() + kStlHeaderBytes + sizeof count;
  for (std::uint32_t i = 0; i < count; ++i, triangle += kStlTriangleBytes) {
    float numbers[12];  // the normal, then three vertices
    std::memcpy(numbers, triangle, sizeof numbers);
    for (int v = 1; v <= 3; ++v) {
      surface.vertices.emplace_back(numbers[3 * v], numbers[3 * v + 1], numbers[3 * v + 2]);
    }
    append_triangle_of_last_three(surface);
  }
  return surface;
}

RawSurface read_obj(const std::string& file, std::string_view text) {
  RawSurface surface;
  const auto corner = [&](const Line& line, std::size_t i) {
    const std::string_view word = line.words[i].substr(0, line.words[i].find('/'));
    int index = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
    const int count = static_cast<int>(surface.vertices.size());
    const int from_zero = index > 0 ? index - 1 : count + index;
    if (error != std::errc() || end != word.data() + word.size() || index == 0 || from_zero < 0 ||
        from_zero >= count) {
      line.fail(fmt::format("'{}' is no corner, must be the number of a vertex above", word));
    }
    return from_zero;
  };
  for_each_line(file, text, [&](const Line& line) {
    if (line.words[0] == "v") surface.vertices.push_back(line.vector_after(1));
    if (line.words[0] != "f") return;
    if (line.words.size() < 4) line.fail("has too few corners, must have three or more");
    for (std::size_t i = 2; i + 1 < line.words.size(); ++i) {
      surface.triangles.emplace_back(corner(line, 1), corner(line, i), corner(line, i + 1));
    }
  });
  return surface;
}

RawSurface read_raw(const std::filesystem::path& path) {
  const std::string file = path.string();
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  if (extension != ".stl" && extension != ".obj") {
    throw InputError(fmt::format("{}: is no surface file, must be named .stl or .obj", file));
  }
  const std::string content = read_file(path);
  if (extension == ".obj") return read_obj(file, content);
  if (content.size() == binary_stl_size(content)) return read_binary_stl(content);
  const bool is_text = content.find('\0') == std::string::npos;
  if (is_text && content.starts_with("solid")) return read_ascii_stl(file, content);
  if (content.empty()) throw InputError(fmt::format("{}: is empty, must hold a surface", file));
  const std::size_t expected = binary_stl_size(content);
  if (!is_text && content.size() < expected) {
    throw InputError(fmt::format(
        "{}: is cut short, holds {} bytes of the {} that binary STL of {} triangles has",
        file,
        content.size(),
        expected,
        binary_stl_count(content)));
  }
  throw InputError(fmt::format(
      "{}: holds {} bytes, must be ASCII STL or binary STL of {} triangles as its header says",
      file,
      content.size(),
      binary_stl_count(content)));
}

}  // namespace

SurfaceMesh read_surface(const SurfaceFile& surface) {
  if (surface.triangles.cols() > 0) return {surface.vertices, surface.triangles};
  const RawSurface raw = read_raw(surface.file);
  if (raw.triangles.empty()) {
    throw InputError(
        fmt::format("{}: has no triangle, must hold a closed surface", surface.file.string()));
  }
  SurfaceMesh mesh;
  mesh.vertices.resize(3, static_cast<Eigen::Index>(raw.vertices.size()));
  for (std::size_t i = 0; i < raw.vertices.size(); ++i) {
    if (!raw.vertices[i].allFinite()) {
      throw InputError(
          fmt::format("{}: vertex {} is not finite, must be", surface.file.string(), i + 1));
    }
    mesh.vertices.col(static_cast<Eigen::Index>(i)) =
        surface.metres_per_unit * raw.vertices[i] + surface.at;
  }
  mesh.triangles.resize(3, static_cast<Eigen::Index>(raw.triangles.size()));
  for (std::size_t i = 0; i < raw.triangles.size(); ++i) {
    mesh.triangles.col(static_cast<Eigen::Index>(i)) = raw.triangles[i];
  }
  return mesh;
}

Box bounds_of(const SurfaceMesh& surface) {
  assert(surface.triangles.cols() > 0);
  const Eigen::Vector3d first = surface.vertices.col(surface.triangles(0, 0));
  Box box = {first, first};
  for (const int v : surface.triangles.reshaped()) {
    box.min = box.min.cwiseMin(surface.vertices.col(v));
    box.max = box.max.cwiseMax(surface.vertices.col(v));
  }
  return box;
}

void write_stl(const std::filesystem::path& path, const SurfaceMesh& surface) {
  std::string bytes = "binary STL in mm";
  bytes.resize(kStlHeaderBytes, ' ');
  const auto append = [&](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  append(static_cast<std::uint32_t>(surface.triangles.cols()));
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    Eigen::Matrix3d corners;
    for (int i = 0; i < 3; ++i) corners.col(i) = surface.vertices.col(surface.triangles(i, t));
    const Eigen::Vector3d normal =
        (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0)).normalized();
    for (const double x : normal) append(static_cast<float>(x));
    for (const double x : corners.reshaped()) append(static_cast<float>(x * kMillimetresPerMetre));
    append(std::uint16_t{0});
  }
  write_file_atomically(path, bytes);
}

}  // namespace twang
