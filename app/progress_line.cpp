// SPDX-License-Identifier: GPL-3.0-or-later
#include "app/progress_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang::app {
namespace {

constexpr double kSettled_s = 0.5;  // a rate taken over less would jump about

/// "0:07", "12:30", "1:02:03".
std::string clock_text(double seconds) {
  const auto whole = static_cast<long>(std::ceil(seconds));
  if (whole >= 3600) {
    return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
  }
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

std::string progress_line(const std::string& prefix, const Progress& progress, double elapsed_s) {
  constexpr int kWidth = 24;
  std::string line = prefix.empty() ? "" : prefix + "  ";
  line += fmt::format("{:<20}", progress.stage);
  const bool known = progress.total > 0.0;
  if (known) {
    const double part = std::clamp(progress.done / progress.total, 0.0, 1.0);
    const auto filled = static_cast<std::size_t>(part * kWidth);
    line += fmt::format(" [{}{}] {:3.0f} %",
                        std::string(filled, '#'),
                        std::string(kWidth - filled, '.'),
                        100.0 * part);
  } else {
    line += fmt::format(" {:.0f}", progress.done);
    if (!progress.unit.empty()) line += fmt::format(" {}", progress.unit);
  }
  if (progress.unit.empty() || elapsed_s < kSettled_s || !(progress.done > 0.0)) return line;
  const double rate = progress.done / elapsed_s;
  line += fmt::format("  {:.0f} {}/s", rate, progress.unit);
  if (known && progress.done < progress.total) {
    line += fmt::format("  {} left", clock_text((progress.total - progress.done) / rate));
  }
  return line;
}

}  // namespace twang::app
