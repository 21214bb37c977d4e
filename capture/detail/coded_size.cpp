// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/coded_size.hpp"

#include "core/constants.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace twang::detail {
namespace {

constexpr std::size_t kAround = 24;    // frames on either side that say what is usual
constexpr std::size_t kWitnesses = 5;  // of the same type, at least
// Doublings between the costs of two pictures, over what is usual for their types: of films at a
// rate factor of 18 to 27, repeats show 0.6 to 5, nine of ten others less than 0.6, all under 1.7.
constexpr double kUndecided = 0.7;
constexpr double kOddsPerDoubling = 4.0;
constexpr double kLeast = -3.0;
constexpr double kMost = 5.0;

/// Logarithm to the base two of a picture's cost over the usual one; nan if not known.
double relative_cost(const std::vector<CodedPicture>& pictures, std::size_t n) {
  if (pictures[n].bytes <= 0) return kNaN;
  std::vector<double> usual;
  const std::size_t end = std::min(n + kAround + 1, pictures.size());
  for (std::size_t k = std::max(n, kAround) - kAround; k < end; ++k) {
    const CodedPicture& other = pictures[k];
    if (k != n && other.as == pictures[n].as && other.bytes > 0) {
      usual.push_back(static_cast<double>(other.bytes));
    }
  }
  if (usual.size() < kWitnesses) return kNaN;
  const auto middle = usual.begin() + static_cast<std::ptrdiff_t>(usual.size() / 2);
  std::nth_element(usual.begin(), middle, usual.end());
  return std::log2(static_cast<double>(pictures[n].bytes) / *middle);
}

}  // namespace

std::vector<double> repeat_evidence(const std::vector<CodedPicture>& pictures) {
  std::vector<double> evidence(pictures.size(), 0.0);
  double before = kNaN;
  for (std::size_t n = 0; n < pictures.size(); ++n) {
    const double now = relative_cost(pictures, n);
    const double odds = kOddsPerDoubling * (std::abs(now - before) - kUndecided);
    if (std::isfinite(odds)) evidence[n] = std::clamp(odds, kLeast, kMost);
    before = now;
  }
  return evidence;
}

}  // namespace twang::detail
