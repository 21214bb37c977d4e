// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/trace_file.hpp"

#include "core/atomic_file.hpp"
#include "core/constants.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace twang {
namespace {

using test::holds;
using test::refusal_of;
using test::TemporaryFolder;

Trace read_text(std::string_view text, const std::string& time_column = "time_s") {
  const TemporaryFolder folder;
  return read_trace_csv(folder.write("trace.csv", text), time_column);
}

TEST(TraceFile, EveryDoubleReadsBackExactlyAndNanStaysNan) {
  Trace trace;
  trace.channels = {{"tip.x_mm", {}}, {"tip.sigma_mm", {}}, {"observable_rad", {}}};
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
  std::uniform_int_distribution<int> exponent(-300, 300);
  for (int row = 0; row < 500; ++row) {
    trace.time_s.push_back(row / 240.0);
    for (Channel& channel : trace.channels) {
      channel.values.push_back(std::ldexp(mantissa(random), exponent(random)));
    }
  }
  using Limits = std::numeric_limits<double>;
  trace.channels[0].values[0] = kNaN;
  trace.channels[1].values[7] = -kNaN;
  trace.channels[0].values[1] = Limits::max();
  trace.channels[0].values[2] = Limits::denorm_min();
  trace.channels[0].values[3] = 0.1;
  trace.channels[2].values[499] = kNaN;
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "trace.csv";
  write_trace_csv(path, trace);
  EXPECT_EQ(folder.num_entries(), 1U);
  const Trace read = read_trace_csv(path);
  EXPECT_EQ(read.time_s, trace.time_s);
  ASSERT_EQ(read.channels.size(), 3U);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(read.channels[c].name, trace.channels[c].name);
    ASSERT_EQ(read.channels[c].values.size(), 500U);
    for (std::size_t row = 0; row < 500; ++row) {
      const double expected = trace.channels[c].values[row];
      const double found = read.channels[c].values[row];
      EXPECT_TRUE(std::isnan(expected) ? std::isnan(found) : found == expected)
          << found << " for " << expected;
    }
  }
  EXPECT_EQ(Trace::num_finite(read.channels[0]), 499U);
  EXPECT_EQ(read_file(path).find("-nan"), std::string::npos) << "a missing sample is nan";
}

TEST(TraceFile, PutsTheTimeFirst) {
  const TemporaryFolder folder;
  write_trace_csv(folder.path() / "t.csv", {{0.0, 0.5}, {{"a", {1.0, kNaN}}, {"b", {-2.5, 3.0}}}});
  EXPECT_EQ(read_file(folder.path() / "t.csv"), "time_s,a,b\n0,1,-2.5\n0.5,nan,3\n");
}

TEST(TraceFile, FindsTheTimeColumnWhereverItStands) {
  const Trace trace = read_text("a,t,b\n1,0.5,2\n3,0.75,4\n", "t");
  EXPECT_EQ(trace.time_s, (std::vector<double>{0.5, 0.75}));
  EXPECT_EQ(trace.num_samples(), 2U);
  ASSERT_EQ(trace.channels.size(), 2U);
  ASSERT_NE(trace.find("a"), nullptr);
  EXPECT_EQ(trace.find("a")->values, (std::vector<double>{1, 3}));
  EXPECT_EQ(trace.find("b")->values, (std::vector<double>{2, 4}));
  EXPECT_EQ(trace.find("t"), nullptr);
  EXPECT_EQ(trace.find("c"), nullptr);
}

TEST(TraceFile, AcceptsTheDialectsOfOtherPrograms) {
  const Trace trace = read_text(
      "\xEF\xBB\xBF# made elsewhere\r\n\"time_s\" , \"x\",y\r\n\r\n 0 , +1.5e3 ,\r\n# note\r\n"
      "1,NaN,-.5\r\n2,nan,7");
  EXPECT_EQ(trace.time_s, (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(trace.find("x")->values[0], 1500.0);
  EXPECT_TRUE(std::isnan(trace.find("x")->values[1]));
  EXPECT_TRUE(std::isnan(trace.find("x")->values[2]));
  EXPECT_TRUE(std::isnan(trace.find("y")->values[0])) << "an empty cell is a missing sample";
  EXPECT_EQ(trace.find("y")->values[1], -0.5);
  EXPECT_EQ(trace.find("y")->values[2], 7.0);
}

TEST(TraceFile, AcceptsWhatASpreadsheetMakesOfIt) {
  // every cell quoted, a cleared cell, a cleared row, a deleted row, an unnamed column at the end
  const Trace trace = read_text(
      "\xEF\xBB\xBF\"time_s\",\"tip, left\",\"observable_mm\",\r\n\"0\",\"1.5\",\"-2\",\r\n"
      "0.1,,3,\r\n,,,\r\n0.4,4,\"nan\",\r\n");
  EXPECT_EQ(trace.time_s, (std::vector<double>{0, 0.1, 0.4}));
  ASSERT_EQ(trace.channels.size(), 2U);
  ASSERT_NE(trace.find("tip, left"), nullptr);
  EXPECT_EQ(trace.find("tip, left")->values[0], 1.5);
  EXPECT_TRUE(std::isnan(trace.find("tip, left")->values[1]));
  EXPECT_EQ(trace.find("observable_mm")->values[1], 3.0);
  EXPECT_TRUE(std::isnan(trace.find("observable_mm")->values[2]));
}

struct Fault {
  const char* name;
  std::string content;
  const char* said;  ///< follows the file's name at once
};

class TraceRefusal : public ::testing::TestWithParam<Fault> {};

TEST_P(TraceRefusal, NamesFileAndLineInOneSentence) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("t.csv", GetParam().content);
  const std::string message = refusal_of([&] { (void)read_trace_csv(path); });
  EXPECT_TRUE(message.starts_with(path.string() + ":")) << message;
  EXPECT_TRUE(holds(message, std::string("t.csv") + GetParam().said));
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

INSTANTIATE_TEST_SUITE_P(
    TraceFile,
    TraceRefusal,
    ::testing::Values(
        Fault{"Empty", "", ": is empty"},
        Fault{"OnlyComments", "# a\n\n", ": is empty"},
        Fault{"Binary", std::string("time_s,a\n\0\1\2", 12), ": is a binary file"},
        Fault{"NoTimeColumn", "# a\nt,x\n0,1\n", ":2: has no time column 'time_s'"},
        Fault{"ColumnTwice", "time_s,x,x\n0,1,2\n", ":1: the column 'x' appears twice"},
        Fault{"TimeTwice", "time_s,time_s\n0,1\n", ":1: the column 'time_s' appears twice"},
        Fault{"NoRows", "time_s,x\n", ": has a header and no rows"},
        Fault{"ShortRow", "time_s,x,y\n0,1,2\n\n1,2\n", ":4: has 2 cells, must be 3"},
        Fault{"LongRow", "time_s,x\n0,1,2\n", ":2: has 3 cells, must be 2"},
        Fault{"CellOfLetters", "time_s,x\n0,1\n1,abc\n", ":3: x is 'abc', must be a number"},
        Fault{"CellWithATail", "time_s,x\n0,1.5mm\n", ":2: x is '1.5mm', must be a number"},
        Fault{"CellWithTwoSigns", "time_s,x\n0,+-1\n", ":2: x is '+-1', must be a number"},
        Fault{"CellTooLarge", "time_s,x\n0,1e999\n", ":2: x is '1e999', must be a number"},
        Fault{"Semicolons", "time_s;x\n0;1,5\n", ":1: columns are separated by semicolons"},
        Fault{"Tabs", "time_s\tx\n0\t1.5\n", ":1: columns are separated by tabs"},
        Fault{"DecimalComma",
              "time_s,x\n0,\"1,5\"\n",
              ":2: x is '1,5', must be a number with a decimal point"},
        Fault{"Utf16", std::string("\xFF\xFEt\0,\0x\0\n\0", 10), ": is UTF-16 text"},
        Fault{"TimeMissing", "time_s,x\n,1\n", ":2: time_s is '', must be a finite time"},
        Fault{"TimeNan", "time_s,x\nnan,1\n", ":2: time_s is 'nan'"},
        Fault{"TimeInfinite", "time_s,x\n0,1\ninf,1\n", ":3: time_s is 'inf'"},
        Fault{"TimeRepeated", "time_s,x\n0,1\n0,2\n", ":3: time_s is '0', must be a finite time"},
        Fault{"TimeDecreases", "time_s,x\n0,1\n2,2\n1,3\n", ":4: time_s is '1'"}),
    [](const auto& fault) { return std::string(fault.param.name); });

TEST(TraceFile, RefusesAMissingFileAndAFolder) {
  const TemporaryFolder folder;
  EXPECT_TRUE(holds(refusal_of([&] { (void)read_trace_csv(folder.path() / "t.csv"); }),
                    "t.csv: no such file"));
  EXPECT_TRUE(holds(refusal_of([&] { (void)read_trace_csv(folder.path()); }), "is a folder"));
}

}  // namespace
}  // namespace twang
