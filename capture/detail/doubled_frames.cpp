// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/doubled_frames.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace twang::detail {
namespace {

// A marker stands if it moved by less than so many sigmas, and should have moved if the frames
// around put it farther away than so many.
constexpr double kStandsSigmas = 2.0;
constexpr double kMovesSigmas = 6.0;
constexpr int kBlock_px = 16;
// Neighbours on either side that a frame is compared with: more than a film repeats in a row.
constexpr std::size_t kNeighbours = 6;
constexpr double kHardly = 0.1;         // of the neighbours' change
constexpr double kClearly = 0.2;        // of the neighbours' change: something moved
constexpr double kMotion = 6.0;         // change of a block that shows motion [grey levels]
constexpr double kNoNoise = 0.5;        // of the film's usual noise
constexpr double kVisibleNoise = 0.15;  // mean change that noise must reach to be missed: below,
                                        // compression has taken it away [grey levels]

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void DoubledFrames::add(const LumaFrame& frame) {
  const std::size_t size =
      static_cast<std::size_t>(frame.width_px) * static_cast<std::size_t>(frame.height_px);
  const bool first = m_before.size() != size;
  m_before.resize(size);
  const int columns = (frame.width_px + kBlock_px - 1) / kBlock_px;
  std::vector<double> changes;
  std::vector<unsigned> row_of_blocks(static_cast<std::size_t>(columns));
  for (int top = 0; top < frame.height_px; top += kBlock_px) {
    const int bottom = std::min(top + kBlock_px, frame.height_px);
    std::fill(row_of_blocks.begin(), row_of_blocks.end(), 0U);
    for (int y = top; y < bottom; ++y) {
      const std::uint8_t* now = frame.pixels + y * frame.stride;
      std::uint8_t* before = m_before.data() + static_cast<std::ptrdiff_t>(y) * frame.width_px;
      for (int block = 0; !first && block < columns; ++block) {
        unsigned sum = 0;
        const int end = std::min((block + 1) * kBlock_px, frame.width_px);
        for (int x = block * kBlock_px; x < end; ++x) {
          sum += static_cast<unsigned>(std::abs(now[x] - before[x]));
        }
        row_of_blocks[static_cast<std::size_t>(block)] += sum;
      }
      std::memcpy(before, now, static_cast<std::size_t>(frame.width_px));
    }
    for (int block = 0; block < columns; ++block) {
      const int width = std::min((block + 1) * kBlock_px, frame.width_px) - block * kBlock_px;
      changes.push_back(row_of_blocks[static_cast<std::size_t>(block)] /
                        static_cast<double>(width * (bottom - top)));
    }
  }
  m_largest.push_back(*std::max_element(changes.begin(), changes.end()));
  m_typical.push_back(median(std::move(changes)));
}

DoubledFrames::Verdict DoubledFrames::decide() const {
  const std::size_t n = m_largest.size();
  std::vector<bool> doubled(n, false);
  std::vector<bool> changed(n, true);
  if (n < 3) return {doubled, changed};
  const double noise = median({m_typical.begin() + 1, m_typical.end()});
  const auto largest_in = [&](std::size_t first, std::size_t last) {
    double largest = 0.0;
    for (std::size_t k = std::max<std::size_t>(first, 1); k < std::min(last, n); ++k) {
      largest = std::max(largest, m_largest[k]);
    }
    return largest;
  };
  for (std::size_t i = 1; i < n; ++i) {
    const double moving = std::min(largest_in(i > kNeighbours ? i - kNeighbours : 1, i),
                                   largest_in(i + 1, i + 1 + kNeighbours));
    const bool stands = moving > kMotion && m_largest[i] < kHardly * moving;
    const bool silent = noise < kVisibleNoise || m_typical[i] < kNoNoise * noise;
    doubled[i] = stands && silent;
    changed[i] = m_largest[i] > kClearly * moving && m_largest[i] > kMotion;
  }
  return {doubled, changed};
}

std::vector<int> stands_against_motion(const std::vector<Eigen::Vector2d>& position_px,
                                       const std::vector<double>& sigma_px) {
  const std::size_t n = position_px.size();
  std::vector<int> verdict(n, 0);
  for (std::size_t i = 2; i + 2 < n; ++i) {
    const auto& p = position_px;
    // The cubic through the four neighbours.
    const Eigen::Vector2d expected = (4.0 * (p[i - 1] + p[i + 1]) - p[i - 2] - p[i + 2]) / 6.0;
    if (!expected.allFinite() || !p[i].allFinite()) continue;
    const double step = (p[i] - p[i - 1]).norm();
    // Before a release nothing should have moved.
    const bool moved_before = (p[i - 1] - p[i - 2]).norm() > kStandsSigmas * sigma_px[i];
    if (step > kMovesSigmas * sigma_px[i]) {
      verdict[i] = -1;
    } else if (moved_before && step < kStandsSigmas * sigma_px[i] &&
               (p[i] - expected).norm() > kMovesSigmas * sigma_px[i]) {
      verdict[i] = 1;
    }
  }
  return verdict;
}

}  // namespace twang::detail
