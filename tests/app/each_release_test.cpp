// SPDX-License-Identifier: GPL-3.0-or-later
// `twang calibrate --each-release`: several plucks in one trace, from the command to its files.
#include "core/atomic_file.hpp"
#include "tests/support/command.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <numbers>
#include <sstream>
#include <string>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

constexpr double kPluck_s = 1.2;

/// A strip's tip, pulled and let go at 0.3, 1.5 and 2.7 s; 64 Hz and 10 1/s.
void write_plucks(const fs::path& path) {
  std::ostringstream text;
  text << "time_s,observable_mm\n" << std::setprecision(10);
  for (int i = 0; i < 3 * 288; ++i) {
    const double t = i / 240.0;
    const double s = std::fmod(t, kPluck_s);
    const double noise = 5e-3 * std::sin(1e4 * i * i);
    double y = 0.5 * (1.0 - std::cos(std::numbers::pi * std::min(s / 0.2, 1.0)));
    if (s > 0.3)
      y *= std::exp(-10.0 * (s - 0.3)) * std::cos(2.0 * std::numbers::pi * 64.0 * (s - 0.3));
    text << t << ',' << y + noise << '\n';
  }
  write_file_atomically(path, text.str());
}

nlohmann::json read_json(const fs::path& path) {
  std::ifstream stream(path);
  return nlohmann::json::parse(stream);
}

TEST(CalibrateEachRelease, WritesEveryReleaseAndTheirScatter) {
  const TemporaryFolder folder;
  write_plucks(folder / "plucks.csv");
  const fs::path out = folder / "out";
  const CommandOutcome outcome = run_twang({"calibrate",
                                            TWANG_SOURCE_DIR "/rigs/strip.toml",
                                            "--trace",
                                            (folder / "plucks.csv").string(),
                                            "--each-release",
                                            "--no-validation",
                                            "--dx",
                                            "2",
                                            "--out",
                                            out.string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("3 releases in 1 recording"), std::string::npos) << outcome.err;
  for (const char* file : {"trace_1.csv", "trace_2.csv", "trace_3.csv"})
    EXPECT_TRUE(fs::exists(out / file)) << file;
  const nlohmann::json modes = read_json(out / "modes.json");
  ASSERT_EQ(modes.at("repeats").size(), 3U);
  for (std::size_t n = 0; n < 3; ++n) {
    const nlohmann::json& repeat = modes.at("repeats").at(n);
    // Two samples.
    EXPECT_NEAR(
        repeat.at("release_s").get<double>(), kPluck_s * static_cast<double>(n) + 0.3, 2.0 / 240.0);
    EXPECT_NEAR(repeat.at("frequency_hz").get<double>(), 64.0, 0.1);
    ASSERT_EQ(repeat.at("decay_checks").size(), 2U);
    for (const nlohmann::json& check : repeat.at("decay_checks"))
      EXPECT_NEAR(check.at("decay_per_s").get<double>(), 10.0, 1.0) << check;
  }
  EXPECT_GT(modes.at("repeat_scatter").at("frequency_hz").get<double>(), 0.0);
  const nlohmann::json material = read_json(out / "material.json");
  EXPECT_GT(material.at("uncertainty").at("repeats").get<double>(), 0.0);
  EXPECT_LT(material.at("uncertainty").at("repeats").get<double>(), 2e-3);
  EXPECT_NEAR(material.at("frequency_hz").get<double>(), 64.0, 0.1);
}

}  // namespace
}  // namespace twang::test
