// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/marker_pattern.hpp"

#include "capture/detail/tag_cells.hpp"
#include "core/constants.hpp"
#include "core/error.hpp"
#include "rigs/marker_dictionary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <random>
#include <vector>

namespace twang {

/// An axis-aligned rectangle.
struct MarkerPattern::Rectangle {
  double x0, x1, y0, y1;
};

namespace {

// Of the waves' mean: then a fiftieth of the texture is as dark or bright as can be.
constexpr double kTextureGain = 0.75;
constexpr double kHalf = 0.5;              // half the outer size
constexpr double kHalfBar = 1.0 / 6.0;     // half the width of a cross's bar
constexpr double kHoleRadius = 1.0 / 4.0;  // of a ring
constexpr std::size_t kBitsPerWord = 64;
// Of a patch's texture, waves a size: three cameras' pixels long or more from 16 pixels a size on.
constexpr double kCoarsestWave = 2.0;
constexpr double kFinestWave = 5.0;

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
      fmt::format("a marker of kind '{}' has no picture of its own, must be a cross, dot, "
                  "ring or checker",
                  to_string(kind)));
}

MarkerPattern::MarkerPattern(const Marker& marker) : m_kind(marker.kind) {
  if (m_kind == MarkerKind::Patch) draw_texture(marker.id);
  if (m_kind == MarkerKind::ArUco || m_kind == MarkerKind::AprilTag) take_cells(marker);
}

void MarkerPattern::take_cells(const Marker& marker) {
  const MarkerDictionary* dictionary = find_marker_dictionary(marker.kind, marker.dictionary);
  if (dictionary == nullptr) {
    throw InputError(fmt::format("marker '{}': dictionary is '{}', must be {}",
                                 marker.id,
                                 marker.dictionary,
                                 expected_marker_dictionary(marker.kind, marker.dictionary)));
  }
  if (marker.tag < 0 || marker.tag >= dictionary->num_tags) {
    throw InputError(fmt::format("marker '{}': tag is {}, must be 0 to {} in {}",
                                 marker.id,
                                 marker.tag,
                                 dictionary->num_tags - 1,
                                 dictionary->name));
  }
  const int side = dictionary->num_data_cells;
  m_num_cells = side + 2;
  m_correctable_cells = dictionary->correctable_cells;
  const std::vector<bool> data = detail::tag_cells(*dictionary, marker.tag);
  for (int row = 0; row < m_num_cells; ++row) {
    for (int column = 0; column < m_num_cells; ++column) {
      const bool inside = std::min(row, column) > 0 && std::max(row, column) <= side;
      if (!inside || data[static_cast<std::size_t>((row - 1) * side + column - 1)]) {
        set_ink(row, column);
      }
    }
  }
}

/// Waves of any phase, in directions spread over the half circle.
void MarkerPattern::draw_texture(const std::string& id) {
  std::seed_seq seed(id.begin(), id.end());
  std::mt19937 random(seed);
  // No distributions of the standard library: what they make of the numbers is not the same
  // everywhere.
  const auto uniform = [&random] { return static_cast<double>(random()) / 0x1p32; };
  for (std::size_t i = 0; i < kWaves; ++i) {
    const double direction = kPi * (static_cast<double>(i) + uniform()) / kWaves;
    const double frequency = kCoarsestWave + (kFinestWave - kCoarsestWave) * uniform();
    m_waves[i] = {
        frequency * std::cos(direction), frequency * std::sin(direction), kTwoPi * uniform()};
  }
}

/// Half a tone of grey and the waves, averaged over a square: each is dimmed by what a mean over a
/// length does to a wave.
double MarkerPattern::texture(double x, double y, double width) const {
  const auto dimming = [width](double frequency) {
    const double half = kPi * frequency * width;
    return std::abs(half) > 1e-6 ? std::sin(half) / half : 1.0;
  };
  double sum = 0.0;
  for (const Wave& wave : m_waves) {
    sum += std::cos(kTwoPi * (wave.u * x + wave.v * y) + wave.phase_rad) * dimming(wave.u) *
           dimming(wave.v);
  }
  return std::clamp(0.5 + kTextureGain * sum / kWaves, 0.0, 1.0);
}

bool MarkerPattern::ink(int row, int column) const {
  assert(row >= 0 && row < m_num_cells && column >= 0 && column < m_num_cells);
  const auto bit = static_cast<std::size_t>(row * m_num_cells + column);
  return (m_cells[bit / kBitsPerWord] >> (bit % kBitsPerWord) & 1U) != 0;
}

void MarkerPattern::set_ink(int row, int column) {
  const auto bit = static_cast<std::size_t>(row * m_num_cells + column);
  m_cells[bit / kBitsPerWord] |= std::uint64_t{1} << (bit % kBitsPerWord);
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
      break;  // has greys
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
      return texture(x, y, 0.0);
  }
  return 1.0;
}

double MarkerPattern::averaged(double x, double y, double width) const {
  if (!(width > 0.0)) return value(x, y);
  if (m_kind == MarkerKind::Patch) return texture(x, y, width);
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
