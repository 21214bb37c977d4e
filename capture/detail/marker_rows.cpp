// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/marker_rows.hpp"

#include "core/constants.hpp"
#include "core/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang::detail {
namespace {

constexpr std::size_t kMostRows = 60;  // what a page can show
constexpr double kTallest = 92.0;      // of a row
constexpr double kNames = 120.0;       // widths of the columns
constexpr double kPaths = 480.0;
constexpr double kSigmas = 170.0;
constexpr double kTitle = 8.0;  // heights of letters
constexpr double kNumbers = 7.5;

}  // namespace

void draw_lost_stretches(SheetCanvas& canvas,
                         const SheetPlot& plot,
                         const MarkerSummary& marker,
                         const std::vector<double>& time_s) {
  if (time_s.size() < 2) return;
  const double half_frame =
      0.5 * (time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1);
  for (const TimedLoss& loss : marker.lost) {
    const double left = plot.at(std::max(plot.x_low, loss.start_s - half_frame), 0.0).x();
    const double right = plot.at(std::min(plot.x_high, loss.end_s + half_frame), 0.0).x();
    canvas.fill({left, plot.box.y, std::max(1.0, right - left), plot.box.height},
                SheetColour{248, 208, 204});
  }
}

MarkerRows::MarkerRows(const Rig& rig,
                       const TrackResult& result,
                       const std::vector<MarkerSummary>& markers,
                       const SheetBox& box)
    : m_result(result),
      m_markers(markers),
      m_box(box),
      m_num_rows(std::min(markers.size(), kMostRows)) {
  m_row_height =
      std::min(kTallest, box.height / static_cast<double>(std::max<std::size_t>(1, m_num_rows)));
  m_letters = std::clamp(0.55 * m_row_height, 4.0, 8.0);
  m_box.height = m_row_height * static_cast<double>(m_num_rows);
  for (const Marker& marker : rig.markers) {
    m_paths_mm.push_back(displacement_mm(rig, result.trace, marker));
    for (const Eigen::Vector2d& at : m_paths_mm.back()) {
      if (at.allFinite()) m_reach_mm = std::max(m_reach_mm, 1.05 * at.cwiseAbs().maxCoeff());
    }
  }
}

double MarkerRows::middle(std::size_t row) const {
  return m_box.y + (static_cast<double>(row) + 0.5) * m_row_height;
}

void MarkerRows::draw(SheetCanvas& canvas) const {
  for (std::size_t row = 0; row <= m_num_rows; ++row) {
    const double y = m_box.y + static_cast<double>(row) * m_row_height;
    canvas.line({{m_box.x, y}, {m_box.right(), y}}, kRule, 0.5);
  }
  draw_names(canvas);
  const double first = m_box.x + kNames;
  const double second = first + kPaths + 24.0;
  const double third = second + kPaths + 34.0;
  draw_paths(canvas, first, 0, "to the right in the picture");
  draw_paths(canvas, second, 1, "down in the picture");
  draw_sigmas(canvas, third);
  draw_words(canvas, third + kSigmas + 30.0);
}

void MarkerRows::draw_names(SheetCanvas& canvas) const {
  for (std::size_t row = 0; row < m_num_rows; ++row) {
    const MarkerSummary& marker = m_markers[row];
    canvas.text({m_box.x, middle(row) + 0.5 * m_letters},
                SheetCanvas::shortened(marker.id, m_letters, kNames - 14.0),
                m_letters,
                marker.frames_lost > 0 ? kAlarm : kInk);
  }
}

void MarkerRows::draw_paths(SheetCanvas& canvas,
                            double left,
                            int axis,
                            const std::string& title) const {
  const std::vector<double>& time_s = m_result.trace.time_s;
  if (time_s.size() < 2) return;
  canvas.text({left, m_box.y - 10.0},
              fmt::format("{}; a row is {} mm high", title, rounded_text(2.0 * m_reach_mm, 3)),
              kTitle);
  SheetPlot plot{{left, m_box.y, kPaths, m_box.height},
                 time_s.front(),
                 time_s.back(),
                 -m_reach_mm,
                 m_reach_mm};
  for (std::size_t row = 0; row < m_num_rows; ++row) {
    SheetPlot of_row = plot;
    of_row.box.y = middle(row) - 0.5 * m_row_height;
    of_row.box.height = m_row_height;
    draw_lost_stretches(canvas, of_row, m_markers[row], time_s);
  }
  const double step = tick_step(plot.x_high - plot.x_low, 4);
  for (const double t : ticks_between(plot.x_low, plot.x_high, step)) {
    const double x = plot.at(t, 0.0).x();
    canvas.line({{x, m_box.y}, {x, m_box.bottom()}}, kRule, 0.5);
    canvas.text({x, m_box.bottom() + 15.0}, tick_text(t, step), kNumbers, kFaint, TextSide::Middle);
  }
  canvas.text(
      {left + kPaths, m_box.bottom() + 29.0}, "time [s]", kNumbers, kFaint, TextSide::Right);
  for (std::size_t row = 0; row < std::min(m_num_rows, m_paths_mm.size()); ++row) {
    plot.box.y = middle(row) - 0.5 * m_row_height;
    plot.box.height = m_row_height;
    std::vector<double> path;
    for (const Eigen::Vector2d& at : m_paths_mm[row]) path.push_back(at[axis]);
    plot.draw_curve(canvas, time_s, path, marker_colour(row));
  }
}

void MarkerRows::draw_sigmas(SheetCanvas& canvas, double left) const {
  constexpr double kLowest = -4.0;  // decades of a pixel: below, a compressed picture stands still
  double low = 0.0;
  double high = -2.0;
  for (const MarkerSummary& marker : m_markers) {
    for (const double px : {marker.sigma_px, marker.noise_floor_px}) {
      if (!(px > 0.0)) continue;
      low = std::min(low, std::log10(px));
      high = std::max(high, std::log10(px));
    }
  }
  low = std::max(kLowest, std::floor(low));
  high = std::max(low + 1.0, std::ceil(high));
  const SheetPlot scale{{left, m_box.y, kSigmas, m_box.height}, low, high, 0.0, 1.0};
  canvas.text({left, m_box.y - 10.0}, "sigma of a coordinate [px]", kTitle);
  for (double power = low; power <= high + 0.5; power += 1.0) {
    const double x = scale.at(power, 0.0).x();
    canvas.line({{x, m_box.y}, {x, m_box.bottom()}}, kRule, 0.5);
    canvas.text({x, m_box.bottom() + 15.0},
                fmt::format("{:g}", std::pow(10.0, power)),
                kNumbers,
                kFaint,
                TextSide::Middle);
  }
  const double radius = std::clamp(0.18 * m_row_height, 1.5, 4.0);
  for (std::size_t row = 0; row < m_num_rows; ++row) {
    const auto place = [&](double px) {
      const double decade = px > 0.0 ? std::max(low, std::log10(px)) : kNaN;
      return Eigen::Vector2d(scale.at(decade, 0.0).x(), middle(row));
    };
    canvas.dot(place(m_markers[row].noise_floor_px), radius, kOrange);
    canvas.dot(place(m_markers[row].sigma_px), radius, kBlue);
  }
  const double legend = m_box.bottom() + 29.0;
  canvas.dot({left + 3.0, legend - 3.5}, 3.0, kBlue);
  canvas.text({left + 11.0, legend}, "as stated", kNumbers, kFaint);
  canvas.dot({left + 78.0, legend - 3.5}, 3.0, kOrange);
  canvas.text({left + 86.0, legend}, "while it stands", kNumbers, kFaint);
}

void MarkerRows::draw_words(SheetCanvas& canvas, double left) const {
  const double width = m_box.right() - left;
  canvas.text({left, m_box.y - 10.0}, "frames seen; lost", kTitle);
  for (std::size_t row = 0; row < m_num_rows; ++row) {
    const MarkerSummary& marker = m_markers[row];
    const bool lost = marker.frames_lost > 0;
    const bool roomy = lost && m_row_height > 3.2 * m_letters;
    const double base = middle(row) + 0.5 * m_letters - (roomy ? 0.9 * m_letters : 0.0);
    std::string words = fmt::format("{}", marker.frames_seen);
    if (lost) {
      words += fmt::format("; {} lost in {} stretch{}",
                           marker.frames_lost,
                           marker.lost.size(),
                           marker.lost.size() == 1 ? "" : "es");
    }
    canvas.text({left, base},
                SheetCanvas::shortened(words, m_letters, width),
                m_letters,
                lost ? kAlarm : kInk);
    if (!roomy || marker.lost.empty()) continue;
    canvas.text({left, base + 1.9 * m_letters},
                SheetCanvas::shortened(marker.lost.front().stretch.reason, m_letters, width),
                m_letters,
                kFaint);
  }
  if (m_markers.size() > m_num_rows) {
    canvas.text({left, m_box.bottom() + 29.0},
                fmt::format("and {} markers more", m_markers.size() - m_num_rows),
                kNumbers,
                kFaint);
  }
}

}  // namespace twang::detail
