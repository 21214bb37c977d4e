// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/dark_regions.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace twang::detail {
namespace {

/// Marked pixels of a row, first .. end - 1.
struct Run {
  int first;
  int end;
  std::size_t region;
};

/// Extent and sums of what has been seen of a region; its pixels may be known by several numbers.
struct Sums {
  std::size_t joined_to;  // a smaller number or its own
  int left, top, right, bottom;
  long area = 0;
  double x = 0.0;
  double y = 0.0;

  void add(const Sums& other) {
    left = std::min(left, other.left);
    top = std::min(top, other.top);
    right = std::max(right, other.right);
    bottom = std::max(bottom, other.bottom);
    area += other.area;
    x += other.x;
    y += other.y;
  }
};

class RegionGatherer {
 public:
  RegionGatherer(const std::uint8_t* mask, std::ptrdiff_t stride, int width, int height)
      : m_width(width) {
    for (int y = 0; y < height; ++y) add_row(mask + y * stride, y);
  }

  [[nodiscard]] std::vector<DarkRegion> regions() const {
    std::vector<DarkRegion> regions;
    for (std::size_t i = 0; i < m_sums.size(); ++i) {
      const Sums& sums = m_sums[i];
      if (sums.joined_to != i) continue;
      const auto area = static_cast<double>(sums.area);
      regions.push_back({sums.left,
                         sums.top,
                         sums.right - sums.left + 1,
                         sums.bottom - sums.top + 1,
                         sums.area,
                         {sums.x / area, sums.y / area}});
    }
    return regions;
  }

 private:
  void add_row(const std::uint8_t* row, int y) {
    std::swap(m_above, m_runs);
    m_runs.clear();
    std::size_t above = 0;
    for (int x = 0; x < m_width;) {
      const void* marked = std::memchr(row + x, 255, static_cast<std::size_t>(m_width - x));
      if (!marked) break;
      const auto first = static_cast<int>(static_cast<const std::uint8_t*>(marked) - row);
      const void* plain = std::memchr(row + first, 0, static_cast<std::size_t>(m_width - first));
      x = plain ? static_cast<int>(static_cast<const std::uint8_t*>(plain) - row) : m_width;
      add_run(first, x, y, above);
    }
  }

  /// @param above  the first run above that may touch this one or one to the right of it
  void add_run(int first, int end, int y, std::size_t& above) {
    while (above < m_above.size() && m_above[above].end < first) ++above;
    std::size_t region = m_sums.size();
    for (std::size_t k = above; k < m_above.size() && m_above[k].first <= end; ++k) {
      const std::size_t touched = root(m_above[k].region);
      region = region == m_sums.size() ? touched : join(region, touched);
    }
    const long length = end - first;
    const auto pixels = static_cast<double>(length);
    Sums sums{region, first, y, end - 1, y, length, 0.5 * pixels * (first + end - 1), pixels * y};
    if (region == m_sums.size()) {
      m_sums.push_back(sums);
    } else {
      m_sums[region].add(sums);
    }
    m_runs.push_back({first, end, region});
  }

  std::size_t root(std::size_t region) {
    while (m_sums[region].joined_to != region) {
      region = m_sums[region].joined_to = m_sums[m_sums[region].joined_to].joined_to;
    }
    return region;
  }

  std::size_t join(std::size_t a, std::size_t b) {
    if (a == b) return a;
    if (b < a) std::swap(a, b);
    m_sums[a].add(m_sums[b]);
    m_sums[b].joined_to = a;
    return a;
  }

  int m_width;
  std::vector<Run> m_above;
  std::vector<Run> m_runs;
  std::vector<Sums> m_sums;
};

}  // namespace

std::vector<DarkRegion> dark_regions(const std::uint8_t* mask,
                                     std::ptrdiff_t stride,
                                     int width_px,
                                     int height_px) {
  return RegionGatherer(mask, stride, width_px, height_px).regions();
}

}  // namespace twang::detail
