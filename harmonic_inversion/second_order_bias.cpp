// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/second_order_bias.hpp"

#include "core/constants.hpp"

#include <cmath>
#include <complex>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Complex = std::complex<double>;

/// What moves nothing by more than this part of its sigma is left as it is.
constexpr double kNegligibleMove = 0.01;
/// Steps of the time stamps that differ by less than this part are the same.
constexpr double kSameStep = 1e-9;
/// Samples after which the powers of a step are begun anew, and the exponent that is nothing.
constexpr Index kPowers = 256;
constexpr double kGone = 40.0;

/// Adds Re[(squared t² + mixed t) exp(s t)] at the times of `t` to `out`.
void add_excess(const VectorXd& t, Complex s, Complex squared, Complex mixed, VectorXd& out) {
  double step = 0.0;
  Complex factor = 1.0;
  Complex wave = 1.0;
  for (Index i = 0; i < t.size(); ++i) {
    if (s.real() * t(i) < -kGone) return;
    if (i % kPowers == 0) {
      wave = std::exp(s * t(i));
    } else {
      const double next = t(i) - t(i - 1);
      if (std::abs(next - step) > kSameStep * step) factor = std::exp(s * (step = next));
      wave *= factor;
    }
    out(i) += t(i) * ((squared * t(i) + mixed) * wave).real();
  }
}

/// E[δs²] of pole k, s = -d + i 2 pi f.
Complex square_of_pole(const SinusoidFit& fit, Index k) {
  const Eigen::Matrix2d v = fit.pole_covariance.block<2, 2>(2 * k, 2 * k) * fit.variance();
  return {v(1, 1) - kTwoPi * kTwoPi * v(0, 0), -2.0 * kTwoPi * v(0, 1)};
}

/// E[δz δs] of pole k, z = a - i b.
Complex mixed_with_pole(const SinusoidFit& fit, const ChannelFit& channel, Index k) {
  const Eigen::MatrixXd& all = channel.covariance_with_poles;
  const Index row = all.rows() - 2 * channel.cosine.size() + 2 * k;
  const Eigen::Matrix2d v = all.block<2, 2>(row, 2 * k) * fit.variance();
  return {kTwoPi * v(1, 0) - v(0, 1), kTwoPi * v(0, 0) + v(1, 1)};
}

/// Whether every pole of `moved` is within its sigma of that of `fit`, and decays if that does.
bool is_small_move(const SinusoidFit& fit, const SinusoidFit& moved) {
  for (std::size_t k = 0; k < fit.poles.size(); ++k) {
    const auto i = 2 * static_cast<Index>(k);
    const DampedPole& from = fit.poles[k];
    const DampedPole& to = moved.poles[k];
    const double variance = fit.variance();
    if (!(std::pow(to.frequency_hz - from.frequency_hz, 2) <=
          fit.pole_covariance(i, i) * variance) ||
        !(std::pow(to.decay_per_s - from.decay_per_s, 2) <=
          fit.pole_covariance(i + 1, i + 1) * variance) ||
        std::signbit(to.decay_per_s) != std::signbit(from.decay_per_s))
      return false;
  }
  return true;
}

}  // namespace

std::vector<VectorXd> mean_excess(const std::vector<SampleSeries>& series, const SinusoidFit& fit) {
  std::vector<VectorXd> out;
  for (std::size_t c = 0; c < series.size(); ++c) {
    const ChannelFit& channel = fit.channels[c];
    out.push_back(VectorXd::Zero(series[c].value.size()));
    for (Index k = 0; k < channel.cosine.size(); ++k) {
      const DampedPole& pole = fit.poles[static_cast<std::size_t>(k)];
      const Complex z(channel.cosine(k), -channel.sine(k));
      add_excess(series[c].time_s,
                 {-pole.decay_per_s, kTwoPi * pole.frequency_hz},
                 0.5 * z * square_of_pole(fit, k),
                 mixed_with_pole(fit, channel, k),
                 out.back());
    }
  }
  return out;
}

std::optional<SinusoidFit> without_bias(const std::vector<SampleSeries>& series,
                                        const SinusoidFit& fit,
                                        const std::vector<VectorXd>& weights,
                                        RefineOptions options) {
  const std::vector<VectorXd> excess = mean_excess(series, fit);
  double squares = 0.0;
  for (std::size_t c = 0; c < series.size(); ++c) {
    squares += excess[c].cwiseProduct(weights[c]).squaredNorm();
  }
  // No parameter moves by more sigmas than the whole excess has; the model scatters by as many as
  // there are parameters, to first order.
  if (!(squares > kNegligibleMove * kNegligibleMove * fit.variance())) return std::nullopt;
  if (!(squares < fit.num_parameters * fit.variance())) return std::nullopt;
  std::vector<SampleSeries> lifted = series;
  for (std::size_t c = 0; c < series.size(); ++c) lifted[c].value += excess[c];
  options.records.clear();
  options.weights = weights;
  SinusoidFit out = refine_sinusoids(lifted, fit.poles, options);
  if (out.termination != Termination::Converged || !is_small_move(fit, out)) return std::nullopt;
  out.sum_of_squares = fit.sum_of_squares;
  for (std::size_t c = 0; c < series.size(); ++c) {
    out.channels[c].sum_of_squares = fit.channels[c].sum_of_squares;
    out.channels[c].residual.resize(0);
  }
  return out;
}

}  // namespace twang
