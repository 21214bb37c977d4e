// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/companions.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

namespace twang::detail {
namespace {

constexpr double kForget = 0.98;  // memory of some fifty frames
constexpr double kEnoughFrames = 6.0;
constexpr double kLeastMotion_px =
    1.0;  // rms of a companion's motion from which it tells something
// Error of a share where the motion changes its shape (pulled by a hand, then free).
constexpr double kSigmaShare = 0.06;
constexpr double kLeastSigma_px = 0.1;
constexpr int kLeastMajority = 2;  // one against one tells nothing
constexpr double kBeside = 4.0;    // sigmas from which a place contradicts a companion

}  // namespace

Companions::Companions(std::size_t num_markers) {
  const auto n = static_cast<Eigen::Index>(num_markers);
  m_product.setZero(n, n);
  m_sum.setZero(n, n);
  m_square.setZero(n, n);
  m_count.setZero(n, n);
}

void Companions::add(const std::vector<Eigen::Vector2d>& moved_px) {
  const auto n = static_cast<Eigen::Index>(moved_px.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector2d& own = moved_px[static_cast<std::size_t>(i)];
    if (!own.allFinite()) continue;
    const std::complex<double> u(own.x(), own.y());
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::Vector2d& other = moved_px[static_cast<std::size_t>(j)];
      if (!other.allFinite()) continue;
      const std::complex<double> v(other.x(), other.y());
      m_product(i, j) = kForget * m_product(i, j) + u * std::conj(v);
      m_sum(i, j) = kForget * m_sum(i, j) + v;
      m_square(i, j) = kForget * m_square(i, j) + other.squaredNorm();
      m_count(i, j) = kForget * m_count(i, j) + 1.0;
    }
  }
}

/// What marker j, gone so far, says of marker i.
std::optional<Forecast> Companions::predict_by(Eigen::Index i,
                                               Eigen::Index j,
                                               const Eigen::Vector2d& moved_px) const {
  const double count = m_count(i, j);
  if (j == i || !moved_px.allFinite() || count < kEnoughFrames) return std::nullopt;
  const std::complex<double> mean_i = m_sum(j, i) / count;
  const std::complex<double> mean_j = m_sum(i, j) / count;
  const double variance_i = m_square(j, i) / count - std::norm(mean_i);
  const double variance_j = m_square(i, j) / count - std::norm(mean_j);
  if (variance_j < kLeastMotion_px * kLeastMotion_px) return std::nullopt;
  const std::complex<double> together = m_product(i, j) / count - mean_i * std::conj(mean_j);
  const std::complex<double> gone = std::complex(moved_px.x(), moved_px.y()) - mean_j;
  const std::complex<double> follows = together / variance_j * gone;
  const std::complex<double> u = mean_i + follows;
  const double left = std::max(0.0, variance_i - std::norm(together) / variance_j);
  const double widening = std::max(1.0, std::abs(gone) / std::sqrt(variance_j));
  return Forecast{{u.real(), u.imag()},
                  std::sqrt(left) * widening + kSigmaShare * std::abs(follows) + kLeastSigma_px};
}

std::optional<Forecast> Companions::predict(std::size_t marker,
                                            const std::vector<Eigen::Vector2d>& moved_px) const {
  std::optional<Forecast> best;
  for (std::size_t j = 0; j < moved_px.size(); ++j) {
    const auto told =
        predict_by(static_cast<Eigen::Index>(marker), static_cast<Eigen::Index>(j), moved_px[j]);
    if (told && (!best || told->sigma_px < best->sigma_px)) best = told;
  }
  return best;
}

bool Companions::contradict(std::size_t marker,
                            const std::vector<Eigen::Vector2d>& moved_px,
                            double slack_px,
                            double sure_px) const {
  int for_it = 0;
  int against = 0;
  for (std::size_t j = 0; j < moved_px.size(); ++j) {
    const auto told =
        predict_by(static_cast<Eigen::Index>(marker), static_cast<Eigen::Index>(j), moved_px[j]);
    if (!told || told->sigma_px > sure_px) continue;
    const bool beside = (told->px - moved_px[marker]).norm() > kBeside * told->sigma_px + slack_px;
    ++(beside ? against : for_it);
  }
  return against >= for_it + kLeastMajority;
}

}  // namespace twang::detail
