// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/align_marker.hpp"

#include <cstddef>
#include <memory>
#include <vector>

namespace twang {
namespace detail {
class MarkerDrawing;
}

/// A marker's template and placement, as fitted to one picture.
struct FittedMarker {
  MarkerTemplate marker;
  MarkerAlignment alignment;
};

/// Fits the markers of one picture, one after the other: what is done once, in the first frame, so
/// that later frames have a fixed reference. Markers of one kind and size share their drawings, and
/// the search for a marker's blur starts at that of the one before.
class MarkerFitter {
 public:
  explicit MarkerFitter(const LumaFrame& frame);
  ~MarkerFitter();
  MarkerFitter(const MarkerFitter&) = delete;
  MarkerFitter& operator=(const MarkerFitter&) = delete;

  /// Aligns a marker with size and slant free and chooses the blur that explains the picture best.
  /// @param start        rough placement, size within a third of the truth
  /// @param farthest_px  gives up farther than this from the start [px]
  /// @return             `alignment.converged` says whether there was a marker to fit
  [[nodiscard]] FittedMarker fit(const MarkerPattern& pattern,
                                 const MarkerPlacement& start,
                                 double farthest_px);

 private:
  [[nodiscard]] detail::MarkerDrawing& drawing(const MarkerPattern& pattern, double size_px);

  const LumaFrame& m_frame;
  std::vector<std::unique_ptr<detail::MarkerDrawing>> m_drawings;
  std::size_t m_first_blur;  // of the blurs tried
};

/// One marker alone.
[[nodiscard]] FittedMarker fit_marker(const LumaFrame& frame,
                                      const MarkerPattern& pattern,
                                      const MarkerPlacement& start,
                                      double farthest_px);

/// Size of a marker that lies so: the square root of its outer square's area [px].
[[nodiscard]] double placed_size_px(const MarkerPlacement& placement);

}  // namespace twang
