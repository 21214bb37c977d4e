// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/even_record.hpp"
#include "harmonic_inversion/refine_sinusoids.hpp"
#include "harmonic_inversion/sample_scatter.hpp"

#include <Eigen/Core>

#include <memory>
#include <vector>

namespace twang {

/// The channels of an inversion with the weights and tolerances of their fits.
class WeightedData {
 public:
  /// Each channel begins with the weight of its own spread.
  WeightedData(const std::vector<SampleSeries>& series, double step_s);

  bool fit_drift = true;   ///< a drift per channel takes part in the fits
  bool is_robust = false;  ///< outliers in short runs count less, too, see `robust_factors`

  [[nodiscard]] const std::vector<SampleSeries>& series() const { return m_series; }

  /// For fits that are to be judged, and for those that are kept.
  [[nodiscard]] RefineOptions trial_options() const;
  [[nodiscard]] RefineOptions final_options() const;

  /// Whether the residual of `fit` is what round-off of samples and phases leaves.
  [[nodiscard]] bool is_round_off(const SinusoidFit& fit) const;
  /// Whether it is so small beside the signal that the fit is about to become exact.
  [[nodiscard]] bool is_nearly_exact(const SinusoidFit& fit) const;

  /// Data less model, unweighted, whether or not the fit has kept it.
  [[nodiscard]] Eigen::VectorXd residual(const SinusoidFit& fit, std::size_t c) const;

  /// How far the sum of squares by which a long even record was fitted, that of moments of its
  /// blocks, is from that of `residual` at every sample, as a part of it; 0 where all samples were
  /// summed up anyway. An error of the moments shows in it to first order.
  /// @param fit  with its residuals
  [[nodiscard]] double moment_mismatch(const SinusoidFit& fit, std::size_t c) const;

  /// One a channel and sample, 1 / sigma, 0 for an outlier.
  [[nodiscard]] const std::vector<Eigen::VectorXd>& weights() const { return m_weights; }

  /// Residuals in units of each channel's noise; where the weights of a channel differ, with the
  /// `sigma` of each sample in that unit.
  [[nodiscard]] std::vector<SampleSeries> weighted_residuals(const SinusoidFit& fit) const;
  /// For fits of those.
  [[nodiscard]] RefineOptions residual_options(const std::vector<SampleSeries>& residuals) const;

  /// Weights each channel by what a fit of its own would leave and the stated sigmas, and isolated
  /// outliers by 0. What the joint fit leaves would not do: of two repeats that differ, the one it
  /// comes nearer to would gain weight, round by round, until it had all.
  /// Returns the largest change of the part of its weight that an outlier keeps.
  double weigh(const SinusoidFit& fit);

  /// Whether a weighing found samples that would count less if `is_robust`.
  [[nodiscard]] bool saw_runs_of_outliers() const { return m_saw_runs_of_outliers; }

  /// The Bayes criterion of a fit with the outliers as they are now, the value of each being an
  /// unknown, and where each run of them begins, which any of the n samples may be, two more:
  ///
  ///     sum_i (factor_i² r_i² / variance_i + ln variance_i)
  ///       + (p + sum_i (1 - factor_i) + 2 sum_runs max (1 - factor_i)) ln n
  [[nodiscard]] double criterion(const SinusoidFit& fit) const;

  /// By it the samples of each channel are weighed.
  [[nodiscard]] const std::vector<SampleScatter>& scatter() const { return m_scatter; }

  /// One a channel and sample.
  [[nodiscard]] std::vector<std::vector<bool>> outliers() const;
  [[nodiscard]] int num_outliers() const { return m_num_outliers; }
  /// One a channel: samples that keep a part of their weight.
  [[nodiscard]] std::vector<int> num_down_weighted() const;

 private:
  [[nodiscard]] Eigen::VectorXd residual(const SinusoidFit& fit,
                                         const ChannelFit& channel,
                                         std::size_t c) const;
  /// Of channel `c` alone, with as many poles.
  [[nodiscard]] Eigen::VectorXd residual_of_own_fit(const SinusoidFit& fit, std::size_t c) const;
  [[nodiscard]] RefineOptions options_with_step(double relative_step, int max_iterations) const;
  /// The part of its weight that each sample keeps.
  [[nodiscard]] Eigen::VectorXd find_factors(std::size_t c, const Eigen::VectorXd& r);
  /// By residuals of which each counts by its factor.
  [[nodiscard]] SampleScatter find_scatter(std::size_t c,
                                           const Eigen::VectorXd& r,
                                           const SinusoidFit& fit) const;

  const std::vector<SampleSeries>& m_series;
  double m_step_s;
  std::vector<double> m_floor;                         ///< round-off of each channel
  std::vector<Eigen::VectorXd> m_weights;              ///< one a channel
  std::vector<Eigen::VectorXd> m_factors;              ///< likewise
  std::vector<SampleScatter> m_scatter;                ///< likewise
  std::vector<std::unique_ptr<EvenRecord>> m_records;  ///< one a channel, null: not long or even
  int m_num_outliers = 0;
  bool m_saw_runs_of_outliers = false;
};

}  // namespace twang
