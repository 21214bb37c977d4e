// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/video_reader.hpp"
#include "tests/support/real_recordings.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <vector>

namespace twang::test {
namespace {

namespace fs = std::filesystem;

TEST(VideoReader, ReadsARealFilmToItsEnd) {
  const fs::path real = real_recordings();
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
