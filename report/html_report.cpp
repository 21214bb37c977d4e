// SPDX-License-Identifier: GPL-3.0-or-later
#include "report/html_report.hpp"

#include "core/text.hpp"
#include "core/version.hpp"
#include "report/detail/aligned_chart.hpp"
#include "report/detail/embedded_texts.hpp"
#include "report/detail/html_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

namespace twang {
namespace {

using detail::escape_html;

/// More sections than this get a line of links to them.
constexpr std::size_t kMostSectionsWithoutContents = 3;

/// The browser may load nothing from anywhere: the page is complete.
constexpr const char* kContentPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

bool is_unit(std::string_view word) {
  static constexpr std::array kUnits = {"%",
                                        "Pa",
                                        "kPa",
                                        "MPa",
                                        "GPa",
                                        "s",
                                        "ms",
                                        "µs",
                                        "1/s",
                                        "Hz",
                                        "m",
                                        "mm",
                                        "µm",
                                        "g",
                                        "kg",
                                        "rad",
                                        "mrad",
                                        "px"};
  return std::find(kUnits.begin(), kUnits.end(), word) != kUnits.end();
}

/// Escaped text in which a number stays on one line with its sigma and its unit.
std::string prose_html(std::string_view text) {
  constexpr std::string_view kPlusMinus = "±";
  std::string bound;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view after = text.substr(i + 1);
    const std::string_view word = after.substr(0, after.find_first_of(" .,;:()"));
    const bool after_number = i > 0 && std::isdigit(static_cast<unsigned char>(text[i - 1])) != 0;
    const bool binds = text.substr(0, i).ends_with(kPlusMinus) ||
                       (after_number && (word == kPlusMinus || is_unit(word)));
    bound += text[i] == ' ' && binds ? "\u00a0" : std::string(1, text[i]);
  }
  return escape_html(bound);
}

/// Whether a cell is a number, perhaps with a sign, a sigma or a unit, and belongs to the right.
bool reads_as_number(std::string_view cell) {
  for (const std::string_view sign : {"-", "+", "−", "±", "<", ">", "≈"}) {
    if (cell.starts_with(sign)) {
      cell.remove_prefix(sign.size());
      break;
    }
  }
  while (cell.starts_with(' ')) cell.remove_prefix(1);
  return !cell.empty() && std::isdigit(static_cast<unsigned char>(cell.front())) != 0;
}

/// A column of numbers and blanks with at least one number.
bool is_number_column(const TextTable& table, std::size_t column) {
  bool has_number = false;
  for (const std::vector<std::string>& row : table.rows) {
    if (column >= row.size()) continue;
    const std::string& cell = row[column];
    if (cell.empty() || cell == "–" || cell == "-" || cell == "nan") continue;
    if (!reads_as_number(cell)) return false;
    has_number = true;
  }
  return has_number;
}

std::string table_row(const std::vector<std::string>& cells,
                      const std::vector<bool>& is_number,
                      const char* element) {
  std::string html = "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const bool number = i < is_number.size() && is_number[i];
    html += fmt::format(
        "<{0}{1}>{2}</{0}>", element, number ? " class=\"number\"" : "", escape_html(cells[i]));
  }
  return html + "</tr>\n";
}

std::string table_html(const TextTable& table) {
  std::size_t num_columns = table.head.size();
  for (const auto& row : table.rows) num_columns = std::max(num_columns, row.size());
  std::vector<bool> is_number(num_columns);
  for (std::size_t i = 0; i < num_columns; ++i) is_number[i] = is_number_column(table, i);

  std::string html = "<div class=\"table-frame\"><table class=\"text\">\n";
  if (!table.head.empty())
    html += "<thead>" + table_row(table.head, is_number, "th") + "</thead>\n";
  html += "<tbody>\n";
  for (const auto& row : table.rows) html += table_row(row, is_number, "td");
  return html + "</tbody></table></div>\n";
}

/// Rows of name, value, meaning as a grid; any other table as it is.
std::string key_figures_html(const TextTable& table) {
  if (table.rows.empty()) return {};
  const bool is_triple = std::all_of(
      table.rows.begin(), table.rows.end(), [](const auto& r) { return r.size() == 3; });
  if (!is_triple) return table_html(table);
  std::string html = "<dl class=\"key-figures\">\n";
  for (const auto& row : table.rows) {
    html += fmt::format(
        "<div><dt>{}</dt><dd class=\"value\">{}</dd><dd class=\"meaning\">{}</dd></div>\n",
        escape_html(row[0]),
        prose_html(row[1]),
        prose_html(row[2]));
  }
  return html + "</dl>\n";
}

std::string warnings_html(const std::vector<std::string>& warnings) {
  if (warnings.empty()) return {};
  std::string html = "<aside class=\"warnings\"><h2>Before you trust this</h2><ul>\n";
  for (const std::string& warning : warnings)
    html += fmt::format("<li>{}</li>\n", prose_html(warning));
  return html + "</ul></aside>\n";
}

/// Ordinary notes, folded away behind all sections.
std::string remarks_html(const std::vector<std::string>& remarks) {
  if (remarks.empty()) return {};
  std::string html = fmt::format(
      "<details class=\"remarks\"><summary>Notes on the way ({})</summary><ul>\n", remarks.size());
  for (const std::string& remark : remarks)
    html += fmt::format("<li>{}</li>\n", prose_html(remark));
  return html + "</ul></details>\n";
}

/// "0.02 to 1.4" of the finite values, "–" if there is none.
std::string extent_text(const std::vector<double>& values) {
  constexpr int kDigits = 4;
  double lowest = INFINITY;
  double highest = -INFINITY;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
  }
  if (lowest > highest) return "–";
  return rounded_text(lowest, kDigits) + " to " + rounded_text(highest, kDigits);
}

/// What a reader without scripts sees of a chart.
TextTable chart_summary(const Chart& chart) {
  TextTable table;
  table.head = {"Curve", "Samples", chart.x_label, chart.y_label};
  for (const ChartSeries& series : chart.series) {
    table.rows.push_back({series.label,
                          fmt::format("{}", series.y.size()),
                          extent_text(series.x),
                          extent_text(series.y)});
  }
  for (const ChartMark& mark : chart.marks)
    table.rows.push_back({mark.label, "", fmt::format("at {}", rounded_text(mark.x, 4)), ""});
  return table;
}

std::string chart_html(const Chart& chart, const std::string& id) {
  if (!detail::has_values(chart)) {
    return fmt::format("<p class=\"hint\">{} over {}: there are no values to draw.</p>\n",
                       escape_html(chart.y_label),
                       escape_html(chart.x_label));
  }
  return fmt::format(
      "<figure><div class=\"chart\" data-chart=\"{0}\" role=\"img\" aria-label=\"{1} over {2}\">"
      "</div>\n<noscript><p>The chart is drawn by a script, which this browser does not run. It "
      "shows:</p>\n{3}</noscript>\n<script type=\"application/json\" id=\"{0}\">{4}</script>"
      "</figure>\n",
      id,
      escape_html(chart.y_label),
      escape_html(chart.x_label),
      table_html(chart_summary(chart)),
      detail::chart_json(chart));
}

std::string section_html(const ReportSection& section, std::size_t number) {
  std::string html =
      fmt::format("<section id=\"section-{}\"><h2>{}</h2>\n", number, escape_html(section.title));
  for (const std::string& paragraph : section.paragraphs)
    html += fmt::format("<p>{}</p>\n", prose_html(paragraph));
  if (!section.picture_png.empty()) {
    html += fmt::format(
        "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\">"
        "<figcaption>{0}</figcaption></figure>\n",
        escape_html(section.picture_caption),
        detail::base64(section.picture_png));
  }
  for (std::size_t i = 0; i < section.charts.size(); ++i)
    html += chart_html(section.charts[i], fmt::format("chart-{}-{}", number, i + 1));
  for (const TextTable& table : section.tables) html += table_html(table);
  return html + "</section>\n";
}

std::string contents_html(const std::vector<ReportSection>& sections) {
  if (sections.size() <= kMostSectionsWithoutContents) return {};
  std::string html = "<nav aria-label=\"Contents\">\n";
  for (std::size_t i = 0; i < sections.size(); ++i)
    html += fmt::format("<a href=\"#section-{}\">{}</a>\n", i + 1, escape_html(sections[i].title));
  return html + "</nav>\n";
}

bool has_chart(const ReportContent& content) {
  return std::any_of(content.sections.begin(), content.sections.end(), [](const auto& section) {
    return !section.charts.empty();
  });
}

std::string footer_html(bool with_charts) {
  std::string html = fmt::format("<footer><p>Written by twang {}.", kVersion);
  if (with_charts) {
    html += fmt::format(
        " Charts drawn by uPlot.</p>\n<details><summary>Licence of uPlot</summary><pre>{}</pre>"
        "</details>",
        escape_html(detail::kUplotLicence));
  } else {
    html += "</p>";
  }
  return html + "</footer>\n";
}

}  // namespace

std::string render_html(const ReportContent& content) {
  const bool with_charts = has_chart(content);
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<title>{}</title>\n",
      kContentPolicy,
      escape_html(content.title));
  if (with_charts) html += fmt::format("<style>{}</style>\n", detail::kUplotStyle);
  html += fmt::format("<style>\n{}</style>\n</head>\n<body>\n<main>\n<h1>{}</h1>\n",
                      detail::kPageStyle,
                      escape_html(content.title));
  if (!content.headline.empty())
    html += fmt::format("<p class=\"headline\">{}</p>\n", prose_html(content.headline));
  html += warnings_html(content.warnings);
  html += key_figures_html(content.key_figures);
  html += contents_html(content.sections);
  for (std::size_t i = 0; i < content.sections.size(); ++i)
    html += section_html(content.sections[i], i + 1);
  html += remarks_html(content.remarks);
  html += "</main>\n" + footer_html(with_charts);
  if (with_charts) {
    html += fmt::format(
        "<script>{}</script>\n<script>\n{}</script>\n", detail::kUplotScript, detail::kPageScript);
  }
  return html + "</body>\n</html>\n";
}

}  // namespace twang
