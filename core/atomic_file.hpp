// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string_view>

namespace twang {

/// A file under construction: written beside its target under a temporary name, renamed onto it by
/// `commit`.
///
/// Destroyed without `commit`, it removes the temporary file and leaves the target as it was.
class AtomicFile {
 public:
  /// @throws InputError if the target's folder does not exist or cannot be written to
  explicit AtomicFile(std::filesystem::path target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Where to write; keeps the target's extension, by which some writers choose their format.
  [[nodiscard]] const std::filesystem::path& temporary_path() const { return m_temporary; }
  /// Puts the file in its place.
  /// @throws InputError if that fails
  void commit();

 private:
  std::filesystem::path m_target;
  std::filesystem::path m_temporary;
  bool m_committed = false;
};

/// Writes `content` to `path`, whole or not at all.
/// @throws InputError if the file cannot be written
void write_file_atomically(const std::filesystem::path& path, std::string_view content);

/// The whole content of a file.
/// @throws InputError if it cannot be read
[[nodiscard]] std::string read_file(const std::filesystem::path& path);

}  // namespace twang
