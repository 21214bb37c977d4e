// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/forecast.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace twang::detail {
namespace {

constexpr std::size_t kMemory = 16;     // frames behind a forecast
constexpr double kForgetError = 0.25;   // weight of the newest in running means
constexpr double kForgetFrames = 0.88;  // weight of a triple over that of the next newer one
constexpr int kEnoughTriples = 3;       // from which a vibration is told
constexpr double kFirstError = 0.5;     // before anything is known, in scales
constexpr double kLeastSigma = 0.015;   // in scales
// What holds the damped recurrence where the places do not: one sigma each.
constexpr double kSigmaPlace_px = 0.3;
constexpr double kSigmaA = 2.0;
constexpr double kSigmaB = 0.3;
constexpr double kSigmaMiddle = 1.0;  // in scales
// Growth of the uncertainty with each frame lost, in parts of the first.
constexpr double kGrowthVibration = 0.6;
constexpr double kGrowthVelocity = 3.0;

}  // namespace

MotionForecast::MotionForecast(const Eigen::Vector2d& rest_px,
                               const Eigen::Vector2d& first_px,
                               double scale_px)
    : m_rest(rest_px), m_scale_px(scale_px), m_damped(2.0, 1.0, 0.0, 0.0) {
  m_recent.push_back({first_px, true});
  m_error.fill(kFirstError * scale_px);
  predict();
}

void MotionForecast::found(const Eigen::Vector2d& px) {
  if (m_frames_lost == 0) {
    for (std::size_t k = 0; k < m_error.size(); ++k) {
      m_error[k] += kForgetError * ((m_forecasts[k] - px).norm() - m_error[k]);
    }
  } else if ((px - m_next.px).norm() > 3.0 * m_next.sigma_px) {
    m_recent.clear();  // what was expected was wrong: begin anew
  }
  m_frames_lost = 0;
  m_recent.push_back({px, true});
  if (m_recent.size() > kMemory) m_recent.pop_front();
  predict();
}

void MotionForecast::lost() {
  ++m_frames_lost;
  m_recent.push_back({m_next.px, false});
  if (m_recent.size() > kMemory) m_recent.pop_front();
  predict();
}

Eigen::Vector2d MotionForecast::by_velocity() const {
  const Eigen::Vector2d& last = m_recent.back().px;
  if (m_recent.size() < 2) return last;
  return 2.0 * last - m_recent[m_recent.size() - 2].px;
}

/// kappa and its use, from triples of consecutive places that were all seen.
void MotionForecast::fit_vibration() {
  double product = 0.0;
  double square = 0.0;
  int triples = 0;
  for (std::size_t i = 1; i + 1 < m_recent.size(); ++i) {
    if (!m_recent[i - 1].seen || !m_recent[i].seen || !m_recent[i + 1].seen) continue;
    const Eigen::Vector2d y = m_recent[i].px - m_rest;
    product += y.dot(m_recent[i - 1].px + m_recent[i + 1].px - 2.0 * m_rest);
    square += y.squaredNorm();
    ++triples;
  }
  // Of a lost marker's thinning memory: the fit stays what it was.
  if (m_frames_lost > 0) return;
  m_num_triples = triples;
  if (square > 0.0) m_kappa = std::clamp(product / square, -2.0, 2.0);
}

void MotionForecast::fit_damped_vibration() {
  if (m_frames_lost > 0) return;
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  normal.diagonal() << 1.0 / (kSigmaA * kSigmaA), 1.0 / (kSigmaB * kSigmaB),
      1.0 / std::pow(kSigmaMiddle * m_scale_px, 2), 1.0 / std::pow(kSigmaMiddle * m_scale_px, 2);
  Eigen::Vector4d gradient(2.0 * normal(0, 0), normal(1, 1), 0.0, 0.0);
  double weight = 1.0 / (kSigmaPlace_px * kSigmaPlace_px);
  for (std::size_t i = m_recent.size() - 1; i-- > 1; weight *= kForgetFrames) {
    if (!m_recent[i - 1].seen || !m_recent[i].seen || !m_recent[i + 1].seen) continue;
    for (int axis = 0; axis < 2; ++axis) {
      Eigen::Vector4d row = Eigen::Vector4d::Zero();
      row[0] = m_recent[i].px[axis] - m_rest[axis];
      row[1] = m_rest[axis] - m_recent[i - 1].px[axis];
      row[2 + axis] = 1.0;
      normal += weight * row * row.transpose();
      gradient += weight * (m_recent[i + 1].px[axis] - m_rest[axis]) * row;
    }
  }
  const Eigen::Vector4d fitted = normal.ldlt().solve(gradient);
  if (!fitted.allFinite()) return;
  m_damped = fitted;
  m_damped[1] = std::clamp(m_damped[1], 0.2, 1.0);  // a free vibration does not grow
  m_damped[0] = std::clamp(m_damped[0], -2.0, 2.0);
}

void MotionForecast::predict() {
  m_forecasts.fill(by_velocity());
  if (m_recent.size() >= 3) {
    fit_vibration();
    fit_damped_vibration();
    if (m_num_triples >= kEnoughTriples) {
      const Eigen::Vector2d y = m_recent.back().px - m_rest;
      const Eigen::Vector2d before = m_recent[m_recent.size() - 2].px - m_rest;
      m_forecasts[1] = m_rest + m_kappa * y - before;
      m_forecasts[2] = m_rest + m_damped[0] * y - m_damped[1] * before + m_damped.tail<2>();
    }
  }
  if (m_frames_lost == 0) {
    const auto least = std::min_element(m_error.begin(), m_error.end());
    m_best = static_cast<std::size_t>(least - m_error.begin());
  }
  const double growth = m_best == 0 ? kGrowthVelocity : kGrowthVibration;
  m_next.px = m_forecasts[m_best];
  m_next.sigma_px = (m_error[m_best] + kLeastSigma * m_scale_px) * (1.0 + growth * m_frames_lost);
}

}  // namespace twang::detail
