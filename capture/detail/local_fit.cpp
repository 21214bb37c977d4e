// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/local_fit.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace twang::detail {
namespace {

constexpr std::size_t kAtLeast = 14;  // samples: twice the terms
constexpr int kCubicTerms = 4;
constexpr int kNumOmegas = 52;    // grid from 0 to half the frame rate
constexpr int kHalvings = 4;      // of the grid's step about the best: 0.3 degrees a frame are left
constexpr double kFrames = 16.0;  // unit of time in the terms: keeps them of one size
constexpr double kFarOut = 3.5;   // residuals between a sample and a fit that drops it
constexpr double kSingular = 1e-13;  // ratio of pivots

using Terms = Eigen::Matrix<double, kMostTerms, 1>;
using Normal = Eigen::Matrix<double, kMostTerms, kMostTerms>;

/// Those of the cubic come first, the others are 0 then.
Terms terms(double omega, double t) {
  const double u = t / kFrames;
  Terms row = Terms::Zero();
  if (omega == 0.0) {
    row.head<kCubicTerms>() << 1.0, u, u * u, u * u * u;
  } else {
    const double c = std::cos(omega * t);
    const double s = std::sin(omega * t);
    row << 1.0, u, u * u, c, s, u * c, u * s;
  }
  return row;
}

Eigen::Index num_terms(double omega) { return omega == 0.0 ? kCubicTerms : kMostTerms; }

/// Sum of squared residuals, and the solution where asked for.
double solve(double omega, const Samples& samples, LocalFit* fit) {
  const auto rows = static_cast<Eigen::Index>(samples.t.size());
  Eigen::Matrix<double, kMostTerms, kMostSamples> A;
  for (Eigen::Index i = 0; i < rows; ++i) {
    A.col(i) = terms(omega, samples.t[static_cast<std::size_t>(i)]);
  }
  const Eigen::Map<const Eigen::VectorXd> y(samples.y.data(), rows);
  Normal normal = Normal::Zero();
  for (Eigen::Index i = 0; i < rows; ++i) normal.noalias() += A.col(i) * A.col(i).transpose();
  for (Eigen::Index k = num_terms(omega); k < kMostTerms; ++k) normal(k, k) = 1.0;
  const Terms right = A.leftCols(rows) * y;
  const Eigen::LDLT<Normal> ldlt(normal);
  const auto pivots = ldlt.vectorD();
  if (pivots.minCoeff() <= kSingular * pivots.maxCoeff()) {
    return std::numeric_limits<double>::infinity();
  }
  const Terms x = ldlt.solve(right);
  if (fit) {
    const Eigen::Index n = num_terms(omega);
    fit->omega = omega;
    fit->coefficients = x.head(n);
    const Normal inverse = ldlt.solve(Normal::Identity());
    fit->covariance = inverse.topLeftCorner(n, n);
  }
  return (A.leftCols(rows).transpose() * x - y).squaredNorm();
}

double variance(double omega, const Samples& samples, LocalFit* fit = nullptr) {
  const auto freedom =
      static_cast<double>(samples.t.size()) - static_cast<double>(num_terms(omega));
  return solve(omega, samples, fit) / freedom;
}

double best_omega(const Samples& samples) {
  double best = 0.0;
  double least = variance(0.0, samples);
  const auto attempt = [&](double omega) {
    const double value = variance(omega, samples);
    if (value < least) {
      least = value;
      best = omega;
    }
  };
  double step = kPi / kNumOmegas;
  for (int i = 1; i < kNumOmegas; ++i) attempt(step * i);
  if (best == 0.0) return best;
  for (int i = 0; i < kHalvings; ++i) {
    step *= 0.5;
    const double middle = best;
    if (middle > 1.5 * step) attempt(middle - step);
    if (middle + step < kPi) attempt(middle + step);
  }
  return best;
}

LocalFit fit_with(double omega, const Samples& samples, double floor) {
  LocalFit fit;
  fit.residual = std::max(floor, std::sqrt(variance(omega, samples, &fit)));
  return fit;
}

/// The sample that the others' fit leaves farthest out, if it is far.
std::optional<std::size_t> outlier(double omega, const Samples& samples, double floor) {
  const LocalFit fit = fit_with(omega, samples, floor);
  if (!std::isfinite(fit.residual)) return std::nullopt;
  std::optional<std::size_t> farthest;
  double most = 0.0;
  for (std::size_t i = 0; i < samples.t.size(); ++i) {
    const double out = std::abs(samples.y[i] - fit.at(samples.t[i]).at);
    if (out <= most) continue;
    most = out;
    farthest = i;
  }
  if (!farthest) return std::nullopt;
  Samples others = samples;
  others.t.erase(others.t.begin() + static_cast<std::ptrdiff_t>(*farthest));
  others.y.erase(others.y.begin() + static_cast<std::ptrdiff_t>(*farthest));
  const LocalFit without = fit_with(omega, others, floor);
  if (!std::isfinite(without.residual)) return std::nullopt;
  const LocalFit::Expected there = without.at(samples.t[*farthest]);
  if (!(std::abs(samples.y[*farthest] - there.at) > kFarOut * there.error)) return std::nullopt;
  return farthest;
}

}  // namespace

LocalFit::Expected LocalFit::at(double t) const {
  const Coefficients row = terms(omega, t).head(num_terms(omega));
  return {row.dot(coefficients), residual * std::sqrt(1.0 + row.dot(covariance * row))};
}

std::optional<LocalFit> best_fit(const Samples& given, double floor, int most_dropped) {
  if (given.t.size() < kAtLeast) return std::nullopt;
  Samples samples = given;
  double omega = best_omega(samples);
  for (int i = 0; i < most_dropped && samples.t.size() > kAtLeast; ++i) {
    const auto out = outlier(omega, samples, floor);
    if (!out) break;
    samples.t.erase(samples.t.begin() + static_cast<std::ptrdiff_t>(*out));
    samples.y.erase(samples.y.begin() + static_cast<std::ptrdiff_t>(*out));
    if (i == 0) omega = best_omega(samples);
  }
  LocalFit fit = fit_with(omega, samples, floor);
  if (!std::isfinite(fit.residual)) return std::nullopt;
  return fit;
}

}  // namespace twang::detail
