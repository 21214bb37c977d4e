// SPDX-License-Identifier: GPL-3.0-or-later
// `twang invert --sigma-column`: any table may bring the standard deviations of its samples.
#include "core/atomic_file.hpp"
#include "tests/support/command.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

/// A vibration of 20 Hz and a decay of 4 1/s in `y` and of 31 Hz in `z`. From 0.5 to 0.7 s `y` is
/// off by 0.8 in turn, which `e` says, and `z` by as much from 0.2 to 0.4 s, which `g` says.
void write_table(const fs::path& path, const std::string& bad_sigma = "") {
  const auto in = [](double t, double from) { return t > from && t < from + 0.2; };
  std::ostringstream text;
  text << "time_s,y,e,z,g\n" << std::setprecision(12);
  for (int i = 0; i < 300; ++i) {
    const double t = i / 240.0;
    const double noise = 1e-3 * std::sin(1e4 * i * i);
    const double off = i % 3 == 0 ? 0.8 : -0.4;
    const auto vibration = [&](double f) {
      return std::exp(-4.0 * t) * std::sin(2.0 * std::numbers::pi * f * t + 0.6) + noise;
    };
    text << t << ',' << vibration(20.0) + (in(t, 0.5) ? off : 0.0) << ',';
    if (i == 41 && !bad_sigma.empty()) {
      text << bad_sigma;
    } else {
      text << (in(t, 0.5) ? 1.0 : 0.001);
    }
    text << ',' << vibration(31.0) + (in(t, 0.2) ? off : 0.0) << ',' << (in(t, 0.2) ? 1.0 : 0.001)
         << '\n';
  }
  write_file_atomically(path, text.str());
}

nlohmann::json invert(const fs::path& table, const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"invert", table.string(), "--json", "-"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const CommandOutcome outcome = run_twang(arguments);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return nlohmann::json::parse(outcome.out);
}

double sigma_of_decay(const nlohmann::json& result) {
  return result.at("modes").at(0).at("decay_sigma_per_s").get<double>();
}

TEST(SigmaColumn, WeighsTheColumnsOfAnyTable) {
  const TemporaryFolder folder;
  const fs::path table = folder / "table.csv";
  write_table(table);
  const auto alike = invert(table, {"--column", "y"});
  EXPECT_TRUE(alike.at("weights").at("y").at("sigma_column").is_null());
  const auto weighed = invert(table, {"--column", "y", "--sigma-column", "e"});
  EXPECT_EQ(weighed.at("weights").at("y").at("sigma_column"), "e");
  EXPECT_NEAR(weighed.at("modes").at(0).at("frequency_hz").get<double>(), 20.0, 1e-3);
  // The noise outside the bad fifth of a second is a hundredth of that within.
  EXPECT_LT(sigma_of_decay(weighed), 0.1 * sigma_of_decay(alike));
  // One each, in the order of the columns; they are no columns to invert themselves.
  const auto each = invert(table, {"--sigma-column", "e", "--sigma-column", "g"}).at("columns");
  EXPECT_EQ(each.size(), 2U);
  EXPECT_EQ(each.at("y").at("weights").at("y").at("sigma_column"), "e");
  EXPECT_EQ(each.at("z").at("weights").at("z").at("sigma_column"), "g");
  EXPECT_NEAR(each.at("z").at("modes").at(0).at("frequency_hz").get<double>(), 31.0, 1e-3);
  const auto joint = invert(
      table,
      {"--joint", "--column", "y", "--column", "z", "--sigma-column", "e", "--sigma-column", "g"});
  EXPECT_EQ(joint.at("weights").at("z").at("sigma_column"), "g");
}

TEST(SigmaColumn, IsRefusedInOneSentenceWhereItIsNone) {
  const TemporaryFolder folder;
  const fs::path table = folder / "table.csv";
  const auto expect_refused = [&](const std::vector<std::string>& more,
                                  const std::vector<std::string>& must_name) {
    std::vector<std::string> arguments = {"invert", table.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const CommandOutcome outcome = run_twang(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    for (const std::string& word : must_name)
      EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err << "\nmust name " << word;
  };
  const std::vector<std::string> flags = {"--column", "y", "--sigma-column", "e"};
  for (const char* bad : {"0", "-0.001"}) {
    write_table(table, bad);
    expect_refused(flags, {"table.csv", "column e", std::string(" is ") + bad, "row 42"});
  }
  write_table(table);
  expect_refused({"--column", "y", "--sigma-column", "h"}, {"table.csv", "column h"});
  expect_refused({"--sigma-column", "e", "--sigma-column", "g", "--sigma-column", "e"},
                 {"--sigma-column", "3 times"});
}

}  // namespace
}  // namespace twang::test
