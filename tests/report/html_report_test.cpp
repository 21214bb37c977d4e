// SPDX-License-Identifier: GPL-3.0-or-later
#include "report/html_report.hpp"

#include "core/version.hpp"
#include "tests/report/sample_content.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace twang {
namespace {

using test::kHostileText;
using test::sample_content;

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t times = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++times;
  return times;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// The page without what stands between `begin` and `end`, which both stay.
std::string without_inside(const std::string& html,
                           const std::string& begin,
                           const std::string& end) {
  std::string rest = html;
  for (std::size_t at = rest.find(begin); at != std::string::npos; at = rest.find(begin, at + 1)) {
    const std::size_t inside = rest.find('>', at) + 1;
    rest.erase(inside, rest.find(end, inside) - inside);
  }
  return rest;
}

/// The values of all attributes `name` in tags; what stands in scripts and styles is no tag.
std::vector<std::string> attribute_values(const std::string& html, const std::string& name) {
  const std::string page =
      without_inside(without_inside(html, "<script", "</script>"), "<style", "</style>");
  std::vector<std::string> values;
  for (std::size_t open = page.find('<'); open != std::string::npos;
       open = page.find('<', open + 1)) {
    const std::string tag = page.substr(open, page.find('>', open) - open);
    const std::string start = " " + name + "=\"";
    const std::size_t value = tag.find(start);
    EXPECT_EQ(tag.find(" " + name + "='"), std::string::npos);
    if (value == std::string::npos) continue;
    const std::size_t first = value + start.size();
    values.push_back(tag.substr(first, tag.find('"', first) - first));
  }
  return values;
}

/// The page without the two texts that are not ours: the chart library and its style.
std::string own_page(const std::string& html) {
  std::string own = html;
  const std::size_t start = own.find("<script>/*! ");
  own.erase(start, own.find("</script>", start) - start);
  return own;
}

TEST(HtmlReport, ShowsEveryPieceOfItsContent) {
  const std::string html = render_html(sample_content());
  for (const char* piece : {"<title>twang calibration: strip</title>",
                            "<h1>twang calibration: strip</h1>",
                            "Young&#39;s modulus is",
                            "<li>Frames 311 to 314 are doubled.</li>",
                            "<dt>Identified E</dt>",
                            "of the mesh limit",
                            "<h2>The motion</h2>",
                            "<p>Followed through 240 frames.</p>",
                            "<figcaption>The marker</figcaption>",
                            "src=\"data:image/png;base64,iVBORw==\"",
                            "<td>lost</td>",
                            "\"label\":\"tracked\"",
                            "\"label\":\"fit starts\"",
                            "\"x_label\":\"Time [s]\"",
                            "\"log_y\":true"})
    EXPECT_TRUE(contains(html, piece)) << piece;
  EXPECT_TRUE(contains(html, std::string("Written by twang ") + kVersion));
}

TEST(HtmlReport, LoadsNothingFromOutsideTheFile) {
  const std::string html = render_html(sample_content());
  const std::vector<std::string> sources = attribute_values(html, "src");
  EXPECT_EQ(sources, std::vector<std::string>({"data:image/png;base64,iVBORw=="}));
  const std::vector<std::string> links = attribute_values(html, "href");
  EXPECT_EQ(links,
            std::vector<std::string>({"#section-1", "#section-2", "#section-3", "#section-4"}));
  EXPECT_TRUE(contains(html, "content=\"default-src 'none';"));
  for (const char* loader : {"<link", "<iframe", "<object", "<embed", "@import", "url(", "fetch("})
    EXPECT_FALSE(contains(html, loader)) << loader;
}

TEST(HtmlReport, NamesNoAddressButInTheLibrarysOwnComment) {
  const std::string html = render_html(sample_content());
  const std::string own = own_page(html);
  EXPECT_FALSE(contains(own, "http://"));
  EXPECT_FALSE(contains(own, "https://"));
  // What remains is the banner by which the library names its home; it is a comment.
  EXPECT_EQ(count(html, "http"), count(own, "http") + 1);
  EXPECT_TRUE(contains(html, "<script>/*! https://github.com/leeoniya/uPlot (v1.6.32) */"));
}

TEST(HtmlReport, LetsNoTextBreakOutOfItsPlace) {
  const std::string html = render_html(sample_content());
  EXPECT_FALSE(contains(html, "<img src=x"));
  EXPECT_FALSE(contains(html, "onerror=\""));
  // Every script that begins ends once: five charts' data less the empty one, library, page.
  EXPECT_EQ(count(html, "<script"), 6U);
  EXPECT_EQ(count(html, "</script>"), 6U);
  EXPECT_TRUE(contains(
      html, "&lt;/script&gt;&lt;img src=x onerror=&quot;alert(&#39;1&#39;)&quot;&gt;&amp;amp;"));
  EXPECT_TRUE(contains(html, "\\u003c/script>\\u003cimg src=x onerror=\\\"alert('1')\\\">&amp;"));
}

TEST(HtmlReport, EscapesTheTitleInHeadAndBody) {
  ReportContent content;
  content.title = kHostileText;
  content.headline = kHostileText;
  content.key_figures = {{}, {{kHostileText, kHostileText, kHostileText}}};
  content.warnings = {kHostileText};
  content.remarks = {kHostileText};
  const std::string html = render_html(content);
  EXPECT_FALSE(contains(html, "</script>"));
  EXPECT_EQ(count(html, "&lt;/script&gt;"), 8U);
}

TEST(HtmlReport, PutsWarningsFirstAndFoldsOrdinaryNotesAwayAtTheEnd) {
  const std::string html = render_html(sample_content());
  const std::size_t box = html.find("<aside class=\"warnings\">");
  const std::size_t box_end = html.find("</aside>");
  const std::size_t notes = html.find("<details class=\"remarks\">");
  ASSERT_LT(box, box_end);
  ASSERT_LT(box_end, notes);
  const std::size_t doubled = html.find("Frames 311 to 314 are doubled.");
  const std::size_t rate = html.find("Constant rate: 240 frames");
  EXPECT_TRUE(box < doubled && doubled < box_end);
  EXPECT_GT(rate, notes);
  EXPECT_GT(notes, html.rfind("</section>"));
  ReportContent content = sample_content();
  content.warnings.clear();
  content.remarks.clear();
  EXPECT_FALSE(contains(render_html(content), "Before you trust this"));
  EXPECT_FALSE(contains(render_html(content), "<details class=\"remarks\">"));
}

TEST(HtmlReport, CarriesTheLicenceOfTheChartLibrary) {
  const std::string html = render_html(sample_content());
  EXPECT_TRUE(contains(html, "Copyright (c) 2022 Leon Sorokin"));
  EXPECT_TRUE(
      contains(html, "The above copyright notice and this permission notice shall be included in"));
}

TEST(HtmlReport, LeavesOutTheLibraryWhereThereIsNoChart) {
  ReportContent content;
  content.title = "No chart";
  content.sections = {{"Prose", {"Only."}, {}, "", {}, {}}};
  const std::string html = render_html(content);
  EXPECT_FALSE(contains(html, "uPlot"));
  EXPECT_FALSE(contains(html, "<script"));
}

TEST(HtmlReport, SaysThatAChartIsEmpty) {
  const std::string html = render_html(sample_content());
  EXPECT_TRUE(contains(html, "nothing at all over x: there are no values to draw."));
  EXPECT_EQ(count(html, "class=\"chart\""), 4U);
}

TEST(HtmlReport, SummarizesChartsForReadersWithoutScripts) {
  const std::string html = render_html(sample_content());
  EXPECT_EQ(count(html, "<noscript>"), 4U);
  EXPECT_TRUE(
      contains(html,
               "<td>motion</td><td class=\"number\">4</td><td class=\"number\">0 to 30.00</td>"
               "<td class=\"number\">0 to 1.000</td>"));
}

TEST(HtmlReport, RangesColumnsOfNumbersToTheRight) {
  const std::string html = render_html(sample_content());
  EXPECT_TRUE(contains(html, "<th class=\"number\">f [Hz]</th><th>Note</th>"));
  EXPECT_TRUE(contains(html, "<td class=\"number\">–</td><td>lost</td>"));
}

TEST(HtmlReport, KeepsANumberWithItsSigmaAndUnit) {
  const std::string html = render_html(sample_content());
  EXPECT_TRUE(contains(html, "is 1894\u00a0±\u00a037\u00a0MPa at 55.42\u00a0Hz."));
}

TEST(HtmlReport, StaysSmall) {
  // Library 51 kB, page under 20 kB; two curves of 240 samples of seven digits fit in 15 kB.
  EXPECT_LT(render_html(sample_content()).size(), 95'000U);
}

}  // namespace
}  // namespace twang
