// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/tag_cells.hpp"

#include "capture/detail/embedded_codes.hpp"

#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h10.h>
#include <apriltag/tag36h11.h>

#include <array>
#include <cassert>
#include <charconv>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace twang::detail {
namespace {

std::string_view codes_of_table(std::string_view table) {
  constexpr int kTables = 4;
  const std::array<std::pair<std::string_view, std::string_view>, kTables> tables = {
      {{"4x4", kAruco4x4}, {"5x5", kAruco5x5}, {"6x6", kAruco6x6}, {"7x7", kAruco7x7}}};
  for (const auto& [name, text] : tables) {
    if (name == table) return text;
  }
  throw std::logic_error("no codes are built in for the dictionary " + std::string(table));
}

/// The word of that number in a text of words, lines that begin with # left out.
std::uint64_t read_code(std::string_view text, int number) {
  std::size_t at = 0;
  for (int passed = 0;; ++passed) {
    at = text.find_first_not_of(" \n", at);
    while (at != std::string_view::npos && text[at] == '#') {
      at = text.find_first_not_of(" \n", text.find('\n', at));
    }
    if (at == std::string_view::npos) break;
    const std::size_t end = text.find_first_of(" \n", at);
    const std::string_view word = text.substr(at, end - at);
    if (passed < number) {
      at = end;
      continue;
    }
    std::uint64_t code = 0;
    constexpr int kHexadecimal = 16;
    const auto read = std::from_chars(word.data(), word.data() + word.size(), code, kHexadecimal);
    if (read.ec == std::errc{} && read.ptr == word.data() + word.size()) return code;
    break;
  }
  throw std::logic_error("the codes that are built in cannot be read");
}

std::vector<bool> aruco_cells(const MarkerDictionary& dictionary, int tag) {
  const int count = dictionary.num_data_cells * dictionary.num_data_cells;
  const std::uint64_t code = read_code(codes_of_table(dictionary.table), tag);
  std::vector<bool> ink;
  for (int bit = count - 1; bit >= 0; --bit) ink.push_back((code >> bit & 1U) == 0);
  return ink;
}

/// The first ArUco tags: two bits of the number a row, in one of four words of five cells
/// [Garrido-Jurado et al. 2014].
std::vector<bool> original_aruco_cells(int tag) {
  constexpr int kSide = 5;
  constexpr std::array<unsigned, 4> kWords = {0b10000, 0b10111, 0b01001, 0b01110};
  std::vector<bool> ink;
  for (int row = 0; row < kSide; ++row) {
    const unsigned word = kWords[static_cast<unsigned>(tag) >> (2 * (kSide - 1 - row)) & 3U];
    for (int column = 0; column < kSide; ++column) {
      ink.push_back((word >> (kSide - 1 - column) & 1U) == 0);
    }
  }
  return ink;
}

struct Family {
  std::string_view name;
  apriltag_family_t* (*create)();
  void (*destroy)(apriltag_family_t*);
};

constexpr std::array kFamilies = {Family{"tag16h5", tag16h5_create, tag16h5_destroy},
                                  Family{"tag25h9", tag25h9_create, tag25h9_destroy},
                                  Family{"tag36h10", tag36h10_create, tag36h10_destroy},
                                  Family{"tag36h11", tag36h11_create, tag36h11_destroy}};

std::vector<bool> april_cells(const MarkerDictionary& dictionary, int tag) {
  const int side = dictionary.num_data_cells;
  for (const Family& known : kFamilies) {
    if (known.name != dictionary.table) continue;
    const std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family(known.create(),
                                                                                  known.destroy);
    if (tag >= static_cast<int>(family->ncodes) || static_cast<int>(family->nbits) != side * side) {
      throw std::logic_error("libapriltag knows another " + std::string(known.name));
    }
    std::vector<bool> ink(static_cast<std::size_t>(side * side));
    for (std::uint32_t i = 0; i < family->nbits; ++i) {
      // Counted from the border's outer corner.
      const auto column = static_cast<int>(family->bit_x[i]) - 1;
      const auto row = static_cast<int>(family->bit_y[i]) - 1;
      const bool paper = (family->codes[tag] >> (family->nbits - 1 - i) & 1U) != 0;
      ink[static_cast<std::size_t>(row * side + column)] = !paper;
    }
    return ink;
  }
  throw std::logic_error("no codes are built in for the family " + std::string(dictionary.table));
}

}  // namespace

std::vector<bool> tag_cells(const MarkerDictionary& dictionary, int tag) {
  assert(tag >= 0 && tag < dictionary.num_tags);
  if (dictionary.kind == MarkerKind::AprilTag) return april_cells(dictionary, tag);
  return dictionary.table == "original" ? original_aruco_cells(tag) : aruco_cells(dictionary, tag);
}

}  // namespace twang::detail
