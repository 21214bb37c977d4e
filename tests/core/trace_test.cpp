// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/trace.hpp"

#include <gtest/gtest.h>

namespace twang {
namespace {

Trace columns(const std::vector<std::string>& names) {
  Trace trace;
  trace.time_s = {0.0};
  for (const std::string& name : names) trace.channels.push_back({name, {1.0}});
  return trace;
}

TEST(Trace, KnowsWhoseSigmaAColumnIs) {
  const Trace trace = columns({"tip.x_mm",
                               "tip.z_mm",
                               "tip.sigma_mm",
                               "tip.time_offset_s",
                               "observable_mm",
                               "observable.sigma_mm",
                               "second.x_mm",
                               "y",
                               "y.sigma_v"});
  EXPECT_EQ(trace.sigma_of("tip.x_mm"), trace.find("tip.sigma_mm"));
  EXPECT_EQ(trace.sigma_of("tip.z_mm"), trace.find("tip.sigma_mm"));
  EXPECT_EQ(trace.sigma_of("observable_mm"), trace.find("observable.sigma_mm"));
  EXPECT_EQ(trace.sigma_of("y"), trace.find("y.sigma_v"));
  EXPECT_EQ(trace.sigma_of("second.x_mm"), nullptr);
  EXPECT_EQ(trace.sigma_of("z"), nullptr);
}

TEST(Trace, KnowsWhoseTimeOffsetAColumnIs) {
  const Trace trace =
      columns({"tip.x_mm", "tip.time_offset_s", "observable_mm", "observable.time_offset_s", "y"});
  EXPECT_EQ(trace.time_offset_of("tip.x_mm"), trace.find("tip.time_offset_s"));
  EXPECT_EQ(trace.time_offset_of("observable_mm"), trace.find("observable.time_offset_s"));
  EXPECT_EQ(trace.time_offset_of("y"), nullptr);
}

}  // namespace
}  // namespace twang
