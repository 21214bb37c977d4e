// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"
#include "core/termination.hpp"
#include "harmonic_inversion/damped_pole.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang {

class EvenRecord;

struct RefineOptions {
  bool fit_drift = false;  ///< a linear drift per channel, beside the offset
  int max_iterations = 60;
  double max_frequency_hz = kInfinity;  ///< no pole goes above it: Nyquist, for even stamps [Hz]
  double relative_step = 1e-13;    ///< stops when no parameter moves by more than this part of it
  std::vector<bool> fixed_decays;  ///< one a pole: its decay stays as given; empty: none
  std::vector<Eigen::VectorXd> weights;  ///< one a channel and sample, 1 / sigma; empty: all 1
  /// One a channel, with its weights in it, instead of `weights`; null where there is none. They
  /// spare every fit the setting up, and must outlive it.
  std::vector<const EvenRecord*> records;
  bool keep_residuals = true;  ///< whether `ChannelFit::residual` is wanted
  void check() const;
};

/// The linear part of a fit in one channel.
struct ChannelFit {
  double offset = 0.0;  ///< at time 0 of the series, in its unit
  double drift_per_s = 0.0;
  Eigen::VectorXd cosine;       ///< one a pole: coefficients of exp(-d t) cos(2 pi f t)
  Eigen::VectorXd sine;         ///< and of exp(-d t) sin(2 pi f t)
  Eigen::VectorXd residual;     ///< data - model, one a sample, unweighted; empty if not wanted
  Eigen::MatrixXd covariance;   ///< of (offset, [drift], cosine, sine of each pole), unit variance
  double sum_of_squares = 0.0;  ///< of the unweighted residual where the weight is above 0
  Eigen::MatrixXd covariance_at_poles;  ///< as `covariance`, were the poles known
  /// Of those (rows) with (f1, d1, f2, d2 ...) (columns); empty if the poles were given.
  Eigen::MatrixXd covariance_with_poles;
};

/// A least-squares fit of damped sinusoids with its covariance.
struct SinusoidFit {
  std::vector<DampedPole> poles;
  std::vector<ChannelFit> channels;
  Eigen::MatrixXd pole_covariance;  ///< of (f1, d1, f2, d2 ...) [Hz², Hz/s, 1/s²], unit variance
  double sum_of_squares = 0.0;      ///< of the weighted residuals
  int num_samples = 0;              ///< with a weight above 0
  int num_parameters = 0;           ///< poles and linear ones
  Termination termination = Termination::NotRun;

  /// sum_of_squares over the degrees of freedom: by it the covariances are to be scaled.
  [[nodiscard]] double variance() const;
  /// Amplitude at time 0 of pole `k` in channel `c`.
  [[nodiscard]] double amplitude(std::size_t c, std::size_t k) const;
};

/// Least squares for the poles of all modes together, on the real time stamps (Ceres, variable
/// projection): for given poles offsets, drifts and amplitudes are linear and solved for exactly.
///
///     y_c(t) = o_c + s_c t + sum_k exp(-d_k t) (a_ck cos 2 pi f_k t + b_ck sin 2 pi f_k t)
///     J = (I - B B⁺) dB/dp x                                           [Kaufman 1975]
///
/// The covariance is that of all parameters, nuisances included.
///
/// @param start  the poles from which to iterate; none: only the linear part is fitted
/// @throws InputError if a series is empty or sizes disagree
[[nodiscard]] SinusoidFit refine_sinusoids(const std::vector<SampleSeries>& series,
                                           const std::vector<DampedPole>& start,
                                           const RefineOptions& options = {});

/// The linear part alone, for poles that stay as they are.
[[nodiscard]] SinusoidFit fit_amplitudes(const std::vector<SampleSeries>& series,
                                         const std::vector<DampedPole>& poles,
                                         const RefineOptions& options = {});

}  // namespace twang
