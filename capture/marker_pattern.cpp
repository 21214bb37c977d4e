// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/marker_pattern.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace twang {

/// An axis-aligned rectangle.
struct MarkerPattern::Rectangle {
  double x0, x1, y0, y1;
};

namespace {

constexpr double kHalf = 0.5;              // half the outer size
constexpr double kHalfBar = 1.0 / 6.0;     // half the width of a cross's bar
constexpr double kHoleRadius = 1.0 / 4.0;  // of a ring

double overlap(double a0, double a1, double b0, double b1) {
  return std::max(0.0, std::min(a1, b1) - std::max(a0, b0));
}

template <typename Rectangle>
double common_area(const Rectangle& a, const Rectangle& b) {
  return overlap(a.x0, a.x1, b.x0, b.x1) * overlap(a.y0, a.y1, b.y0, b.y1);
}

/// Antiderivative of sqrt(r² - x²), |x| <= r.
double circle_integral(double x, double r) {
  const double height = std::sqrt(std::max(0.0, r * r - x * x));
  return 0.5 * (x * height + r * r * std::asin(std::clamp(x / r, -1.0, 1.0)));
}

/// Area that a rectangle shares with the disk of radius r around the origin.
///
/// Between the abscissas at which the circle crosses the rectangle's rows, the upper and the lower
/// bound of the common part are each either the circle or the rectangle's edge.
template <typename Rectangle>
double area_in_disk(const Rectangle& box, double r) {
  const double near_x = std::max({box.x0, -box.x1, 0.0});
  const double near_y = std::max({box.y0, -box.y1, 0.0});
  if (near_x * near_x + near_y * near_y >= r * r) return 0.0;
  const double far_x = std::max(std::abs(box.x0), std::abs(box.x1));
  const double far_y = std::max(std::abs(box.y0), std::abs(box.y1));
  if (far_x * far_x + far_y * far_y <= r * r) return (box.x1 - box.x0) * (box.y1 - box.y0);

  const double left = std::max(box.x0, -r);
  const double right = std::min(box.x1, r);
  const double cut0 = std::sqrt(std::max(0.0, r * r - box.y0 * box.y0));
  const double cut1 = std::sqrt(std::max(0.0, r * r - box.y1 * box.y1));
  std::array<double, 6> cuts = {left, -cut0, -cut1, cut0, cut1, right};
  for (double& cut : cuts) cut = std::clamp(cut, left, right);
  std::sort(cuts.begin(), cuts.end());

  double area = 0.0;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double a = cuts[i];
    const double b = cuts[i + 1];
    const double middle = 0.5 * (a + b);
    const double height = std::sqrt(std::max(0.0, r * r - middle * middle));
    if (b <= a || height <= box.y0 || -height >= box.y1) continue;
    const double under_circle = circle_integral(b, r) - circle_integral(a, r);
    area += height < box.y1 ? under_circle : box.y1 * (b - a);
    area += -height > box.y0 ? under_circle : -box.y0 * (b - a);
  }
  return area;
}

bool needs_more_than_a_kind(MarkerKind kind) {
  return kind == MarkerKind::ArUco || kind == MarkerKind::AprilTag || kind == MarkerKind::Patch;
}

}  // namespace

MarkerPattern::MarkerPattern(MarkerKind kind) : m_kind(kind) {
  if (!needs_more_than_a_kind(kind)) return;
  throw InputError(
      fmt::format("a marker of kind '{}' has no known picture, must be a cross, dot, "
                  "ring or checker",
                  to_string(kind)));
}

MarkerPattern::MarkerPattern(const Marker& marker) : m_kind(marker.kind) {
  if (!needs_more_than_a_kind(marker.kind)) return;
  throw InputError(
      fmt::format("marker '{}' is of kind '{}', which has no known picture, must be a cross, dot, "
                  "ring or checker",
                  marker.id,
                  to_string(marker.kind)));
}

bool MarkerPattern::ink(int row, int column) const {
  assert(row >= 0 && row < m_num_cells && column >= 0 && column < m_num_cells);
  const auto bit = static_cast<std::size_t>(row * m_num_cells + column);
  return (m_cells[bit / 64] >> (bit % 64) & 1U) != 0;
}

double MarkerPattern::ink_area_of_cells(const Rectangle& box) const {
  const auto cell = [this](double x) {
    return static_cast<int>(
        std::clamp(std::floor((x + kHalf) * m_num_cells), 0.0, m_num_cells - 1.0));
  };
  double area = 0.0;
  for (int row = cell(box.y0); row <= cell(box.y1); ++row) {
    const double y0 = static_cast<double>(row) / m_num_cells - kHalf;
    const double height = overlap(box.y0, box.y1, y0, y0 + 1.0 / m_num_cells);
    for (int column = cell(box.x0); column <= cell(box.x1); ++column) {
      if (!ink(row, column)) continue;
      const double x0 = static_cast<double>(column) / m_num_cells - kHalf;
      area += height * overlap(box.x0, box.x1, x0, x0 + 1.0 / m_num_cells);
    }
  }
  return area;
}

double MarkerPattern::ink_area(const Rectangle& box) const {
  switch (m_kind) {
    case MarkerKind::Cross:
      return common_area(box, {-kHalf, kHalf, -kHalfBar, kHalfBar}) +
             common_area(box, {-kHalfBar, kHalfBar, -kHalf, kHalf}) -
             common_area(box, {-kHalfBar, kHalfBar, -kHalfBar, kHalfBar});
    case MarkerKind::Dot:
      return area_in_disk(box, kHalf);
    case MarkerKind::Ring:
      return area_in_disk(box, kHalf) - area_in_disk(box, kHoleRadius);
    case MarkerKind::Checker:
      return common_area(box, {-kHalf, 0.0, -kHalf, 0.0}) +
             common_area(box, {0.0, kHalf, 0.0, kHalf});
    case MarkerKind::ArUco:
    case MarkerKind::AprilTag:
      return ink_area_of_cells(box);
    case MarkerKind::Patch:
      break;
  }
  return 0.0;
}

double MarkerPattern::value(double x, double y) const {
  const double ax = std::abs(x);
  const double ay = std::abs(y);
  const double square = x * x + y * y;
  const auto paper = [](bool is_ink) { return is_ink ? 0.0 : 1.0; };
  switch (m_kind) {
    case MarkerKind::Cross:
      return paper(std::min(ax, ay) <= kHalfBar && std::max(ax, ay) <= kHalf);
    case MarkerKind::Dot:
      return paper(square <= kHalf * kHalf);
    case MarkerKind::Ring:
      return paper(square <= kHalf * kHalf && square >= kHoleRadius * kHoleRadius);
    case MarkerKind::Checker:
      return paper(std::max(ax, ay) <= kHalf && x * y > 0.0);
    case MarkerKind::ArUco:
    case MarkerKind::AprilTag: {
      if (!(std::max(ax, ay) < kHalf)) return 1.0;
      const auto cell = [this](double at) { return static_cast<int>((at + kHalf) * m_num_cells); };
      return paper(ink(cell(y), cell(x)));
    }
    case MarkerKind::Patch:
      break;
  }
  return 1.0;
}

double MarkerPattern::averaged(double x, double y, double width) const {
  if (!(width > 0.0)) return value(x, y);
  const double half = 0.5 * width;
  const double ink = ink_area({x - half, x + half, y - half, y + half});
  return std::clamp(1.0 - ink / (width * width), 0.0, 1.0);
}

double MarkerPattern::rotational_period_rad() const {
  switch (m_kind) {
    case MarkerKind::Dot:
    case MarkerKind::Ring:
      return 0.0;
    case MarkerKind::Cross:
      return kPi / 2.0;
    case MarkerKind::Checker:
      return kPi;
    case MarkerKind::ArUco:
    case MarkerKind::AprilTag:
    case MarkerKind::Patch:
      break;
  }
  return kTwoPi;
}

}  // namespace twang
