// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/follow_marker.hpp"

#include "capture/detail/search_marker.hpp"
#include "core/constants.hpp"
#include "core/units.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang::detail {
namespace {

constexpr double kForget = 0.2;           // weight of the newest in running means
constexpr double kCapture = 0.3;          // alignment is trusted to converge from so far, in sizes
constexpr double kLeastScoreDrop = 0.08;  // below the usual score that is allowed at any rate
constexpr double kScoreDropRatio = 3.0;   // and as a multiple of what the usual one lacks of 1
constexpr double kLeastScore = 0.5;
constexpr double kContrastRange = 2.0;  // factor about the usual contrast, either way
constexpr double kMostSigma_px = 0.5;
constexpr double kMostTurn_rad = 25.0 * kRadiansPerDegree;  // between frames
constexpr double kFindingsApart = 0.5;                      // of two findings, in sizes
constexpr double kReachSlack = 1.05;                        // a free vibration does not grow
constexpr double kReachSlackSizes = 0.3;
constexpr double kWidestGate = 4.0;  // in sizes
constexpr double kGateSigmas = 4.0;  // about what companions say
constexpr double kLeastCorrelation = 0.45;
constexpr double kVisibleBlur_px = 0.8;
constexpr int kEnoughBlurs = 10;
constexpr double kKnownMotion = 3.0;  // sigma of a forecast that still tells the motion, in sizes
// What the three sources of a place are worth.
constexpr double kTrustCompanion = 0.6;
constexpr double kTrustReach = 0.1;
constexpr double kReachSigma = 0.6;  // of the places within the reach, in reaches
// A marker seen for the first time: how it may differ from what is usual.
constexpr double kFirstScoreDrop = 0.06;
constexpr double kFirstSizeMisfit = 0.15;
constexpr double kFirstContrastRange = 2.0;
constexpr double kNoMotionDrop = 0.01;  // of the score, with which it need not be moving
constexpr double kFirstMotion = 0.3;    // blur from which its length is fitted, in sizes
constexpr int kBetterLooks = 12;        // tries to fit its pattern later

}  // namespace

MarkerFollower::MarkerFollower(FittedMarker fitted, const MarkerBackground& background)
    : m_marker(std::move(fitted.marker)),
      m_px_from_pattern(fitted.alignment.placement.px_from_pattern),
      m_background(background),
      m_seen(true),
      m_size_px(placed_size_px(fitted.alignment.placement)),
      m_typical_score(fitted.alignment.score),
      m_typical_contrast(fitted.alignment.contrast),
      m_light(fitted.alignment.light),
      m_forecast(background.rest_px, fitted.alignment.placement.position_px, m_size_px) {
  const Eigen::Vector2d& at = fitted.alignment.placement.position_px;
  m_background.reach_px = std::max(m_background.reach_px, (at - m_background.rest_px).norm());
}

MarkerFollower::MarkerFollower(const MarkerPattern& pattern,
                               const MarkerPlacement& due,
                               const MarkerBackground& background,
                               const UsualLooks& usual)
    : m_marker(pattern, usual.size_ratio * placed_size_px(due), usual.blur_px),
      m_px_from_pattern(usual.size_ratio * due.px_from_pattern),
      m_background(background),
      m_usual(usual),
      m_seen(false),
      m_size_px(usual.size_ratio * placed_size_px(due)),
      m_typical_score(usual.score),
      m_typical_contrast(usual.contrast),
      m_forecast(background.rest_px, background.rest_px, m_size_px) {
  m_marker.mark_even();
}

MarkerAlignment MarkerFollower::align_at(const LumaFrame& frame, const Eigen::Vector2d& at) const {
  AlignOptions options;
  options.farthest_px = 0.6 * m_size_px;
  if (frames_lost() == 0) options.light = m_light;
  MarkerPlacement start{at, m_px_from_pattern, Eigen::Vector2d::Zero()};
  // Half of what it moved since the last frame and half of what it will: at a turning point the
  // marker is sharp.
  Eigen::Vector2d moved = Eigen::Vector2d::Zero();
  if (frames_lost() == 0) {
    moved = at - m_forecast.last_px();
  } else if (forecast().sigma_px < kKnownMotion * m_size_px) {
    moved = forecast().px - m_forecast.last_px();
  }
  const Eigen::Vector2d blur = m_blur_ratio * moved;
  const double visible = m_num_blurs < kEnoughBlurs ? moved.norm() : blur.norm();
  if (visible > 2.0 * kVisibleBlur_px) {
    options.fit_motion = true;
    start.motion_px = blur.norm() > kVisibleBlur_px ? blur : kVisibleBlur_px * moved.normalized();
  }
  return align_marker(frame, m_marker, start, options);
}

/// Why what was found is not this marker by its looks; null if it may be.
const char* MarkerFollower::doubt(const MarkerAlignment& found) const {
  if (!found.converged) return "nothing there looks like it";
  const double drop = std::max(kLeastScoreDrop, kScoreDropRatio * (1.0 - m_typical_score));
  if (found.score < std::max(kLeastScore, 1.0 - drop)) return "it is hidden or blurred";
  const double contrast = found.contrast / m_typical_contrast;
  if (!(contrast < kContrastRange && contrast > 1.0 / kContrastRange))
    return "its contrast changed";
  if (!(found.sigma_px < kMostSigma_px)) return "its place is too uncertain";
  if (std::abs(found.turn_rad) > kMostTurn_rad) return "it seems to have turned too far";
  return nullptr;
}

/// A marker never seen so far: of the size and shape that the layout says, sharp or moving any way,
/// and held to what is usual.
MarkerFollower::Finding MarkerFollower::first_look(const LumaFrame& frame,
                                                   const Eigen::Vector2d& at) const {
  AlignOptions options;
  options.farthest_px = kFindingsApart * m_size_px + 1.0;
  Finding best{align_marker(frame, m_marker, {at, m_px_from_pattern, {0.0, 0.0}}, options),
               nullptr};
  options.fit_motion = true;
  const double slanted = std::sqrt(0.5);
  for (const Eigen::Vector2d& way : {Eigen::Vector2d(1.0, 0.0),
                                     Eigen::Vector2d(0.0, 1.0),
                                     Eigen::Vector2d(slanted, slanted),
                                     Eigen::Vector2d(slanted, -slanted)}) {
    if (best.alignment.converged && best.alignment.score > m_usual.score - kNoMotionDrop) break;
    const MarkerPlacement start{at, m_px_from_pattern, kFirstMotion * m_size_px * way};
    const MarkerAlignment found = align_marker(frame, m_marker, start, options);
    if (!found.converged || found.placement.motion_px.norm() > m_size_px) continue;
    if (!best.alignment.converged || found.score > best.alignment.score) best.alignment = found;
  }
  const MarkerAlignment& found = best.alignment;
  const double contrast = m_usual.contrast > 0.0 ? found.contrast / m_usual.contrast : 1.0;
  if (!found.converged) {
    best.why_not = "nothing there looks like it";
  } else if (found.score < m_usual.score - kFirstScoreDrop || !(found.sigma_px < kMostSigma_px) ||
             std::abs(found.turn_rad) > kMostTurn_rad || contrast > kFirstContrastRange ||
             contrast < 1.0 / kFirstContrastRange) {
    best.why_not = "it is hidden or blurred";
  }
  return best;
}

MarkerFollower::Finding MarkerFollower::look_at(const LumaFrame& frame,
                                                const Eigen::Vector2d& px) const {
  if (!m_seen) return first_look(frame, px);
  Finding finding{align_at(frame, px), nullptr};
  finding.why_not = doubt(finding.alignment);
  return finding;
}

MarkerFollower::Finding MarkerFollower::look_ahead(const LumaFrame& frame) const {
  const Forecast& forecast = m_forecast.next();
  Eigen::Vector2d expected = forecast.px;
  const Eigen::Vector2d last = m_forecast.last_px();
  // A fast swing turns round; it does not go on beyond its reach.
  if (!within_reach(expected) && (expected - last).norm() > m_size_px) {
    const Eigen::Vector2d out = expected - rest_px();
    expected = rest_px() + out * (m_background.reach_px / out.norm());
  }
  Finding finding = look_at(frame, expected);
  const auto near = [&](const Finding& found) {
    return found.good() && ((found.px() - expected).norm() < kCapture * m_size_px ||
                            (found.px() - last).norm() < kCapture * m_size_px);
  };
  if (near(finding) || frames_lost() > 0) {
    if (finding.good() && !near(finding)) finding.why_not = "nothing there looks like it";
    return finding;
  }
  Finding at_last = look_at(frame, last);
  if (near(at_last)) return at_last;
  if (finding.good()) finding.why_not = "nothing there looks like it";
  return finding;
}

double MarkerFollower::reach_px() const {
  return kReachSlack * m_background.reach_px + kReachSlackSizes * m_size_px;
}

bool MarkerFollower::within_reach(const Eigen::Vector2d& px) const {
  return (px - rest_px()).norm() < reach_px();
}

/// How far from where it is expected it may be found beyond its reach.
double MarkerFollower::gate_px() const {
  if (!m_seen) return 0.0;
  const double moved = frames_lost() == 0 ? (forecast().px - m_forecast.last_px()).norm() : 0.0;
  const double gate = std::min(m_size_px * (1.0 + frames_lost()), kWidestGate * m_size_px) + moved;
  return std::min(gate, std::max(m_half_way_px, kCapture * m_size_px));
}

bool MarkerFollower::allowed(const Eigen::Vector2d& px,
                             const std::optional<Forecast>& companion) const {
  if (within_reach(px)) return true;
  if (companion && (px - companion->px).norm() <
                       kGateSigmas * companion->sigma_px + kReachSlackSizes * m_size_px) {
    return true;
  }
  return m_seen && (px - m_forecast.last_px()).norm() < gate_px();
}

std::vector<MarkerFollower::Finding> MarkerFollower::look_around(
    const LumaFrame& frame, const std::optional<Forecast>& companion, const char*& why_not) const {
  const auto box =
      [](Eigen::Vector2d& low, Eigen::Vector2d& high, const Eigen::Vector2d& middle, double half) {
        low = low.cwiseMin(Eigen::Vector2d(middle.array() - half));
        high = high.cwiseMax(Eigen::Vector2d(middle.array() + half));
      };
  Eigen::Vector2d low = rest_px();
  Eigen::Vector2d high = rest_px();
  box(low, high, rest_px(), reach_px());
  if (m_seen) box(low, high, m_forecast.last_px(), gate_px());
  if (companion) {
    box(low, high, companion->px, kGateSigmas * companion->sigma_px + kReachSlackSizes * m_size_px);
  }
  std::vector<Finding> good;
  for (const MarkerPeak& peak : search_marker(frame,
                                              m_marker,
                                              m_px_from_pattern,
                                              0.5 * (low + high),
                                              0.5 * (high - low).maxCoeff(),
                                              kLeastCorrelation)) {
    if (!allowed(peak.position_px, companion)) continue;
    Finding finding = look_at(frame, peak.position_px);
    if (!finding.alignment.converged || !allowed(finding.px(), companion)) continue;
    if (!finding.good()) {
      why_not = finding.why_not;
      continue;
    }
    const bool known = std::any_of(good.begin(), good.end(), [&](const Finding& other) {
      return (other.px() - finding.px()).norm() < kFindingsApart * m_size_px;
    });
    if (!known) good.push_back(std::move(finding));
  }
  return good;
}

std::vector<Eigen::Vector2d> MarkerFollower::look_alikes(const LumaFrame& frame,
                                                         double sizes,
                                                         double least) const {
  const Eigen::Vector2d& at = m_forecast.last_px();
  std::vector<Eigen::Vector2d> others;
  for (const MarkerPeak& peak :
       search_marker(frame, m_marker, m_px_from_pattern, at, sizes * m_size_px, least)) {
    if ((peak.position_px - at).norm() > m_size_px) others.push_back(peak.position_px);
  }
  return others;
}

double MarkerFollower::cost(const Eigen::Vector2d& px,
                            const std::optional<Forecast>& companion) const {
  if (!allowed(px, companion)) return kInfinity;
  const auto density = [&](const Eigen::Vector2d& middle, double sigma_px) {
    const double sigma = sigma_px / m_size_px;
    const double square = (px - middle).squaredNorm() / (m_size_px * m_size_px);
    return std::exp(-0.5 * square / (sigma * sigma)) / (kTwoPi * sigma * sigma);
  };
  const double by_companion = companion ? kTrustCompanion : 0.0;
  const double by_motion = m_seen ? (1.0 - by_companion) * (1.0 - kTrustReach) : 0.0;
  double sum = (1.0 - by_companion - by_motion) *
               density(rest_px(), std::max(kReachSigma * reach_px(), kCapture * m_size_px));
  if (companion) sum += by_companion * density(companion->px, companion->sigma_px);
  if (m_seen) sum += by_motion * density(forecast().px, forecast().sigma_px);
  return -2.0 * std::log(std::max(sum, 1e-12));
}

/// Once a marker that was hidden at first stands about still, its pattern is fitted too.
void MarkerFollower::look_better(const LumaFrame& frame, const MarkerAlignment& found) {
  FittedMarker again = fit_marker(frame, m_marker.pattern(), found.placement, kCapture * m_size_px);
  --m_better_looks;
  if (!again.alignment.converged || again.alignment.score <= found.score) return;
  const double size = placed_size_px(again.alignment.placement);
  if (std::abs(std::log(size / m_size_px)) > kFirstSizeMisfit) return;
  m_better_looks = 0;
  m_marker = std::move(again.marker);
  m_px_from_pattern = again.alignment.placement.px_from_pattern;
  m_size_px = size;
  m_typical_score = again.alignment.score;
  m_typical_contrast = again.alignment.contrast;
  m_light = again.alignment.light;
}

void MarkerFollower::accept(const LumaFrame& frame, Finding finding) {
  const MarkerAlignment& found = finding.alignment;
  const Eigen::Vector2d& px = found.placement.position_px;
  double moved = frames_lost() == 0 ? (px - m_forecast.last_px()).norm() : kInfinity;
  if (!m_seen) {
    m_seen = true;
    m_typical_score = found.score;
    m_typical_contrast = found.contrast;
    m_better_looks = kBetterLooks;
    m_forecast = MotionForecast(m_background.rest_px, px, m_size_px);
    moved = kInfinity;
  } else {
    const double blur = found.placement.motion_px.norm();
    if (blur > 0.0 && moved > 2.0 * kVisibleBlur_px && moved < kInfinity) {
      m_blur_ratio += kForget * (std::min(blur / moved, 1.0) - m_blur_ratio);
      ++m_num_blurs;
    }
    m_typical_score += kForget * (found.score - m_typical_score);
    m_typical_contrast += kForget * (found.contrast - m_typical_contrast);
    m_forecast.found(px);
  }
  m_px_from_pattern = found.placement.px_from_pattern;
  m_light = found.light;
  m_background.reach_px = std::max(m_background.reach_px, (px - rest_px()).norm());
  if (m_better_looks > 0 && moved < kVisibleBlur_px) look_better(frame, found);
}

}  // namespace twang::detail
