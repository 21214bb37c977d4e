// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/temporary_folder.hpp"

#include <stdlib.h>

#include <cstdlib>
#include <stdexcept>

namespace twang::test {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (fs::temp_directory_path() / "twang-test-XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr)
    throw std::runtime_error("no temporary folder can be made");
  m_path = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(m_path, ignored);
}

int TemporaryFolder::num_entries() const {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : fs::recursive_directory_iterator(m_path)) ++count;
  return count;
}

fs::path real_recordings() {
  if (const char* folder = std::getenv("TWANG_REAL_DATA")) return folder;
  const fs::path beside = fs::path(TWANG_SOURCE_DIR) / ".." / "shared" / "real";
  return fs::is_directory(beside) ? beside : fs::path();
}

}  // namespace twang::test
