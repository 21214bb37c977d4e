// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/real_recordings.hpp"

#include <cstdlib>

namespace twang::test {

std::filesystem::path real_recordings() {
  namespace fs = std::filesystem;
  if (const char* folder = std::getenv("TWANG_REAL_DATA")) return folder;
  const fs::path beside = fs::path(TWANG_SOURCE_DIR) / ".." / "shared" / "real";
  return fs::is_directory(beside) ? beside : fs::path();
}

}  // namespace twang::test
