// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/detail/csv_stream.hpp"

#include "core/error.hpp"
#include "core/text.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

namespace twang::detail {
namespace {

constexpr std::size_t kMostPending = 1U << 16U;  // bytes, before they are handed on

[[noreturn]] void fail(const std::filesystem::path& path) {
  const int reason = errno;
  throw InputError(fmt::format("{}: cannot be written: {}{}",
                               path.string(),
                               std::strerror(reason),
                               reason == ENOSPC ? ", free some and go on with --resume" : ""));
}

}  // namespace

CsvStream::CsvStream(std::filesystem::path path,
                     const std::string& header,
                     std::optional<std::int64_t> continue_at)
    : m_path(std::move(path)) {
  const int truncate = continue_at ? 0 : O_TRUNC;
  m_file = ::open(m_path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | truncate, 0666);
  if (m_file < 0) fail(m_path);
  if (!continue_at) {
    m_pending = header + "\n";
    return;
  }
  struct stat status {};
  const bool known = ::fstat(m_file, &status) == 0;
  if (!known || status.st_size < *continue_at) {
    ::close(m_file);
    throw InputError(fmt::format("{}: has {} bytes, must have the {} that the checkpoint saw",
                                 m_path.string(),
                                 known ? static_cast<std::int64_t>(status.st_size) : 0,
                                 *continue_at));
  }
  m_length = *continue_at;
  if (::ftruncate(m_file, m_length) != 0 || ::lseek(m_file, m_length, SEEK_SET) != m_length) {
    ::close(m_file);
    fail(m_path);
  }
}

CsvStream::~CsvStream() {
  try {
    flush();
  } catch (const InputError&) {  // said by whoever flushed before
  }
  ::close(m_file);
}

void CsvStream::add(std::span<const double> values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) m_pending += ',';
    m_pending += exact_text(values[i]);
  }
  m_pending += '\n';
  if (m_pending.size() > kMostPending) flush();
}

void CsvStream::flush() {
  std::string_view rest = m_pending;
  while (!rest.empty()) {
    const ssize_t written = ::write(m_file, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      m_pending.clear();
      fail(m_path);
    }
    m_length += written;
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  m_pending.clear();
}

std::int64_t CsvStream::sync() {
  flush();
  if (::fsync(m_file) != 0 && errno != EINVAL && errno != EROFS) fail(m_path);
  return m_length;
}

}  // namespace twang::detail
