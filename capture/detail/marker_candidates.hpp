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

/// Looks for everything in `box` that looks like a marker of one of `patterns`: tags that can be
/// read, and dark blobs on a lighter surround at several scales, each aligned with the ideal
/// picture and judged by its score. A patch has no ideal picture and is not found here.
class CandidateSearch {
 public:
  CandidateSearch(const LumaFrame& frame,
                  std::vector<MarkerPattern> patterns,
                  const SearchBox& box,
                  TemplateStore& templates);

  /// Tags, and blobs of about 8 px and more: a third of the time that all take.
  void look_for_large();
  /// Blobs of 5 to about 28 px.
  void look_for_small();
  /// What was found, best first. Where several patterns fit one place, the best; nothing within a
  /// tag.
  [[nodiscard]] std::vector<MarkerCandidate> found() const;

 private:
  void look_at_windows(const std::vector<int>& windows_px);
  [[nodiscard]] bool in_a_tag(const Eigen::Vector2d& px) const;

  const LumaFrame& m_frame;
  std::vector<MarkerPattern> m_patterns;
  SearchBox m_box;
  TemplateStore& m_templates;
  std::vector<MarkerCandidate> m_tags;
  std::vector<MarkerCandidate> m_found;
};

/// Both.
[[nodiscard]] std::vector<MarkerCandidate> find_candidates(
    const LumaFrame& frame,
    const std::vector<MarkerPattern>& patterns,
    const SearchBox& box,
    TemplateStore& templates);

}  // namespace twang::detail
