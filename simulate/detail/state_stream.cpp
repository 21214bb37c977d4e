// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/detail/state_stream.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

#include <cstring>

namespace twang::detail {

void StateWriter::append(const void* data, std::size_t size) {
  m_bytes.append(static_cast<const char*>(data), size);
}

void StateWriter::write(double value) { append(&value, sizeof value); }

void StateWriter::write(const Eigen::VectorXd& values) {
  write_count(values.size());
  append(values.data(), static_cast<std::size_t>(values.size()) * sizeof(double));
}

void StateWriter::write_count(std::int64_t value) { append(&value, sizeof value); }

void StateWriter::write_text(std::string_view text) {
  write_count(static_cast<std::int64_t>(text.size()));
  append(text.data(), text.size());
}

void StateReader::fail() const {
  throw InputError(fmt::format(
      "{}: is no checkpoint of this scene, must be one that the same scene wrote", m_file));
}

void StateReader::take(void* data, std::size_t size) {
  if (m_bytes.size() < size) fail();
  std::memcpy(data, m_bytes.data(), size);
  m_bytes.remove_prefix(size);
}

double StateReader::read_number() {
  double value = 0.0;
  take(&value, sizeof value);
  return value;
}

std::int64_t StateReader::read_count() {
  std::int64_t value = 0;
  take(&value, sizeof value);
  return value;
}

Eigen::VectorXd StateReader::read_vector(Eigen::Index size) {
  if (read_count() != size) fail();
  Eigen::VectorXd values(size);
  if (size > 0) take(values.data(), static_cast<std::size_t>(size) * sizeof(double));
  return values;
}

std::string StateReader::read_text() {
  const std::int64_t size = read_count();
  if (size < 0 || static_cast<std::uint64_t>(size) > m_bytes.size()) fail();
  std::string text(m_bytes.substr(0, static_cast<std::size_t>(size)));
  m_bytes.remove_prefix(text.size());
  return text;
}

}  // namespace twang::detail
