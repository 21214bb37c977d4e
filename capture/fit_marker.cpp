// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/fit_marker.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace twang {
namespace {

// Blurs tried, a third apart; about the least residual a parabola tells more.
constexpr std::array kBlurs_px = {0.0, 0.3, 0.45, 0.6, 0.8, 1.05, 1.4, 1.9, 2.5, 3.3};
constexpr std::size_t kUsualBlur = 3;  // of these; the first search starts there
// What the parabola tells is rounded to so much, far below what a place depends on: markers that
// look alike then share one drawing, which following them finds in the processor's cache.
constexpr double kBlurStep_px = 0.05;
// A blur beyond this part of the size leaves nothing of the pattern.
constexpr double kWidestBlur = 0.2;
// A drawing serves all markers whose size differs by no more [-].
constexpr double kSameSize = 0.005;

}  // namespace

namespace detail {

/// A marker of one size, and its templates by their blur.
class MarkerDrawing {
 public:
  MarkerDrawing(const MarkerPattern& pattern, double size_px) : m_sharp(pattern, size_px) {}

  [[nodiscard]] bool serves(const MarkerPattern& pattern, double size_px) const {
    return m_sharp.pattern() == pattern && std::abs(size_px / m_sharp.size_px() - 1.0) <= kSameSize;
  }
  [[nodiscard]] const MarkerTemplate& blurred(double blur_px) {
    auto place = m_templates.find(blur_px);
    if (place == m_templates.end()) {
      place = m_templates.emplace(blur_px, MarkerTemplate(m_sharp, blur_px)).first;
    }
    return place->second;
  }
  [[nodiscard]] double size_px() const { return m_sharp.size_px(); }

 private:
  SharpMarker m_sharp;
  std::map<double, MarkerTemplate> m_templates;
};

}  // namespace detail

namespace {

using detail::MarkerDrawing;

/// A blur and the mean square residual it leaves.
struct Trial {
  double blur_px, square;
};

/// Tries blurs for a marker of known size.
class BlurSearch {
 public:
  BlurSearch(const LumaFrame& frame,
             MarkerDrawing& drawing,
             const MarkerPlacement& start,
             const AlignOptions& options)
      : m_frame(frame), m_drawing(drawing), m_start(start), m_options(options) {}

  /// The best of all, if there was any to be aligned.
  std::optional<FittedMarker> run(std::size_t first_blur);

 private:
  bool attempt(double blur_px);
  void walk(std::size_t from, int step);

  const LumaFrame& m_frame;
  MarkerDrawing& m_drawing;
  const MarkerPlacement& m_start;
  const AlignOptions& m_options;
  std::vector<Trial> m_trials;
  std::optional<FittedMarker> m_best;
};

/// Whether that blur is better than all before, or cannot be judged.
bool BlurSearch::attempt(double blur_px) {
  const MarkerTemplate& marker = m_drawing.blurred(blur_px);
  const MarkerAlignment found = align_marker(m_frame, marker, m_start, m_options);
  if (!found.converged) return true;
  m_trials.push_back({blur_px, found.residual * found.residual});
  if (m_best && found.residual >= m_best->alignment.residual) return false;
  m_best = FittedMarker{marker, found};
  return true;
}

/// The residual has one minimum: on from it, it grows.
void BlurSearch::walk(std::size_t from, int step) {
  for (auto i = static_cast<int>(from); i >= 0 && i < static_cast<int>(kBlurs_px.size());
       i += step) {
    const double blur_px = kBlurs_px[static_cast<std::size_t>(i)];
    if (blur_px > kWidestBlur * m_drawing.size_px()) {
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

std::optional<FittedMarker> BlurSearch::run(std::size_t first_blur) {
  walk(first_blur, -1);
  if (!m_best || m_best->marker.blur_px() >= kBlurs_px[first_blur]) walk(first_blur + 1, 1);
  std::sort(m_trials.begin(), m_trials.end(), [](const Trial& a, const Trial& b) {
    return a.blur_px < b.blur_px;
  });
  if (const auto between = least_between(m_trials)) {
    attempt(kBlurStep_px * std::round(*between / kBlurStep_px));
  }
  if (m_best) m_best->marker.mark_even();
  return std::move(m_best);
}

/// The blur tried that is nearest to one found.
std::size_t nearest_blur(double blur_px) {
  const auto nearest =
      std::min_element(kBlurs_px.begin(), kBlurs_px.end(), [&](double a, double b) {
        return std::abs(a - blur_px) < std::abs(b - blur_px);
      });
  return static_cast<std::size_t>(nearest - kBlurs_px.begin());
}

}  // namespace

double placed_size_px(const MarkerPlacement& placement) {
  return std::sqrt(std::abs(placement.px_from_pattern.determinant()));
}

MarkerFitter::MarkerFitter(const LumaFrame& frame) : m_frame(frame), m_first_blur(kUsualBlur) {}
MarkerFitter::~MarkerFitter() = default;

MarkerDrawing& MarkerFitter::drawing(const MarkerPattern& pattern, double size_px) {
  for (const auto& drawing : m_drawings) {
    if (drawing->serves(pattern, size_px)) return *drawing;
  }
  return *m_drawings.emplace_back(std::make_unique<MarkerDrawing>(pattern, size_px));
}

FittedMarker MarkerFitter::fit(const MarkerPattern& pattern,
                               const MarkerPlacement& start,
                               double farthest_px) {
  AlignOptions options;
  options.fit_shape = true;
  options.farthest_px = farthest_px;
  FittedMarker fitted{drawing(pattern, placed_size_px(start)).blurred(kBlurs_px[m_first_blur]), {}};
  fitted.alignment = align_marker(m_frame, fitted.marker, start, options);
  if (!fitted.alignment.converged) return fitted;

  const MarkerPlacement& placement = fitted.alignment.placement;
  MarkerDrawing& drawn = drawing(pattern, placed_size_px(placement));
  std::optional<FittedMarker> best =
      BlurSearch(m_frame, drawn, placement, options).run(m_first_blur);
  if (!best) return fitted;
  m_first_blur = nearest_blur(best->marker.blur_px());
  return std::move(*best);
}

FittedMarker fit_marker(const LumaFrame& frame,
                        const MarkerPattern& pattern,
                        const MarkerPlacement& start,
                        double farthest_px) {
  return MarkerFitter(frame).fit(pattern, start, farthest_px);
}

}  // namespace twang
