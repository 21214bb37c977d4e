// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace twang::detail {

/// A table that grows row by row while a simulation runs.
class CsvStream {
 public:
  /// @param header       of a new file
  /// @param continue_at  length up to which an old file is kept; absent: a new one
  /// @throws InputError if it cannot be opened, or is shorter than that
  CsvStream(std::filesystem::path path,
            const std::string& header,
            std::optional<std::int64_t> continue_at);
  ~CsvStream();
  CsvStream(const CsvStream&) = delete;
  CsvStream& operator=(const CsvStream&) = delete;

  /// Adds a row; every double reads back exactly.
  void add(std::span<const double> values);
  /// Hands what was added to the system.
  /// @throws InputError if it cannot be written
  void flush();
  /// The same, down to the disk; returns the file's length.
  std::int64_t sync();

 private:
  std::filesystem::path m_path;
  std::string m_pending;
  std::int64_t m_length = 0;
  int m_file = -1;
};

}  // namespace twang::detail
