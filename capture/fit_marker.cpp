// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/fit_marker.hpp"

#include <Eigen/LU>

#include <array>
#include <cmath>
#include <optional>

namespace twang {
namespace {

constexpr double kFirstBlur_px = 0.7;
// Blurs tried, a third apart: the residual is flat to a fraction of that about its least.
constexpr std::array kBlurs_px = {0.0, 0.3, 0.45, 0.6, 0.8, 1.05, 1.4, 1.9, 2.5, 3.3};
// A blur beyond this part of the size leaves nothing of the pattern.
constexpr double kWidestBlur = 0.2;

}  // namespace

double placed_size_px(const MarkerPlacement& placement) {
  return std::sqrt(std::abs(placement.px_from_pattern.determinant()));
}

FittedMarker fit_marker(const LumaFrame& frame,
                        const MarkerPattern& pattern,
                        const MarkerPlacement& start,
                        double farthest_px) {
  AlignOptions options;
  options.fit_shape = true;
  options.farthest_px = farthest_px;
  FittedMarker fitted{MarkerTemplate(pattern, placed_size_px(start), kFirstBlur_px), {}};
  fitted.alignment = align_marker(frame, fitted.marker, start, options);
  if (!fitted.alignment.converged) return fitted;

  const double size_px = placed_size_px(fitted.alignment.placement);
  const MarkerTemplate sharp(pattern, size_px, 0.0);
  const MarkerPlacement first = fitted.alignment.placement;
  std::optional<FittedMarker> best;
  for (const double blur_px : kBlurs_px) {
    if (blur_px > kWidestBlur * size_px) break;
    FittedMarker tried{sharp.with_blur(blur_px), {}};
    tried.alignment = align_marker(frame, tried.marker, first, options);
    if (!tried.alignment.converged) continue;
    if (!best || tried.alignment.residual < best->alignment.residual) best = tried;
  }
  return best ? *best : fitted;
}

}  // namespace twang
