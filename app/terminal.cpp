// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/terminal.hpp"

#include "app/progress_line.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <string>
#include <system_error>
#include <utility>

namespace twang::app {
namespace {

namespace fs = std::filesystem;

std::atomic<bool> interrupted{false};
bool bar_stands = false;

void on_interrupt(int) {
  interrupted = true;
  std::signal(SIGINT, SIG_DFL);
}

void draw_bar(const std::string& line) {
  fmt::print(stderr, "\r\033[K{}", line);
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

ProgressCallback terminal_progress(std::function<std::string()> prefix) {
  using Clock = std::chrono::steady_clock;
  struct Stage {
    std::string name;
    double done = 0.0;
    Clock::time_point start;
    Clock::time_point drawn;
  };
  const bool on_terminal = ::isatty(STDERR_FILENO) != 0;
  return
      [on_terminal, prefix = std::move(prefix), stage = Stage{}](const Progress& progress) mutable {
        constexpr auto kBetweenDrawings = std::chrono::milliseconds(100);
        if (!on_terminal) return !interrupted;
        const auto now = Clock::now();
        if (stage.name != progress.stage || progress.done < stage.done) {
          stage = {std::string(progress.stage), 0.0, now, stage.drawn};
        }
        stage.done = progress.done;
        if (now - stage.drawn > kBetweenDrawings) {
          stage.drawn = now;
          const std::chrono::duration<double> elapsed = now - stage.start;
          draw_bar(progress_line(prefix ? prefix() : "", progress, elapsed.count()));
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
