// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulate/checkpoint.hpp"

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/sha256.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace twang {
namespace {

constexpr std::string_view kMagic = "twang-checkpoint/1\n";
constexpr std::size_t kChecksumLength = 64;  // SHA-256 in hexadecimal

/// Waits until a file's bytes are on the disk.
void sync_to_disk(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool done = file >= 0 && ::fsync(file) == 0;
  const int reason = errno;
  if (file >= 0) ::close(file);
  if (!done)
    throw InputError(
        fmt::format("{}: cannot be written: {}", path.string(), std::strerror(reason)));
}

}  // namespace

void write_checkpoint(const std::filesystem::path& path, std::string_view state) {
  AtomicFile file(path);
  {
    std::ofstream stream(file.temporary_path(), std::ios::binary | std::ios::trunc);
    const std::string checksum = sha256_of_text(state);
    stream.write(kMagic.data(), static_cast<std::streamsize>(kMagic.size()));
    stream.write(checksum.data(), static_cast<std::streamsize>(checksum.size()));
    stream.write(state.data(), static_cast<std::streamsize>(state.size()));
    stream.flush();
    if (!stream)
      throw InputError(fmt::format(
          "{}: cannot be written, is the disk full? (the checkpoint before still stands)",
          path.string()));
  }
  sync_to_disk(file.temporary_path());
  file.commit();
}

std::string read_checkpoint(const std::filesystem::path& path) {
  const std::string content = read_file(path);
  const std::size_t begin = kMagic.size() + kChecksumLength;
  if (content.size() < begin || !content.starts_with(kMagic))
    throw InputError(
        fmt::format("{}: is no checkpoint, must be one that twang simulate wrote", path.string()));
  std::string state = content.substr(begin);
  if (sha256_of_text(state) != std::string_view(content).substr(kMagic.size(), kChecksumLength))
    throw InputError(fmt::format(
        "{}: is damaged, its checksum is not that of its content; start again without --resume",
        path.string()));
  return state;
}

}  // namespace twang
