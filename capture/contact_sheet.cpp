// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/contact_sheet.hpp"

#include "capture/detail/marker_rows.hpp"
#include "capture/detail/sheet_canvas.hpp"
#include "capture/track_summary.hpp"
#include "core/constants.hpp"
#include "core/text.hpp"
#include "rigs/observable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

using namespace detail;

constexpr int kWidth_px = 1600;
constexpr int kHeight_px = 1130;
constexpr double kMargin = 40.0;
constexpr double kTopOfPictures = 104.0;
constexpr double kPictureHeight = 388.0;
constexpr double kWidestPicture = 690.0;
constexpr double kTopOfRows = 588.0;
constexpr double kBottomOfRows = 990.0;
constexpr double kTopOfNotes = 1046.0;
constexpr std::size_t kManyMarkers = 12;
constexpr double kExact_px = 1e-9;     // round-off: four points fit a homography
constexpr std::size_t kMostNotes = 8;  // in two columns

/// Six digits at most, without trailing zeros.
std::string plain(double value) { return fmt::format("{:.6g}", value); }

struct Range {
  double low = kInfinity;
  double high = -kInfinity;
  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  /// Widened by a part of itself, and to at least `least`.
  [[nodiscard]] Range widened(double part, double least) const {
    if (!(low <= high)) return {0.0, least};
    const double middle = 0.5 * (low + high);
    const double half = std::max(0.5 * least, (0.5 + part) * (high - low));
    return {middle - half, middle + half};
  }
};

class ContactSheet {
 public:
  ContactSheet(const Rig& rig, const std::string& film, const TrackResult& result)
      : m_rig(rig),
        m_film(film),
        m_result(result),
        m_time_s(result.trace.time_s),
        m_markers(summarize_markers(rig, result)),
        m_canvas(kWidth_px, kHeight_px) {}

  Image draw() {
    draw_title();
    const double right_of_picture = draw_picture();
    const double left = right_of_picture + 90.0;
    const double width = kWidth_px - kMargin - left;
    draw_observable({left, kTopOfPictures, width, 150.0});
    const double half = 0.5 * (width - 80.0);
    draw_time_base({left, 352.0, half, 110.0});
    draw_plane({left + half + 80.0, 352.0, half, 110.0});
    MarkerRows(m_rig,
               m_result,
               m_markers,
               {kMargin, kTopOfRows, kWidth_px - 2.0 * kMargin, kBottomOfRows - kTopOfRows})
        .draw(m_canvas);
    draw_notes();
    return m_canvas.image();
  }

 private:
  void draw_title();
  double draw_picture();
  void draw_observable(const SheetBox& box);
  void draw_time_base(const SheetBox& box);
  void draw_plane(const SheetBox& box);
  void draw_notes();
  [[nodiscard]] Range time_range() const {
    Range range;
    for (const double t : m_time_s) range.add(t);
    return range.widened(0.0, 1e-3);
  }

  const Rig& m_rig;
  const std::string& m_film;
  const TrackResult& m_result;
  const std::vector<double>& m_time_s;
  std::vector<MarkerSummary> m_markers;
  SheetCanvas m_canvas;
};

void ContactSheet::draw_title() {
  const double width = kWidth_px - 2.0 * kMargin;
  m_canvas.text({kMargin, 46.0}, SheetCanvas::shortened(m_film, 15.0, 0.6 * width), 15.0);
  m_canvas.text({kWidth_px - kMargin, 46.0},
                SheetCanvas::shortened(m_rig.name, 11.0, 0.35 * width),
                11.0,
                kFaint,
                TextSide::Right);
  const TimeBaseSummary& time = m_result.time_base;
  const double length_s = m_time_s.empty() ? 0.0 : m_time_s.back() - m_time_s.front();
  m_canvas.text({kMargin, 70.0},
                fmt::format("{} frames, {} s at {} frames/s ({}); {} repeated, {} missing; {} mm a "
                            "pixel",
                            time.frames,
                            rounded_text(length_s, 4),
                            plain(time.capture_fps),
                            time.source,
                            time.doubled,
                            time.gaps,
                            rounded_text(m_result.mm_per_px, 4)),
                9.0,
                kFaint);
}

/// @return where the picture ends at the right
double ContactSheet::draw_picture() {
  const Image& image = m_result.first_frame;
  const double scale = std::min(kWidestPicture / image.width_px, kPictureHeight / image.height_px);
  const SheetBox box{
      kMargin, kTopOfPictures - 8.0, scale * image.width_px, scale * image.height_px};
  m_canvas.picture(box, image);
  m_canvas.outline(box, kFaint);
  const auto on_sheet = [&](const Eigen::Vector2d& px) {
    return Eigen::Vector2d(Eigen::Vector2d(box.x, box.y) +
                           scale * (px + Eigen::Vector2d::Constant(0.5)));
  };
  const double letters = m_markers.size() > kManyMarkers ? 5.0 : 8.0;
  for (std::size_t i = 0; i < m_result.tracks.size(); ++i) {
    std::vector<Eigen::Vector2d> path;
    for (const Eigen::Vector2d& px : m_result.tracks[i].position_px) path.push_back(on_sheet(px));
    m_canvas.line(path, marker_light_colour(i), 0.75);
  }
  for (std::size_t i = 0; i < m_result.tracks.size(); ++i) {
    const MarkerTrack& track = m_result.tracks[i];
    const std::size_t n = m_result.layout_frame;
    if (n >= track.position_px.size() || !track.position_px[n].allFinite()) continue;
    const Eigen::Vector2d at = on_sheet(track.position_px[n]);
    const double radius = std::max(4.0, 0.8 * scale * m_result.size_px[i]);
    const SheetColour colour = marker_light_colour(i);
    m_canvas.ring(at, radius, colour);
    const Eigen::Vector2d arm(0.45 * radius, 0.0);
    const Eigen::Vector2d down(0.0, 0.45 * radius);
    m_canvas.line({at - arm, at + arm}, kAlarm, 0.5);
    m_canvas.line({at - down, at + down}, kAlarm, 0.5);
    const double width = SheetCanvas::text_width(track.id, letters);
    const double left = at.x() + radius + 2.0 + width < box.right()
                            ? at.x() + 0.75 * radius
                            : at.x() - 0.75 * radius - width;
    m_canvas.label(
        {left, std::max(box.y + letters + 2.0, at.y() - 0.75 * radius)}, track.id, letters, colour);
  }
  const double right = std::max(box.right(), kMargin + 340.0);
  m_canvas.text(
      {box.x, box.bottom() + 16.0},
      SheetCanvas::shortened(
          fmt::format("{}, {} x {} px: the layout found, the paths taken",
                      m_result.layout_frame == 0 ? std::string("first frame")
                                                 : fmt::format("frame {}", m_result.layout_frame),
                      image.width_px,
                      image.height_px),
          7.5,
          right - box.x),
      7.5,
      kFaint);
  return right;
}

void ContactSheet::draw_observable(const SheetBox& box) {
  const Channel* channel =
      m_rig.observable ? m_result.trace.find(observable_column(m_rig.observable->kind)) : nullptr;
  if (channel == nullptr) {
    m_canvas.outline(box, kRule);
    m_canvas.text({box.x + 0.5 * box.width, box.y + 0.5 * box.height},
                  "the rig defines no observable",
                  8.5,
                  kFaint,
                  TextSide::Middle);
    return;
  }
  Range values;
  for (const double value : channel->values) values.add(value);
  values = values.widened(0.05, 1e-6);
  const Range time = time_range();
  const SheetPlot plot{box, time.low, time.high, values.low, values.high};
  plot.draw_axes(m_canvas,
                 fmt::format("observable [{}]", observable_unit(m_rig.observable->kind)),
                 "time [s]");
  for (const MarkerSummary& marker : m_markers) {
    const auto& used = m_rig.observable->markers;
    if (std::find(used.begin(), used.end(), marker.id) != used.end()) {
      draw_lost_stretches(m_canvas, plot, marker, m_time_s);
    }
  }
  plot.draw_curve(m_canvas, m_time_s, channel->values, kBlue);
}

void ContactSheet::draw_time_base(const SheetBox& box) {
  std::vector<double> at_s;
  std::vector<double> interval_ms;
  Range range;
  for (std::size_t n = 1; n < m_time_s.size(); ++n) {
    at_s.push_back(m_time_s[n]);
    interval_ms.push_back(1e3 * (m_time_s[n] - m_time_s[n - 1]));
    range.add(interval_ms.back());
  }
  const double nominal_ms = 1e3 / m_result.time_base.capture_fps;
  const double spread_ms = range.high - range.low;
  range.add(nominal_ms);
  constexpr double kLeastRange = 0.1;  // of the nominal interval: round-off is no jitter
  const Range shown = range.widened(0.15, kLeastRange * nominal_ms);
  const Range time = time_range();
  const SheetPlot plot{box, time.low, time.high, shown.low, shown.high};
  plot.draw_axes(m_canvas, "time from frame to frame [ms]", "time [s]");
  for (std::size_t i = 0; i < at_s.size(); ++i) {
    const bool doubled = i + 1 < m_result.doubled.size() && m_result.doubled[i + 1];
    const bool gap = interval_ms[i] > 1.5 * nominal_ms;
    m_canvas.dot(plot.at(at_s[i], interval_ms[i]),
                 doubled || gap ? 2.6 : 1.1,
                 doubled ? kOrange
                 : gap   ? kAlarm
                         : kBlue);
  }
  const TimeBaseSummary& base = m_result.time_base;
  constexpr double kEven = 1e-4;  // of the interval
  m_canvas.text(
      {box.x, box.bottom() + 42.0},
      spread_ms < kEven * nominal_ms
          ? fmt::format(
                "even, {:.5g} ms; the file plays at {:.5g} frames/s", nominal_ms, base.file_fps)
          : fmt::format("{:.4g} to {:.4g} ms; the file plays at {:.5g} frames/s",
                        range.low,
                        range.high,
                        base.file_fps),
      7.5,
      kFaint);
  m_canvas.text({box.x, box.bottom() + 56.0},
                fmt::format("{} repeated (orange), {} missing (red)", base.doubled, base.gaps),
                7.5,
                base.doubled + base.gaps > 0 ? kAlarm : kFaint);
}

void ContactSheet::draw_plane(const SheetBox& box) {
  const std::vector<double> residual = plane_residual_by_frame(m_rig, m_result);
  Range range;
  for (const double value : residual) range.add(value);
  if (!(range.low <= range.high)) {
    m_canvas.text({box.x, box.y - 9.0}, "fixed markers about their places [px]", 8.5);
    m_canvas.outline(box, kRule);
    m_canvas.text({box.x + 0.5 * box.width, box.y + 0.5 * box.height},
                  "fewer than three fixed markers",
                  8.0,
                  kFaint,
                  TextSide::Middle);
    return;
  }
  const Range time = time_range();
  const SheetPlot plot{box, time.low, time.high, 0.0, std::max(0.05, 1.15 * range.high)};
  plot.draw_axes(m_canvas, "fixed markers about their places [px]", "time [s]");
  plot.draw_curve(m_canvas, m_time_s, residual, kBlue);
  m_canvas.text({box.x, box.bottom() + 42.0},
                m_result.plane_residual_px > kExact_px
                    ? fmt::format("rms {} px = {} mm over the film",
                                  rounded_text(m_result.plane_residual_px, 2),
                                  rounded_text(m_result.plane_residual_mm, 2))
                    : "on the average they determine the map and fit it exactly",
                7.5,
                kFaint);
}

void ContactSheet::draw_notes() {
  constexpr double kLetters = 7.5;
  constexpr double kLine = 17.0;
  const double column = 0.5 * (kWidth_px - 2.0 * kMargin - 30.0);
  m_canvas.line({{kMargin, kTopOfNotes - 16.0}, {kWidth_px - kMargin, kTopOfNotes - 16.0}}, kRule);
  std::vector<std::string> notes = sentences_of(m_result.notes, Severity::Warning);
  for (std::string& remark : sentences_of(m_result.notes, Severity::Remark)) {
    notes.push_back(std::move(remark));
  }
  const std::size_t shown = std::min(notes.size(), kMostNotes);
  for (std::size_t i = 0; i < shown; ++i) {
    const bool more = i + 1 == kMostNotes && notes.size() > kMostNotes;
    const std::string words =
        more ? fmt::format("... and {} notes more", notes.size() - kMostNotes + 1) : notes[i];
    const std::size_t rows = kMostNotes / 2;
    m_canvas.text({kMargin + (i < rows ? 0.0 : column + 30.0),
                   kTopOfNotes + 4.0 + kLine * static_cast<double>(i % rows)},
                  SheetCanvas::shortened(words, kLetters, column),
                  kLetters);
  }
}

}  // namespace

Image draw_contact_sheet(const Rig& rig, const std::string& film, const TrackResult& result) {
  return ContactSheet(rig, film, result).draw();
}

}  // namespace twang
