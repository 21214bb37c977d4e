// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/atomic_file.hpp"

#include "core/error.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

namespace twang {
namespace {

namespace fs = std::filesystem;

fs::path temporary_beside(const fs::path& target) {
  const std::string name =
      fmt::format(".{}.{}.part{}", target.stem().string(), ::getpid(), target.extension().string());
  return target.parent_path() / name;
}

}  // namespace

AtomicFile::AtomicFile(fs::path target) : m_target(std::move(target)) {
  const fs::path folder = m_target.has_parent_path() ? m_target.parent_path() : fs::path(".");
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw InputError(fmt::format("{}: the folder '{}' does not exist, must be there to write into",
                                 m_target.string(),
                                 folder.string()));
  }
  if (fs::is_directory(m_target, error)) {
    throw InputError(
        fmt::format("{}: is a folder, must be a file name to write to", m_target.string()));
  }
  m_temporary = temporary_beside(m_target);
  if (std::ofstream probe(m_temporary, std::ios::binary); !probe) {
    throw InputError(fmt::format("{}: cannot be written, must be in a folder with write permission",
                                 m_target.string()));
  }
}

AtomicFile::~AtomicFile() {
  if (m_committed) return;
  std::error_code ignored;
  fs::remove(m_temporary, ignored);
}

void AtomicFile::commit() {
  std::error_code error;
  fs::rename(m_temporary, m_target, error);
  if (error) {
    throw InputError(fmt::format("{}: cannot be written: {}", m_target.string(), error.message()));
  }
  m_committed = true;
}

void write_file_atomically(const fs::path& path, std::string_view content) {
  AtomicFile file(path);
  {
    std::ofstream stream(file.temporary_path(), std::ios::binary | std::ios::trunc);
    stream.write(content.data(), static_cast<std::streamsize>(content.size()));
    stream.flush();
    if (!stream) {
      throw InputError(fmt::format("{}: cannot be written, is the disk full?", path.string()));
    }
  }
  file.commit();
}

std::string read_file(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) throw InputError(fmt::format("{}: no such file", path.string()));
  if (fs::is_directory(path, error)) {
    throw InputError(fmt::format("{}: is a folder, must be a file", path.string()));
  }
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream content;
  if (stream) content << stream.rdbuf();
  if (!stream || stream.bad()) throw InputError(fmt::format("{}: cannot be read", path.string()));
  return std::move(content).str();
}

}  // namespace twang
