// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/companions.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

namespace twang::detail {
namespace {

constexpr double kForget = 0.98;      // memory of some fifty frames
constexpr double kEnoughFrames = 6.0;
constexpr double kLeastMotion_px = 1.0;  // rms of a companion's motion from which it tells something
// Error of a share where the motion changes its shape (pulled by a hand, then free).
constexpr double kSigmaShare = 0.06;
constexpr double kLeastSigma_px = 0.1;

}  // namespace

Companions::Companions(std::size_t num_markers) {
  const auto n = static_cast<Eigen::Index>(num_markers);
  m_product.setZero(n, n);
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
      m_product(i, j) = kForget * m_product(i, j) + u * std::complex(other.x(), -other.y());
      m_square(i, j) = kForget * m_square(i, j) + other.squaredNorm();
      m_count(i, j) = kForget * m_count(i, j) + 1.0;
    }
  }
}

std::optional<Forecast> Companions::predict(std::size_t marker,
                                            const std::vector<Eigen::Vector2d>& moved_px) const {
  const auto i = static_cast<Eigen::Index>(marker);
  std::optional<Forecast> best;
  for (Eigen::Index j = 0; j < m_count.cols(); ++j) {
    const Eigen::Vector2d& other = moved_px[static_cast<std::size_t>(j)];
    const double count = m_count(i, j);
    if (j == i || !other.allFinite() || count < kEnoughFrames ||
        m_square(i, j) < count * kLeastMotion_px * kLeastMotion_px) {
      continue;
    }
    const std::complex<double> share = m_product(i, j) / m_square(i, j);
    const std::complex<double> u = share * std::complex(other.x(), other.y());
    // The square of i over the frames it shares with j is that of j over those it shares with i.
    const double left = std::max(0.0, m_square(j, i) - std::norm(m_product(i, j)) / m_square(i, j));
    const double widening = std::max(1.0, other.norm() / std::sqrt(m_square(i, j) / count));
    const double sigma =
        std::sqrt(left / count) * widening + kSigmaShare * std::abs(u) + kLeastSigma_px;
    if (!best || sigma < best->sigma_px) best = {Eigen::Vector2d(u.real(), u.imag()), sigma};
  }
  return best;
}

}  // namespace twang::detail
