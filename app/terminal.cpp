// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/terminal.hpp"

#include "core/atomic_file.hpp"
#include "core/error.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <system_error>

namespace twang::app {
namespace {

namespace fs = std::filesystem;

std::atomic<bool> interrupted{false};
bool bar_stands = false;

void on_interrupt(int) {
  interrupted = true;
  std::signal(SIGINT, SIG_DFL);
}

void draw_bar(const Progress& progress) {
  constexpr int kWidth = 30;
  if (progress.total > 0.0) {
    const double part = std::min(1.0, progress.done / progress.total);
    const int filled = static_cast<int>(part * kWidth);
    fmt::print(stderr,
               "\r\033[K{:<26} [{}{}] {:3.0f} %",
               progress.stage,
               std::string(static_cast<std::size_t>(filled), '#'),
               std::string(static_cast<std::size_t>(kWidth - filled), '.'),
               100.0 * part);
  } else {
    fmt::print(stderr, "\r\033[K{:<26} {:.0f}", progress.stage, progress.done);
  }
  std::fflush(stderr);
  bar_stands = true;
}

/// The outermost part of `folder` that does not exist yet; empty if all do.
fs::path first_missing(const fs::path& folder) {
  fs::path missing;
  for (fs::path at = fs::absolute(folder).lexically_normal(); !at.empty(); at = at.parent_path()) {
    if (fs::exists(at)) break;
    missing = at;
    if (at == at.parent_path()) break;
  }
  return missing;
}

}  // namespace

void catch_interrupts() {
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
}

ProgressCallback terminal_progress() {
  const bool on_terminal = ::isatty(STDERR_FILENO) != 0;
  auto last = std::chrono::steady_clock::time_point{};
  return [on_terminal, last](const Progress& progress) mutable {
    constexpr auto kBetweenDrawings = std::chrono::milliseconds(100);
    const auto now = std::chrono::steady_clock::now();
    if (on_terminal && now - last > kBetweenDrawings) {
      last = now;
      draw_bar(progress);
    }
    return !interrupted;
  };
}

void clear_progress() {
  if (!bar_stands) return;
  fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
  bar_stands = false;
}

void say(std::string_view line) {
  clear_progress();
  fmt::print(stderr, "{}\n", line);
}

void print_result(std::string_view text) {
  clear_progress();
  std::fwrite(text.data(), 1, text.size(), stdout);
  if (!text.empty() && text.back() != '\n') std::fputc('\n', stdout);
  if (std::fflush(stdout) != 0) throw InputError("standard output cannot be written to");
}

void write_json(const std::string& target, std::string_view json) {
  if (target == "-") {
    print_result(json);
  } else {
    write_file_atomically(target, json);
  }
}

OutputFolder::OutputFolder(fs::path folder) : m_folder(std::move(folder)) {
  std::error_code error;
  if (fs::exists(m_folder, error) && !fs::is_directory(m_folder, error)) {
    throw InputError(
        fmt::format("{}: is a file, must be a folder to write results into", m_folder.string()));
  }
  m_made = first_missing(m_folder);
  m_staging = m_folder / fmt::format(".twang-{}", ::getpid());
  fs::create_directories(m_staging, error);
  if (error) {
    throw InputError(
        fmt::format("{}: cannot be made or written to: {}", m_folder.string(), error.message()));
  }
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  fs::remove_all(m_staging, ignored);
  if (!m_committed && !m_made.empty()) fs::remove_all(m_made, ignored);
}

void OutputFolder::commit() {
  for (const auto& entry : fs::directory_iterator(m_staging)) {
    std::error_code error;
    fs::rename(entry.path(), m_folder / entry.path().filename(), error);
    if (error) {
      throw InputError(fmt::format("{}: cannot be written: {}",
                                   (m_folder / entry.path().filename()).string(),
                                   error.message()));
    }
  }
  m_committed = true;
}

}  // namespace twang::app
