// SPDX-License-Identifier: GPL-3.0-or-later
#include "report/detail/aligned_chart.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "report/detail/html_text.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <limits>
#include <string>

namespace twang::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A row as text: a value as its digit, a gap as |, no sample as a dot.
std::string row_text(const std::vector<ChartCell>& row) {
  std::string text;
  for (const ChartCell& cell : row) {
    switch (cell.kind) {
      case ChartCell::Kind::Missing:
        text += '.';
        break;
      case ChartCell::Kind::Gap:
        text += '|';
        break;
      case ChartCell::Kind::Value:
        text += std::to_string(static_cast<int>(cell.value));
        break;
    }
  }
  return text;
}

Chart chart_of(std::vector<ChartSeries> series) { return {"x", "y", std::move(series), {}, false}; }

TEST(AlignedChart, MergesSeriesOntoOneAxis) {
  const AlignedChart aligned =
      align_series(chart_of({{"a", {1, 3, 5}, {1, 2, 3}}, {"b", {2, 3, 6}, {4, 5, 6}}}));
  EXPECT_EQ(aligned.x, (std::vector<double>{1, 2, 3, 5, 6}));
  EXPECT_EQ(row_text(aligned.rows[0]), "1.23.");
  EXPECT_EQ(row_text(aligned.rows[1]), ".45.6");
}

TEST(AlignedChart, SortsEachSeriesAndKeepsRepeatedPlaces) {
  const AlignedChart aligned =
      align_series(chart_of({{"a", {3, 1, 3, 2}, {7, 1, 8, 2}}, {"b", {3}, {9}}}));
  EXPECT_EQ(aligned.x, (std::vector<double>{1, 2, 3, 3}));
  EXPECT_EQ(row_text(aligned.rows[0]), "1278");
  EXPECT_EQ(row_text(aligned.rows[1]), "..9.");
}

TEST(AlignedChart, BreaksALineFromTheSampleBeforeAGapToTheOneAfter) {
  // a's gap at 3 reaches over b's places 2 and 4 to a's samples at 1 and 5.
  const AlignedChart aligned =
      align_series(chart_of({{"a", {1, 3, 5, 7}, {1, kNaN, 2, 3}}, {"b", {2, 4, 6}, {4, 5, 6}}}));
  EXPECT_EQ(row_text(aligned.rows[0]), "1|||2.3");
  EXPECT_EQ(row_text(aligned.rows[1]), ".4.5.6.");
}

TEST(AlignedChart, TakesInfinityForAGapAndDropsSamplesWithoutAPlace) {
  const AlignedChart aligned =
      align_series(chart_of({{"a", {1, 2, kNaN, 3, kInfinity}, {1, kInfinity, 5, 2, 6}}}));
  EXPECT_EQ(aligned.x, (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(row_text(aligned.rows[0]), "1|2");
}

TEST(AlignedChart, HasGapsWhereALogarithmicAxisCannotShowAValue) {
  Chart chart = chart_of({{"a", {1, 2, 3}, {1, 0, -1}}});
  EXPECT_EQ(row_text(align_series(chart).rows[0]), "10-1");
  chart.log_y = true;
  EXPECT_EQ(row_text(align_series(chart).rows[0]), "1||");
}

TEST(AlignedChart, ExtendsItsAxisToTheMarks) {
  Chart chart = chart_of({{"a", {1, 2}, {1, 2}}});
  chart.marks = {{9, "after"}, {1, "at"}, {0, "before"}, {kNaN, "nowhere"}};
  const AlignedChart aligned = align_series(chart);
  EXPECT_EQ(aligned.x, (std::vector<double>{0, 1, 2, 9}));
  EXPECT_EQ(row_text(aligned.rows[0]), ".12.");
}

TEST(AlignedChart, RefusesASeriesWithMoreXThanY) {
  try {
    static_cast<void>(align_series(chart_of({{"a", {1, 2}, {1}}})));
    FAIL() << "must throw";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "chart series \"a\": has 2 x and 1 y, must have as many of each");
  }
}

TEST(ChartJson, IsValidJsonWithGapsAsNullAndMissingSamplesAsEmptyText) {
  Chart chart{"t [s]", "u \"[mm]\"", {}, {{2.5, "m"}}, true};
  chart.series = {{"a<b", {1, 2, 4}, {0.1, kNaN, 3}, ChartSeries::Style::Dashed},
                  {"c", {5}, {1.0 / 3.0}, ChartSeries::Style::Points},
                  {"d", {5}, {1e-12}}};
  const nlohmann::json json = nlohmann::json::parse(chart_json(chart));
  const nlohmann::json none = nlohmann::json::array();
  const nlohmann::json expected = {
      {"x_label", "t [s]"},
      {"y_label", "u \"[mm]\""},
      {"log_x", false},
      {"log_y", true},
      {"marks", {{{"x", 2.5}, {"label", "m"}}}},
      {"x", {1, 2, 2.5, 4, 5}},
      {"series",
       {{{"label", "a<b"},
         {"style", "dashed"},
         {"y", {0.1, nullptr, nullptr, 3, ""}},
         {"bars", none}},
        {{"label", "c"}, {"style", "points"}, {"y", {"", "", "", "", 0.3333333}}, {"bars", none}},
        {{"label", "d"}, {"style", "line"}, {"y", {"", "", "", "", 1e-12}}, {"bars", none}}}}};
  EXPECT_EQ(json, expected) << json.dump();
}

TEST(ChartJson, HasErrorBarsWhereBothEndsCanBeDrawn) {
  Chart chart = chart_of({{"a", {1, 2, 0, 3}, {10, 20, 30, 40}}, {"b", {1}, {2}}});
  chart.series[0].y_sigma = {1, kNaN, 2, 4};
  chart.log_x = true;  // which has no place for the third
  const auto json = nlohmann::json::parse(chart_json(chart));
  EXPECT_EQ(json["log_x"], true);
  EXPECT_EQ(json["x"], (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(json["series"][0]["bars"], (std::vector<std::vector<double>>{{1, 9, 11}, {3, 36, 44}}));
  EXPECT_TRUE(json["series"][1]["bars"].empty());
  chart.series[0].y_sigma.pop_back();
  EXPECT_THROW((void)chart_json(chart), InputError);
}

TEST(ChartJson, CannotEndItsScript) {
  const Chart chart{"</script>", "<!--", {{"</ScRiPt>", {1}, {1}}}, {{1, "<script>"}}, false};
  const std::string json = chart_json(chart);
  EXPECT_EQ(json.find('<'), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(json).at("x_label"), "</script>");
}

TEST(ChartJson, SurvivesBytesThatAreNoText) {
  const Chart chart{"\xff", "y", {{"a", {1}, {1}}}, {}, false};
  EXPECT_EQ(nlohmann::json::parse(chart_json(chart)).at("x_label"), "\xEF\xBF\xBD");
}

TEST(Base64, AgreesWithTheVectorsOfRfc4648) {
  const auto encoded = [](const std::string& text) {
    return base64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  };
  EXPECT_EQ(encoded(""), "");
  EXPECT_EQ(encoded("f"), "Zg==");
  EXPECT_EQ(encoded("fo"), "Zm8=");
  EXPECT_EQ(encoded("foo"), "Zm9v");
  EXPECT_EQ(encoded("foob"), "Zm9vYg==");
  EXPECT_EQ(encoded("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace twang::detail
