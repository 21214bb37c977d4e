// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/doubled_frames.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace twang::detail {
namespace {

constexpr std::ptrdiff_t kManyPixels = 1 << 19;  // from here on a part of the rows says enough
constexpr int kRowStep = 4;
constexpr double kBlack = 4.0;    // below and
constexpr double kWhite = 251.0;  // above these the sensor's noise is cut off [grey levels]
constexpr int kMinBlocks = 16;    // not cut off, to speak of noise
constexpr int kShares = 64;       // steps of the share of unequal pixels
// A repeat coded anew errs by up to seven levels in its worst block; where a printed edge, 200
// levels high, moves by 0.6 px across a block, that changes by eight. [grey levels]
constexpr float kMotion = 8.0F;
constexpr float kMotionMost = 12.0F;  // where the coder speaks for a repeat
constexpr double kSpeaks = 0.5;       // odds from which it does, as a logarithm
// The light of one picture coded twice differs by up to two levels.
constexpr float kSameLight = 3.0F;
constexpr float kSteadyLight = 0.25F;  // mean change below which no lamp flickers [grey levels]
constexpr std::size_t kWindow = 24;    // frames on either side that say what noise is usual
constexpr std::size_t kMinWitnesses = 8;
constexpr double kUsual = 0.75;  // quantile: up to two frames of three may be repeats
constexpr double kAlive = 0.1;   // usual share of unequal pixels from which noise can be missed
// Where a coder takes most of it away, it takes more of some pictures than of others.
constexpr double kClear = 0.4;  // usual share from which a picture without it is a repeat
constexpr double kMissingShare =
    0.25;                         // of the usual share; repeats hardly ever reach a tenth of it
constexpr double kPresent = 0.5;  // of the usual share; other frames hardly ever stay below 0.6
constexpr std::size_t kLongestRun = 4;  // of frames without the noise that all are repeats
constexpr double kSome = 0.1;           // of the frames, that may lie between the two

using Shares = std::array<int, kShares + 1>;  // blocks by their share of unequal pixels

/// The share that half of the blocks stay below.
float median(const Shares& shares) {
  const int wanted = std::accumulate(shares.begin(), shares.end(), 0) / 2;
  int below = 0;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    below += shares[i];
    if (below > wanted) return static_cast<float>(i) / kShares;
  }
  return 0.0F;
}

/// What most frames show that are no repeats; 0 where there are too few to say.
double usual(std::vector<float> shares) {
  if (shares.size() < kMinWitnesses) return 0.0;
  const double rank = std::ceil(kUsual * static_cast<double>(shares.size() - 1));
  const auto at = shares.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(shares.begin(), at, shares.end());
  return *at;
}

/// Whether the noise on one side of a frame is the usual one, and each picture clearly has it or
/// clearly lacks it. A coder that keeps more or less of it leaves many between the two.
bool is_steady(const std::vector<float>& shares, double usual_share) {
  if (shares.size() < kMinWitnesses) return true;
  const double present = usual(shares);
  if (present < kPresent * usual_share) return false;
  const auto between = std::count_if(shares.begin(), shares.end(), [&](float share) {
    return share > kMissingShare * present && share < kPresent * present;
  });
  return static_cast<double>(between) <= kSome * static_cast<double>(shares.size());
}

}  // namespace

void DoubledFrames::add(const LumaFrame& frame) {
  const std::ptrdiff_t pixels = static_cast<std::ptrdiff_t>(frame.width_px) * frame.height_px;
  const int step = pixels >= kManyPixels ? kRowStep : 1;
  const int columns = frame.width_px / kBlock_px;
  const int rows = frame.height_px / kBlock_px;
  const int block_rows = kBlock_px / step;
  const double block_pixels = kBlock_px * block_rows;
  const bool first = m_changes.empty();
  m_before.resize(static_cast<std::size_t>(columns * rows * block_rows * kBlock_px));
  m_blocks.resize(static_cast<std::size_t>(columns));

  Change change;
  Shares all{};
  Shares grey{};  // where neither black nor white cuts the noise off
  double light = 0.0;
  std::uint8_t* before = m_before.data();
  for (int top = 0; top < rows; ++top) {
    const std::uint8_t* now = frame.pixels + top * kBlock_px * frame.stride;
    // The first picture stands before itself.
    if (first) compare_blocks(now, step * frame.stride, block_rows, before, m_blocks);
    compare_blocks(now, step * frame.stride, block_rows, before, m_blocks);
    before += columns * block_rows * kBlock_px;
    for (const BlockSums& block : m_blocks) {
      const double mean = block.light / block_pixels;
      const auto share = static_cast<std::size_t>(kShares * block.unequal / block_pixels);
      light += mean;
      change.largest = std::max(change.largest, static_cast<float>(block.change / block_pixels));
      ++all[share];
      if (mean > kBlack && mean < kWhite) ++grey[share];
    }
  }
  light /= std::max(1, rows * columns);
  change.brightness = first ? 0.0F : static_cast<float>(light - m_lights.back());
  change.unequal = median(std::accumulate(grey.begin(), grey.end(), 0) < kMinBlocks ? all : grey);
  m_lights.push_back(light);
  m_changes.push_back(change);
  m_coded.push_back({frame.coded_bytes, frame.coded_as, columns * rows});
}

/// Shares of unequal pixels of a frame's neighbours [first, end), where the light is steady.
std::vector<float> DoubledFrames::witnesses(std::size_t first,
                                            std::size_t end,
                                            std::size_t frame) const {
  std::vector<float> shares;
  for (std::size_t k = first; k < end; ++k) {
    const Change& change = m_changes[k];
    if (k != frame && std::abs(change.brightness) <= kSteadyLight) shares.push_back(change.unequal);
  }
  return shares;
}

DoubledFrames::Noise DoubledFrames::noise_around(std::size_t frame) const {
  const std::size_t first = std::max<std::size_t>(frame, kWindow + 1) - kWindow;
  const std::size_t end = std::min(frame + kWindow + 1, m_changes.size());
  Noise noise;
  noise.usual = usual(witnesses(first, end, frame));
  noise.steady = noise.usual >= kClear && is_steady(witnesses(first, frame, frame), noise.usual) &&
                 is_steady(witnesses(frame, end, frame), noise.usual);
  return noise;
}

std::vector<Likeness> DoubledFrames::decide() const {
  std::vector<Likeness> likeness(m_changes.size(), Likeness::Different);
  const std::vector<double> evidence = repeat_evidence(m_coded);
  for (std::size_t n = 1; n < m_changes.size(); ++n) {
    const Change& change = m_changes[n];
    if (change.largest > (evidence[n] > kSpeaks ? kMotionMost : kMotion)) continue;
    if (std::abs(change.brightness) > kSameLight) continue;
    const Noise noise = noise_around(n);
    if (noise.usual >= kAlive && change.unequal > kPresent * noise.usual) continue;
    const bool missing = noise.steady && change.unequal < kMissingShare * noise.usual;
    likeness[n] = missing ? Likeness::Same : Likeness::Alike;
  }
  // A film that freezes repeats itself to the last pixel; a coder that drops the noise for a while
  // does not.
  for (std::size_t begin = 0; begin < likeness.size();) {
    std::size_t end = begin;
    float unequal = 0.0F;
    while (end < likeness.size() && likeness[end] == Likeness::Same) {
      unequal = std::max(unequal, m_changes[end++].unequal);
    }
    if (end - begin > kLongestRun && unequal > 0.0F) {
      std::fill(likeness.begin() + static_cast<std::ptrdiff_t>(begin),
                likeness.begin() + static_cast<std::ptrdiff_t>(end),
                Likeness::Alike);
    }
    begin = end + 1;
  }
  return likeness;
}

}  // namespace twang::detail
