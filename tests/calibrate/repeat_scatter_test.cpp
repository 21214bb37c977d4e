// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/repeat_scatter.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace twang {
namespace {

TEST(RelativeStandardError, IsThatOfTheMean) {
  // mean 10, standard deviation 2, four values: 2 / sqrt(4) / 10 with (n - 1) in the deviation
  const double deviation = std::sqrt((4.0 + 4.0 + 4.0 + 4.0) / 3.0);
  EXPECT_NEAR(relative_standard_error({8.0, 12.0, 8.0, 12.0}), deviation / 2.0 / 10.0, 1e-12);
  EXPECT_EQ(relative_standard_error({5.0}), 0.0);
}

}  // namespace
}  // namespace twang
