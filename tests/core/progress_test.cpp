// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/progress.hpp"

#include <gtest/gtest.h>

#include <string>

namespace twang {
namespace {

TEST(Progress, ReachesTheCallback) {
  std::string stage;
  double share = 0.0;
  const ProgressCallback callback = [&](const Progress& progress) {
    stage = progress.stage;
    share = progress.done / progress.total;
    return true;
  };
  report_progress(callback, {"tracking", 3.0, 12.0});
  EXPECT_EQ(stage, "tracking");
  EXPECT_EQ(share, 0.25);
}

TEST(Progress, StopsTheWorkWhenTheCallbackSaysSo) {
  const ProgressCallback stop = [](const Progress&) { return false; };
  EXPECT_THROW(report_progress(stop, {"tracking", 1.0, 2.0}), Cancelled);
}

TEST(Progress, NeedsNoCallback) { EXPECT_NO_THROW(report_progress({}, {"tracking", 1.0, 2.0})); }

}  // namespace
}  // namespace twang
