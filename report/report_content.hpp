// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace twang {

/// One curve or cloud of points of a chart; nan breaks a line.
struct ChartSeries {
  std::string label;
  std::vector<double> x;
  std::vector<double> y;
  enum class Style { Line, Points, Dashed } style = Style::Line;
  std::vector<double> y_sigma = {};  ///< half length of the error bars, as many as y; empty: none
};

/// A vertical line with a label.
struct ChartMark {
  double x = 0.0;
  std::string label;
};

/// A chart of curves over a common axis; zoomable in the report, legible in print.
struct Chart {
  std::string x_label;  ///< with its unit
  std::string y_label;  ///< with its unit
  std::vector<ChartSeries> series;
  std::vector<ChartMark> marks;
  bool log_y = false;
  bool log_x = false;  ///< what is not positive is left out
};

/// A table of texts; the first row is the head.
struct TextTable {
  std::vector<std::string> head;
  std::vector<std::vector<std::string>> rows;
};

/// A part of a report: any of prose, picture, chart, table, in this order.
struct ReportSection {
  std::string title;
  std::vector<std::string> paragraphs;
  std::vector<std::uint8_t> picture_png;  ///< empty: none
  std::string picture_caption;
  std::vector<Chart> charts;
  std::vector<TextTable> tables;
};

/// What a report shows; whoever fills it has computed everything.
struct ReportContent {
  std::string title;
  std::string headline;   ///< the result in one sentence, with units
  TextTable key_figures;  ///< name, value, meaning
  std::vector<ReportSection> sections;
  std::vector<std::string> warnings;  ///< what to know before the numbers are trusted
  std::vector<std::string> remarks;   ///< what else was noted on the way
};

}  // namespace twang
