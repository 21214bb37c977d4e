// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <string_view>

namespace twang::detail {

/// Puts a computation's state into bytes, exactly; `StateReader` takes it out in the same order.
class StateWriter {
 public:
  void write(double value);
  void write(const Eigen::VectorXd& values);
  void write_count(std::int64_t value);
  void write_flag(bool value) { write_count(value ? 1 : 0); }
  void write_text(std::string_view text);
  [[nodiscard]] const std::string& bytes() const { return m_bytes; }

 private:
  void append(const void* data, std::size_t size);
  std::string m_bytes;
};

/// @throws InputError from all functions if the bytes end too early or are of another state
class StateReader {
 public:
  /// @param file  named in complaints
  StateReader(std::string_view bytes, std::string file) : m_bytes(bytes), m_file(std::move(file)) {}

  [[nodiscard]] double read_number();
  /// @param size  that it must have
  [[nodiscard]] Eigen::VectorXd read_vector(Eigen::Index size);
  [[nodiscard]] std::int64_t read_count();
  [[nodiscard]] bool read_flag() { return read_count() != 0; }
  [[nodiscard]] std::string read_text();
  [[nodiscard]] bool at_end() const { return m_bytes.empty(); }

 private:
  void take(void* data, std::size_t size);
  [[noreturn]] void fail() const;

  std::string_view m_bytes;  // not yet read
  std::string m_file;
};

}  // namespace twang::detail
