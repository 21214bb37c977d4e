// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <complex>
#include <optional>
#include <vector>

namespace twang {

/// Sums of an evenly sampled record times damped sinusoids. The first sum near a place in the
/// complex plane reads the record, further ones there only a few moments of each of its blocks,
/// whose length is the step to which that band is decimated.
///
///     S_q(s) = sum_n t_n^q y_n e^(s t_n),   q = 0, 1
///            = sum_b e^(s t_b) sum_p a^p / p! M_bp (q = 0),   a = (s - s0) H
///     M_bp   = sum_(n in block b) y_n e^(s0 (t_n - t_b)) x_n^p,   x_n = (t_n - t_b) / H
///
/// t_b is the middle of block b, H half its length, s0 the centre of a cell with |a| <= 1/2, where
/// 14 moments are as good as all samples.
class ZoomedRecord {
 public:
  /// @param value     referred to, not copied
  /// @param excluded  samples that count as 0, rising
  ZoomedRecord(const Eigen::VectorXd& value,
               double start_s,
               double step_s,
               std::vector<Eigen::Index> excluded);

  struct Sums {
    std::complex<double> plain;  ///< q = 0
    std::complex<double> timed;  ///< q = 1
  };

  /// Not for several threads at once: it remembers the moments.
  /// @param exponent  s [1/s]; it must not grow out of all bounds within the record
  [[nodiscard]] Sums at(std::complex<double> exponent) const;

 private:
  /// M_bp of one s0: a row a moment, a column a block; real parts above imaginary ones.
  struct Cell {
    std::complex<double> centre;
    Eigen::MatrixXd moments;
  };

  [[nodiscard]] Sums sum_of_beginning(std::complex<double> exponent, Eigen::Index count) const;
  [[nodiscard]] const Cell& cell_near(std::complex<double> exponent) const;
  [[nodiscard]] Cell make_cell(std::complex<double> centre) const;

  const Eigen::VectorXd* m_value;
  double m_start_s;
  double m_step_s;
  std::vector<Eigen::Index> m_excluded;
  Eigen::Index m_length;  ///< samples of a block
  double m_half_s;        ///< H
  mutable std::vector<Cell> m_cells;
};

}  // namespace twang
