// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/rig.hpp"

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <string>

namespace twang {

/// The ideal picture of a marker, as printed: 0 where it is ink, 1 where it is paper.
///
/// One definition serves finding, aligning and rendering. Coordinates are in units of the outer
/// size, centred, x right, y down: the pattern fills [-1/2, 1/2]². Outside it is paper.
///
///     cross     two bars across the whole size, each a third of the size wide
///     dot       a filled disk of diameter 1
///     ring      a disk of diameter 1 with a hole of diameter 1/2
///     checker   a square of side 1, its upper left and lower right quadrants ink
///     aruco, apriltag   a square of cells, the outermost ink
///     patch     a smooth grey texture that its id decides and that goes on over the paper. It
///               stands for natural texture in rendered films alone: in a film, a patch looks as
///               its first frame shows it
///
/// A small value, cheap to copy and to compare.
class MarkerPattern {
 public:
  /// Of a marker of any kind.
  /// @throws InputError naming the marker, if there is no such dictionary or no such tag in it
  explicit MarkerPattern(const Marker& marker);
  /// Of a kind whose picture the kind alone decides: cross, dot, ring, checker.
  /// @throws InputError for the others
  explicit MarkerPattern(MarkerKind kind);

  [[nodiscard]] MarkerKind kind() const { return m_kind; }
  [[nodiscard]] double value(double x, double y) const;
  /// The same, area-averaged over a square of side `width` around (x, y): what a pixel of that
  /// size sees. Values 0..1. Cost: a few evaluations near an edge, one elsewhere.
  [[nodiscard]] double averaged(double x, double y, double width) const;
  /// Angle after which the pattern repeats under rotation; 0 where every turn looks the same (dot,
  /// ring) [rad].
  [[nodiscard]] double rotational_period_rad() const;

  /// Cells along a tag's side, its black border included; 0 for what is no tag.
  [[nodiscard]] int num_cells() const { return m_num_cells; }
  /// Whether a cell of a tag is ink; rows from the top, columns from the left.
  [[nodiscard]] bool ink(int row, int column) const;
  /// Cells of a tag that may be misread without leaving doubt which tag of its dictionary it is.
  [[nodiscard]] int correctable_cells() const { return m_correctable_cells; }

  [[nodiscard]] auto operator<=>(const MarkerPattern&) const = default;

 private:
  struct Rectangle;
  /// One of the waves that a patch's texture is made of.
  struct Wave {
    double u = 0.0, v = 0.0;  // waves a size, along x and y
    double phase_rad = 0.0;
    [[nodiscard]] auto operator<=>(const Wave&) const = default;
  };
  static constexpr std::size_t kWaves = 6;

  void take_cells(const Marker& marker);
  void draw_texture(const std::string& id);
  void set_ink(int row, int column);
  [[nodiscard]] double texture(double x, double y, double width) const;
  [[nodiscard]] double ink_area(const Rectangle& box) const;
  [[nodiscard]] double ink_area_of_cells(const Rectangle& box) const;

  MarkerKind m_kind;
  int m_num_cells = 0;
  int m_correctable_cells = 0;
  std::array<std::uint64_t, 2> m_cells{};  // a bit a cell, row by row; 1: ink
  std::array<Wave, kWaves> m_waves{};
};

}  // namespace twang
