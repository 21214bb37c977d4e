// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/refine_sinusoids.hpp"

#include <optional>
#include <string>
#include <vector>

namespace twang {

struct SelectionOptions;

/// `n ln(RSS / n) + p ln n` [Schwarz 1978].
[[nodiscard]] double bayes_criterion(const SinusoidFit& fit);

/// ln of the chance that `num_linear` columns chosen blindly lower the residual of white noise from
/// `before` to `after` or below, with `num_free` degrees of freedom left: ln I_r(num_free / 2,
/// num_linear / 2), r = after / before; `num_linear` is even.
[[nodiscard]] double log_chance_of_gain(double before, double after, int num_free, int num_linear);

/// Samples that stand far out of the residual alone, not in a run with their neighbours.
[[nodiscard]] std::vector<bool> find_isolated_outliers(const Eigen::VectorXd& residual);

/// What a damped sinusoid of a fit must satisfy to be called a mode.
class ModeCriteria {
 public:
  ModeCriteria(const std::vector<SampleSeries>& series, const SelectionOptions& options);

  /// Whether `larger`, with one more pole, is worth it: the Bayes criterion falls, and the gain is
  /// rarer in white noise than the false-alarm rate.
  [[nodiscard]] bool is_supported(const SinusoidFit& smaller, const SinusoidFit& larger) const;

  /// The fall of the sum of squares, in units of the noise variance, below which no mode among
  /// `num_samples` samples is supported.
  [[nodiscard]] double least_gain(int num_samples) const;

  /// Why pole `k` is no mode whatever it explains, in a few words.
  [[nodiscard]] std::optional<std::string> objection(const SinusoidFit& fit, std::size_t k) const;

  /// Why pole `k`, overlapping a stronger one, is no mode of its own.
  /// @param without  the best fit without it
  [[nodiscard]] std::optional<std::string> overlap_objection(const SinusoidFit& fit,
                                                             std::size_t k,
                                                             const SinusoidFit& without) const;

  /// Whether only a fit without pole `k` tells whether it is needed: it is weak or overlaps.
  [[nodiscard]] bool needs_refit_to_judge(const SinusoidFit& fit, std::size_t k) const;

  /// d below 0 by more than chance.
  [[nodiscard]] bool is_growing(const SinusoidFit& fit, std::size_t k) const;

  /// The largest ratio of amplitude to its sigma over the channels.
  [[nodiscard]] double amplitude_over_sigma(const SinusoidFit& fit, std::size_t k) const;

  /// Whether there is no other mode that a mode could be confused with and it stands so far out of
  /// the noise that it is one, even where it is gone within some samples and the amplitude at the
  /// first of them follows an uncertain decay.
  [[nodiscard]] bool is_lone_and_sure(const SinusoidFit& fit, std::size_t k) const;

  /// Of the longest series [s].
  [[nodiscard]] double duration_s() const;

  /// Indices of the poles, least energy first.
  [[nodiscard]] std::vector<std::size_t> by_energy(const SinusoidFit& fit) const;

 private:
  [[nodiscard]] double amplitude_over_sigma(const SinusoidFit& fit,
                                            std::size_t k,
                                            Eigen::MatrixXd ChannelFit::*which) const;
  [[nodiscard]] double energy(const SinusoidFit& fit, std::size_t k) const;
  [[nodiscard]] std::optional<std::size_t> overlapped_by(const SinusoidFit& fit,
                                                         std::size_t k) const;

  const std::vector<SampleSeries>& m_series;
  const SelectionOptions& m_options;
  std::vector<double> m_scale;  ///< 1 / spread of each channel
};

}  // namespace twang
