// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/sheet_canvas.hpp"

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace twang::detail {
namespace {

constexpr int kFiner = 2;  // drawn so much larger than it is shown
constexpr int kShift = 4;  // OpenCV draws to a sixteenth of a pixel
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kCapital_px = 21.0;  // height of this font's capitals at scale 1

cv::Scalar scalar(SheetColour colour) {
  return {static_cast<double>(colour.red),
          static_cast<double>(colour.green),
          static_cast<double>(colour.blue)};
}

/// Centres of drawn pixels are integers in OpenCV; edges of the sheet's pixels are integers here.
cv::Point fine(const Eigen::Vector2d& at) {
  const double steps = 1 << kShift;
  return {static_cast<int>(std::lround((kFiner * at.x() - 0.5) * steps)),
          static_cast<int>(std::lround((kFiner * at.y() - 0.5) * steps))};
}

cv::Rect whole(const SheetBox& box) {
  const auto edge = [](double v) { return static_cast<int>(std::lround(kFiner * v)); };
  return {
      edge(box.x), edge(box.y), edge(box.right()) - edge(box.x), edge(box.bottom()) - edge(box.y)};
}

std::string ascii(const std::string& words) {
  std::string plain;
  for (const char c : words) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xC0U) == 0x80U) continue;  // inside a longer letter
    plain += byte >= 0x20 && byte < 0x7f ? c : '?';
  }
  return plain;
}

double font_scale(double height) { return kFiner * height / kCapital_px; }
int font_stroke(double height) { return height > 10.0 ? 3 : 2; }

// Told apart by most eyes.
constexpr std::array kOnWhite = {SheetColour{205, 125, 0},
                                 SheetColour{0, 115, 200},
                                 SheetColour{55, 150, 20},
                                 SheetColour{205, 60, 145},
                                 SheetColour{150, 135, 0},
                                 SheetColour{100, 85, 215}};
constexpr std::array kOnPicture = {SheetColour{255, 170, 0},
                                   SheetColour{0, 190, 255},
                                   SheetColour{120, 230, 60},
                                   SheetColour{255, 110, 200},
                                   SheetColour{240, 230, 40},
                                   SheetColour{150, 140, 255}};

}  // namespace

SheetColour marker_colour(std::size_t marker) { return kOnWhite[marker % kOnWhite.size()]; }
SheetColour marker_light_colour(std::size_t marker) {
  return kOnPicture[marker % kOnPicture.size()];
}

struct SheetCanvas::Impl {
  cv::Mat drawn;
};

SheetCanvas::SheetCanvas(int width_px, int height_px) : m_impl(std::make_unique<Impl>()) {
  m_impl->drawn =
      cv::Mat(kFiner * height_px, kFiner * width_px, CV_8UC3, cv::Scalar(255, 255, 255));
}

SheetCanvas::~SheetCanvas() = default;

void SheetCanvas::line(const std::vector<Eigen::Vector2d>& points,
                       SheetColour colour,
                       double width) {
  const int thick = std::max(1, static_cast<int>(std::lround(kFiner * width)));
  std::vector<cv::Point> run;
  const auto end_run = [&] {
    if (run.size() == 1) {
      cv::circle(m_impl->drawn,
                 run.front(),
                 (thick << kShift) / 2,
                 scalar(colour),
                 cv::FILLED,
                 cv::LINE_AA,
                 kShift);
    }
    if (run.size() > 1) {
      cv::polylines(m_impl->drawn, run, false, scalar(colour), thick, cv::LINE_AA, kShift);
    }
    run.clear();
  };
  for (const Eigen::Vector2d& point : points) {
    if (point.allFinite()) {
      run.push_back(fine(point));
    } else {
      end_run();
    }
  }
  end_run();
}

void SheetCanvas::dot(const Eigen::Vector2d& at, double radius, SheetColour colour) {
  if (!at.allFinite()) return;
  const int fine_radius = static_cast<int>(std::lround(kFiner * radius * (1 << kShift)));
  cv::circle(m_impl->drawn, fine(at), fine_radius, scalar(colour), cv::FILLED, cv::LINE_AA, kShift);
}

void SheetCanvas::fill(const SheetBox& box, SheetColour colour) {
  cv::rectangle(m_impl->drawn, whole(box), scalar(colour), cv::FILLED);
}

void SheetCanvas::outline(const SheetBox& box, SheetColour colour) {
  cv::rectangle(m_impl->drawn, whole(box), scalar(colour), kFiner);
}

void SheetCanvas::text(const Eigen::Vector2d& at,
                       const std::string& words,
                       double height,
                       SheetColour colour,
                       TextSide side) {
  double x = at.x();
  if (side == TextSide::Middle) x -= 0.5 * text_width(words, height);
  if (side == TextSide::Right) x -= text_width(words, height);
  const cv::Point origin(static_cast<int>(std::lround(kFiner * x)),
                         static_cast<int>(std::lround(kFiner * at.y())));
  cv::putText(m_impl->drawn,
              ascii(words),
              origin,
              kFont,
              font_scale(height),
              scalar(colour),
              font_stroke(height),
              cv::LINE_AA);
}

void SheetCanvas::label(const Eigen::Vector2d& at,
                        const std::string& words,
                        double height,
                        SheetColour colour) {
  const cv::Point origin(static_cast<int>(std::lround(kFiner * at.x())),
                         static_cast<int>(std::lround(kFiner * at.y())));
  const int stroke = font_stroke(height);
  for (const auto& [ink, width] :
       {std::pair{SheetColour{}, stroke + (height > 6.0 ? 4 : 3)}, {colour, stroke}}) {
    cv::putText(m_impl->drawn,
                ascii(words),
                origin,
                kFont,
                font_scale(height),
                scalar(ink),
                width,
                cv::LINE_AA);
  }
}

void SheetCanvas::ring(const Eigen::Vector2d& at, double radius, SheetColour colour) {
  if (!at.allFinite()) return;
  const int fine_radius = static_cast<int>(std::lround(kFiner * radius * (1 << kShift)));
  cv::circle(m_impl->drawn, fine(at), fine_radius, scalar(colour), 2 * kFiner, cv::LINE_AA, kShift);
}

double SheetCanvas::text_width(const std::string& words, double height) {
  int below = 0;
  const cv::Size size =
      cv::getTextSize(ascii(words), kFont, font_scale(height), font_stroke(height), &below);
  return static_cast<double>(size.width) / kFiner;
}

std::string SheetCanvas::shortened(const std::string& words, double height, double width) {
  if (text_width(words, height) <= width) return words;
  std::string start = words;
  while (!start.empty() && text_width(start + "...", height) > width) start.pop_back();
  return start + "...";
}

void SheetCanvas::picture(const SheetBox& box, const Image& image) {
  // OpenCV's header takes what it only reads as writable.
  const cv::Mat given(image.height_px,
                      image.width_px,
                      image.channels == 3 ? CV_8UC3 : CV_8UC1,
                      const_cast<std::uint8_t*>(image.pixels.data()));
  cv::Mat colour;
  if (image.channels == 3) {
    colour = given;
  } else {
    cv::cvtColor(given, colour, cv::COLOR_GRAY2RGB);
  }
  const cv::Rect place = whole(box) & cv::Rect(0, 0, m_impl->drawn.cols, m_impl->drawn.rows);
  if (place.empty()) return;
  const bool smaller = place.width < colour.cols;
  cv::Mat scaled;
  cv::resize(colour, scaled, place.size(), 0.0, 0.0, smaller ? cv::INTER_AREA : cv::INTER_LINEAR);
  scaled.copyTo(m_impl->drawn(place));
}

Image SheetCanvas::image() const {
  cv::Mat shown;
  cv::resize(m_impl->drawn, shown, {}, 1.0 / kFiner, 1.0 / kFiner, cv::INTER_AREA);
  Image image{shown.cols, shown.rows, 3, {}};
  image.pixels.assign(shown.datastart, shown.dataend);
  return image;
}

double tick_step(double range, int fewest) {
  const double most = range / fewest;
  if (!(most > 0.0) || !std::isfinite(most)) return 1.0;
  const double power = std::pow(10.0, std::floor(std::log10(most)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= most) return factor * power;
  }
  return power;
}

std::vector<double> ticks_between(double low, double high, double step) {
  constexpr double kRoundOff = 1e-6;  // of a step
  constexpr double kMost = 1000.0;
  std::vector<double> ticks;
  const double first = std::ceil(low / step - kRoundOff);
  const double last = std::min(std::floor(high / step + kRoundOff), first + kMost);
  for (double n = first; n <= last; n += 1.0) ticks.push_back(n * step);
  return ticks;
}

std::string tick_text(double value, double step) {
  const int digits = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  const double shown = std::abs(value) < 1e-6 * step ? 0.0 : value;
  return digits > 6 ? fmt::format("{:.3g}", shown) : fmt::format("{:.{}f}", shown, digits);
}

Eigen::Vector2d SheetPlot::at(double x, double y) const {
  return {box.x + (x - x_low) / (x_high - x_low) * box.width,
          box.bottom() - (y - y_low) / (y_high - y_low) * box.height};
}

void SheetPlot::draw_axes(SheetCanvas& canvas,
                          const std::string& title,
                          const std::string& x_label) const {
  constexpr double kLetters = 7.5;
  constexpr double kTitle = 8.5;
  canvas.text({box.x, box.y - 9.0}, title, kTitle);
  const double y_step = tick_step(y_high - y_low, 3);
  for (const double y : ticks_between(y_low, y_high, y_step)) {
    const double height = at(x_low, y).y();
    canvas.line({{box.x, height}, {box.right(), height}}, kRule, 0.5);
    canvas.text({box.x - 6.0, height + 0.5 * kLetters},
                tick_text(y, y_step),
                kLetters,
                kFaint,
                TextSide::Right);
  }
  const double x_step = tick_step(x_high - x_low, std::max(2, static_cast<int>(box.width / 130.0)));
  for (const double x : ticks_between(x_low, x_high, x_step)) {
    const double across = at(x, y_low).x();
    canvas.line({{across, box.y}, {across, box.bottom()}}, kRule, 0.5);
    canvas.text({across, box.bottom() + 7.0 + kLetters},
                tick_text(x, x_step),
                kLetters,
                kFaint,
                TextSide::Middle);
  }
  canvas.line({{box.x, box.y}, {box.x, box.bottom()}, {box.right(), box.bottom()}}, kFaint, 0.5);
  canvas.text(
      {box.right(), box.bottom() + 19.0 + kLetters}, x_label, kLetters, kFaint, TextSide::Right);
}

void SheetPlot::draw_curve(SheetCanvas& canvas,
                           const std::vector<double>& x,
                           const std::vector<double>& y,
                           SheetColour colour) const {
  std::vector<Eigen::Vector2d> points;
  points.reserve(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) points.push_back(at(x[i], y[i]));
  canvas.line(points, colour, 0.75);
}

}  // namespace twang::detail
