// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/text.hpp"

#include "core/constants.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <vector>

namespace twang {
namespace {

TEST(ExactText, IsTheShortestThatReadsBack) {
  EXPECT_EQ(exact_text(0.1), "0.1");
  EXPECT_EQ(exact_text(-2.0), "-2");
  EXPECT_EQ(exact_text(0.1 + 0.2), "0.30000000000000004");
  for (const double value : {kPi,
                             1.0 / 3.0,
                             -6.02214076e23,
                             std::numeric_limits<double>::max(),
                             std::numeric_limits<double>::denorm_min()}) {
    EXPECT_EQ(std::strtod(exact_text(value).c_str(), nullptr), value);
  }
}

TEST(ExactText, NamesWhatIsNotFinite) {
  EXPECT_EQ(exact_text(kNaN), "nan");
  EXPECT_EQ(exact_text(-kNaN), "nan");
  EXPECT_EQ(exact_text(kInfinity), "inf");
  EXPECT_EQ(exact_text(-kInfinity), "-inf");
}

TEST(EscapeXml, LeavesNoMarkupAndNoControlCharacter) {
  EXPECT_EQ(escape_xml("a<b & \"c\">\n"), "a&lt;b &amp; &quot;c&quot;&gt; ");
  EXPECT_EQ(escape_xml("µ 3.5"), "µ 3.5");
}

TEST(RoundedText, HasTheDigitsAskedFor) {
  EXPECT_EQ(rounded_text(kPi, 1), "3");
  EXPECT_EQ(rounded_text(kPi, 4), "3.142");
  EXPECT_EQ(rounded_text(-48.5353, 3), "-48.5");
  EXPECT_EQ(rounded_text(0.000164449, 3), "0.000164");
  EXPECT_EQ(rounded_text(2.0, 3), "2.00");
  EXPECT_EQ(rounded_text(1234567.0, 3), "1230000");
  EXPECT_EQ(rounded_text(0.0, 5), "0");
}

TEST(RoundedText, CountsDigitsAfterRounding) {
  EXPECT_EQ(rounded_text(0.9996, 3), "1.00");
  EXPECT_EQ(rounded_text(99.96, 3), "100");
  EXPECT_EQ(rounded_text(-9.999, 2), "-10");
}

TEST(RoundedText, UsesAnExponentOnlyOutsideTheReadableRange) {
  EXPECT_EQ(rounded_text(1e-4, 2), "0.00010");
  EXPECT_EQ(rounded_text(9.94e-5, 2), "9.9e-05");
  EXPECT_EQ(rounded_text(9.96e-5, 2), "0.00010");
  EXPECT_EQ(rounded_text(9.9e6, 2), "9900000");
  EXPECT_EQ(rounded_text(1.66e9, 3), "1.66e+09");
}

TEST(RoundedText, NamesWhatIsNotFinite) {
  EXPECT_EQ(rounded_text(-kNaN, 3), "nan");
  EXPECT_EQ(rounded_text(kInfinity, 3), "inf");
}

TEST(NearestWord, HasTheSmallestEditDistance) {
  const std::vector<std::string> keys = {"size_mm", "position_mm", "min_mm", "max_mm", "fixed"};
  EXPECT_EQ(nearest_word("siz_mm", keys), "size_mm");
  EXPECT_EQ(nearest_word("postion_mm", keys), "position_mm");
  EXPECT_EQ(nearest_word("fixd", keys), "fixed");
  EXPECT_EQ(nearest_word("fixed", keys), "fixed");
  EXPECT_EQ(nearest_word("maxmm", keys), "max_mm");
  // By letters replaced, left out and put in: kitten -> sitting is 3, -> kit is 3, -> mitten is 1.
  EXPECT_EQ(nearest_word("kitten", std::vector<std::string>{"sitting", "kit", "mitten"}), "mitten");
}

TEST(NearestWord, TakesTheFirstOfEquallyNearAndNothingOfNothing) {
  EXPECT_EQ(nearest_word("b", std::vector<std::string>{"a", "c"}), "a");
  EXPECT_EQ(nearest_word("", std::vector<std::string>{"abc", "a"}), "a");
  EXPECT_EQ(nearest_word("b", {}), "");
}

TEST(WithArticle, GoesByTheFirstLetter) {
  for (const char* word : {"cross", "dot", "ring", "checker", "patch"}) {
    EXPECT_EQ(with_article(word), std::string("a ") + word);
  }
  for (const char* word : {"aruco", "apriltag", "AprilTag", "image"}) {
    EXPECT_EQ(with_article(word), std::string("an ") + word);
  }
  EXPECT_EQ(with_article(""), "a ");
}

}  // namespace
}  // namespace twang
