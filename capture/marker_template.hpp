// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/alignment_kernels.hpp"
#include "capture/marker_pattern.hpp"
#include "capture/sharp_marker.hpp"
#include "capture/video_reader.hpp"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

namespace twang {

/// A marker's ideal picture as a camera sees it at one size and blur, with its gradient: the fixed
/// reference that markers are aligned with, so that nothing can drift.
///
/// The pattern of `marker_pattern.hpp` is averaged over a pixel, blurred by a Gaussian and sampled
/// finely once, with its derivatives; afterwards a sample costs one look-up: the second-order
/// expansion about the nearest cell. Coordinates are those of the
/// pattern: in units of the outer size, centred, x right, y down. Copies share the samples.
class MarkerTemplate {
 public:
  /// Value (0 ink .. 1 paper) and its derivatives by the pattern's coordinates [1/size].
  struct Sample {
    double value;
    double du;
    double dv;
  };

  /// @param size_px  outer size of the marker in the picture, > 0 [px]
  /// @param blur_px  standard deviation of the lens's blur, >= 0 [px]
  MarkerTemplate(const MarkerPattern& pattern, double size_px, double blur_px);
  /// A marker as a picture shows it (a patch): the picture, lightly smoothed, takes the place of
  /// the pattern. What is left of its noise shifts all later alignments alike, by about what noise
  /// makes one of them scatter; their differences, which are what is measured, do not know of it.
  /// @param px_from_pattern  size, turn and slant, as in `MarkerPlacement` [px]
  [[nodiscard]] static MarkerTemplate cut_out(const MarkerPattern& pattern,
                                              const LumaFrame& frame,
                                              const Eigen::Vector2d& position_px,
                                              const Eigen::Matrix2d& px_from_pattern);
  /// Of a marker drawn before, which is most of the cost; the blur is in addition to a picture's
  /// own if it was cut out of one.
  MarkerTemplate(const SharpMarker& sharp, double blur_px);
  /// Notes where the template and its copies do not change, which alignments along a path of motion
  /// then make use of; pays where the template stays in use.
  void mark_even();

  [[nodiscard]] Sample at(double u, double v) const;
  /// The table itself, for inner loops; valid as long as the template.
  [[nodiscard]] detail::TemplateCells cells() const;
  [[nodiscard]] const MarkerPattern& pattern() const { return m_pattern; }
  [[nodiscard]] double size_px() const { return m_size_px; }
  [[nodiscard]] double blur_px() const { return m_blur_px; }
  /// Whether a turn of the marker can be seen.
  [[nodiscard]] bool has_turn() const { return m_has_turn; }
  /// Whether the marker ends at a circle (dot, ring) or at a square.
  [[nodiscard]] bool is_round() const { return !m_has_turn; }
  /// Whether there is paper around it, as around all that is printed.
  [[nodiscard]] bool has_rim() const { return !m_cut_out; }

 private:
  using Cell = std::array<detail::CellNumber, detail::kCellNumbers>;
  void make_cells(const float* first, std::ptrdiff_t stride, bool mirrored);
  [[nodiscard]] Cell& cell(int column, int row);

  struct Table {
    std::vector<Cell> cells;
    bool even_marked = false;
  };

  MarkerPattern m_pattern;
  double m_size_px;
  double m_blur_px;
  bool m_has_turn;
  bool m_cut_out;  // of a picture
  double m_cells_per_unit;
  int m_side = 0;  // cells along the square that the blur reaches
  int m_part = 0;  // as in TemplateCells
  std::shared_ptr<Table> m_table;
};

}  // namespace twang
