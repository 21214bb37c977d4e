// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/join_repeats.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace twang {
namespace {

TEST(JoinRepeats, LaysWindowsOverEachOtherFromTimeZero) {
  const Trace first{{0.0, 0.1, 0.2, 0.3}, {{"y", {1.0, 2.0, 3.0, 4.0}}}};
  const Trace second{{5.0, 5.1, 5.25}, {{"y", {10.0, 20.0, 30.0}}}};
  const Trace joint = join_repeats({{&first, {"y"}, 0.1, 0.3}, {&second, {"y"}, 5.0, 5.25}});
  ASSERT_EQ(joint.num_samples(), 4U);  // 0, 0.1, 0.2 of the first, 0.25 of the second alone
  EXPECT_NEAR(joint.time_s[3], 0.25, 1e-12);
  const Channel* a = joint.find("1:y");
  const Channel* b = joint.find("2:y");
  ASSERT_NE(a, nullptr);
  ASSERT_NE(b, nullptr);
  EXPECT_EQ(a->values[0], 2.0);
  EXPECT_EQ(a->values[2], 4.0);
  EXPECT_TRUE(std::isnan(a->values[3]));
  EXPECT_EQ(b->values[0], 10.0);
  EXPECT_EQ(b->values[1], 20.0);
  EXPECT_TRUE(std::isnan(b->values[2]));
  EXPECT_EQ(b->values[3], 30.0);
}

TEST(RelativeStandardError, IsThatOfTheMean) {
  // mean 10, standard deviation 2, four values: 2 / sqrt(4) / 10 with (n - 1) in the deviation
  const double deviation = std::sqrt((4.0 + 4.0 + 4.0 + 4.0) / 3.0);
  EXPECT_NEAR(relative_standard_error({8.0, 12.0, 8.0, 12.0}), deviation / 2.0 / 10.0, 1e-12);
  EXPECT_EQ(relative_standard_error({5.0}), 0.0);
}

}  // namespace
}  // namespace twang
