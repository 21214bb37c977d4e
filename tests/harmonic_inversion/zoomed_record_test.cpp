// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/zoomed_record.hpp"

#include "core/constants.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace twang {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::VectorXd;

constexpr Index kLongRecord = 9001;  // no multiple of the blocks
constexpr double kStart = 0.25;
constexpr double kStep = 1.0 / 500.0;

VectorXd noisy_values() {
  VectorXd out(kLongRecord);
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  for (Index i = 0; i < kLongRecord; ++i) {
    const double t = kStart + static_cast<double>(i) * kStep;
    out(i) = std::exp(-0.2 * t) * std::cos(kTwoPi * 61.0 * t) + 0.1 * normal(generator);
  }
  return out;
}

const std::vector<Index> kExcluded = {0, 140, 9000};

void expect_all_samples(const ZoomedRecord& record, const VectorXd& values, Complex s) {
  Complex plain;
  Complex timed;
  double size = 0.0;  // of the terms, by which round-off is measured
  for (Index i = 0; i < kLongRecord; ++i) {
    if (std::find(kExcluded.begin(), kExcluded.end(), i) != kExcluded.end()) continue;
    const double t = kStart + static_cast<double>(i) * kStep;
    plain += values(i) * std::exp(s * t);
    timed += t * values(i) * std::exp(s * t);
    size += std::abs(values(i) * std::exp(s * t));
  }
  const ZoomedRecord::Sums sums = record.at(s);
  // Phases of thousands of turns, with sixteen digits, in the sum as in the moments.
  EXPECT_LT(std::abs(sums.plain - plain), 1e-12 * size) << s;
  EXPECT_LT(std::abs(sums.timed - timed), 1e-12 * size * kStep * kLongRecord) << s;
}

TEST(ZoomedRecord, HasTheSumsOfAllSamplesNearAndFar) {
  const VectorXd values = noisy_values();
  const ZoomedRecord record(values, kStart, kStep, kExcluded);
  const Complex centre(-0.2, kTwoPi * 61.0);
  expect_all_samples(record, values, centre);
  // Across the cell about it, whose radius is half over half a block's 0.14 s, and beyond.
  for (const double radius : {0.01, 1.0, 3.5, 20.0}) {
    for (const double turn : {0.0, 0.25, 0.6}) {
      expect_all_samples(record, values, centre + std::polar(radius, kTwoPi * turn));
    }
  }
}

TEST(ZoomedRecord, SumsUpWhatGrowsAndWhatIsSoonGone) {
  const VectorXd values = noisy_values();
  const ZoomedRecord record(values, kStart, kStep, kExcluded);
  for (const double decay : {-0.5, 0.0, 3.0, 40.0, 60.0, 300.0}) {
    expect_all_samples(record, values, {-decay, kTwoPi * 33.0});
  }
}

}  // namespace
}  // namespace twang
