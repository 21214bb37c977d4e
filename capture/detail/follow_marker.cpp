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

constexpr std::size_t kMemory = 12;       // positions behind a forecast
constexpr double kForget = 0.2;           // weight of the newest in running means
constexpr double kCapture = 0.3;          // alignment is trusted to converge from so far, in sizes
constexpr double kLeastScoreDrop = 0.08;  // below the usual score that is allowed at any rate
constexpr double kScoreDropRatio = 3.0;   // and as a multiple of what the usual one lacks of 1
constexpr double kLeastScore = 0.5;
constexpr double kContrastRange = 2.0;  // factor about the usual contrast, either way
constexpr double kMostSigma_px = 0.5;
constexpr double kMostTurn_rad = 25.0 * kRadiansPerDegree;  // between frames
constexpr double kApart = 0.5;                              // of two markers' centres, in sizes
constexpr double kReachSlack = 1.05;                        // a free vibration does not grow
constexpr double kReachSlackSizes = 0.3;
constexpr double kWidestGate = 4.0;  // in sizes
constexpr double kLeastCorrelation = 0.45;
constexpr double kLookAlike = 0.75;  // correlation of a thing that could be taken for the marker
constexpr double kLookAround = 6.0;  // for such things, in sizes
constexpr double kVisibleBlur_px = 0.8;
constexpr int kEnoughBlurs = 10;

double nearest_look_alike(const LumaFrame& frame,
                          const MarkerTemplate& marker,
                          const Eigen::Matrix2d& px_from_pattern,
                          const Eigen::Vector2d& at,
                          double size_px) {
  double nearest = kInfinity;
  for (const MarkerPeak& peak :
       search_marker(frame, marker, px_from_pattern, at, kLookAround * size_px, kLookAlike)) {
    const double distance = (peak.position_px - at).norm();
    if (distance > size_px) nearest = std::min(nearest, distance);
  }
  return nearest;
}

}  // namespace

MarkerFollower::MarkerFollower(const LumaFrame& first,
                               FittedMarker fitted,
                               MarkerBackground background)
    : m_marker(std::move(fitted.marker)),
      m_px_from_pattern(fitted.alignment.placement.px_from_pattern),
      m_background(background),
      m_size_px(placed_size_px(fitted.alignment.placement)),
      m_typical_score(fitted.alignment.score),
      m_typical_contrast(fitted.alignment.contrast) {
  const Eigen::Vector2d& at = fitted.alignment.placement.position_px;
  m_half_way_px = 0.5 * nearest_look_alike(first, m_marker, m_px_from_pattern, at, m_size_px);
  m_recent.push_back(at);
  m_predicted = at;
  m_forecasts = {at, at};
  m_background.reach_px = std::max(m_background.reach_px, (at - m_background.rest_px).norm());
}

/// By constant velocity, and as a free vibration about rest: y(n+1) = κ y(n) − y(n−1) with κ from
/// the recent samples by least squares; for a sinusoid κ = 2 cos(ω Δt).
Eigen::Vector2d MarkerFollower::predict() {
  const std::size_t n = m_recent.size();
  const Eigen::Vector2d& last = m_recent.back();
  if (n < 2) {
    m_forecasts = {last, last};
    return last;
  }
  const Eigen::Vector2d& before = m_recent[n - 2];
  m_forecasts[0] = last + (last - before);
  m_forecasts[1] = m_forecasts[0];
  double product = 0.0;
  double square = 0.0;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const Eigen::Vector2d y = m_recent[i] - m_background.rest_px;
    const Eigen::Vector2d sum = m_recent[i - 1] + m_recent[i + 1] - 2.0 * m_background.rest_px;
    product += y.dot(sum);
    square += y.squaredNorm();
  }
  if (square > 0.0 && n >= 5) {
    const double kappa = std::clamp(product / square, -2.0, 2.0);
    m_forecasts[1] = m_background.rest_px + kappa * (last - m_background.rest_px) -
                     (before - m_background.rest_px);
  }
  const Eigen::Vector2d& forecast = m_forecasts[m_forecast_error[1] < m_forecast_error[0] ? 1 : 0];
  // A fast swing turns round; it does not go on beyond its reach.
  if (within_reach(forecast) || (forecast - last).norm() < m_size_px) return forecast;
  const Eigen::Vector2d out = forecast - m_background.rest_px;
  return m_background.rest_px + out * (m_background.reach_px / out.norm());
}

MarkerAlignment MarkerFollower::align_at(const LumaFrame& frame, const Eigen::Vector2d& at) const {
  AlignOptions options;
  options.farthest_px = 0.6 * m_size_px;
  MarkerPlacement start{at, m_px_from_pattern, Eigen::Vector2d::Zero()};
  // Half of what it moved since the last frame and half of what it will: at a turning point the
  // marker is sharp.
  const Eigen::Vector2d moved = m_frames_lost == 0 ? at - m_recent.back() : at - at;
  const Eigen::Vector2d blur = m_blur_ratio * moved;
  const double visible = m_num_blurs < kEnoughBlurs ? moved.norm() : blur.norm();
  if (visible > 2.0 * kVisibleBlur_px) {
    options.fit_motion = true;
    start.motion_px = blur.norm() > kVisibleBlur_px ? blur : kVisibleBlur_px * moved.normalized();
  }
  return align_marker(frame, m_marker, start, options);
}

MarkerFollower::Verdict MarkerFollower::judge(const MarkerAlignment& found,
                                              const std::vector<Eigen::Vector2d>& taken) const {
  if (!found.converged) return {false, "nothing there looks like it"};
  const double drop = std::max(kLeastScoreDrop, kScoreDropRatio * (1.0 - m_typical_score));
  if (found.score < std::max(kLeastScore, 1.0 - drop)) return {false, "it is hidden or blurred"};
  const double contrast = found.contrast / m_typical_contrast;
  if (!(contrast < kContrastRange && contrast > 1.0 / kContrastRange)) {
    return {false, "its contrast changed"};
  }
  if (!(found.sigma_px < kMostSigma_px)) return {false, "its place is too uncertain"};
  if (std::abs(found.turn_rad) > kMostTurn_rad) return {false, "it seems to have turned too far"};
  for (const Eigen::Vector2d& other : taken) {
    if ((other - found.placement.position_px).norm() < kApart * m_size_px) {
      return {false, "another marker is there"};
    }
  }
  return {true, ""};
}

/// How far from its last place it may be found beyond its reach.
double MarkerFollower::gate_px() const {
  const double moved = (m_predicted - m_recent.back()).norm();
  const double gate = std::min(m_size_px * (1.0 + m_frames_lost), kWidestGate * m_size_px) + moved;
  return std::min(gate, std::max(m_half_way_px, kCapture * m_size_px));
}

bool MarkerFollower::within_reach(const Eigen::Vector2d& px) const {
  return (px - m_background.rest_px).norm() <
         kReachSlack * m_background.reach_px + kReachSlackSizes * m_size_px;
}

bool MarkerFollower::allowed(const Eigen::Vector2d& px) const {
  return within_reach(px) || (px - m_recent.back()).norm() < gate_px();
}

std::optional<MarkerAlignment> MarkerFollower::search(const LumaFrame& frame,
                                                      const std::vector<Eigen::Vector2d>& taken,
                                                      std::string& why) const {
  const double gate = gate_px();
  const double reach = kReachSlack * m_background.reach_px + kReachSlackSizes * m_size_px;
  const Eigen::Vector2d& last = m_recent.back();
  const Eigen::Vector2d low = (last.array() - gate).min(m_background.rest_px.array() - reach);
  const Eigen::Vector2d high = (last.array() + gate).max(m_background.rest_px.array() + reach);
  std::vector<MarkerAlignment> good;
  for (const MarkerPeak& peak : search_marker(frame,
                                              m_marker,
                                              m_px_from_pattern,
                                              0.5 * (low + high),
                                              0.5 * (high - low).maxCoeff(),
                                              kLeastCorrelation)) {
    const MarkerAlignment found = align_at(frame, peak.position_px);
    const Eigen::Vector2d& px = found.placement.position_px;
    if (!found.converged || !allowed(px)) continue;
    const Verdict verdict = judge(found, taken);
    const bool known = std::any_of(good.begin(), good.end(), [&](const MarkerAlignment& other) {
      return (other.placement.position_px - px).norm() < kApart * m_size_px;
    });
    if (verdict.good && !known) good.push_back(found);
    if (!verdict.good) why = verdict.why;
  }
  if (good.empty()) return std::nullopt;
  // A vibration stays within the reach it has shown: what lies farther out counts only if nothing
  // lies within.
  const auto beyond = std::stable_partition(good.begin(), good.end(), [&](const auto& found) {
    return within_reach(found.placement.position_px);
  });
  if (beyond != good.begin()) good.erase(beyond, good.end());
  const auto distance = [&](const MarkerAlignment& found) {
    return (found.placement.position_px - m_predicted).norm();
  };
  const auto nearest = std::min_element(
      good.begin(), good.end(), [&](const MarkerAlignment& a, const MarkerAlignment& b) {
        return distance(a) < distance(b);
      });
  // Of several, only one where it was expected, by a forecast that is not stale.
  if (good.size() > 1 && (m_frames_lost > 0 || distance(*nearest) > kCapture * m_size_px)) {
    why = "several places look like it";
    return std::nullopt;
  }
  return *nearest;
}

void MarkerFollower::accept(const MarkerAlignment& found) {
  const Eigen::Vector2d& px = found.placement.position_px;
  if (m_frames_lost > 0) m_recent.clear();
  for (std::size_t k = 0; k < m_forecasts.size() && m_frames_lost == 0; ++k) {
    m_forecast_error[k] += kForget * ((m_forecasts[k] - px).norm() - m_forecast_error[k]);
  }
  const double moved = m_recent.empty() ? 0.0 : (px - m_recent.back()).norm();
  const double blur = found.placement.motion_px.norm();
  if (blur > 0.0 && moved > 2.0 * kVisibleBlur_px) {
    m_blur_ratio += kForget * (std::min(blur / moved, 1.0) - m_blur_ratio);
    ++m_num_blurs;
  }
  m_px_from_pattern = found.placement.px_from_pattern;
  m_typical_score += kForget * (found.score - m_typical_score);
  m_typical_contrast += kForget * (found.contrast - m_typical_contrast);
  m_background.reach_px = std::max(m_background.reach_px, (px - m_background.rest_px).norm());
  m_recent.push_back(px);
  if (m_recent.size() > kMemory) m_recent.pop_front();
  m_frames_lost = 0;
}

MarkerSample MarkerFollower::follow(const LumaFrame& frame,
                                    const std::vector<Eigen::Vector2d>& taken) {
  m_predicted = predict();
  std::optional<MarkerAlignment> found;
  std::string why = "nothing there looks like it";
  for (const Eigen::Vector2d& start : {m_predicted, m_recent.back()}) {
    if (m_frames_lost > 0) break;  // the forecast is stale: look everywhere
    const MarkerAlignment tried = align_at(frame, start);
    const Eigen::Vector2d& px = tried.placement.position_px;
    const bool near = (px - m_predicted).norm() < kCapture * m_size_px ||
                      (px - m_recent.back()).norm() < kCapture * m_size_px;
    const Verdict verdict = judge(tried, taken);
    if (verdict.good && near && allowed(px)) {
      found = tried;
      break;
    }
    if (!verdict.good) why = verdict.why;
  }
  if (!found) found = search(frame, taken, why);
  if (!found) {
    ++m_frames_lost;
    return {Eigen::Vector2d::Constant(kNaN), kNaN, why};
  }
  accept(*found);
  return {found->placement.position_px, found->sigma_px, ""};
}

}  // namespace twang::detail
