// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/invert_harmonics.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace twang {

inline constexpr double kRate_hz = 240.0;  // of a film

/// The mode of the nearest frequency; null if there is none.
inline const DampedSinusoid* nearest(const InversionResult& result, double frequency_hz) {
  const auto it =
      std::min_element(result.modes.begin(), result.modes.end(), [&](const auto& a, const auto& b) {
        return std::abs(a.frequency_hz - frequency_hz) < std::abs(b.frequency_hz - frequency_hz);
      });
  return it == result.modes.end() ? nullptr : &*it;
}

/// What was found and what was not, for the message of a failed test.
inline std::string listing(const InversionResult& result) {
  std::string out = result.message + "\n" + result.method + "\n";
  for (const auto& m : result.modes) {
    out += "  mode " + std::to_string(m.frequency_hz) + " Hz " + std::to_string(m.decay_per_s) +
           " 1/s\n";
  }
  for (const auto& m : result.rejected) {
    out += "  rejected " + std::to_string(m.frequency_hz) + " Hz: " + m.reason + "\n";
  }
  return out;
}

}  // namespace twang
