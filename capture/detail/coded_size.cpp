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
constexpr double kHeaderOnly = 16.0;  // bytes of a picture of which all is as it was
constexpr double kTelling = 128.0;    // bytes from which differences are no accident
// With fewer bytes a block a coder leaves what moved by less than 0.4 px where it was.
constexpr double kStarved = 0.08;
constexpr double kCopies = -4.0;
// Nothing refers to a picture before one that is coded by itself: a coder leaves out of it what it
// can, up to a quarter of a pixel of motion.
constexpr double kNotReferredTo = -8.0;

/// Of the pictures around that `counts`; nan where these are few.
template <typename Counts>
double usual_bytes(const std::vector<CodedPicture>& pictures, std::size_t n, const Counts& counts) {
  std::vector<double> usual;
  const std::size_t end = std::min(n + kAround + 1, pictures.size());
  for (std::size_t k = std::max(n, kAround) - kAround; k < end; ++k) {
    if (k != n && pictures[k].bytes > 0 && counts(pictures[k])) {
      usual.push_back(static_cast<double>(pictures[k].bytes));
    }
  }
  if (usual.size() < kWitnesses) return kNaN;
  const auto middle = usual.begin() + static_cast<std::ptrdiff_t>(usual.size() / 2);
  std::nth_element(usual.begin(), middle, usual.end());
  return *middle;
}

struct Cost {
  double relative = kNaN;  // over the usual one, as a logarithm to the base two; nan if not known
  double usual = kNaN;     // [bytes]
};

Cost cost_of(const std::vector<CodedPicture>& pictures, std::size_t n) {
  if (pictures[n].bytes <= 0) return {};
  const double usual = usual_bytes(
      pictures, n, [&](const CodedPicture& other) { return other.as == pictures[n].as; });
  return {std::log2(static_cast<double>(pictures[n].bytes) / usual), usual};
}

/// How much a difference in cost says: nothing where pictures cost little more than their header.
double weight(double usual_bytes) {
  return std::clamp(
      std::log2(usual_bytes / kHeaderOnly) / std::log2(kTelling / kHeaderOnly), 0.0, 1.0);
}

}  // namespace

std::vector<double> repeat_evidence(const std::vector<CodedPicture>& pictures) {
  std::vector<double> evidence(pictures.size(), 0.0);
  Cost before;
  for (std::size_t n = 0; n < pictures.size(); ++n) {
    const Cost now = cost_of(pictures, n);
    const double odds = kOddsPerDoubling * (std::abs(now.relative - before.relative) - kUndecided);
    if (std::isfinite(odds)) {
      evidence[n] = weight(std::min(now.usual, before.usual)) * std::clamp(odds, kLeast, kMost);
    }
    const double of_all = usual_bytes(pictures, n, [](const CodedPicture&) { return true; });
    if (of_all < kStarved * pictures[n].blocks) evidence[n] += kCopies;
    if (n + 1 < pictures.size() && pictures[n + 1].as == 'I' && pictures[n].as != 'I') {
      evidence[n] = std::min(evidence[n], kNotReferredTo);
    }
    before = now;
  }
  return evidence;
}

}  // namespace twang::detail
