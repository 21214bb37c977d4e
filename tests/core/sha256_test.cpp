// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/sha256.hpp"

#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <string>

namespace twang {
namespace {

// The standard's own examples (FIPS 180-2, appendix B) and the empty message.
constexpr const char* kOfAbc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
constexpr const char* kOfNothing =
    "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
constexpr const char* kOfAMillionA =
    "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0";

TEST(Sha256, OfATextEqualsTheStandardsVectors) {
  EXPECT_EQ(sha256_of_text("abc"), kOfAbc);
  EXPECT_EQ(sha256_of_text(""), kOfNothing);
  EXPECT_EQ(sha256_of_text(std::string(1000000, 'a')), kOfAMillionA);
}

TEST(Sha256, OfAFileEqualsThatOfItsBytes) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(sha256_of_file(folder.write("abc", "abc")), kOfAbc);
  EXPECT_EQ(sha256_of_file(folder.write("empty", "")), kOfNothing);
  // Longer than the pieces a file is read in.
  const std::string long_text(3 * (1 << 20) + 17, '\r');
  EXPECT_EQ(sha256_of_file(folder.write("long", long_text)), sha256_of_text(long_text));
}

TEST(Sha256, RefusesAMissingFileAndAFolder) {
  const test::TemporaryFolder folder;
  EXPECT_TRUE(test::holds(test::refusal_of([&] { (void)sha256_of_file(folder.path() / "none"); }),
                          "/none: "));
  EXPECT_TRUE(test::holds(test::refusal_of([&] { (void)sha256_of_file(folder.path()); }),
                          folder.path().string() + ": "));
}

}  // namespace
}  // namespace twang
