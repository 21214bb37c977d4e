// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

namespace twang::test {

/// A fresh folder that goes with the object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return m_path; }
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const {
    return m_path / name;
  }
  /// Number of files and folders in it, at any depth, hidden ones included.
  [[nodiscard]] int num_entries() const;

 private:
  std::filesystem::path m_path;
};

/// The folder of real recordings beside the checkout, or that named by TWANG_REAL_DATA; empty if
/// there is none.
[[nodiscard]] std::filesystem::path real_recordings();

}  // namespace twang::test
