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
constexpr int kUsualBlur = 3;  // of these; the search starts there
// A blur beyond this part of the size leaves nothing of the pattern.
constexpr double kWidestBlur = 0.2;
// A marker is drawn anew if the size found is another than the one it was drawn at [-].
constexpr double kSameSize = 0.005;

/// A blur and the mean square residual it leaves.
struct Trial {
  double blur_px, square;
};

/// Tries blurs for a marker of known size.
class BlurSearch {
 public:
  BlurSearch(const LumaFrame& frame,
             const SharpMarker& sharp,
             const MarkerPlacement& start,
             const AlignOptions& options)
      : m_frame(frame), m_sharp(sharp), m_start(start), m_options(options) {}

  /// The best of all, if there was any to be aligned.
  std::optional<FittedMarker> run();

 private:
  bool attempt(double blur_px);
  void walk(int from, int step);

  const LumaFrame& m_frame;
  const SharpMarker& m_sharp;
  const MarkerPlacement& m_start;
  const AlignOptions& m_options;
  std::vector<Trial> m_trials;
  std::optional<FittedMarker> m_best;
};

/// Whether that blur is better than all before, or cannot be judged.
bool BlurSearch::attempt(double blur_px) {
  FittedMarker tried{MarkerTemplate(m_sharp, blur_px), {}};
  tried.alignment = align_marker(m_frame, tried.marker, m_start, m_options);
  if (!tried.alignment.converged) return true;
  m_trials.push_back({blur_px, tried.alignment.residual * tried.alignment.residual});
  if (m_best && tried.alignment.residual >= m_best->alignment.residual) return false;
  m_best = std::move(tried);
  return true;
}

/// The residual has one minimum: on from it, it grows.
void BlurSearch::walk(int from, int step) {
  for (int i = from; i >= 0 && i < static_cast<int>(kBlurs_px.size()); i += step) {
    const double blur_px = kBlurs_px[static_cast<std::size_t>(i)];
    if (blur_px > kWidestBlur * m_sharp.size_px()) {
      if (step > 0) return;
      continue;
    }
    if (!attempt(blur_px)) return;
  }
}

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

std::optional<FittedMarker> BlurSearch::run() {
  walk(kUsualBlur, -1);
  if (!m_best || m_best->marker.blur_px() >= kBlurs_px[kUsualBlur]) walk(kUsualBlur + 1, 1);
  std::sort(m_trials.begin(), m_trials.end(), [](const Trial& a, const Trial& b) {
    return a.blur_px < b.blur_px;
  });
  if (const auto between = least_between(m_trials)) attempt(*between);
  if (m_best) m_best->marker.mark_even();
  return std::move(m_best);
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
  std::optional<SharpMarker> sharp(std::in_place, pattern, placed_size_px(start));
  FittedMarker fitted{MarkerTemplate(*sharp, kFirstBlur_px), {}};
  fitted.alignment = align_marker(frame, fitted.marker, start, options);
  if (!fitted.alignment.converged) return fitted;

  const double size_px = placed_size_px(fitted.alignment.placement);
  if (std::abs(size_px / sharp->size_px() - 1.0) > kSameSize) sharp.emplace(pattern, size_px);
  std::optional<FittedMarker> best =
      BlurSearch(frame, *sharp, fitted.alignment.placement, options).run();
  return best ? std::move(*best) : std::move(fitted);
}

}  // namespace twang
