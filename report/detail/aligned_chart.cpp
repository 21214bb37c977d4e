// SPDX-License-Identifier: GPL-3.0-or-later
#include "report/detail/aligned_chart.hpp"

#include "core/error.hpp"
#include "report/detail/html_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace twang::detail {
namespace {

struct Sample {
  double x = 0.0;
  ChartCell cell;
};

std::vector<Sample> sorted_samples(const ChartSeries& series, const Chart& chart) {
  if (series.x.size() != series.y.size()) {
    throw InputError(
        fmt::format("chart series \"{}\": has {} x and {} y, must have as many of each",
                    series.label,
                    series.x.size(),
                    series.y.size()));
  }
  std::vector<Sample> samples;
  samples.reserve(series.x.size());
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!std::isfinite(series.x[i]) || (chart.log_x && series.x[i] <= 0.0)) continue;
    const bool drawable = std::isfinite(series.y[i]) && (!chart.log_y || series.y[i] > 0.0);
    samples.push_back(
        {series.x[i],
         {drawable ? ChartCell::Kind::Value : ChartCell::Kind::Gap, drawable ? series.y[i] : 0.0}});
  }
  std::stable_sort(
      samples.begin(), samples.end(), [](const Sample& a, const Sample& b) { return a.x < b.x; });
  return samples;
}

/// The places of the marks as one more series, which has no samples to draw.
std::vector<Sample> mark_places(const std::vector<ChartMark>& marks) {
  std::vector<Sample> places;
  for (const ChartMark& mark : marks) {
    if (std::isfinite(mark.x)) places.push_back({mark.x, {}});
  }
  std::sort(
      places.begin(), places.end(), [](const Sample& a, const Sample& b) { return a.x < b.x; });
  return places;
}

/// The places without a sample on either side of a gap belong to it.
void widen_gaps(std::vector<ChartCell>& row) {
  const auto widen = [](auto first, auto last) {
    bool in_gap = false;
    for (auto cell = first; cell != last; ++cell) {
      if (cell->kind != ChartCell::Kind::Missing) {
        in_gap = cell->kind == ChartCell::Kind::Gap;
      } else if (in_gap) {
        cell->kind = ChartCell::Kind::Gap;
      }
    }
  };
  widen(row.begin(), row.end());
  widen(row.rbegin(), row.rend());
}

const char* style_name(ChartSeries::Style style) {
  switch (style) {
    case ChartSeries::Style::Points:
      return "points";
    case ChartSeries::Style::Dashed:
      return "dashed";
    case ChartSeries::Style::Line:
      break;
  }
  return "line";
}

std::string cell_json(const ChartCell& cell) {
  switch (cell.kind) {
    case ChartCell::Kind::Missing:
      return "\"\"";
    case ChartCell::Kind::Gap:
      return "null";
    case ChartCell::Kind::Value:
      break;
  }
  return json_number(cell.value);
}

/// `[text(item), ...]`
template <typename Items, typename Text>
std::string json_array(const Items& items, const Text& text) {
  std::string json = "[";
  for (const auto& item : items) {
    if (json.size() > 1) json += ',';
    json += text(item);
  }
  return json + "]";
}

/// The ends of a series' error bars, where both place and length are known.
std::string bars_json(const ChartSeries& series, const Chart& chart) {
  if (series.y_sigma.empty()) return "[]";
  if (series.y_sigma.size() != series.y.size()) {
    throw InputError(fmt::format(
        "chart series \"{}\": has {} y and {} sigmas, must have as many of each or none",
        series.label,
        series.y.size(),
        series.y_sigma.size()));
  }
  std::vector<std::string> bars;
  for (std::size_t i = 0; i < series.y.size(); ++i) {
    const double low = series.y[i] - series.y_sigma[i];
    const double high = series.y[i] + series.y_sigma[i];
    if (!std::isfinite(series.x[i]) || !std::isfinite(low) || !std::isfinite(high)) continue;
    if ((chart.log_x && series.x[i] <= 0.0) || (chart.log_y && low <= 0.0)) continue;
    bars.push_back(
        fmt::format("[{},{},{}]", json_number(series.x[i]), json_number(low), json_number(high)));
  }
  return json_array(bars, [](const std::string& bar) { return bar; });
}

}  // namespace

AlignedChart align_series(const Chart& chart) {
  std::vector<std::vector<Sample>> columns;
  for (const ChartSeries& series : chart.series) {
    columns.push_back(sorted_samples(series, chart));
  }
  columns.push_back(mark_places(chart.marks));

  AlignedChart aligned;
  aligned.rows.resize(chart.series.size());
  std::vector<std::size_t> heads(columns.size(), 0);
  const auto has_next = [&](std::size_t c) { return heads[c] < columns[c].size(); };
  while (true) {
    double x = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (has_next(c)) x = std::min(x, columns[c][heads[c]].x);
    }
    if (!std::isfinite(x)) break;
    aligned.x.push_back(x);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const bool here = has_next(c) && columns[c][heads[c]].x == x;
      if (c < aligned.rows.size()) {
        aligned.rows[c].push_back(here ? columns[c][heads[c]].cell : ChartCell{});
      }
      if (here) ++heads[c];
    }
  }
  for (std::vector<ChartCell>& row : aligned.rows) widen_gaps(row);
  return aligned;
}

bool has_values(const Chart& chart) {
  return std::any_of(chart.series.begin(), chart.series.end(), [&](const ChartSeries& series) {
    const std::vector<Sample> samples = sorted_samples(series, chart);
    return std::any_of(samples.begin(), samples.end(), [](const Sample& sample) {
      return sample.cell.kind == ChartCell::Kind::Value;
    });
  });
}

std::string chart_json(const Chart& chart) {
  const AlignedChart aligned = align_series(chart);
  std::string series;
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    series += fmt::format("{}{{\"label\":{},\"style\":\"{}\",\"y\":{},\"bars\":{}}}",
                          i == 0 ? "" : ",",
                          json_string_for_script(chart.series[i].label),
                          style_name(chart.series[i].style),
                          json_array(aligned.rows[i], cell_json),
                          bars_json(chart.series[i], chart));
  }
  const std::string marks = json_array(chart.marks, [](const ChartMark& mark) {
    return fmt::format(
        "{{\"x\":{},\"label\":{}}}", json_number(mark.x), json_string_for_script(mark.label));
  });
  return fmt::format(
      "{{\"x_label\":{},\"y_label\":{},\"log_x\":{},\"log_y\":{},\"marks\":{},\"x\":{},\"series\":["
      "{}]}}",
      json_string_for_script(chart.x_label),
      json_string_for_script(chart.y_label),
      chart.log_x,
      chart.log_y,
      marks,
      json_array(aligned.x, json_number),
      series);
}

}  // namespace twang::detail
