// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/marker_candidates.hpp"

#include "capture/detail/dark_regions.hpp"
#include "capture/detail/find_tags.hpp"
#include "capture/detail/in_parallel.hpp"
#include "capture/fit_marker.hpp"
#include "core/constants.hpp"
#include "core/units.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace twang::detail {
namespace {

constexpr double kTemplateBlur_px = 0.7;
constexpr double kSizeStep = 1.15;  // ratio of neighbouring sizes in the store
// Side of the square whose mean a pixel is compared with; a marker is found at a few of them.
const std::vector<int> kSmallWindows_px = {15, 31};
const std::vector<int> kLargeWindows_px = {63, 127, 255, 511};
// The picture is made smaller for larger windows, until they are of about this size; the smallest
// blob of interest keeps the same number of pixels.
constexpr int kPlainWindow_px = 63;
constexpr double kLeastDarker = 12.0;  // than that mean, beyond noise and shading [grey levels]
constexpr int kSmallestBlob_px = 5;
constexpr double kLargestBlob = 0.9;  // in windows: beyond, the mean is the blob's own
constexpr double kSmallestBlob = 0.12;
constexpr double kLargestAspect = 1.9;
constexpr double kLeastScore = 0.7;
constexpr double kLeastContrast = 15.0;  // [grey levels]
constexpr double kLargestSlant = 1.7;    // ratio of the longer to the shorter axis
constexpr double kLargestMisfit = 1.7;   // fitted over guessed size, either way
constexpr double kSamePlace = 0.35;      // in sizes
constexpr double kGoodScore = 0.93;      // further turns are not tried

/// A dark region and what its outline says.
struct Blob {
  Eigen::Vector2d centre_px;
  double width_px, height_px, area_px;
  [[nodiscard]] double fill() const { return area_px / (width_px * height_px); }
  [[nodiscard]] double extent() const { return std::max(width_px, height_px); }
};

/// A marker that a blob might be.
struct Guess {
  Eigen::Vector2d centre_px;
  double size_px;
};

/// The picture at a part of its size.
cv::Mat shrunk(const cv::Mat& grey, int by) {
  if (by == 1) return grey;
  const int columns = grey.cols / by;
  const int rows = grey.rows / by;
  cv::Mat small;
  cv::resize(grey(cv::Rect(0, 0, by * columns, by * rows)),
             small,
             {columns, rows},
             0.0,
             0.0,
             cv::INTER_AREA);
  return small;
}

std::vector<Blob> find_blobs(const cv::Mat& grey, const SearchBox& box, int window_px) {
  const int by = std::max(1, (window_px + 1) / (kPlainWindow_px + 1));
  const cv::Mat picture = shrunk(grey, by);
  const int window = (window_px + 1) / by - 1;  // odd
  cv::Mat dark;
  cv::adaptiveThreshold(
      picture, dark, 255, cv::ADAPTIVE_THRESH_MEAN_C, cv::THRESH_BINARY_INV, window, kLeastDarker);
  std::vector<Blob> blobs;
  for (const DarkRegion& region :
       dark_regions(dark.data, static_cast<std::ptrdiff_t>(dark.step[0]), dark.cols, dark.rows)) {
    const int w = region.width_px;
    const int h = region.height_px;
    const int extent = std::max(w, h);
    const bool at_edge = region.left == 0 || region.top == 0 || region.left + w == picture.cols ||
                         region.top + h == picture.rows;
    if (at_edge || std::min(w, h) < kSmallestBlob_px || extent > kLargestAspect * std::min(w, h) ||
        extent > kLargestBlob * window || extent < kSmallestBlob * window) {
      continue;
    }
    const auto centre = [&](int axis) { return by * (region.centre_px[axis] + 0.5) - 0.5; };
    blobs.push_back({{centre(0) + box.x0, centre(1) + box.y0},
                     static_cast<double>(by * w),
                     static_cast<double>(by * h),
                     static_cast<double>(by * by * region.area_px)});
  }
  return blobs;
}

/// Markers of a kind that a blob's area and outline allow; the area of each kind's ink follows from
/// its definition.
std::vector<Guess> guesses(const MarkerPattern& pattern, const Blob& blob) {
  const double fill = blob.fill();
  const auto within = [fill](double low, double high) { return fill > low && fill < high; };
  switch (pattern.kind()) {
    case MarkerKind::Dot:
      if (within(0.62, 0.92)) return {{blob.centre_px, std::sqrt(4.0 / kPi * blob.area_px)}};
      break;
    case MarkerKind::Cross:  // 5/9 of its square; upright its arms reach the outline, turned not
      if (within(0.3, 0.75)) return {{blob.centre_px, std::sqrt(1.8 * blob.area_px)}};
      break;
    case MarkerKind::Ring:  // the hole may have closed
      if (within(0.4, 0.9)) return {{blob.centre_px, blob.extent()}};
      break;
    case MarkerKind::Checker: {
      if (within(0.35, 0.68)) return {{blob.centre_px, std::sqrt(2.0 * blob.area_px)}};
      if (!within(0.68, 1.01)) break;
      // One quadrant alone: the marker's centre is its lower right or upper left corner.
      const Eigen::Vector2d half(0.5 * blob.width_px, 0.5 * blob.height_px);
      const double size = 2.0 * std::sqrt(blob.area_px);
      return {{blob.centre_px + half, size}, {blob.centre_px - half, size}};
    }
    default:
      break;
  }
  return {};
}

bool plausible(const MarkerAlignment& found, const Guess& guess) {
  if (!found.converged || found.score < kLeastScore || found.contrast < kLeastContrast) {
    return false;
  }
  const Eigen::Vector2d axes =
      Eigen::JacobiSVD<Eigen::Matrix2d>(found.placement.px_from_pattern).singularValues();
  const double ratio = placed_size_px(found.placement) / guess.size_px;
  return axes[0] < kLargestSlant * axes[1] && ratio < kLargestMisfit &&
         ratio > 1.0 / kLargestMisfit;
}

/// Aligns from a few turns and keeps the best.
std::optional<MarkerCandidate> align_guess(const LumaFrame& frame,
                                           const MarkerPattern& pattern,
                                           const Guess& guess,
                                           TemplateStore& templates) {
  const MarkerTemplate& marker = templates.get(pattern, guess.size_px);
  AlignOptions options;
  options.fit_shape = true;
  options.farthest_px = 0.5 * guess.size_px + 1.0;
  std::optional<MarkerCandidate> best;
  for (const double turn_deg : {0.0, -16.0, 16.0}) {
    const MarkerAlignment found =
        align_marker(frame,
                     marker,
                     upright_marker(guess.centre_px, guess.size_px, turn_deg * kRadiansPerDegree),
                     options);
    if (plausible(found, guess) && (!best || found.score > best->score)) {
      best = {pattern, found.placement, placed_size_px(found.placement), found.score};
    }
    if (!marker.has_turn() || (best && best->score > kGoodScore)) break;
  }
  return best;
}

/// Tags, aligned from where they were read.
std::vector<MarkerCandidate> tag_candidates(const LumaFrame& frame,
                                            const std::vector<MarkerPattern>& patterns,
                                            const SearchBox& box,
                                            TemplateStore& templates) {
  LumaFrame part = frame;
  part.pixels += box.y0 * frame.stride + box.x0;
  part.width_px = box.x1 - box.x0;
  part.height_px = box.y1 - box.y0;
  std::vector<MarkerCandidate> candidates;
  for (const FoundTag& tag : find_tags(part, patterns)) {
    MarkerPlacement start = tag.placement;
    start.position_px += Eigen::Vector2d(box.x0, box.y0);
    const Guess guess{start.position_px, placed_size_px(start)};
    const MarkerPattern& pattern = patterns[tag.pattern];
    AlignOptions options;
    options.fit_shape = true;
    options.farthest_px = 0.5 * guess.size_px;
    const MarkerAlignment aligned =
        align_marker(frame, templates.get(pattern, guess.size_px), start, options);
    if (!plausible(aligned, guess)) continue;
    candidates.push_back(
        {pattern, aligned.placement, placed_size_px(aligned.placement), aligned.score});
  }
  return candidates;
}

bool lies_within(const Eigen::Vector2d& px, const MarkerCandidate& tag) {
  const Eigen::Vector2d offset = px - tag.placement.position_px;
  return (tag.placement.px_from_pattern.inverse() * offset).cwiseAbs().maxCoeff() < 0.5;
}

bool same_place(const MarkerCandidate& a, const MarkerCandidate& b) {
  return (a.placement.position_px - b.placement.position_px).norm() <
         kSamePlace * std::max(a.size_px, b.size_px);
}

}  // namespace

const MarkerTemplate& TemplateStore::get(const MarkerPattern& pattern, double size_px) {
  const int step = static_cast<int>(std::lround(std::log(size_px) / std::log(kSizeStep)));
  const auto key = std::pair(pattern, step);
  auto place = m_templates.find(key);
  if (place == m_templates.end()) {
    place = m_templates
                .emplace(key, MarkerTemplate(pattern, std::pow(kSizeStep, step), kTemplateBlur_px))
                .first;
  }
  return place->second;
}

CandidateSearch::CandidateSearch(const LumaFrame& frame,
                                 std::vector<MarkerPattern> patterns,
                                 const SearchBox& box,
                                 TemplateStore& templates)
    : m_frame(frame), m_patterns(std::move(patterns)), m_box(box), m_templates(templates) {}

void CandidateSearch::look_for_large() {
  m_tags = tag_candidates(m_frame, m_patterns, m_box, m_templates);
  look_at_windows(kLargeWindows_px);
}

void CandidateSearch::look_for_small() { look_at_windows(kSmallWindows_px); }

bool CandidateSearch::in_a_tag(const Eigen::Vector2d& px) const {
  return std::any_of(
      m_tags.begin(), m_tags.end(), [&](const auto& tag) { return lies_within(px, tag); });
}

/// At each window that the picture has room for.
void CandidateSearch::look_at_windows(const std::vector<int>& windows_px) {
  const int width = m_box.x1 - m_box.x0;
  const int height = m_box.y1 - m_box.y0;
  if (width < 2 * kSmallestBlob_px || height < 2 * kSmallestBlob_px) return;
  // OpenCV's header takes what it only reads as writable.
  auto* first = const_cast<std::uint8_t*>(m_frame.pixels + m_box.y0 * m_frame.stride + m_box.x0);
  const cv::Mat grey(height, width, CV_8UC1, first, static_cast<std::size_t>(m_frame.stride));
  std::vector<std::vector<Blob>> blobs(windows_px.size());
  for_each_in_parallel(windows_px.size(), [&](std::size_t i) {
    if (windows_px[i] <= 2 * std::min(width, height)) {
      blobs[i] = find_blobs(grey, m_box, windows_px[i]);
    }
  });
  for (const std::vector<Blob>& at_window : blobs) {
    for (const Blob& blob : at_window) {
      if (in_a_tag(blob.centre_px)) continue;
      for (const MarkerPattern& pattern : m_patterns) {
        for (const Guess& guess : guesses(pattern, blob)) {
          const bool known = std::any_of(m_found.begin(), m_found.end(), [&](const auto& other) {
            return other.pattern == pattern && other.score > kGoodScore &&
                   (other.placement.position_px - guess.centre_px).norm() <
                       0.25 * kSamePlace * other.size_px;
          });
          if (known) continue;
          if (auto candidate = align_guess(m_frame, pattern, guess, m_templates)) {
            m_found.push_back(*candidate);
          }
        }
      }
    }
  }
}

std::vector<MarkerCandidate> CandidateSearch::found() const {
  std::vector<MarkerCandidate> found = m_found;
  std::erase_if(found, [&](const auto& other) { return in_a_tag(other.placement.position_px); });
  found.insert(found.end(), m_tags.begin(), m_tags.end());
  std::stable_sort(
      found.begin(), found.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
  std::vector<MarkerCandidate> best;
  for (const MarkerCandidate& candidate : found) {
    const bool taken = std::any_of(
        best.begin(), best.end(), [&](const auto& other) { return same_place(candidate, other); });
    if (!taken) best.push_back(candidate);
  }
  return best;
}

std::vector<MarkerCandidate> find_candidates(const LumaFrame& frame,
                                             const std::vector<MarkerPattern>& patterns,
                                             const SearchBox& box,
                                             TemplateStore& templates) {
  CandidateSearch search(frame, patterns, box, templates);
  search.look_for_large();
  search.look_for_small();
  return search.found();
}

}  // namespace twang::detail
