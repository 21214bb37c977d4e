// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/projected_fit.hpp"
#include "harmonic_inversion/zoomed_record.hpp"

#include <array>
#include <optional>
#include <vector>

namespace twang {

/// A long series on an even grid, which needs no matrix of all samples to be fitted: products of
/// damped sinusoids are geometric series, their products with the samples come from moments of a
/// few blocks, and their values repeat from block to block but for a factor.
///
///     sum_n t_n^q φ_j φ_k,   q = 0, 1, 2
///     sum_n t_n^q φ_k y_n,   q = 0, 1                                  (see ZoomedRecord)
///     φ_k(t_0 + (b L + l) h) = φ_k(t_0) u_k^(b L) u_k^l,   0 <= l < L
///
/// Not for several threads at once.
class EvenRecord {
 public:
  /// Nothing if the series is short, the stamps are uneven, or the weights differ by more than a
  /// few zeros.
  [[nodiscard]] static std::optional<EvenRecord> from(const SampleSeries& series,
                                                      const Eigen::VectorXd& weights);

  /// Samples with a weight above 0, and the weights of all.
  [[nodiscard]] Eigen::Index num_used() const;
  [[nodiscard]] Eigen::VectorXd weights() const;
  [[nodiscard]] double weight() const { return m_weight; }  ///< the one they have if not 0

  /// Takes other weights if they are as even; false, and all as it was, if not.
  [[nodiscard]] bool set_weights(const Eigen::VectorXd& weights);

  /// As the free function. Nothing where that is the better one: a residual near round-off, a pole
  /// that grows out of all bounds.
  [[nodiscard]] std::optional<ProjectedFit> fit_projected(const std::vector<DampedPole>& poles,
                                                          bool fit_drift,
                                                          bool with_derivatives) const;

  /// The model at all stamps.
  [[nodiscard]] Eigen::VectorXd evaluate_model(const std::vector<DampedPole>& poles,
                                               bool fit_drift,
                                               const Eigen::VectorXd& coefficients) const;

  [[nodiscard]] static bool can_evaluate(const std::vector<DampedPole>& poles, double duration_s);

 private:
  class Sinusoids;
  /// Sums of [1, t / T, cosines and sines] times the values r, and of t [cosines and sines].
  struct Sums {
    Eigen::VectorXd basis;
    Eigen::VectorXd timed;
  };
  /// sum_n t_n^q v_n v_n^T, v = (cosine and sine of each pole, 1), q = 0, 1, 2.
  using Moments = std::array<Eigen::MatrixXd, 3>;

  EvenRecord(const SampleSeries& series, double step_s);

  void sum_up_alone();
  [[nodiscard]] Moments moments(const std::vector<DampedPole>& poles) const;
  /// Of the residual with `coefficients`, whose squares are added to `squares`.
  [[nodiscard]] Sums sum_up(const std::vector<DampedPole>& poles,
                            bool fit_drift,
                            const Eigen::VectorXd& coefficients,
                            bool timed,
                            double& squares) const;

  /// sum_up() without coefficients, by moments.
  [[nodiscard]] Sums sum_up_quickly(const std::vector<DampedPole>& poles,
                                    bool fit_drift,
                                    bool timed) const;

  const SampleSeries* m_series;
  double m_step_s;
  double m_weight = 1.0;
  std::vector<Eigen::Index> m_excluded;  ///< samples of no weight
  ZoomedRecord m_zoomed;
  double m_sum = 0.0;      ///< of the values that have a weight,
  double m_timed = 0.0;    ///< of them times t,
  double m_squares = 0.0;  ///< and of their squares
};

}  // namespace twang
