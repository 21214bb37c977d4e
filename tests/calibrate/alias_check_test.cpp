// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/alias_check.hpp"

#include "tests/support/expect_refusal.hpp"

#include <gtest/gtest.h>

namespace twang::test {
namespace {

DampedSinusoid at(double frequency_hz) {
  DampedSinusoid mode;
  mode.frequency_hz = frequency_hz;
  mode.decay_per_s = 2.0;
  return mode;
}

TEST(AliasCheck, FoldsLikeACamera) {
  EXPECT_DOUBLE_EQ(folded_hz(168.0, 240.0), 72.0);
  EXPECT_DOUBLE_EQ(folded_hz(312.0, 240.0), 72.0);
  EXPECT_DOUBLE_EQ(folded_hz(72.0, 240.0), 72.0);
}

TEST(AliasCheck, FirstModeAboveNyquistIsNamedByTheReportedModulus) {
  // The true first mode is at 0.7 of the rate; the maker's modulus puts it at 150 Hz.
  const std::vector<std::string> warnings =
      alias_warnings({{at(72.0)}, 240.0, {72.0, 400.0}, 150.0});
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(holds(warnings[0], "at 72.0"));
  EXPECT_TRUE(holds(warnings[0], "alias of one at 168 Hz"));
}

TEST(AliasCheck, FirstModeAboveNyquistIsNamedByAnOvertone) {
  // Truth: 168 and 2.2 x 168 = 369.6, seen at 72 and 129.6 -> 110.4 of 240.
  const std::vector<std::string> warnings =
      alias_warnings({{at(72.0), at(110.4)}, 240.0, {72.0, 158.4}, {}});
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(holds(warnings[0], "alias of one at 168 Hz"));
}

TEST(AliasCheck, FoldedOvertoneIsNamed) {
  const std::vector<std::string> warnings =
      alias_warnings({{at(40.0), at(10.0)}, 240.0, {40.0, 250.0}, {}});
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(holds(warnings[0], "natural frequency 2 at 250 Hz"));
}

TEST(AliasCheck, SoundSignalIsLeftAlone) {
  EXPECT_TRUE(alias_warnings({{at(40.0), at(81.0)}, 240.0, {40.0, 80.0, 500.0}, 36.0}).empty());
  EXPECT_TRUE(alias_warnings({{at(72.0)}, 240.0, {72.0, 400.0}, 65.0}).empty());
  EXPECT_TRUE(alias_warnings({{}, 240.0, {72.0}, 65.0}).empty());
}

}  // namespace
}  // namespace twang::test
