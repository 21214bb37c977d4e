// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/video_reader.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <vector>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

TEST(VideoReader, ReadsARealFilmToItsEnd) {
  const char* folder = std::getenv("TWANG_REAL_DATA");
  const fs::path real = folder ? fs::path(folder) : fs::path(TWANG_SOURCE_DIR) / "../shared/real";
  const fs::path path = real / "knex_tower" / "tower.mp4";
  if (!fs::exists(path)) GTEST_SKIP() << "the real recordings are not beside the checkout";
  VideoReader reader(path);
  std::vector<double> stamps;
  while (const auto frame = reader.read()) stamps.push_back(frame->stamp_s);
  // 582 pictures, of which the edit list takes the first three away; evenly at 30 a second.
  ASSERT_EQ(stamps.size(), 579U);
  for (std::size_t n = 0; n < stamps.size(); ++n) {
    EXPECT_NEAR(stamps[n] - stamps[0], static_cast<double>(n) / 30.0, 1e-9);
  }
}

}  // namespace
}  // namespace twang::test
