// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/align_marker.hpp"

#include <Eigen/Core>

#include <map>
#include <utility>
#include <vector>

namespace twang::detail {

/// Something in a picture that looks like a marker.
struct MarkerCandidate {
  MarkerPattern pattern;
  MarkerPlacement placement;
  double size_px = 0.0;  ///< outer size [px]
  double score = 0.0;    ///< correlation with the ideal picture [-]
};

/// A rectangle of pixels, half open.
struct SearchBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// Templates of moderate blur for any size, made when first asked for; sizes within a few per cent
/// share one.
class TemplateStore {
 public:
  [[nodiscard]] const MarkerTemplate& get(const MarkerPattern& pattern, double size_px);

 private:
  std::map<std::pair<MarkerPattern, int>, MarkerTemplate> m_templates;
};

/// Everything in `box` that looks like a marker of one of `patterns`: tags that can be read, and
/// dark blobs on a lighter surround at several scales, each aligned with the ideal picture and
/// judged by its score. Where several patterns fit one place, the best; nothing within a tag. A
/// patch has no ideal picture and is not found here.
[[nodiscard]] std::vector<MarkerCandidate> find_candidates(
    const LumaFrame& frame,
    const std::vector<MarkerPattern>& patterns,
    const SearchBox& box,
    TemplateStore& templates);

}  // namespace twang::detail
