// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/image.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace twang::detail {

/// Red, green, blue, 0 to 255.
struct SheetColour {
  int red = 0;
  int green = 0;
  int blue = 0;
};

inline constexpr SheetColour kInk{30, 34, 40};
inline constexpr SheetColour kFaint{112, 118, 126};
inline constexpr SheetColour kRule{222, 225, 229};
/// The colour of the marker of that number, on white and over a picture.
[[nodiscard]] SheetColour marker_colour(std::size_t marker);
[[nodiscard]] SheetColour marker_light_colour(std::size_t marker);

inline constexpr SheetColour kBlue{25, 100, 190};
inline constexpr SheetColour kAlarm{205, 40, 40};
inline constexpr SheetColour kOrange{214, 128, 10};

/// A rectangle of the sheet [px].
struct SheetBox {
  double x = 0.0;
  double y = 0.0;
  double width = 0.0;
  double height = 0.0;
  [[nodiscard]] double right() const { return x + width; }
  [[nodiscard]] double bottom() const { return y + height; }
};

enum class TextSide { Left, Middle, Right };  ///< which point of a text is given

/// A white sheet to draw on; drawn at twice its size, so that lines and letters come out smooth.
class SheetCanvas {
 public:
  SheetCanvas(int width_px, int height_px);
  ~SheetCanvas();
  SheetCanvas(const SheetCanvas&) = delete;
  SheetCanvas& operator=(const SheetCanvas&) = delete;

  /// A line through points; broken where one is not finite, where a single one becomes a dot.
  void line(const std::vector<Eigen::Vector2d>& points, SheetColour colour, double width = 1.0);
  void dot(const Eigen::Vector2d& at, double radius, SheetColour colour);
  void fill(const SheetBox& box, SheetColour colour);
  void outline(const SheetBox& box, SheetColour colour);
  /// One line of text, `at` on its base line; letters beyond ASCII become question marks.
  /// @param height  of a capital letter [px]
  void text(const Eigen::Vector2d& at,
            const std::string& words,
            double height,
            SheetColour colour = kInk,
            TextSide side = TextSide::Left);
  /// The same over a picture: light letters with a dark rim.
  void label(const Eigen::Vector2d& at,
             const std::string& words,
             double height,
             SheetColour colour);
  void ring(const Eigen::Vector2d& at, double radius, SheetColour colour);
  [[nodiscard]] static double text_width(const std::string& words, double height);
  /// The text, or as much of its beginning as fits into `width`, with dots.
  [[nodiscard]] static std::string shortened(const std::string& words, double height, double width);
  /// A picture (grey or RGB) scaled to fill the box.
  void picture(const SheetBox& box, const Image& image);

  [[nodiscard]] Image image() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> m_impl;
};

/// The largest step of 1, 2 or 5 times a power of ten that puts at least `fewest` steps in a range.
[[nodiscard]] double tick_step(double range, int fewest);
/// Multiples of `step` from `low` to `high`.
[[nodiscard]] std::vector<double> ticks_between(double low, double high, double step);
/// A tick's number with the digits that its step calls for.
[[nodiscard]] std::string tick_text(double value, double step);

/// A plot: where values lie on the sheet.
struct SheetPlot {
  SheetBox box;
  double x_low = 0.0;
  double x_high = 1.0;
  double y_low = 0.0;
  double y_high = 1.0;

  [[nodiscard]] Eigen::Vector2d at(double x, double y) const;
  /// Title above, grid and numbers along both axes.
  void draw_axes(SheetCanvas& canvas, const std::string& title, const std::string& x_label) const;
  /// A curve, broken at nan.
  void draw_curve(SheetCanvas& canvas,
                  const std::vector<double>& x,
                  const std::vector<double>& y,
                  SheetColour colour) const;
};

}  // namespace twang::detail
