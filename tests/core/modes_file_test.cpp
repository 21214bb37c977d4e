// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/modes_file.hpp"

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace twang::test {
namespace {

class ModesFile : public ::testing::Test {
 protected:
  std::vector<DampedSinusoid> read(const std::string& text) {
    const auto path = m_folder.path() / "modes.json";
    write_file_atomically(path, text);
    return read_modes(path);
  }
  std::string complaint(const std::string& text) {
    try {
      (void)read(text);
    } catch (const InputError& error) {
      const std::string message = error.what();
      return message.substr(message.find("modes.json") + 12);
    }
    return "";
  }
  TemporaryFolder m_folder;
};

TEST_F(ModesFile, GivesSinusoidsWithTheirSigmas) {
  const auto modes = read(R"({"format": "twang-modes/1", "modes": [
      {"frequency_hz": 12.5, "frequency_sigma_hz": 0.01, "decay_per_s": 3.25,
       "decay_sigma_per_s": 0.02, "frequency_decay_covariance": -1e-5, "channels": {}},
      {"frequency_hz": 80, "frequency_sigma_hz": null, "decay_per_s": 0}]})");
  ASSERT_EQ(modes.size(), 2U);
  EXPECT_EQ(modes[0].frequency_hz, 12.5);
  EXPECT_EQ(modes[0].frequency_sigma_hz, 0.01);
  EXPECT_EQ(modes[0].decay_per_s, 3.25);
  EXPECT_EQ(modes[0].decay_sigma_per_s, 0.02);
  EXPECT_EQ(modes[0].frequency_decay_covariance, -1e-5);
  EXPECT_EQ(modes[1].frequency_hz, 80.0);
  EXPECT_TRUE(std::isnan(modes[1].frequency_sigma_hz));
  EXPECT_TRUE(read(R"({"format": "twang-modes/1", "modes": []})").empty());
}

TEST_F(ModesFile, SaysWhatIsWrongWithAFile) {
  EXPECT_NE(complaint("{"), "");
  EXPECT_EQ(complaint("[]"), "must be a JSON object");
  EXPECT_EQ(complaint(R"({"format": "twang-material/1"})"),
            R"(format is "twang-material/1", must be twang-modes/1)");
  EXPECT_EQ(complaint(R"({"format": "twang-modes/1"})"), "modes is missing");
  EXPECT_NE(complaint(R"({"format": "twang-modes/1", "columns": {}})").find("several columns"),
            std::string::npos);
  EXPECT_EQ(complaint(R"({"format": "twang-modes/1", "modes": [{"frequency_hz": -1}]})"),
            "modes[0].frequency_hz is -1, must be a number >= 0");
  EXPECT_EQ(complaint(R"({"format": "twang-modes/1", "modes": [{"frequency_hz": 1}]})"),
            "modes[0].decay_per_s is missing");
  for (const char* hz : {"0", "1e300"}) {
    EXPECT_NE(
        complaint(R"({"format": "twang-modes/1", "modes": [{"decay_per_s": 0, "frequency_hz": )" +
                  std::string(hz) + "}]}")
            .find("modes[0].frequency_hz is"),
        std::string::npos)
        << hz;
  }
}

}  // namespace
}  // namespace twang::test
