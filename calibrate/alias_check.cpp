// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/alias_check.hpp"

#include "calibrate/detail/ratio.hpp"
#include "core/constants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace twang {
namespace {

// A reported modulus and a printed part agree to about this factor of frequency.
constexpr double kExpected = 1.5;
// A mesh puts its overtones to this, relative.
constexpr double kSameFrequency = 0.03;
// The same for one overtone and one sinusoid, where chance must not pass for a reason.
constexpr double kFoldsOnto = 0.01;
constexpr int kTwins = 3;

/// rate - f, rate + f, 2 rate - f: what a camera of that rate cannot tell from f [Hz].
std::array<double, kTwins> twins_of(double frequency_hz, double rate_hz) {
  return {rate_hz - frequency_hz, rate_hz + frequency_hz, 2.0 * rate_hz - frequency_hz};
}

/// Number of the signal's further sinusoids that a mesh explains on which the strongest has such a
/// frequency.
int explained(const AliasQuestion& question, double strongest_hz) {
  const auto own = static_cast<std::size_t>(question.mode);
  int count = 0;
  for (std::size_t k = 1; k < question.modes.size(); ++k) {
    const double seen_hz = question.modes[k].natural_frequency_hz();
    for (std::size_t i = 0; i < question.mesh_hz.size(); ++i) {
      if (i == own) continue;
      const double true_hz = question.mesh_hz[i] * strongest_hz / question.mesh_hz[own];
      // Beyond a few turns of folding an overtone may be anywhere.
      if (true_hz > 2.0 * question.rate_hz) break;
      const double off = std::abs(folded_hz(true_hz, question.rate_hz) - seen_hz);
      if (off > kSameFrequency * true_hz) continue;
      ++count;
      break;
    }
  }
  return count;
}

void ask_for_strongest(const AliasQuestion& question, std::vector<std::string>& warnings) {
  const double f = question.modes.front().natural_frequency_hz();
  const auto twins = twins_of(f, question.rate_hz);
  if (question.expected_hz) {
    const double expected = *question.expected_hz;
    const double nearest = *std::min_element(twins.begin(), twins.end(), [&](double a, double b) {
      return ratio_of(a, expected) < ratio_of(b, expected);
    });
    if (ratio_of(nearest, expected) < kExpected &&
        ratio_of(nearest, expected) < ratio_of(f, expected)) {
      warnings.push_back(fmt::format(
          "The strongest sinusoid at {:.5g} Hz may be the alias of one at {:.5g} Hz, sampled at "
          "{:.5g} frames/s: with the reported modulus natural frequency {} is {:.4g} Hz.",
          f,
          nearest,
          question.rate_hz,
          question.mode + 1,
          expected));
      return;
    }
  }
  for (const double twin : twins) {
    if (explained(question, twin) <= explained(question, f)) continue;
    warnings.push_back(fmt::format(
        "The strongest sinusoid at {:.5g} Hz may be the alias of one at {:.5g} Hz, sampled at "
        "{:.5g} frames/s: the mesh's further natural frequencies then fall on more of what was "
        "found.",
        f,
        twin,
        question.rate_hz));
    return;
  }
}

}  // namespace

double folded_hz(double frequency_hz, double rate_hz) {
  return std::abs(frequency_hz - rate_hz * std::round(frequency_hz / rate_hz));
}

std::vector<std::string> alias_warnings(const AliasQuestion& question) {
  std::vector<std::string> warnings;
  if (question.modes.empty() || question.mesh_hz.empty()) return warnings;
  ask_for_strongest(question, warnings);
  for (const DampedSinusoid& mode : question.modes) {
    const double f = mode.natural_frequency_hz();
    for (std::size_t i = 1; i < question.mesh_hz.size(); ++i) {
      const double true_hz = question.mesh_hz[i];
      if (true_hz <= 0.5 * question.rate_hz || true_hz > 2.0 * question.rate_hz) continue;
      const double off = std::abs(folded_hz(true_hz, question.rate_hz) - f);
      if (off > std::max(kFoldsOnto * true_hz, mode.decay_per_s / kTwoPi)) continue;
      warnings.push_back(fmt::format(
          "The sinusoid at {:.5g} Hz may be the alias of the mesh's natural frequency {} at {:.5g} "
          "Hz, above half of {:.5g} frames/s.",
          f,
          i + 1,
          true_hz,
          question.rate_hz));
    }
  }
  return warnings;
}

}  // namespace twang
