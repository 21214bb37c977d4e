// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/fit_marker.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace twang {
namespace {

constexpr double kFirstBlur_px = 0.7;
// Blurs tried, a third apart; about the least residual a parabola tells more.
constexpr std::array kBlurs_px = {0.0, 0.3, 0.45, 0.6, 0.8, 1.05, 1.4, 1.9, 2.5, 3.3};
// A blur beyond this part of the size leaves nothing of the pattern.
constexpr double kWidestBlur = 0.2;
// Mean square residual over the least, from which wider blurs are not tried.
constexpr double kFarBehind = 3.0;

/// A blur and the mean square residual it leaves.
struct Trial {
  double blur_px, square;
};

/// Where the parabola through the least of the trials and its neighbours is least.
std::optional<double> least_between(const std::vector<Trial>& trials) {
  const auto least =
      std::min_element(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) {
        return a.square < b.square;
      });
  if (trials.size() < 3 || least == trials.begin() || least + 1 == trials.end())
    return std::nullopt;
  const Trial& a = *(least - 1);
  const Trial& b = *least;
  const Trial& c = *(least + 1);
  const double rise_before = (b.square - a.square) / (b.blur_px - a.blur_px);
  const double rise_behind = (c.square - b.square) / (c.blur_px - b.blur_px);
  const double bend = (rise_behind - rise_before) / (c.blur_px - a.blur_px);
  if (!(bend > 0.0)) return std::nullopt;
  return std::clamp(0.5 * (a.blur_px + b.blur_px) - 0.5 * rise_before / bend, a.blur_px, c.blur_px);
}

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
  std::vector<Trial> trials;
  const auto attempt = [&](double blur_px) {
    FittedMarker tried{sharp.with_blur(blur_px), {}};
    tried.alignment = align_marker(frame, tried.marker, first, options);
    if (!tried.alignment.converged) return;
    trials.push_back({blur_px, tried.alignment.residual * tried.alignment.residual});
    if (!best || tried.alignment.residual < best->alignment.residual) best = std::move(tried);
  };
  for (const double blur_px : kBlurs_px) {
    if (blur_px > kWidestBlur * size_px) break;
    attempt(blur_px);
    // The residual has one minimum; wide blurs are dear.
    if (best &&
        trials.back().square > kFarBehind * best->alignment.residual * best->alignment.residual &&
        trials.back().blur_px > best->marker.blur_px()) {
      break;
    }
  }
  if (const auto between = least_between(trials)) attempt(*between);
  return best ? *best : fitted;
}

}  // namespace twang
