// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/sheet_canvas.hpp"
#include "capture/track_markers.hpp"
#include "capture/track_summary.hpp"
#include "rigs/rig.hpp"

#include <string>
#include <vector>

namespace twang::detail {

/// Marks the time in which a marker was lost over the height of a plot whose abscissa is the time.
void draw_lost_stretches(SheetCanvas& canvas,
                         const SheetPlot& plot,
                         const MarkerSummary& marker,
                         const std::vector<double>& time_s);

/// The lower part of a contact sheet: a row for each marker with its name, its displacement to the
/// right and down over time (all at one scale), its sigma and noise floor, and in words how often
/// it was seen and why it was lost.
class MarkerRows {
 public:
  /// @param box  of the rows; titles stand above it, numbers of the axes below
  MarkerRows(const Rig& rig,
             const TrackResult& result,
             const std::vector<MarkerSummary>& markers,
             const SheetBox& box);
  void draw(SheetCanvas& canvas) const;

 private:
  void draw_names(SheetCanvas& canvas) const;
  void draw_paths(SheetCanvas& canvas, double left, int axis, const std::string& title) const;
  void draw_sigmas(SheetCanvas& canvas, double left) const;
  void draw_words(SheetCanvas& canvas, double left) const;
  /// Height of the middle of a row.
  [[nodiscard]] double middle(std::size_t row) const;

  const TrackResult& m_result;
  const std::vector<MarkerSummary>& m_markers;
  SheetBox m_box;
  std::size_t m_num_rows;
  double m_row_height;
  double m_letters;  // height of the rows' letters
  double m_reach_mm = 1e-3;
  std::vector<std::vector<Eigen::Vector2d>> m_paths_mm;
};

}  // namespace twang::detail
