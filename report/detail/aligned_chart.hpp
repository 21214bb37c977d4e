// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "report/report_content.hpp"

#include <string>
#include <vector>

namespace twang::detail {

/// What a series has at a place of the common axis.
struct ChartCell {
  enum class Kind {
    Missing,  ///< no sample: the line passes over
    Gap,      ///< a sample without a value: the line breaks
    Value
  } kind = Kind::Missing;
  double value = 0.0;
};

/// The series of a chart over one common ascending axis, as the chart library wants them.
struct AlignedChart {
  std::vector<double> x;                     ///< ascending; repeated where a series repeats a place
  std::vector<std::vector<ChartCell>> rows;  ///< [series][place]
};

/// Sorts each series by x and merges them onto one axis that also holds the places of the marks.
///
/// A sample whose x is not finite, or not positive on a logarithmic axis, is left out. A y that is
/// not finite, or not positive on a logarithmic axis, is a gap, and so is everything between it and
/// the samples beside it.
///
/// @throws InputError if a series has not as many x as y
[[nodiscard]] AlignedChart align_series(const Chart& chart);

/// Whether any series has a sample that can be drawn.
[[nodiscard]] bool has_values(const Chart& chart);

/// The chart as JSON, safe inside a script element: x_label, y_label, log_x, log_y, x, marks
/// [{x, label}] and series [{label, style, y, bars}], where a y of null is a gap and one of "" no
/// sample, and a bar is [x, low, high].
///
/// @throws InputError if a series has not as many x as y, or some sigmas but not as many
[[nodiscard]] std::string chart_json(const Chart& chart);

}  // namespace twang::detail
