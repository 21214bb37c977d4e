// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/atomic_file.hpp"
#include "report/html_report.hpp"
#include "tests/report/sample_content.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace twang {
namespace {

TEST(ReportInBrowser, DrawsEveryChartWithoutAnError) {
  if (std::system("command -v chromium > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "chromium is not installed";
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "twang_report_in_browser";
  std::filesystem::create_directories(folder);
  write_file_atomically(folder / "report.html", render_html(test::sample_content()));
  const std::string command = fmt::format(
      "cd '{}' && chromium --headless --no-sandbox --disable-gpu --disable-quic --no-first-run "
      "--disable-background-networking --disable-component-update --disable-sync "
      "--user-data-dir=profile --enable-logging=stderr --dump-dom report.html > dom.html 2> "
      "log.txt",
      folder.string());
  ASSERT_EQ(std::system(command.c_str()), 0) << read_file(folder / "log.txt");

  const std::string log = read_file(folder / "log.txt");
  EXPECT_EQ(log.find("Uncaught"), std::string::npos) << log;
  EXPECT_EQ(log.find("Content Security Policy"), std::string::npos) << log;
  const std::string page = read_file(folder / "dom.html");
  std::size_t num_canvases = 0;
  for (std::size_t at = page.find("<canvas"); at != std::string::npos;
       at = page.find("<canvas", at + 1))
    ++num_canvases;
  EXPECT_EQ(num_canvases, 4U);
  // The legend is made from the data, so it shows that they arrived.
  EXPECT_NE(page.find(">tracked<"), std::string::npos);
  EXPECT_NE(page.find("&lt;/script&gt;&lt;img src=x"), std::string::npos);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace twang
