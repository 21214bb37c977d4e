// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/morlet_ridge.hpp"

#include "core/constants.hpp"
#include "core/text.hpp"
#include "harmonic_inversion/ridge_line.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <optional>
#include <vector>

namespace twang {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::array kWidths = {3.0, 4.0, 6.0, 9.0, 14.0, 20.0, 30.0};  // ω τ; 6: a cycle is τ
constexpr double kCone = 3.5;     // τ from an edge: 0.02 % of the wavelet is cut off
constexpr double kSupport = 4.5;  // τ, beyond which the wavelet is nothing
constexpr double kSpacing = 0.5;  // τ between two points of the ridge
constexpr double kMostPoints = 64.0;
constexpr double kLeastSpan = 1.5;  // τ, of the ridge
constexpr Index kLeastPoints = 4;
constexpr double kRidgeStandsOut = 5.0;  // noises of W above which |W| counts
constexpr double kLeak = 1e-3;           // of |W|, from another mode; or
constexpr double kLeakInNoise = 0.2;     // of the noise of W
constexpr double kFullness = 0.5;        // of the samples that an even record has under a wavelet

/// W at one time: a sum of samples with complex weights.
struct Point {
  double time_s = 0.0;
  Complex value;
  Index first = 0;  // sample
  Eigen::VectorXcd weights;
};

double largest_column_sum(const Eigen::Matrix3d& a) {
  return a.cwiseAbs().colwise().sum().maxCoeff();
}

class Transform {
 public:
  Transform(const CheckedSignal& signal, double tau_s) : m_signal(signal), m_tau_s(tau_s) {}

  /// The points outside the cone of influence that other modes and noise leave alone.
  [[nodiscard]] std::vector<Point> ridge() const {
    const double d = m_signal.mode().decay_per_s;
    const double shift = d * m_tau_s * m_tau_s;
    const VectorXd& t = m_signal.time_s;
    const double from = t(0) + kCone * m_tau_s + std::max(0.0, shift);
    const double to = t(t.size() - 1) - kCone * m_tau_s;
    std::vector<Point> points;
    if (!(to > from)) return points;
    // The ridge ends before the mode, thinned by no more than its best averaging, is lost.
    double end = to;
    if (d > 0.0) {
      const double largest =
          m_signal.amplitude() * std::sqrt(static_cast<double>(t.size())) / m_signal.noise;
      end = std::min(end, std::max(from, std::log(std::max(1.0, largest)) / d + shift));
    }
    const double step = std::max(kSpacing * m_tau_s, (end - from) / kMostPoints);
    for (double time = from; time <= end; time += step) {
      if (auto point = transform_at(time)) points.push_back(std::move(*point));
    }
    return points;
  }

 private:
  const CheckedSignal& m_signal;
  double m_tau_s;

  /// |W| of a mode as foretold by the fit, where the wavelet stands at the first mode's frequency.
  [[nodiscard]] double foretold(std::size_t k, double time_s) const {
    const DampedSinusoid& mode = m_signal.modes[k];
    const double apart = kTwoPi * (mode.frequency_hz - m_signal.mode().frequency_hz);
    const double d = mode.decay_per_s;
    return m_signal.amplitude(k) *
           std::exp(0.5 * (d * d - apart * apart) * m_tau_s * m_tau_s - d * time_s);
  }

  [[nodiscard]] std::optional<Point> transform_at(double time_s) const {
    const VectorXd& t = m_signal.time_s;
    const double* begin = t.data();
    const double* end = begin + t.size();
    Point point;
    point.time_s = time_s;
    point.first = std::lower_bound(begin, end, time_s - kSupport * m_tau_s) - begin;
    const Index count =
        std::lower_bound(begin, end, time_s + kSupport * m_tau_s) - begin - point.first;
    const double step_s = (t(t.size() - 1) - t(0)) / static_cast<double>(t.size() - 1);
    if (static_cast<double>(count) * step_s < kFullness * 2.0 * kCone * m_tau_s) return {};
    Eigen::MatrixX3d basis(count, 3);
    VectorXd gauss(count);
    const double omega = kTwoPi * m_signal.mode().frequency_hz;
    for (Index i = 0; i < count; ++i) {
      const double s = t(point.first + i) - time_s;
      gauss(i) = std::exp(-0.5 * s * s / (m_tau_s * m_tau_s));
      basis.row(i) << 1.0, std::cos(omega * s), std::sin(omega * s);
    }
    const Eigen::MatrixX3d weighted = gauss.asDiagonal() * basis;
    const Eigen::Matrix3d normal = weighted.transpose().lazyProduct(basis);
    const Eigen::Matrix3d inverse = normal.inverse();
    // The reciprocal condition, as LAPACK has it; not a number if singular.
    if (!(1.0 / (largest_column_sum(normal) * largest_column_sum(inverse)) > 1e-6)) return {};
    const Eigen::MatrixX3d dual = weighted.lazyProduct(inverse);
    point.weights = dual.col(1).cast<Complex>() - Complex(0.0, 1.0) * dual.col(2).cast<Complex>();
    point.value =
        (point.weights.array() * m_signal.value.segment(point.first, count).array().cast<Complex>())
            .sum();
    // Of one of the two parts of W, which share the noise.
    const double noise = m_signal.noise * point.weights.norm() / std::sqrt(2.0);
    const double own = foretold(0, time_s);
    if (own < kRidgeStandsOut * noise || std::abs(point.value) == 0.0) return {};
    double leak = 0.0;
    for (std::size_t k = 1; k < m_signal.modes.size(); ++k) leak += foretold(k, time_s);
    if (leak > std::max(kLeak * own, kLeakInNoise * noise)) return {};
    return point;
  }
};

/// The covariances of ln|W| and of the phase: real and imaginary part of dW / W, with |W| as it is
/// smoothed; where the noise has lifted it, a point would else weigh more.
std::array<MatrixXd, 2> covariances(const std::vector<Point>& points,
                                    const VectorXd& smooth,
                                    double noise) {
  const auto count = static_cast<Index>(points.size());
  std::array<MatrixXd, 2> out = {MatrixXd::Zero(count, count), MatrixXd::Zero(count, count)};
  const auto smoothed = [&](Index j) {
    const Complex value = points[static_cast<std::size_t>(j)].value;
    return value * (smooth(j) / std::abs(value));
  };
  for (Index j = 0; j < count; ++j) {
    const Point& a = points[static_cast<std::size_t>(j)];
    for (Index k = j; k < count; ++k) {
      const Point& b = points[static_cast<std::size_t>(k)];
      const Index first = std::max(a.first, b.first);
      const Index last = std::min(a.first + a.weights.size(), b.first + b.weights.size());
      if (last <= first) break;
      const Eigen::VectorXcd of_a = a.weights.segment(first - a.first, last - first) / smoothed(j);
      const Eigen::VectorXcd of_b = b.weights.segment(first - b.first, last - first) / smoothed(k);
      out[0](j, k) = out[0](k, j) = noise * noise * of_a.real().dot(of_b.real());
      out[1](j, k) = out[1](k, j) = noise * noise * of_a.imag().dot(of_b.imag());
    }
  }
  return out;
}

/// Straight lines through ln|W| and the phase that the mode's frequency leaves.
DecayCheck lines_through(const std::vector<Point>& points, const CheckedSignal& signal) {
  const auto count = static_cast<Index>(points.size());
  const double f = signal.mode().frequency_hz;
  VectorXd time(count);
  VectorXd log_amplitude(count);
  VectorXd phase(count);
  for (Index j = 0; j < count; ++j) {
    const Point& point = points[static_cast<std::size_t>(j)];
    time(j) = point.time_s;
    log_amplitude(j) = std::log(std::abs(point.value));
    const double angle = std::arg(point.value) - kTwoPi * std::fmod(f * point.time_s, 1.0);
    phase(j) = j == 0 ? angle : phase(j - 1) + std::remainder(angle - phase(j - 1), kTwoPi);
  }
  std::array<MatrixXd, 2> covariance =
      covariances(points, log_amplitude.array().exp(), signal.noise);
  const RidgeLine rough = fit_ridge_line(time, log_amplitude, covariance[0]);
  const VectorXd smooth = (rough.mean + rough.slope * (time.array() - rough.mean_x)).exp();
  covariance = covariances(points, smooth, signal.noise);
  const RidgeLine amplitude_line = fit_ridge_line(time, log_amplitude, covariance[0]);
  const RidgeLine phase_line = fit_ridge_line(time, phase, covariance[1]);
  DecayCheck check;
  check.frequency_hz = f + phase_line.slope / kTwoPi;
  check.frequency_sigma_hz = phase_line.slope_sigma / kTwoPi;
  check.decay_per_s = -amplitude_line.slope;
  check.decay_sigma_per_s = amplitude_line.slope_sigma;
  check.num_points = static_cast<int>(count);
  return check;
}

}  // namespace

DecayCheck morlet_ridge(const CheckedSignal& signal) {
  DecayCheck best;
  if (signal.time_s.size() > 1) {
    for (const double width : kWidths) {
      const double tau_s = width / (kTwoPi * signal.mode().frequency_hz);
      const std::vector<Point> points = Transform(signal, tau_s).ridge();
      if (static_cast<Index>(points.size()) < kLeastPoints) continue;
      if (points.back().time_s - points.front().time_s < kLeastSpan * tau_s) continue;
      DecayCheck check = lines_through(points, signal);
      const bool first = best.num_points == 0;
      if (first || check.decay_sigma_per_s < best.decay_sigma_per_s) best = std::move(check);
    }
  }
  best.method += "Morlet wavelet";
  if (best.num_points == 0) {
    best.message = fmt::format(
        "no stretch of the record at {} Hz is free of its edges, of the noise and of other modes "
        "at once",
        rounded_text(signal.mode().frequency_hz, 4));
  }
  return best;
}

}  // namespace twang
