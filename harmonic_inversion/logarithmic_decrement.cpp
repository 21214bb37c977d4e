// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/logarithmic_decrement.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/ridge_line.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kTurns = 3.0;              // noises past zero before the next extremum is sought
constexpr double kExtremumStandsOut = 4.0;  // noises above which an extremum counts
constexpr std::size_t kLeast = 4;           // extrema
constexpr double kReach = 0.125;            // of a period, either side of an extremum
constexpr double kLeastReach = 1.5;         // samples
constexpr double kMostReach = 0.25;         // of a period: no sample serves two extrema
constexpr double kLeastDeterminant = 1e-9;  // of the squared norm: two samples tell a from b
constexpr int kRounds = 4;

struct Extremum {
  long number = 0;  // half periods after the first one
  double time_s = 0.0;
  double height = 0.0;  // > 0
  double sign = 1.0;
};

/// The parabola through three samples; nothing if it has no summit between them.
std::optional<Extremum> summit(const CheckedSignal& signal, Index i, double sign) {
  if (i == 0 || i + 1 >= signal.time_s.size()) return std::nullopt;
  const double left = signal.time_s(i - 1) - signal.time_s(i);
  const double right = signal.time_s(i + 1) - signal.time_s(i);
  const double y = sign * signal.mode_alone(i);
  const double slope_left = (sign * signal.mode_alone(i - 1) - y) / left;
  const double slope_right = (sign * signal.mode_alone(i + 1) - y) / right;
  const double curvature = (slope_right - slope_left) / (right - left);
  const double slope = slope_left - curvature * left;
  if (!(curvature < 0.0)) return std::nullopt;
  const double at = -0.5 * slope / curvature;
  if (at < left || at > right) return std::nullopt;
  return Extremum{0, signal.time_s(i) + at, y + 0.5 * slope * at, sign};
}

/// Alternating extrema until the signal no longer turns beyond the noise.
std::vector<Extremum> find_extrema(const CheckedSignal& signal) {
  std::vector<Extremum> extrema;
  double sign = 0.0;
  Index highest = 0;
  const auto close = [&] {
    if (sign == 0.0) return;
    const auto extremum = summit(signal, highest, sign);
    if (extremum && extremum->height > kExtremumStandsOut * signal.noise)
      extrema.push_back(*extremum);
  };
  for (Index i = 0; i < signal.time_s.size(); ++i) {
    const double y = signal.mode_alone(i);
    if (std::abs(y) > kTurns * signal.noise && y * sign <= 0.0) {
      close();
      sign = y > 0.0 ? 1.0 : -1.0;
      highest = i;
    } else if (sign * y > sign * signal.mode_alone(highest)) {
      highest = i;
    }
  }
  close();
  const double half_period_s = 0.5 / signal.mode().frequency_hz;
  for (Extremum& extremum : extrema) {
    extremum.number = std::lround((extremum.time_s - extrema.front().time_s) / half_period_s);
  }
  // Of a number only one, and only if its sign is the one that is due.
  std::vector<Extremum> due;
  for (const Extremum& extremum : extrema) {
    const bool even = extremum.number % 2 == 0;
    if ((extremum.sign == extrema.front().sign) != even) continue;
    if (!due.empty() && due.back().number == extremum.number) continue;
    due.push_back(extremum);
  }
  return due;
}

/// f and d, the time of extremum 0 and ln of its amplitude, with lines through them.
struct Decrement {
  double frequency_hz = 0.0;
  double frequency_sigma_hz = 0.0;
  double decay_per_s = 0.0;
  double decay_sigma_per_s = 0.0;
  double first_s = 0.0;
  RidgeLine log_amplitude;
};

Decrement from_parabolas(const std::vector<Extremum>& extrema, double noise) {
  const auto count = static_cast<Index>(extrema.size());
  VectorXd number(count);
  VectorXd time(count);
  VectorXd height(count);
  VectorXd variance(count);
  for (Index i = 0; i < count; ++i) {
    const Extremum& extremum = extrema[static_cast<std::size_t>(i)];
    number(i) = static_cast<double>(extremum.number);
    time(i) = extremum.time_s;
    height(i) = std::log(extremum.height);
    variance(i) = std::pow(noise / extremum.height, 2);
  }
  const RidgeLine times = fit_ridge_line_through_independent(number, time, variance);
  Decrement out;
  out.log_amplitude = fit_ridge_line_through_independent(time, height, variance);
  out.frequency_hz = 0.5 / times.slope;
  out.decay_per_s = -out.log_amplitude.slope;
  out.first_s = times.at(0.0);
  return out;
}

/// Amplitude, phase and their covariance for unit noise from the samples about one extremum.
struct LocalFit {
  double time_s = 0.0;
  double log_amplitude = 0.0;
  double phase = 0.0;  // [rad]
  double log_amplitude_variance = 0.0;
  double phase_variance = 0.0;
};

std::optional<LocalFit> fit_about(
    const CheckedSignal& signal, const Decrement& guess, double at_s, double sign, double step_s) {
  const double period_s = 1.0 / guess.frequency_hz;
  const double reach_s =
      std::min(std::max(kReach * period_s, kLeastReach * step_s), kMostReach * period_s);
  const double* begin = signal.time_s.data();
  const double* end = begin + signal.time_s.size();
  const Index first = std::lower_bound(begin, end, at_s - reach_s) - begin;
  const Index last = std::lower_bound(begin, end, at_s + reach_s) - begin;
  if (last - first < 2) return std::nullopt;
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (Index i = first; i < last; ++i) {
    const double t = signal.time_s(i) - at_s;
    const double size = std::exp(-guess.decay_per_s * t);
    const double angle = kTwoPi * guess.frequency_hz * t;
    const Eigen::Vector2d row(size * std::cos(angle), size * std::sin(angle));
    normal += row * row.transpose();
    right += row * sign * signal.mode_alone(i);
  }
  if (!(normal.determinant() > kLeastDeterminant * normal.squaredNorm())) return std::nullopt;
  const Eigen::Matrix2d covariance = normal.inverse();
  const Eigen::Vector2d x = covariance * right;
  if (!(x(0) > 0.0)) return std::nullopt;
  // The noise counts against the amplitude that is foretold: against the one found, points that
  // the noise has lifted would weigh more.
  const double foretold = std::exp(guess.log_amplitude.at(at_s));
  const Eigen::Vector2d along = x.normalized();
  const Eigen::Vector2d across(along(1), -along(0));
  return LocalFit{at_s,
                  0.5 * std::log(x.squaredNorm()),
                  -std::atan2(x(1), x(0)),
                  along.dot(covariance * along) / (foretold * foretold),
                  across.dot(covariance * across) / (foretold * foretold)};
}

/// All extrema from the first one found to the last foretold to stand out: none is left out for
/// being low, which would make the decay look slower.
std::vector<LocalFit> fit_about_all(const CheckedSignal& signal,
                                    const Decrement& guess,
                                    double first_sign) {
  const double last_s = signal.time_s(signal.time_s.size() - 1);
  const double step_s = (last_s - signal.time_s(0)) / static_cast<double>(signal.time_s.size() - 1);
  std::vector<LocalFit> fits;
  double sign = first_sign;
  for (double at_s = guess.first_s; at_s <= last_s; at_s += 0.5 / guess.frequency_hz) {
    if (std::exp(guess.log_amplitude.at(at_s)) < kExtremumStandsOut * signal.noise) break;
    if (const auto fit = fit_about(signal, guess, at_s, sign, step_s)) fits.push_back(*fit);
    sign = -sign;
  }
  return fits;
}

Decrement from_local_fits(const std::vector<LocalFit>& fits, const Decrement& guess, double noise) {
  const auto count = static_cast<Index>(fits.size());
  VectorXd time(count);
  Eigen::MatrixX2d value(count, 2);
  Eigen::MatrixX2d variance(count, 2);
  for (Index i = 0; i < count; ++i) {
    const LocalFit& fit = fits[static_cast<std::size_t>(i)];
    time(i) = fit.time_s;
    value.row(i) << fit.log_amplitude, fit.phase;
    variance.row(i) << fit.log_amplitude_variance, fit.phase_variance;
  }
  variance *= noise * noise;
  Decrement out;
  out.log_amplitude = fit_ridge_line_through_independent(time, value.col(0), variance.col(0));
  const RidgeLine phase = fit_ridge_line_through_independent(time, value.col(1), variance.col(1));
  out.decay_per_s = -out.log_amplitude.slope;
  out.decay_sigma_per_s = out.log_amplitude.slope_sigma;
  out.frequency_hz = guess.frequency_hz + phase.slope / kTwoPi;
  out.frequency_sigma_hz = phase.slope_sigma / kTwoPi;
  out.first_s = guess.first_s - phase.at(guess.first_s) / (kTwoPi * out.frequency_hz);
  return out;
}

}  // namespace

DecayCheck logarithmic_decrement(const CheckedSignal& signal) {
  DecayCheck check;
  check.method += "logarithmic decrement";
  const std::vector<Extremum> extrema = find_extrema(signal);
  const auto refuse = [&](std::size_t count) {
    check.message = fmt::format(
        "extrema that stand out of the noise: {}, at least {} are needed", count, kLeast);
    return check;
  };
  if (extrema.size() < kLeast) return refuse(extrema.size());
  Decrement found = from_parabolas(extrema, signal.noise);
  for (int round = 0; round < kRounds; ++round) {
    if (!(found.frequency_hz > 0.0) || !std::isfinite(found.first_s)) return refuse(0);
    const std::vector<LocalFit> fits = fit_about_all(signal, found, extrema.front().sign);
    if (fits.size() < kLeast) return refuse(fits.size());
    found = from_local_fits(fits, found, signal.noise);
    check.num_points = static_cast<int>(fits.size());
  }
  check.frequency_hz = found.frequency_hz;
  check.frequency_sigma_hz = found.frequency_sigma_hz;
  check.decay_per_s = found.decay_per_s;
  check.decay_sigma_per_s = found.decay_sigma_per_s;
  return check;
}

}  // namespace twang
