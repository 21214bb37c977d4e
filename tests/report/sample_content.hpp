// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"
#include "report/report_content.hpp"

#include <cmath>

namespace twang::test {

/// A text that would end the script, the attribute or the element it stands in, were it not
/// escaped.
inline constexpr const char* kHostileText = "</script><img src=x onerror=\"alert('1')\">&amp;";

/// A report with every kind of content, among it what charts find hard.
inline ReportContent sample_content() {
  Chart motion;
  motion.x_label = "Time [s]";
  motion.y_label = "Tip displacement [mm]";
  motion.marks = {{0.25, "release"}, {0.26, "fit starts"}};
  ChartSeries tracked{"tracked", {}, {}, ChartSeries::Style::Points};
  ChartSeries fitted{"fitted", {}, {}, ChartSeries::Style::Line};
  for (int n = 0; n < 240; ++n) {
    const double t = n / 240.0;
    tracked.x.push_back(t);
    tracked.y.push_back(n % 50 == 7 ? kNaN : std::exp(-5.0 * t) * std::cos(75.0 * t));
    fitted.x.push_back(t + 1e-3);
    fitted.y.push_back(std::exp(-5.0 * t) * std::cos(75.0 * t));
  }
  motion.series = {tracked, fitted};

  Chart spectrum;
  spectrum.x_label = "Frequency [Hz]";
  spectrum.y_label = "Power density [mm²/Hz]";
  spectrum.log_y = true;
  spectrum.series = {{"motion", {0, 10, 20, 30}, {1e-6, 1.0, 0.0, 1e-4}, ChartSeries::Style::Line},
                     {"residual", {5, 25}, {1e-6, 1e-6}, ChartSeries::Style::Dashed}};

  Chart one_sample{"x", "one sample", {{kHostileText, {5.0}, {1.0}}}, {}, false};
  Chart nothing{"x", "nothing at all", {{"empty", {}, {}}}, {}, false};
  Chart tiny{"x", "tiny", {{"constant", {1, 2, 3}, {2.5e-9, 2.5e-9, 2.5e-9}}}, {}, false};

  ReportContent content;
  content.title = "twang calibration: strip";
  content.headline = "The identified Young's modulus is 1894 ± 37 MPa at 55.42 Hz.";
  content.key_figures = {{"Name", "Value", "Meaning"},
                         {{"Identified E", "1894 ± 37 MPa", "of the mesh limit"},
                          {"Damping b", "0.1642 ± 0.0031 ms", "in D = b K"}}};
  content.warnings = {"Frames 311 to 314 are doubled."};
  content.remarks = {"Constant rate: 240 frames at 240 frames/s (stamps)."};
  content.sections = {
      {"The motion", {"Followed through 240 frames."}, {}, "", {motion}, {}},
      {"The spectrum",
       {},
       {0x89, 'P', 'N', 'G'},
       "The marker",
       {spectrum},
       {{{"Mode", "f [Hz]", "Note"}, {{"1", "55.42 ± 0.02", ""}, {"2", "–", "lost"}}}}},
      {kHostileText,
       {kHostileText},
       {},
       "",
       {one_sample, nothing},
       {{{kHostileText}, {{kHostileText}}}}},
      {"Small numbers", {}, {}, "", {tiny}, {}}};
  return content;
}

}  // namespace twang::test
