// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/find_tags.hpp"

#include <apriltag/apriltag.h>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <utility>

namespace twang::detail {
namespace {

constexpr double kEnlarged = 2.0;
// libapriltag compares with the mean of tiles of 4 x 4 pixels: smaller pictures have none.
constexpr int kSmallestPicture_px = 12;

/// Tags with equally many cells, as libapriltag wants a family described. It knows the tags that
/// are sought and no others, so that the dictionary's size costs nothing; as the number of cells
/// that may be wrong is less than half of what two tags of the dictionary differ by, another tag is
/// not taken for one of them.
class Family {
 public:
  explicit Family(int num_cells) {
    m_family.width_at_border = num_cells;
    m_family.total_width = num_cells + 2;  // with a cell of paper around
    m_family.reversed_border = false;
    lay_out(num_cells - 2);
    m_family.name = m_name;
  }
  Family(const Family&) = delete;
  Family& operator=(const Family&) = delete;
  ~Family() = default;

  void add(const MarkerPattern& pattern, std::size_t index) {
    std::uint64_t code = 0;
    for (std::size_t i = 0; i < m_columns.size(); ++i) {
      const bool ink = pattern.ink(static_cast<int>(m_rows[i]), static_cast<int>(m_columns[i]));
      code = code << 1U | (ink ? 0U : 1U);
    }
    m_codes.push_back(code);
    m_indices.push_back(index);
    m_family.codes = m_codes.data();
    m_family.ncodes = static_cast<std::uint32_t>(m_codes.size());
  }

  [[nodiscard]] apriltag_family_t* get() { return &m_family; }
  [[nodiscard]] std::size_t index(int id) const { return m_indices[static_cast<std::size_t>(id)]; }

 private:
  /// libapriltag turns a code by shifting it: its bits run through one quarter of the square, then
  /// through the same quarter turned by a right angle, and so on; the middle cell is the last.
  void lay_out(int side) {
    for (int quarter = 0; quarter < 4; ++quarter) {
      for (int row = 0; row < side / 2; ++row) {
        for (int column = row; column < side - 1 - row; ++column) {
          std::pair<int, int> at(column, row);
          for (int turn = 0; turn < quarter; ++turn) at = {side - 1 - at.second, at.first};
          append(at.first, at.second);
        }
      }
    }
    if (side % 2 == 1) append(side / 2, side / 2);
    m_family.nbits = static_cast<std::uint32_t>(m_columns.size());
    m_family.bit_x = m_columns.data();
    m_family.bit_y = m_rows.data();
  }

  /// A cell of the square within the border.
  void append(int column, int row) {
    m_columns.push_back(static_cast<std::uint32_t>(column + 1));
    m_rows.push_back(static_cast<std::uint32_t>(row + 1));
  }

  char m_name[5] = "tags";
  apriltag_family_t m_family{};
  std::vector<std::uint32_t> m_columns, m_rows;  // of the code's bits, the first the highest
  std::vector<std::uint64_t> m_codes;
  std::vector<std::size_t> m_indices;
};

/// The placement that a detection's map from the square [-1, 1]² says, about its middle. A picture
/// enlarged by `scale` was searched. libapriltag has the upper left *corner* of a picture at (0,
/// 0).
MarkerPlacement placement_of(const apriltag_detection_t& detection, double scale) {
  Eigen::Matrix3d H;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      H(i, j) =
          detection.H
              ->data[static_cast<unsigned>(i) * detection.H->ncols + static_cast<unsigned>(j)];
    }
  }
  const double w = H(2, 2);
  const Eigen::Vector2d middle = H.topRightCorner<2, 1>() / w;
  const Eigen::Matrix2d slopes =
      (H.topLeftCorner<2, 2>() - middle * H.bottomLeftCorner<1, 2>()) / w;
  MarkerPlacement placement;
  placement.position_px = middle / scale - Eigen::Vector2d::Constant(0.5);
  placement.px_from_pattern = 2.0 / scale * slopes;
  return placement;
}

struct DetectionDeleter {
  void operator()(zarray_t* detections) const { apriltag_detections_destroy(detections); }
};

std::vector<FoundTag> detect(const cv::Mat& grey,
                             double scale,
                             const std::vector<MarkerPattern>& patterns,
                             const std::vector<std::size_t>& wanted) {
  // By cells a side and cells that may be wrong. Families are named by the detections: they must
  // stay where they are and outlive the detector.
  std::map<std::pair<int, int>, Family> families;
  for (const std::size_t i : wanted) {
    const MarkerPattern& pattern = patterns[i];
    families.try_emplace({pattern.num_cells(), pattern.correctable_cells()}, pattern.num_cells())
        .first->second.add(pattern, i);
  }
  const std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)> detector(
      apriltag_detector_create(), apriltag_detector_destroy);
  detector->nthreads = 1;
  detector->quad_decimate = 1.0F;
  for (auto& [key, family] : families) {
    apriltag_detector_add_family_bits(detector.get(), family.get(), key.second);
  }
  image_u8_t image{grey.cols, grey.rows, static_cast<std::int32_t>(grey.step), grey.data};
  const std::unique_ptr<zarray_t, DetectionDeleter> detections(
      apriltag_detector_detect(detector.get(), &image));
  std::vector<FoundTag> found;
  for (int i = 0; i < zarray_size(detections.get()); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(detections.get(), i, &detection);
    for (const auto& [key, family] : families) {
      if (const_cast<Family&>(family).get() != detection->family) continue;
      found.push_back({family.index(detection->id), placement_of(*detection, scale)});
    }
  }
  return found;
}

}  // namespace

std::vector<FoundTag> find_tags(const LumaFrame& frame,
                                const std::vector<MarkerPattern>& patterns) {
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < patterns.size(); ++i) {
    if (patterns[i].num_cells() > 0) missing.push_back(i);
  }
  std::vector<FoundTag> found;
  if (missing.empty() || std::min(frame.width_px, frame.height_px) < kSmallestPicture_px) {
    return found;
  }
  // OpenCV's header takes what it only reads as writable.
  auto* first = const_cast<std::uint8_t*>(frame.pixels);
  const cv::Mat grey(
      frame.height_px, frame.width_px, CV_8UC1, first, static_cast<std::size_t>(frame.stride));
  for (const double scale : {1.0, kEnlarged}) {
    cv::Mat searched = grey;
    if (scale > 1.0) cv::resize(grey, searched, {}, scale, scale, cv::INTER_CUBIC);
    const auto more = detect(searched, scale, patterns, missing);
    found.insert(found.end(), more.begin(), more.end());
    for (const FoundTag& tag : more) std::erase(missing, tag.pattern);
    if (missing.empty()) break;
  }
  return found;
}

}  // namespace twang::detail
