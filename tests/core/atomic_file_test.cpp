// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/atomic_file.hpp"

#include "core/error.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

namespace twang {
namespace {

using test::holds;
using test::refusal_of;
using test::TemporaryFolder;

TEST(AtomicFile, AppearsOnlyWhenCommittedAndLeavesNothingElse) {
  const TemporaryFolder folder;
  const std::filesystem::path target = folder.path() / "film.mp4";
  {
    AtomicFile file(target);
    EXPECT_EQ(file.temporary_path().extension(), ".mp4") << "by which a writer chooses its format";
    EXPECT_EQ(file.temporary_path().parent_path(), folder.path()) << "on the same file system";
    std::ofstream(file.temporary_path()) << "whole";
    EXPECT_FALSE(std::filesystem::exists(target));
    file.commit();
    EXPECT_EQ(read_file(target), "whole");
  }
  EXPECT_EQ(read_file(target), "whole");
  EXPECT_EQ(folder.num_entries(), 1U);
}

TEST(AtomicFile, LeavesTheTargetAloneAndNothingBehindWhenGivenUp) {
  const TemporaryFolder folder;
  const std::filesystem::path target = folder.write("a.csv", "old");
  {
    const AtomicFile file(target);
    std::ofstream(file.temporary_path()) << "half";
    EXPECT_EQ(folder.num_entries(), 2U);
  }
  EXPECT_EQ(read_file(target), "old");
  EXPECT_EQ(folder.num_entries(), 1U);
}

TEST(AtomicFile, ReplacesAnOlderFile) {
  const TemporaryFolder folder;
  const std::filesystem::path target = folder.write("a.csv", "a longer old content");
  write_file_atomically(target, "new");
  EXPECT_EQ(read_file(target), "new");
  EXPECT_EQ(folder.num_entries(), 1U);
}

TEST(AtomicFile, KeepsEveryByte) {
  const TemporaryFolder folder;
  std::string bytes;
  for (int i = 0; i < 256; ++i) bytes += static_cast<char>(i);
  bytes += "\r\n\n";
  write_file_atomically(folder.path() / "bytes", bytes);
  EXPECT_EQ(read_file(folder.path() / "bytes"), bytes);
}

TEST(AtomicFile, RefusesAMissingFolderAndATargetThatIsAFolder) {
  const TemporaryFolder folder;
  const auto write_to = [](const std::filesystem::path& path) {
    return refusal_of([&] { write_file_atomically(path, "x"); });
  };
  EXPECT_TRUE(holds(write_to(folder.path() / "none" / "a.csv"), "none' does not exist"));
  EXPECT_TRUE(holds(write_to(folder.path()), "is a folder"));
  EXPECT_EQ(folder.num_entries(), 0U);
}

TEST(ReadFile, RefusesWhatIsNotThereAndAFolder) {
  const TemporaryFolder folder;
  EXPECT_TRUE(holds(refusal_of([&] { (void)read_file(folder.path() / "x"); }), "/x: no such file"));
  EXPECT_TRUE(holds(refusal_of([&] { (void)read_file(folder.path()); }), "is a folder"));
  EXPECT_EQ(read_file(folder.write("empty", "")), "");
}

}  // namespace
}  // namespace twang
